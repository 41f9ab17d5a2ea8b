//! Objects with inertia: the simulation against conservation laws, closed forms and slow palms; and their logs reconstructed.

use palpate::mechanics::{EnergyLandscape, STANDARD_GRAVITY_M_PER_S2};
use palpate::palms::{PalmMotion, PalmPair};
use palpate::reconstruct::Reconstructor;
use palpate::sensor::{Calibration, Rig, Touchpad};
use palpate::shape::SupportFunction;
use palpate::simulate::{ObjectInertia, SimulateError, SimulateOptions, Simulation, simulate};
use palpate::{Log, compare::compare};

const MASS_KG: f64 = 0.2;
const GYRATION_M: f64 = 0.022;

fn shape() -> SupportFunction {
    SupportFunction::new(0.03, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]])
}

/// Palms that swing, so many times faster than in a minute.
fn swinging(speed: f64, rate_hz: f64) -> Vec<(f64, PalmPair)> {
    let duration_s = 60.0 / speed;
    let at = |index: u32| {
        let time_s = f64::from(index) / rate_hz;
        let t = speed * time_s;
        (time_s, PalmPair::hinged(0.9 + 0.35 * (0.31 * t).sin(), 1.2 + 0.3 * (0.47 * t + 0.5).sin()))
    };
    (0..=(duration_s * rate_hz) as u32).map(at).collect()
}

fn with_inertia(damping_per_s: f64) -> SimulateOptions {
    let inertia = ObjectInertia { gyration_radius_m: Some(GYRATION_M), damping_per_s };
    SimulateOptions { inertia: Some(inertia), mass_kg: MASS_KG, with_forces: true, ..SimulateOptions::default() }
}

fn simulated(motion: &[(f64, PalmPair)], options: &SimulateOptions) -> Simulation {
    simulate(&shape(), motion, options).expect("the palms hold the object")
}

#[test]
fn the_energy_grows_by_the_work_of_the_palms() {
    let motion = swinging(8.0, 2000.0);
    let run = simulated(&motion, &with_inertia(0.0));
    let (poses, step_s) = (&run.truth.motion, 1.0 / 2000.0);
    // Rates to the fourth order.
    let rate = |of: &dyn Fn(usize) -> f64, i: usize| {
        (8.0 * (of(i + 1) - of(i - 1)) - (of(i + 2) - of(i - 2))) / (12.0 * step_s)
    };
    let energy_j = |i: usize| {
        let velocity = [rate(&|j| poses[j].com_x_m, i), rate(&|j| poses[j].com_y_m, i)];
        let turning = GYRATION_M * rate(&|j| poses[j].psi_rad, i);
        let kinetic = 0.5 * (velocity[0].powi(2) + velocity[1].powi(2) + turning.powi(2));
        [MASS_KG * kinetic, MASS_KG * (kinetic + STANDARD_GRAVITY_M_PER_S2 * poses[i].com_y_m)]
    };
    // The palms push at their contacts, which they move across.
    let power_w = |i: usize| {
        let sample = &run.log.samples[i];
        let push = |force: Option<f64>, s: Option<f64>| force.expect("a force") * s.expect("a contact");
        push(sample.force1_n, sample.s1_m) * rate(&|j| motion[j].1.phi1_rad, i)
            - push(sample.force2_n, sample.s2_m) * rate(&|j| motion[j].1.phi12_rad(), i)
    };
    let (first, last) = (10, poses.len() - 11);
    // Simpson's rule.
    let work_j: f64 =
        (first..last).step_by(2).map(|i| step_s / 3.0 * (power_w(i) + 4.0 * power_w(i + 1) + power_w(i + 2))).sum();
    let last = first + 2 * (last - first).div_ceil(2);
    let gained_j = energy_j(last)[1] - energy_j(first)[1];
    let largest_j = (first..last).map(|i| energy_j(i)[0]).fold(0.0, f64::max);
    assert!((work_j - gained_j).abs() < 1e-6 * largest_j.max(gained_j.abs()), "{work_j} {gained_j} {largest_j}");
    assert!(largest_j > 1e-5, "hardly moved");
}

