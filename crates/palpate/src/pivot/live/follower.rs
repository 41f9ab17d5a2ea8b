//! Follows the contact over a believed shape: the cheapest paths to each angle of a grid, reading by reading, and whether the newest readings still agree
//! with the shape.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::math::angle::wrapped;
use crate::pivot::calibration::{PivotCalibration, Reading};
use crate::pivot::decode::{Forward, Table};
use crate::pivot::log::PivotSample;
use crate::pivot::motion_prior::LEAP_NATS;
use crate::pivot::posterior::PivotPosterior;
use crate::pivot::result::PivotReconstruction;
use crate::pivot::rig::PadPose;
use crate::pivot::segments::LIFTED_SAMPLES;
use crate::pivot::smoother::Noise;
use crate::pivot::verdict::MODEL_ALLOWANCE;

/// The newest readings contradict the shape when their mean squared distance across its curve, in standard deviations (one is expected), is larger …
const CONTRADICTED: f64 = 6.0;
const EXPECTED: f64 = 1.0;

/// … over so many readings, …
const MEMORY: f64 = 20.0;

/// … of which none counts for more: a gross error contradicts nothing.
const MOST_SQUARE: f64 = 25.0;

/// Angles that are farther from the likeliest than so many of its standard deviations are others, and not part of that.
const ELSEWHERE_SDS: f64 = 4.0;

/// The contact at one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Angle {
    pub theta_rad: f64,
    pub psi_rad: f64,
    pub sd_rad: f64,
}

/// What a sample says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Followed {
    pub angle: Option<Angle>,
    pub is_on_unfelt: bool,
    pub is_contradicted: bool,
}

/// The contact on its way over a shape.
#[derive(Clone, Debug)]
pub(super) struct Follower {
    pad: PadPose,
    calibration: PivotCalibration,
    posterior: PivotPosterior,
    table: Table,
    /// Whether each angle of the outline was felt.
    is_felt: Vec<bool>,
    /// Of the stroke so far; `None` before the first contact and after a lift.
    forward: Option<Forward>,
    without_contact: usize,
    /// Mean squared distance of the newest readings.
    strain: f64,
}

impl Follower {
    /// By a result, and the posterior that came with it.
    pub fn new(found: &PivotReconstruction, posterior: &PivotPosterior, pad: &PadPose) -> Self {
        let least_m = MODEL_ALLOWANCE * found.shape.mean_radius_m();
        let noise = Noise { r_m: found.arm_sd_m.max(least_m), d_m: found.sensor_sd_m.max(least_m) };
        let variance = |theta_rad: f64, [r, d]: [f64; 2]| posterior.variance(theta_rad, [r / noise.r_m, d / noise.d_m]);
        Self {
            pad: *pad,
            calibration: found.calibration,
            posterior: posterior.clone(),
            table: Table::new(&found.shape.coefficients(), noise, variance),
            is_felt: found.outline.iter().map(|point| point.touches > 0).collect(),
            forward: None,
            without_contact: 0,
            strain: EXPECTED,
        }
    }

    /// Takes the next sample in.
    pub fn push(&mut self, sample: &PivotSample) -> Followed {
        let is_contradicted = |strain: f64| strain > CONTRADICTED;
        let Some(s_m) = sample.s_m else {
            self.without_contact += 1;
            if self.without_contact >= LIFTED_SAMPLES {
                self.forward = None;
            }
            return Followed { angle: None, is_on_unfelt: false, is_contradicted: is_contradicted(self.strain) };
        };
        self.without_contact = 0;
        let measured = Reading::new(&self.pad, sample.pivot_x_m, sample.pivot_y_m, s_m).measured(&self.calibration);
        let reading = [measured.r_m, measured.d_m];
        let forward = self.forward.get_or_insert_default();
        forward.push(&self.table, reading, LEAP_NATS);
        let node = forward.cheapest();
        let settled = self.table.settled(node, reading);
        let place = (settled.theta_rad.rem_euclid(TAU) / TAU * self.is_felt.len() as f64) as usize;
        let is_on_unfelt = !self.is_felt.get(place).copied().unwrap_or(false);
        if is_on_unfelt {
            return Followed { angle: None, is_on_unfelt, is_contradicted: is_contradicted(self.strain) };
        }
        self.strain += (settled.square.min(MOST_SQUARE) - self.strain) / MEMORY;
        // What the shape leaves open along its curve moves the angle too.
        let by_shape = self.posterior.variance(settled.theta_rad, settled.along);
        let own = settled.variance + by_shape;
        let sd_rad = with_others(own, forward, node);
        let tilt_rad = self.pad.tilt_rad + self.calibration.tilt_rad;
        let angle = Angle {
            theta_rad: settled.theta_rad.rem_euclid(TAU),
            psi_rad: wrapped(tilt_rad - FRAC_PI_2 - settled.theta_rad),
            sd_rad,
        };
        Followed { angle: Some(angle), is_on_unfelt, is_contradicted: is_contradicted(self.strain) }
    }
}

