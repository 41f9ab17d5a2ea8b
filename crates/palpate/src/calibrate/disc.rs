//! A disc of known radius: a circle touches both palms as far from where they meet, r / tan(φ₂ / 2), whatever its orientation. So it tells the
//! scales and surface offsets too, as far as its radius tells them apart, but not where gravity is.

use super::{Contribution, RigCalibration};
use crate::estimate::calibration::{constants, prior_sd};
use crate::log::{Log, Sample};
use crate::math::statistics::typical_sd;
use crate::reconstruct::{ConstantEstimate, Verdict};
use crate::sensor::{Calibration, Rig, Tolerances};
use nalgebra::{SMatrix, SVector};

/// Zeros, scales, the zero of φ₂, surfaces, and the clock.
const UNKNOWNS: usize = 8;
type Vector = SVector<f64, UNKNOWNS>;
type Matrix = SMatrix<f64, UNKNOWNS, UNKNOWNS>;

/// Rounds of Gauss-Newton, from the stated constants: the residuals are nearly linear in them.
const ROUNDS: usize = 12;
/// Readings further off than this many typical ones are left out: fingers, drop-outs, a disc that was lifted.
const OUTLIER_SDS: f64 = 5.0;
/// Fewest readings of both pads of all logs.
const FEWEST_READINGS: usize = 24;
/// Least standard deviation of a reading: exact logs keep their weights finite.
const LEAST_SD_M: f64 = 1e-7;

/// Why discs tell nothing.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DiscError {
    /// Too few readings.
    #[error("the logs hold {readings} readings of the disc; {FEWEST_READINGS} are needed")]
    TooFewReadings {
        /// So many there are.
        readings: usize,
    },
    /// No radius.
    #[error("the radius of the disc must be a positive number of metres, not {0}")]
    BadRadius(f64),
    /// The readings are those of another disc, or of a rig that is far from what was stated.
    #[error(
        "the readings suggest a disc of {suggested_mm:.1} mm; check --known-radius-mm, or the scales and surface offsets of the rig file"
    )]
    OtherRadius {
        /// The radius with the constants as stated, millimetres.
        suggested_mm: f64,
    },
    /// The readings are not those of such a disc.
    #[error(
        "the readings are not those of a disc of this radius: {left_mm:.2} mm are left in them; check the radius, its unit, and that the object is round"
    )]
    NoDisc {
        /// What is left, millimetres.
        left_mm: f64,
    },
}

/// What may be left in the readings of a disc, as a share of its radius: more is no disc of that radius.
const LARGEST_RESIDUAL: f64 = 0.03;

/// A size that is further off than this many of its standard deviations is a mistake: of the radius, or in the rig file.
const OTHER_SDS: f64 = 5.0;

/// Calibrates a rig by logs of a disc of known radius (metres), which may roll, slide and turn as it likes.
///
/// # Errors
/// [`DiscError`]
pub fn calibrate_with_disc(logs: &[Log], radius_m: f64, rig: &Rig) -> Result<RigCalibration, DiscError> {
    if !(radius_m.is_finite() && radius_m > 0.0) {
        return Err(DiscError::BadRadius(radius_m));
    }
    let all: Vec<&Log> = logs.iter().collect();
    let now = fitted(&all, radius_m, rig)?;
    let left = |log: &Log, calibration: &Calibration| {
        let left = residuals(&[log], radius_m, calibration);
        (!left.is_empty()).then(|| typical_sd(left.iter()))
    };
    let contribution = |log: &Log| Contribution {
        is_used: true,
        verdict: Verdict::default(),
        failure: None,
        constants: fitted(&[log], radius_m, rig).map_or_else(|_| Vec::new(), |alone| estimates(rig, &alone)),
        residual_before_m: left(log, &rig.calibration),
        residual_after_m: left(log, &now.calibration),
        drift: None,
    };
    let constants = estimates(rig, &now);
    Ok(RigCalibration { rig: now, constants, logs: logs.iter().map(contribution).collect() })
}

/// The constants of a rig as estimates from another.
fn estimates(before: &Rig, now: &Rig) -> Vec<ConstantEstimate> {
    ConstantEstimate::all(before, constants(&now.calibration), prior_sd(&now.tolerances))
}

