//! The closed forms (quadratures) that replace the differential equations 19 to 21 of Moll & Erdmann 2001 (`docs/theory.md`,
//! three closed forms).
//!
//! Between two jumps, virtual work gives the height of the centre of mass as a quadrature of the measurements,
//!
//! h' = (φ1' s1 sin φ12 − φ12' s2 sin φ1) / sin φ2,
//!
//! and balance gives its X coordinate without any integration. One unknown is left, h at the first sample. Given it, the contact
//! support functions (r1, d1) and (r2, d2) are known at every instant, and the orientation follows from r' = −d: d1 dψ = dr1 + d1
//! dφ1 and d2 dψ = dr2 + d2 dφ12, two equations for each step of ψ. Both vanish where the lines of force pass through the centre
//! of mass (d1 = d2 = 0, the singularities of eq. 21), so that all steps are solved for together by least squares, with a prior
//! on the change of the rotation from step to step (a tridiagonal system).

use crate::estimate::measurements::{Instant, Measurements};

/// Orientation and contact support functions at one instant, as integrated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Contact {
    pub psi: f64,
    pub r1: f64,
    pub d1: f64,
    pub r2: f64,
    pub d2: f64,
}

/// Orientation, contact support functions and size that follow from a trial height of the centre of mass.
#[derive(Clone, Debug)]
pub(crate) struct Integrated {
    pub psi: Vec<f64>,
    /// The same with the contact support functions at every instant.
    pub contacts: Vec<Contact>,
    /// Mean of r1 and r2 over all instants, metres.
    pub mean_r_m: f64,
}

/// Height of the centre of mass at every instant, above its value at the first (trapezoid rule).
pub(crate) fn relative_height(measurements: &Measurements) -> Vec<f64> {
    let slope1 = |i: &Instant| i.s1 * i.palms.sin12 / i.palms.sin2;
    let slope2 = |i: &Instant| i.s2 * i.palms.sin1 / i.palms.sin2;
    let mut height = Vec::with_capacity(measurements.len());
    height.push(0.0);
    for pair in measurements.instants.windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        let step1 = b.phi1 - a.phi1;
        let step12 = step1 + b.phi2 - a.phi2;
        let rise = 0.5 * (slope1(a) + slope1(b)) * step1 - 0.5 * (slope2(a) + slope2(b)) * step12;
        height.push(height[height.len() - 1] + rise);
    }
    height
}

/// Standard deviation of the change of the rotation from one step to the next that is expected at first, radians.
pub(crate) const RATE_SD: f64 = 0.01;

/// Prior information on each step itself, as a share of that on its change: the system stays regular where nothing determines ψ.
const STEP_INFORMATION: f64 = 1e-3;

/// Largest support function of an object between the palms, as a multiple of the distance of the contacts.
const LARGEST_SUPPORT: f64 = 6.0;

/// A palm whose support function depends on h0 by less than this (cosine of its angle) does not limit it.
const LEAST_SLOPE: f64 = 1e-9;

/// Range of heights h0 for which both palms support the object from below and it is no larger than palms could hold.
pub(crate) fn feasible_heights(measurements: &Measurements, relative: &[f64], size_m: f64) -> Option<(f64, f64)> {
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    for (instant, rise) in measurements.instants.iter().zip(relative) {
        let x = instant.balance_x();
        // 0 < r1 < 6 size and 0 < r2 < 6 size, each linear in h0.
        for (slope, constant) in [
            (instant.palms.cos1, rise * instant.palms.cos1 - x * instant.palms.sin1),
            (-instant.palms.cos12, -rise * instant.palms.cos12 + x * instant.palms.sin12),
        ] {
            if slope.abs() < LEAST_SLOPE {
                continue;
            }
            let (a, b) = (-constant / slope, (LARGEST_SUPPORT * size_m - constant) / slope);
            low = low.max(a.min(b));
            high = high.min(a.max(b));
        }
    }
    (low < high && low.is_finite() && high.is_finite()).then_some((low, high))
}

