//! Strokes of a pivoting grasp, simulated: touch down, drag, lift, swing to rest. Contact geometry is exact, friction as in `statics.rs`.
//!
//! Contact at the body angle θ: the pivot stands r(θ) over the pad, and the pad feels s = u − d(θ), where u is the foot of the pivot.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::pivot::error::PivotSimulateError;
use crate::pivot::log::{PivotLog, PivotSample};
use crate::pivot::rig::PivotRig;
use crate::pivot::statics::Pivoted;
use crate::sensor::{PadContact, Touchpad};
use crate::shape::SupportFunction;
use crate::truth::{TruePose, Truth};

/// Samples of the true support function.
const TRUTH_SAMPLES: usize = 720;

/// Longest way of the pivot along the pad in one step of the simulation, as a share of the mean radius.
const LONGEST_STEP: f64 = 0.02;

/// Samples of a log at most.
const MOST_SAMPLES: usize = 10_000_000;

/// One stroke: the pivot comes down until the object is pressed, is dragged along the pad, and is lifted.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Stroke {
    /// Where the foot of the pivot goes, metres along the pad from its base: down at the first place, then to each of the others in turn.
    pub along_m: Vec<f64>,
    /// Force with which the arm presses while it drags, normal to the pad, in units of the object's weight.
    pub press: f64,
}

/// What a simulation needs besides object and strokes.
#[derive(Clone, Debug, PartialEq)]
pub struct PivotSimulateOptions {
    /// Where the pad lies, and its constant errors.
    pub rig: PivotRig,
    /// The pad: length, noise, rounding, drop-outs.
    pub touchpad: Touchpad,
    /// Standard deviation of each coordinate of the pivot, metres.
    pub arm_noise_sd_m: f64,
    /// Centre of mass in the frame of the object, whose origin is the pivot, metres.
    pub center_of_mass_m: [f64; 2],
    /// Coefficient of friction between pad and object.
    pub friction: f64,
    /// Speed of the arm along the pad, metres per second.
    pub drag_m_per_s: f64,
    /// Speed of the arm across the pad, metres per second.
    pub lift_m_per_s: f64,
    /// Samples per second.
    pub rate_hz: f64,
    /// Seed of the noise.
    pub seed: u64,
}

impl Default for PivotSimulateOptions {
    /// An exact pad of a metre along the X axis, an exact arm, a centre of mass 5 mm from the pivot, friction 0.4, 20 mm/s along the pad,
    /// 10 mm/s across it, 20 samples per second.
    fn default() -> Self {
        Self {
            rig: PivotRig::default(),
            touchpad: Touchpad { length_m: 1.0, ..Touchpad::ideal() },
            arm_noise_sd_m: 0.0,
            center_of_mass_m: [0.0, -0.005],
            friction: 0.4,
            drag_m_per_s: 0.02,
            lift_m_per_s: 0.01,
            rate_hz: 20.0,
            seed: 1,
        }
    }
}

/// A log and what is behind it.
#[derive(Clone, Debug, PartialEq)]
pub struct PivotSimulation {
    /// What the robot knows.
    pub log: PivotLog,
    /// Support function about the pivot, orientation and centre of mass at each sample.
    pub truth: Truth,
    /// Body angle of the contact at each sample, radians; `None` without one.
    pub theta_rad: Vec<Option<f64>>,
    /// Samples before which the object leapt from one contact to another without being lifted.
    pub leaps: Vec<usize>,
}

/// Simulates strokes over a pad. `shape` is the support function about the pivot.
///
/// # Errors
/// When the shape is not convex or does not surround its pivot, or a number is out of range.
pub fn simulate_strokes(
    shape: &SupportFunction,
    strokes: &[Stroke],
    options: &PivotSimulateOptions,
) -> Result<PivotSimulation, PivotSimulateError> {
    check(shape, strokes, options)?;
    let mut run = Run::new(shape, options);
    for stroke in strokes {
        run.stroke(stroke)?;
    }
    Ok(run.finish())
}

/// A simulation as it goes.
struct Run<'a> {
    options: &'a PivotSimulateOptions,
    object: Pivoted<'a>,
    rng: ChaCha8Rng,
    /// Height at which the object is free of the pad, metres.
    clear_m: f64,
    theta: f64,
    touches: bool,
    time_s: f64,
    log: PivotLog,
    motion: Vec<TruePose>,
    theta_rad: Vec<Option<f64>>,
    leaps: Vec<usize>,
}