/// The rig with these constants.
fn known(rig: &Rig, found: &Vector, covariance: &Matrix) -> Rig {
    let variance_of = |difference: &Vector| difference.dot(&(covariance * difference)).max(0.0);
    let unit = |k: usize| Vector::from_fn(|other, _| if other == k { 1.0 } else { 0.0 });
    let sd = |k: usize| variance_of(&unit(k)).sqrt();
    let difference_sd = |one: usize, two: usize| variance_of(&(unit(one) - unit(two))).sqrt();
    let mut tolerances = rig.tolerances;
    tolerances.zero_sd_m = [sd(0), sd(1)];
    tolerances.scale_sd = [sd(2), sd(3)];
    tolerances.angle_zero_sd_rad[1] = sd(4);
    tolerances.surface_sd_m = [sd(5), sd(6)];
    tolerances.clock_offset_sd_s = sd(7);
    tolerances.scale_ratio_sd = Some(difference_sd(2, 3));
    tolerances.surface_difference_sd_m = Some(difference_sd(5, 6));
    Rig::new(of_vector(found, &rig.calibration), tolerances)
}

fn to_vector(calibration: &Calibration) -> Vector {
    let Calibration { zero_m, scale, angle_zero_rad, surface_m, clock_offset_s } = *calibration;
    let values =
        [zero_m[0], zero_m[1], scale[0], scale[1], angle_zero_rad[1], surface_m[0], surface_m[1], clock_offset_s];
    Vector::from(values)
}

fn of_vector(vector: &Vector, stated: &Calibration) -> Calibration {
    Calibration {
        zero_m: [vector[0], vector[1]],
        scale: [vector[2], vector[3]],
        angle_zero_rad: [stated.angle_zero_rad[0], vector[4]],
        surface_m: [vector[5], vector[6]],
        clock_offset_s: vector[7],
    }
}

fn prior_sds(tolerances: &Tolerances) -> Vector {
    let Tolerances { zero_sd_m, scale_sd, angle_zero_sd_rad, surface_sd_m, clock_offset_sd_s, .. } = *tolerances;
    let values = [
        zero_sd_m[0],
        zero_sd_m[1],
        scale_sd[0],
        scale_sd[1],
        angle_zero_sd_rad[1],
        surface_sd_m[0],
        surface_sd_m[1],
        clock_offset_sd_s,
    ];
    Vector::from(values)
}

/// Readings less those of the disc, of all logs in order, metres. (Corrected positions would seem the better for a larger scale.)
fn residuals(logs: &[&Log], radius_m: f64, calibration: &Calibration) -> Vec<f64> {
    let of_sample = |sample: &Sample| {
        let angles = sample.palms.angles();
        let expected = angles.positions([radius_m; 2], [0.0; 2]);
        let bases = sample.palms.base_shifts_m(&angles);
        let scale = calibration.scale;
        let off = |palm: usize, s: Option<f64>| s.map(|s| scale[palm] * (s + bases[palm] - expected[palm]));
        [off(0, sample.s1_m), off(1, sample.s2_m)]
    };
    let of_log =
        |log: &&Log| calibration.corrected(log).samples.iter().flat_map(of_sample).flatten().collect::<Vec<f64>>();
    logs.iter().flat_map(of_log).collect()
}