#[test]
fn a_small_swing_has_the_frequency_of_its_pose() {
    // A push within 50 ms, then the palms stay.
    let push = |t: f64| if t < 0.05 { 2e-3 * (1.0 - (std::f64::consts::PI * t / 0.05).cos()) } else { 4e-3 };
    let motion: Vec<(f64, PalmPair)> =
        (0..8000).map(|i| 5e-4 * f64::from(i)).map(|t| (t, PalmPair::hinged(0.7 + push(t), 1.4))).collect();
    let run = simulated(&motion, &with_inertia(0.0));
    let palms = PalmPair::hinged(0.704, 1.4);
    let psi: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
    let rest = EnergyLandscape::new(&shape(), &palms).descend(psi[200]);
    let crossings: Vec<f64> = (200..psi.len() - 1)
        .filter(|&i| psi[i] < rest && psi[i + 1] >= rest)
        .map(|i| motion[i].0 + 5e-4 * (rest - psi[i]) / (psi[i + 1] - psi[i]))
        .collect();
    let swings = crossings.len() - 1;
    let period_s = (crossings[swings] - crossings[0]) / swings as f64;
    // ω² = g h''/(k² + |dc/dψ|²).
    const STEP: f64 = 1e-4;
    let landscape = EnergyLandscape::new(&shape(), &palms);
    let height = |psi: f64| landscape.height_m(psi);
    let bend_m = (height(rest + STEP) - 2.0 * height(rest) + height(rest - STEP)) / (STEP * STEP);
    let center = |psi: f64| {
        let (theta1, theta2) = palms.contact_angles(psi);
        palms.center_of_mass_m(shape().at(theta1), shape().at(theta2))
    };
    let (before, after) = (center(rest - STEP), center(rest + STEP));
    let path_m = (after[0] - before[0]).hypot(after[1] - before[1]) / (2.0 * STEP);
    let frequency = (STANDARD_GRAVITY_M_PER_S2 * bend_m / (GYRATION_M.powi(2) + path_m.powi(2))).sqrt();
    assert!(swings >= 2 && psi[200..].iter().any(|psi| (psi - rest).abs() > 1e-4), "{swings} swings");
    assert!((frequency * period_s / std::f64::consts::TAU - 1.0).abs() < 1e-3, "{frequency} {period_s}");
}

#[test]
fn slow_palms_leave_no_trace_of_inertia() {
    let motion = swinging(0.5, 20.0);
    let at_rest = simulated(&motion, &SimulateOptions { inertia: None, ..with_inertia(0.0) });
    let slow = simulated(&motion, &with_inertia(2.0));
    // It rings for some seconds at the start and after its only jump.
    let [jump] = &at_rest.jumps[..] else { panic!("{:?}", at_rest.jumps) };
    let settled = |time_s: f64| time_s > 5.0 && !(jump.time_s - 2.0..jump.time_s + 10.0).contains(&time_s);
    for (still, slow) in at_rest.truth.motion.iter().zip(&slow.truth.motion).filter(|(pose, _)| settled(pose.time_s)) {
        assert!(
            (still.psi_rad - slow.psi_rad).abs() < 1.5e-3,
            "{} at {} s",
            still.psi_rad - slow.psi_rad,
            still.time_s
        );
    }
}

#[test]
fn an_object_that_is_thrown_loses_contact() {
    let thrown = simulate(&shape(), &swinging(60.0, 500.0), &with_inertia(0.0));
    assert!(matches!(thrown, Err(SimulateError::LosesContact { time_s, .. }) if time_s < 1.0), "{thrown:?}");
}

#[test]
fn what_is_not_simulated_is_refused() {
    let motion = swinging(1.0, 20.0);
    let refused = |options: SimulateOptions, words: &str| {
        let error = simulate(&shape(), &motion, &options).expect_err("out of range").to_string();
        assert!(error.contains(words), "{error}");
    };
    refused(SimulateOptions { friction: [0.1; 2], ..with_inertia(0.0) }, "friction and inertia");
    refused(with_inertia(-1.0), "damping");
    let inertia = ObjectInertia { gyration_radius_m: Some(0.0), damping_per_s: 0.0 };
    refused(SimulateOptions { inertia: Some(inertia), ..SimulateOptions::default() }, "radius of gyration");
}

/// A log of a random motion that takes so many seconds.
fn fast_log(seed: u64, duration_s: f64, rate_hz: f64) -> Simulation {
    let motion = PalmMotion::random(seed, duration_s, 0.6).and_then(|motion| motion.sample(rate_hz)).expect("possible");
    let touchpad = Touchpad { noise_sd_m: 5e-5, ..Touchpad::ideal() };
    simulated(&motion, &SimulateOptions { touchpad, seed, with_forces: false, ..with_inertia(0.3) })
}

/// That it is certified with its centre of mass, and right.
fn is_right(run: &Simulation, log: &Log, rig: Rig) {
    let found = Reconstructor::new().rig(rig).run(log).expect("a result");
    assert!(found.is_com_certified(), "{}", found.verdict);
    let inertia = found.inertia.expect("balance does not explain it");
    let off = (inertia.gyration_radius_m - GYRATION_M).abs();
    assert!(off < 4.0 * inertia.gyration_radius_sd_m && off < 0.02 * GYRATION_M, "{inertia:?}");
    assert!((inertia.damping_per_s - 0.3).abs() < 4.0 * inertia.damping_sd_per_s, "{inertia:?}");
    let errors = compare(&found, &run.truth).expect("comparable");
    assert!(errors.rms_r_m < 5e-5 && errors.rms_com_m < 5e-5 && errors.rms_psi_rad < 3e-3, "{errors:?}");
}

#[test]
fn fast_palms_are_certified_with_the_centre_of_mass() {
    let run = fast_log(3, 6.0, 100.0);
    is_right(&run, &run.log, Rig::default());
}

#[test]
fn fast_palms_tell_the_rig_as_well() {
    let run = fast_log(3, 6.0, 100.0);
    let mut off = Calibration::default();
    off.zero_m = [3e-4, -2e-4];
    off.angle_zero_rad = [3e-3, -4e-3];
    is_right(&run, &off.distorted(&run.log), Rig::uncalibrated());
}