impl<'a> Run<'a> {
    fn new(shape: &'a SupportFunction, options: &'a PivotSimulateOptions) -> Self {
        let [x, y] = options.center_of_mass_m;
        let tilt = options.rig.pad.tilt_rad + options.rig.calibration.tilt_rad;
        let rest_rad = y.atan2(x) + tilt;
        let object = Pivoted { shape, rho_m: x.hypot(y), rest_rad, friction: options.friction, cos_tilt: tilt.cos() };
        let highest = (0..TRUTH_SAMPLES).map(|node| shape.radius_m(angle(node))).fold(0.0, f64::max);
        Self {
            options,
            object,
            rng: ChaCha8Rng::seed_from_u64(options.seed),
            clear_m: highest + 0.1 * shape.mean_radius_m(),
            theta: rest_rad,
            touches: false,
            time_s: 0.0,
            log: PivotLog::default(),
            motion: Vec::new(),
            theta_rad: Vec::new(),
            leaps: Vec::new(),
        }
    }

    fn stroke(&mut self, stroke: &Stroke) -> Result<(), PivotSimulateError> {
        let Some((&down_m, ways)) = stroke.along_m.split_first() else { return Ok(()) };
        let shape = self.object.shape;
        self.theta = self.object.rest_rad;
        self.touches = false;
        // Down to the contact, and on until the friction cone holds the object.
        let [touch_m, end] = [shape.radius_m(self.theta), self.object.pressed(self.theta, stroke.press)];
        let direction = (end - self.theta).signum();
        let (start, pressed_m) = (self.theta, shape.radius_m(end));
        let fall_m = self.options.lift_m_per_s / self.options.rate_hz;
        let mut height_m = self.clear_m;
        while height_m > pressed_m {
            if height_m <= touch_m {
                self.touches = true;
                self.theta = self.object.lowered(start, height_m, direction);
            }
            self.record(down_m, height_m)?;
            height_m -= fall_m;
        }
        (self.theta, self.touches) = (end, true);
        let mut along_m = down_m;
        self.record(along_m, pressed_m)?;
        let per_sample_m = self.options.drag_m_per_s / self.options.rate_hz;
        let most_m = LONGEST_STEP * shape.mean_radius_m();
        for &to_m in ways {
            let samples = ((to_m - along_m).abs() / per_sample_m).ceil().max(1.0);
            let step_m = (to_m - along_m) / samples;
            let parts = (step_m.abs() / most_m).ceil().max(1.0);
            for _ in 0..samples as usize {
                let before = self.theta;
                for _ in 0..parts as usize {
                    self.theta = self.object.dragged(self.theta, step_m / parts, stroke.press);
                }
                along_m += step_m;
                let rolled = step_m.abs() / shape.radius_m(before).min(shape.radius_m(self.theta));
                if (self.theta - before).abs() > 2.0 * rolled + 0.02 {
                    self.leaps.push(self.log.samples.len());
                }
                self.record(along_m, shape.radius_m(self.theta))?;
            }
        }
        // Up: under its weight alone the object leans on the pad, or hangs.
        let mut height_m = shape.radius_m(self.theta);
        while height_m < self.clear_m {
            height_m += fall_m;
            let (theta, touches) = self.object.hanging(self.theta, height_m);
            if touches && (theta - self.theta).abs() > 0.1 {
                self.leaps.push(self.log.samples.len());
            }
            (self.theta, self.touches) = (theta, touches);
            self.record(along_m, height_m)?;
        }
        Ok(())
    }