/// Contact support functions and orientation for a trial height `h0` of the first instant. `relative` comes from
/// [`relative_height`]; `noise_m` is the standard deviation of a contact position, `rate_sd` that of the change of the
/// rotation from one step to the next, radians.
pub(crate) fn integrate(
    measurements: &Measurements,
    relative: &[f64],
    h0: f64,
    noise_m: f64,
    rate_sd: f64,
) -> Integrated {
    let count = measurements.len();
    let (mut r1, mut d1) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let (mut r2, mut d2) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for (instant, rise) in measurements.instants.iter().zip(relative) {
        let (x, h) = (instant.balance_x(), h0 + rise);
        let r = instant.palms.supports_of_center([x, h]);
        let d = instant.palms.feet(r, [instant.s1, instant.s2]);
        r1.push(r[0]);
        r2.push(r[1]);
        d1.push(d[0]);
        d2.push(d[1]);
    }
    let steps = count.saturating_sub(1);
    // Normal equations of the steps: data on the diagonal, second differences off it (tridiagonal).
    let variance = 2.0 * noise_m * noise_m;
    let smooth = 1.0 / (rate_sd * rate_sd);
    let (mut diagonal, mut right) = (vec![STEP_INFORMATION * smooth; steps], vec![0.0; steps]);
    for i in 0..steps {
        let (a, b) = (&measurements.instants[i], &measurements.instants[i + 1]);
        let (turn1, turn12) = (b.phi1 - a.phi1, b.phi1 + b.phi2 - a.phi1 - a.phi2);
        let (m1, m2) = (0.5 * (d1[i] + d1[i + 1]), 0.5 * (d2[i] + d2[i + 1]));
        diagonal[i] += (m1 * m1 + m2 * m2) / variance;
        right[i] += (m1 * (r1[i + 1] - r1[i] + m1 * turn1) + m2 * (r2[i + 1] - r2[i] + m2 * turn12)) / variance;
        if i > 0 {
            diagonal[i] += smooth;
        }
        if i + 1 < steps {
            diagonal[i] += smooth;
        }
    }
    for i in 1..steps {
        let factor = -smooth / diagonal[i - 1];
        diagonal[i] += factor * smooth;
        right[i] -= factor * right[i - 1];
    }
    for i in (0..steps).rev() {
        let next = if i + 1 < steps { right[i + 1] } else { 0.0 };
        right[i] = (right[i] + smooth * next) / diagonal[i];
    }
    let mut psi = Vec::with_capacity(count);
    psi.push(0.0);
    for step in right {
        psi.push(psi[psi.len() - 1] + step);
    }
    let mean_r_m = r1.iter().chain(&r2).sum::<f64>() / (2 * count).max(1) as f64;
    let contacts = (0..psi.len().min(count))
        .map(|i| Contact { psi: psi[i], r1: r1[i], d1: d1[i], r2: r2[i], d2: d2[i] })
        .collect();
    Integrated { psi, contacts, mean_r_m }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::PalmMotion;
    use crate::shape::{NamedShape, SupportFunction};
    use crate::simulate::{SimulateOptions, Simulation, simulate};
    use std::f64::consts::TAU;

    const SIZE_M: f64 = 0.03;

    fn shape() -> SupportFunction {
        NamedShape::Pebble.shape(SIZE_M).expect("a positive size")
    }

    /// Part of a motion without a jump, at `count` samples, with the force lines well away from the centre of mass.
    fn run(count: usize) -> (Measurements, Simulation) {
        let motion = PalmMotion::through(&[(0.0, 1.2, 1.2), (12.0, 0.9, 1.4)])
            .and_then(|motion| motion.sample((count - 1) as f64 / 12.0))
            .expect("possible");
        let options = SimulateOptions { start_psi_rad: 4.0, ..SimulateOptions::default() };
        let run = simulate(&shape(), &motion, &options).expect("possible");
        assert!(run.jumps.is_empty() && run.log.samples.len() == count);
        for (sample, pose) in run.log.samples.iter().zip(&run.truth.motion) {
            assert!(shape().at(sample.palms.contact_angles(pose.psi_rad).0).d.abs() > 0.3 * SIZE_M);
        }
        (Measurements::new(&run.log, None), run)
    }

    fn heights(run: &Simulation) -> Vec<f64> {
        run.truth.motion.iter().map(|pose| pose.com_y_m).collect()
    }

    #[test]
    fn height_is_virtual_work_to_second_order() {
        let worst = |count: usize| {
            let (measurements, run) = run(count);
            let true_height = heights(&run);
            let relative = relative_height(&measurements);
            let off = relative.iter().zip(&true_height).map(|(rise, height)| (rise - (height - true_height[0])).abs());
            off.fold(0.0, f64::max)
        };
        let errors = [worst(101), worst(201), worst(401)];
        assert!(errors[0] < 1e-3 * SIZE_M, "{errors:?}");
        for pair in errors.windows(2) {
            // The error of the trapezoid rule falls by 4 when the step is halved.
            assert!((3.7..4.3).contains(&(pair[0] / pair[1])), "{errors:?}");
        }
    }

    #[test]
    fn heights_above_palms_apart_count_from_where_their_lines_meet() {
        // The same angles and object, once on a hinge and once with base points that lie out on the palms.
        let (measurements, run) = run(201);
        let moved: Vec<_> = run
            .log
            .samples
            .iter()
            .map(|sample| {
                // Base points slid along their own palms: s shrinks by as much, the meeting point stays.
                let mut sample = *sample;
                let (one, two) = (sample.palms.phi1_rad.sin_cos(), sample.palms.phi12_rad().sin_cos());
                sample.palms.base1_m = [0.01 * one.1, 0.01 * one.0];
                sample.palms.base2_m = [0.004 * two.1, 0.004 * two.0];
                sample.s1_m = sample.s1_m.map(|s| s - 0.01);
                sample.s2_m = sample.s2_m.map(|s| s - 0.004);
                sample
            })
            .collect();
        let apart = Measurements::new(&crate::Log { samples: moved }, None);
        for (a, b) in relative_height(&measurements).iter().zip(relative_height(&apart)) {
            assert!((a - b).abs() < 1e-14);
        }
    }

    #[test]
    fn the_true_height_is_feasible() {
        let (measurements, run) = run(201);
        let (low, high) =
            feasible_heights(&measurements, &relative_height(&measurements), SIZE_M).expect("an object is there");
        let truth = run.truth.motion[0].com_y_m;
        assert!(low < truth && truth < high, "{low} {truth} {high}");
        // And the bounds exclude something: an object of six times the size.
        assert!(low > 0.0 && high < 12.0 * SIZE_M, "{low} {high}");
    }

    #[test]
    fn a_log_that_contradicts_itself_has_no_feasible_height() {
        let (measurements, _) = run(201);
        let mut relative = relative_height(&measurements);
        // A rise by a hundred sizes half-way is more than the palms can hold.
        relative[100..].iter_mut().for_each(|rise| *rise += 100.0 * SIZE_M);
        assert_eq!(feasible_heights(&measurements, &relative, SIZE_M), None);
    }

    #[test]
    fn the_true_height_gives_the_true_motion_and_size() {
        let worst = |count: usize| {
            let (measurements, run) = run(count);
            let true_psi: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
            let turned = true_psi.iter().fold(0.0, |most, psi| f64::max(most, (psi - true_psi[0]).abs()));
            assert!(turned > 0.3, "the object must turn enough: {turned}");
            let found = integrate(&measurements, &relative_height(&measurements), heights(&run)[0], 1e-9, 0.01);
            let off = found.psi.iter().zip(&true_psi).map(|(found, truth)| (found - (truth - true_psi[0])).abs());
            let radii: Vec<f64> = run
                .log
                .samples
                .iter()
                .zip(&true_psi)
                .flat_map(|(sample, psi)| {
                    let (theta1, theta2) = sample.palms.contact_angles(*psi);
                    [shape().at(theta1).r, shape().at(theta2).r]
                })
                .collect();
            let mean = radii.iter().sum::<f64>() / radii.len() as f64;
            assert!((found.mean_r_m - mean).abs() < 1e-3 * SIZE_M, "{} {mean}", found.mean_r_m);
            off.fold(0.0, f64::max)
        };
        let errors = [worst(101), worst(201), worst(401)];
        assert!(errors[0] < 1.0f64.to_radians(), "{errors:?}");
        for pair in errors.windows(2) {
            assert!((3.4..4.6).contains(&(pair[0] / pair[1])), "{errors:?}");
        }
    }

    #[test]
    fn a_wrong_height_gives_a_different_motion() {
        // Otherwise the search over h0 could not find the right one.
        let (measurements, run) = run(201);
        let relative = relative_height(&measurements);
        let end = |h0: f64| integrate(&measurements, &relative, h0, 1e-7, 0.01).psi[200];
        let truth = heights(&run)[0];
        assert!((end(truth + 0.1 * SIZE_M) - end(truth)).rem_euclid(TAU) > 0.05);
    }
}