/// Standard deviation of an angle with this variance, where the others that explain the newest samples count too.
fn with_others(own: f64, forward: &Forward, node: usize) -> f64 {
    own.sqrt().hypot(forward.elsewhere_rad(node, ELSEWHERE_SDS * own.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pivot::reconstruct::{PivotOptions, reconstruct_with_posterior};
    use crate::pivot::simulate::{PivotSimulateOptions, Stroke, simulate_strokes};
    use crate::shape::SupportFunction;

    fn pebble(scale: f64) -> SupportFunction {
        SupportFunction::new(0.03, vec![[0.003, 0.002], [scale * 0.002, -0.001], [0.0004, 0.0006]])
    }

    fn felt(shape: &SupportFunction, to_m: f64) -> crate::pivot::PivotSimulation {
        let options = PivotSimulateOptions { friction: 0.8, ..PivotSimulateOptions::default() };
        let strokes = [0.5 + to_m, 0.5 - to_m].map(|to_m| Stroke { along_m: vec![0.5, to_m], press: 3.0 });
        simulate_strokes(shape, &strokes, &options).expect("it runs")
    }

    #[test]
    fn the_contact_is_followed_until_another_object_contradicts_the_shape() {
        let known = felt(&pebble(1.0), 0.15);
        let (found, posterior) = reconstruct_with_posterior(&known.log, &PivotOptions::default()).expect("a result");
        let mut follower = Follower::new(&found, &posterior, &PadPose::default());
        let mut off = Vec::new();
        for (sample, truth) in known.log.samples.iter().zip(&known.truth.motion) {
            let followed = follower.push(sample);
            assert!(!followed.is_contradicted);
            off.extend(followed.angle.map(|angle| (wrapped(angle.psi_rad - truth.psi_rad), angle.sd_rad)));
        }
        assert!(off.len() > 200, "{}", off.len());
        let first = off[0].0;
        assert!(off.iter().all(|(off, sd)| wrapped(off - first).abs() < 4.0 * sd.hypot(2e-3)), "{off:?}");
        let other = felt(&pebble(2.0), 0.15);
        let contradicted = other.log.samples.iter().filter(|sample| follower.push(sample).is_contradicted).count();
        assert!(contradicted > 100, "{contradicted}");
    }

    #[test]
    fn strain_decides_on_both_sides_of_its_limit() {
        let known = felt(&pebble(1.0), 0.15);
        let (found, posterior) = reconstruct_with_posterior(&known.log, &PivotOptions::default()).expect("a result");
        let mut follower = Follower::new(&found, &posterior, &PadPose::default());
        let lifted = PivotSample { time_s: 0.0, pivot_x_m: 0.5, pivot_y_m: 0.1, s_m: None };
        follower.strain = 0.99 * CONTRADICTED;
        assert!(!follower.push(&lifted).is_contradicted);
        follower.strain = 1.01 * CONTRADICTED;
        assert!(follower.push(&lifted).is_contradicted);
    }

    #[test]
    fn another_angle_counts_beyond_so_many_standard_deviations() {
        let step_rad = TAU / 720.0;
        let forward = Forward::of_two(100, 110);
        let with = |sds: f64| with_others((10.0 * step_rad / sds).powi(2), &forward, 100);
        // Half of the time it is ten steps away.
        let there = 10.0 * step_rad * 0.5_f64.sqrt();
        assert!((with(1.01 * ELSEWHERE_SDS) - there.hypot(10.0 * step_rad / (1.01 * ELSEWHERE_SDS))).abs() < 1e-12);
        assert!((with(0.99 * ELSEWHERE_SDS) - 10.0 * step_rad / (0.99 * ELSEWHERE_SDS)).abs() < 1e-12);
    }

    #[test]
    fn four_gross_errors_in_a_row_contradict_nothing_and_five_do() {
        let known = felt(&pebble(1.0), 0.15);
        let (found, posterior) = reconstruct_with_posterior(&known.log, &PivotOptions::default()).expect("a result");
        let mut follower = Follower::new(&found, &posterior, &PadPose::default());
        let samples = &known.log.samples[..60];
        samples.iter().for_each(|sample| assert!(!follower.push(sample).is_contradicted));
        follower.strain = EXPECTED;
        // No boundary is within two metres of the pivot.
        let gross = |sample: &PivotSample| PivotSample { s_m: sample.s_m.map(|s_m| s_m + 2.0), ..*sample };
        let last = samples.last().expect("sixty");
        let contradicted: Vec<bool> = (0..5).map(|_| follower.push(&gross(last)).is_contradicted).collect();
        assert_eq!(contradicted, [false, false, false, false, true]);
    }

    #[test]
    fn boundary_that_was_not_felt_tells_no_angle() {
        let known = felt(&pebble(1.0), 0.04);
        let (found, posterior) = reconstruct_with_posterior(&known.log, &PivotOptions::default()).expect("a result");
        let mut follower = Follower::new(&found, &posterior, &PadPose::default());
        let far = felt(&pebble(1.0), 0.15);
        let unfelt = far.log.samples.iter().filter(|sample| follower.push(sample).is_on_unfelt).count();
        assert!(unfelt > 50, "{unfelt}");
    }

    /// Strokes over an object, and others over the same object.
    fn twice(shape: &SupportFunction, seed: u64) -> [crate::pivot::PivotSimulation; 2] {
        let touchpad = crate::sensor::Touchpad { noise_sd_m: 1e-4, length_m: 1.0, ..crate::sensor::Touchpad::ideal() };
        let felt = |seed: u64, to_m: [f64; 4]| {
            let options = PivotSimulateOptions {
                touchpad,
                arm_noise_sd_m: 2e-5,
                friction: 0.4,
                seed,
                ..PivotSimulateOptions::default()
            };
            let strokes = to_m.map(|to_m| Stroke { along_m: vec![0.5, to_m], press: 3.0 });
            simulate_strokes(shape, &strokes, &options).expect("it runs")
        };
        [felt(seed, [0.65, 0.35, 0.7, 0.3]), felt(seed + 1, [0.63, 0.36, 0.68, 0.34])]
    }

    #[test]
    fn angles_are_as_exact_as_their_error_bars_say() {
        let objects = [
            pebble(1.0),
            pebble(1.7),
            SupportFunction::new(0.03, vec![[0.004, -0.003], [0.001, 0.002], [0.0, 0.0006], [0.0003, 0.0]]),
            SupportFunction::new(0.025, vec![[0.006, 0.001], [-0.001, 0.0015], [0.0008, 0.0], [0.0, 0.0002]]),
        ];
        let (mut all, mut within) = (0, 0);
        for (shape, seed) in objects.iter().flat_map(|shape| [11, 21, 31, 41].map(|seed| (shape, seed))) {
            let [known, next] = twice(shape, seed);
            let (found, posterior) =
                reconstruct_with_posterior(&known.log, &PivotOptions::default()).expect("a result");
            assert!(found.is_certified(), "{:?}", found.doubts);
            let mut follower = Follower::new(&found, &posterior, &PadPose::default());
            let mut off = Vec::new();
            for (sample, truth) in next.log.samples.iter().zip(&next.truth.motion) {
                let angle = follower.push(sample).angle;
                off.extend(angle.map(|angle| (wrapped(angle.psi_rad - truth.psi_rad), angle.sd_rad)));
            }
            let turn = crate::math::angle::mean_direction(off.iter().map(|(off, _)| *off));
            let rest: Vec<(f64, f64)> = off.iter().map(|(off, sd)| (wrapped(off - turn).abs(), *sd)).collect();
            let near = rest.iter().filter(|(off, sd)| *off < 2.0 * sd).count();
            (all, within) = (all + rest.len(), within + near);
        }
        assert!(all > 800 && (0.93..0.99).contains(&(within as f64 / all as f64)), "{within} of {all}");
    }
}