/// The rig as these logs have it.
fn fitted(logs: &[&Log], radius_m: f64, rig: &Rig) -> Result<Rig, DiscError> {
    let (stated, sds) = (to_vector(&rig.calibration), prior_sds(&rig.tolerances));
    let mut found = stated;
    let mut last = None;
    for _ in 0..ROUNDS {
        let at = |vector: &Vector| residuals(logs, radius_m, &of_vector(vector, &rig.calibration));
        let left = at(&found);
        if left.len() < FEWEST_READINGS {
            return Err(DiscError::TooFewReadings { readings: left.len() });
        }
        let sd_m = typical_sd(left.iter()).max(LEAST_SD_M);
        // In units of the priors, by differences of a thousandth of them.
        let step = 1e-3;
        let slopes: Vec<Vec<f64>> = (0..UNKNOWNS)
            .map(|k| {
                let moved = |sign: f64| {
                    let mut moved = found;
                    moved[k] += sign * step * sds[k];
                    at(&moved)
                };
                moved(1.0).iter().zip(moved(-1.0)).map(|(plus, minus)| (plus - minus) / (2.0 * step)).collect()
            })
            .collect();
        let mut information = Matrix::identity();
        let mut pull = Vector::from_fn(|k, _| if sds[k] > 0.0 { (found[k] - stated[k]) / sds[k] } else { 0.0 });
        for (index, left) in left.iter().enumerate().filter(|(_, left)| left.abs() < OUTLIER_SDS * sd_m) {
            let slope = Vector::from_fn(|k, _| slopes[k][index] / sd_m);
            information += slope * slope.transpose();
            pull += slope * (left / sd_m);
        }
        let Some(covariance) = information.try_inverse() else { break };
        found -= (covariance * pull).component_mul(&sds);
        last = Some((Matrix::from_fn(|i, j| covariance[(i, j)] * sds[i] * sds[j]), sd_m));
    }
    let (covariance, sd_m) = last.ok_or(DiscError::TooFewReadings { readings: 0 })?;
    if sd_m > LARGEST_RESIDUAL * radius_m {
        return Err(DiscError::NoDisc { left_mm: 1e3 * sd_m });
    }
    // In units of what is stated of the size at this radius.
    let [scale, surface_m] =
        [0.5 * (found[2] + found[3] - stated[2] - stated[3]), 0.5 * (found[5] + found[6] - stated[5] - stated[6])];
    let suggested_m = radius_m * (1.0 + scale) + surface_m;
    let stated_sd_m = (radius_m * sds[2].max(sds[3])).hypot(sds[5].max(sds[6]));
    if (suggested_m - radius_m).abs() > OTHER_SDS * stated_sd_m {
        return Err(DiscError::OtherRadius { suggested_mm: 1e3 * suggested_m });
    }
    Ok(known(rig, &found, &covariance))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::PalmPair;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;

    const RADIUS_M: f64 = 0.02;

    fn disc(seed: u64, truth: &Calibration) -> Log {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let sample = |index: u32| {
            let t = 0.05 * f64::from(index);
            let palms = PalmPair::hinged(0.5 + 0.2 * t.sin(), 1.4 + 0.7 * (0.9 * t).sin());
            let [s1, s2] = palms.angles().positions([RADIUS_M; 2], [0.0; 2]);
            let mut noise = || 5e-5 * rng.sample::<f64, _>(StandardNormal);
            Sample::new(t, palms, s1 + noise(), s2 + noise())
        };
        let mut log = truth.distorted(&Log { samples: (0..400).map(sample).collect() });
        log.samples[17].s1_m = Some(0.3);
        log
    }

    #[test]
    fn constants_of_discs_come_out_within_their_error_bars_and_the_size_gains() {
        let tolerances = Tolerances { clock_offset_sd_s: 0.01, ..Tolerances::default() };
        let rig = Rig::new(Calibration::default(), tolerances);
        for seed in 0..6 {
            let truth = rig.drawn(seed);
            let logs = [disc(seed, &truth), disc(seed + 100, &truth)];
            let found = calibrate_with_disc(&logs, RADIUS_M, &rig).expect("a disc");
            let (now, sds) = (to_vector(&found.rig.calibration), prior_sds(&found.rig.tolerances));
            for k in 0..UNKNOWNS {
                let truth = to_vector(&truth)[k];
                assert!((now[k] - truth).abs() < 4.0 * sds[k], "seed {seed}, {k}: {} {truth} {}", now[k], sds[k]);
            }
            assert!(found.rig.tolerances.zero_sd_m[0] < 1e-4 && found.rig.tolerances.angle_zero_sd_rad[1] < 2e-3);
            assert!(found.rig.size_sd() < rig.size_sd() && found.rig.offset_sd_m() < 0.8 * rig.offset_sd_m());
            let after = found.logs[0].residual_after_m.expect("readings");
            assert!(after < 6e-5 && found.logs[0].residual_before_m.expect("readings") > 2.0 * after);
        }
    }

    #[test]
    fn another_object_or_radius_is_refused() {
        let rig = Rig::uncalibrated();
        let log = disc(1, &Calibration::default());
        let of_radius = |radius_m| calibrate_with_disc(std::slice::from_ref(&log), radius_m, &rig);
        assert!(
            matches!(of_radius(0.03), Err(DiscError::OtherRadius { suggested_mm }) if (suggested_mm - 20.0).abs() < 1.0),
            "{:?}",
            of_radius(0.03)
        );
        assert!(of_radius(0.0205).is_ok());
        let noise = |index: usize| Some(0.03 + 0.02 * (1.7 * index as f64).sin());
        let mut other = log.clone();
        other.samples.iter_mut().enumerate().for_each(|(index, sample)| {
            (sample.s1_m, sample.s2_m) = (noise(index), noise(2 * index + 1));
        });
        assert!(matches!(calibrate_with_disc(&[other], RADIUS_M, &rig), Err(DiscError::NoDisc { .. })));
        assert!(matches!(calibrate_with_disc(std::slice::from_ref(&log), 0.0, &rig), Err(DiscError::BadRadius(_))));
        let short = Log { samples: log.samples[..5].to_vec() };
        assert!(matches!(
            calibrate_with_disc(&[short], RADIUS_M, &rig),
            Err(DiscError::TooFewReadings { readings: 10 })
        ));
    }
}
