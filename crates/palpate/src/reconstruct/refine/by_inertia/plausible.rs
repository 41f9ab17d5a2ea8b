//! How much of what balance misses the inertia of an object could be, by the accelerations of the motion that was found: a fit with inertia is worth
//! its time only where that is most of it. Slow palms with friction miss the balance by far more.

use crate::estimate::measurements::Measurements;
use crate::estimate::model::contact::{contacts, residuals};
use crate::mechanics::STANDARD_GRAVITY_M_PER_S2;

/// The accelerations of a motion that was found without inertia may be too small by this factor, and too late or too early by so many samples.
const UNDERESTIMATED: f64 = 3.0;
const MISPLACED: usize = 3;

/// The least share of the squared moments that balance misses which is left when inertia takes what it can. `gyration_m` is the radius of
/// gyration; ψ of each sample.
pub(super) fn least_share_left(
    measurements: &Measurements,
    times_s: &[f64],
    coefficients: &[f64],
    psi: &[f64],
    gyration_m: f64,
) -> f64 {
    let at = |index: usize| contacts(&measurements.instants[index], coefficients, psi[index]);
    let centers: Vec<[f64; 2]> =
        (0..psi.len()).map(|index| measurements.instants[index].palms.center(at(index).r)).collect();
    let acceleration = |index: usize, value: &dyn Fn(usize) -> f64| {
        let rate = |from: usize| (value(from + 1) - value(from)) / (times_s[from + 1] - times_s[from]);
        2.0 * (rate(index) - rate(index - 1)) / (times_s[index + 1] - times_s[index - 1])
    };
    let last = psi.len().saturating_sub(1);
    // |W| of the inertia is at most (k² |ψ''| sin φ₂ + |c''| (|d₁| + |d₂|))/g.
    let moment_m = |index: usize| {
        if index == 0 || index >= last {
            return 0.0;
        }
        let d = at(index).d;
        let turn = acceleration(index, &|i| psi[i]).abs();
        let [x, y] = [0, 1].map(|axis| acceleration(index, &|i| centers[i][axis]));
        (gyration_m * gyration_m * turn + x.hypot(y) * (d[0].abs() + d[1].abs())) / STANDARD_GRAVITY_M_PER_S2
    };
    let possible_m: Vec<f64> = (0..psi.len()).map(moment_m).collect();
    let (mut missed, mut left) = (0.0, 0.0);
    for (index, (instant, psi)) in measurements.instants.iter().zip(psi).enumerate() {
        let missed_m = residuals(instant, coefficients, *psi).value[2].abs();
        let around = index.saturating_sub(MISPLACED)..=(index + MISPLACED).min(last);
        let most_m = UNDERESTIMATED * possible_m[around].iter().copied().fold(0.0, f64::max);
        missed += missed_m * missed_m;
        left += (missed_m - most_m).max(0.0).powi(2);
    }
    if missed > 0.0 { left / missed } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::super::MOST_LEFT;
    use super::*;
    use crate::palms::PalmMotion;
    use crate::sensor::Touchpad;
    use crate::shape::SupportFunction;
    use crate::simulate::{ObjectInertia, SimulateOptions, simulate};

    /// What is left of the balance that a simulated object misses.
    fn left(speed: f64, friction: [f64; 2], inertia: Option<ObjectInertia>) -> f64 {
        let shape = SupportFunction::new(0.03, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]]);
        let motion = PalmMotion::random(3, 40.0 / speed, 0.5).and_then(|motion| motion.sample(10.0 * speed));
        let options = SimulateOptions { touchpad: Touchpad::ideal(), friction, inertia, ..SimulateOptions::default() };
        let run = simulate(&shape, &motion.expect("possible"), &options).expect("possible");
        let psi: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        let times_s: Vec<f64> = run.log.samples.iter().map(|sample| sample.time_s).collect();
        let gyration_m = shape.uniform_gyration_radius_m();
        least_share_left(&Measurements::new(&run.log, None), &times_s, &shape.coefficients(), &psi, gyration_m)
    }

    #[test]
    fn inertia_may_be_all_that_fast_palms_miss_and_little_of_what_friction_does() {
        let inertia = Some(ObjectInertia { gyration_radius_m: None, damping_per_s: 0.3 });
        for speed in [2.0, 5.0, 10.0] {
            let left = left(speed, [0.0; 2], inertia);
            assert!(left < MOST_LEFT, "{speed}: {left}");
        }
        for friction in [[0.05; 2], [0.3, 0.1]] {
            let left = left(1.0, friction, None);
            assert!(left > MOST_LEFT, "{friction:?}: {left}");
        }
    }
}