    /// Writes down one sample.
    fn record(&mut self, along_m: f64, height_m: f64) -> Result<(), PivotSimulateError> {
        if self.log.samples.len() >= MOST_SAMPLES {
            return Err(PivotSimulateError::OutOfRange { what: "the strokes, rate and speeds give too many samples" });
        }
        let rig = &self.options.rig;
        let errors = &rig.calibration;
        // The true pad is turned about its base, and higher.
        let true_pad = crate::pivot::rig::PadPose { tilt_rad: rig.pad.tilt_rad + errors.tilt_rad, ..rig.pad };
        let [x_m, y_m] = true_pad.point(along_m, height_m + errors.height_m);
        let position_m = along_m - self.object.shape.at(self.theta).d;
        let on_pad = self.touches && (0.0..=self.options.touchpad.length_m).contains(&position_m);
        let contact = PadContact { position_m: (1.0 + errors.scale) * position_m + errors.zero_m, force_n: 1.0 };
        let contacts = if on_pad { std::slice::from_ref(&contact) } else { &[] };
        let reading = self.options.touchpad.read(contacts, &mut self.rng);
        let [noise_x, noise_y]: [f64; 2] =
            [0, 1].map(|_| self.options.arm_noise_sd_m * self.rng.sample::<f64, _>(StandardNormal));
        self.log.samples.push(PivotSample {
            time_s: self.time_s,
            pivot_x_m: x_m + noise_x,
            pivot_y_m: y_m + noise_y,
            s_m: reading.map(|reading| reading.position_m),
        });
        let psi_rad = true_pad.psi_rad(self.theta);
        let [cx, cy] = self.options.center_of_mass_m;
        let (sin, cos) = psi_rad.sin_cos();
        self.motion.push(TruePose {
            time_s: self.time_s,
            psi_rad,
            com_x_m: x_m + cx * cos - cy * sin,
            com_y_m: y_m + cx * sin + cy * cos,
        });
        self.theta_rad.push(self.touches.then_some(self.theta));
        self.time_s += 1.0 / self.options.rate_hz;
        Ok(())
    }

    fn finish(self) -> PivotSimulation {
        let support = (0..TRUTH_SAMPLES).map(|node| (angle(node), self.object.shape.radius_m(angle(node)))).collect();
        let truth = Truth { support, motion: self.motion };
        PivotSimulation { log: self.log, truth, theta_rad: self.theta_rad, leaps: self.leaps }
    }
}

fn angle(node: usize) -> f64 {
    std::f64::consts::TAU * node as f64 / TRUTH_SAMPLES as f64
}

fn check(
    shape: &SupportFunction,
    strokes: &[Stroke],
    options: &PivotSimulateOptions,
) -> Result<(), PivotSimulateError> {
    let smallest_m = shape.min_curvature_radius_m();
    if shape.has_nonfinite() || smallest_m.is_nan() || smallest_m < 0.0 || shape.mean_radius_m() <= 0.0 {
        return Err(PivotSimulateError::NotConvex { smallest_m });
    }
    let least_m = (0..TRUTH_SAMPLES).map(|node| shape.radius_m(angle(node))).fold(f64::INFINITY, f64::min);
    if least_m <= 0.0 {
        return Err(PivotSimulateError::PivotOutside { least_m });
    }
    if strokes.iter().all(|stroke| stroke.along_m.is_empty()) {
        return Err(PivotSimulateError::NoStrokes);
    }
    let out = |what| Err(PivotSimulateError::OutOfRange { what });
    let size_m = shape.mean_radius_m();
    if strokes.iter().flat_map(|stroke| &stroke.along_m).any(|along| !(along.abs() <= 1e4 * size_m)) {
        return out("places along the pad must be finite, at most 10 000 mean radii");
    }
    if strokes.iter().any(|stroke| !(stroke.press >= 0.0 && stroke.press.is_finite())) {
        return out("the force of a stroke, in weights, must be a number from 0 on");
    }
    if let Some(what) = options.touchpad.fault() {
        return Err(PivotSimulateError::OutOfRange { what });
    }
    let tilt = options.rig.pad.tilt_rad + options.rig.calibration.tilt_rad;
    if !(tilt.abs() < 1.4) {
        return out("the tilt of the pad must be between -1.4 and 1.4 rad");
    }
    let positive = |value: f64| value > 0.0 && value.is_finite();
    if !(positive(options.drag_m_per_s) && positive(options.lift_m_per_s) && positive(options.rate_hz)) {
        return out("speeds and rate must be positive");
    }
    if !(options.friction >= 0.0 && options.friction.is_finite()) {
        return out("the coefficient of friction must be a number from 0 on");
    }
    let pad = &options.rig.pad;
    let errors = &options.rig.calibration;
    let numbers = [
        options.center_of_mass_m[0],
        options.center_of_mass_m[1],
        pad.base_x_m,
        pad.base_y_m,
        errors.zero_m,
        errors.height_m,
    ];
    if !(options.arm_noise_sd_m >= 0.0 && options.arm_noise_sd_m.is_finite()) || numbers.iter().any(|v| !v.is_finite())
    {
        return out(
            "centre of mass, base of the pad, constant errors and noise of the arm must be finite, the noise not negative",
        );
    }
    if !(errors.scale > -0.5 && errors.scale < 1.0) {
        return out("the relative error of the pad's scale must be between -0.5 and 1");
    }
    Ok(())
}
