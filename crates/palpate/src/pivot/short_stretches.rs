//! Stretches too short for the fit, as an object leaves them that tips over and over: each is laid on the shape that the others tell where one rotation alone
//! explains its readings. They say where the object was, and nothing of the shape.

use crate::math::angle::wrapped;
use crate::pivot::association::{Known, Placement};
use crate::pivot::calibration::Reading;
use crate::pivot::rivals::ITSELF_RAD;
use crate::pivot::smoother::{Problem, State};
use crate::pivot::verdict::RIVAL_NATS;

/// A reading that its shape misses by more standard deviations is not explained.
const MOST_SDS: f64 = 5.0;

/// Contact angles of a stretch, which are known up to a rotation; `None` where no rotation, or more than one, explains its readings.
pub(super) fn placed(
    problem: &Problem,
    known: &Known,
    state: &State,
    readings: &[Reading],
    relative_rad: &[f64],
) -> Option<Vec<f64>> {
    let placements = known.placements(readings, relative_rad);
    let own = Problem { readings, between: None, ..problem.clone() };
    // Half the squared distance of each reading in standard deviations, and its contact angle.
    let settled = |placement: &Placement| -> Vec<(f64, f64)> {
        let turned = relative_rad.iter().enumerate();
        turned.map(|(index, theta_rad)| own.settled(state, index, theta_rad + placement.rotation_rad)).collect()
    };
    let (best, others) = placements.split_first()?;
    let angles = settled(best);
    // Placements are compared along tangents of the curve: two of them may be one.
    let is_elsewhere = |other: &Placement| {
        settled(other).iter().zip(&angles).any(|(other, best)| wrapped(other.1 - best.1).abs() > ITSELF_RAD)
    };
    let is_rival = |other: &&Placement| other.cost < best.cost + RIVAL_NATS;
    let is_explained = angles.iter().all(|(half_square, _)| 2.0 * half_square < MOST_SDS * MOST_SDS);
    let is_alone = !others.iter().filter(is_rival).any(is_elsewhere);
    (is_explained && is_alone).then(|| angles.into_iter().map(|(_, theta_rad)| theta_rad).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::model::contact::support;
    use crate::pivot::calibration::PivotCalibration;
    use crate::pivot::smoother::{Noise, across};
    use crate::shape::ContactSupport;

    const NOISE: Noise = Noise { r_m: 2e-5, d_m: 1e-4 };

    /// A shape that was felt all around, and a stretch of seven readings on it that are off its curve by so many
    /// standard deviations.
    fn laid(second_harmonic_m: f64, first_harmonic_m: f64, off_sds: f64) -> Option<Vec<f64>> {
        let coefficients = vec![0.03, first_harmonic_m, second_harmonic_m, 0.0, 0.0];
        let reading = |theta: f64, off_sds: f64| {
            let ContactSupport { r, d, v } = support(&coefficients, theta);
            let off = across([-d / NOISE.r_m, (r - v) / NOISE.d_m]).map(|off| off_sds * off);
            Reading { along_m: 0.5, above_m: r + off[0] * NOISE.r_m, s_m: 0.5 - d - off[1] * NOISE.d_m }
        };
        let theta_rad: Vec<f64> = (0..200).map(|index| 0.0314 * f64::from(index)).collect();
        let readings: Vec<Reading> = theta_rad.iter().map(|theta| reading(*theta, 0.0)).collect();
        let problem = Problem {
            readings: &readings,
            noise: NOISE,
            order: 2,
            size_m: 0.03,
            spread_m: 0.01,
            stated: PivotCalibration::default(),
            open: Vec::new(),
            between: None,
        };
        let state = State { coefficients: coefficients.clone(), told: [0.0; 3], theta_rad };
        let factor = problem.linearised(&state).factorised(&state.coefficients, 0.0)?;
        let known = Known::new(&problem, &state, &factor);
        let relative_rad: Vec<f64> = (0..7).map(|index| 0.08 * f64::from(index)).collect();
        let short: Vec<Reading> = relative_rad.iter().map(|theta| reading(0.7 + theta, off_sds)).collect();
        placed(&problem, &known, &state, &short, &relative_rad)
    }

    #[test]
    fn a_short_stretch_is_laid_where_it_alone_can_be() {
        let found = laid(0.002, 0.004, 0.0).expect("one place");
        let off = found.iter().enumerate().map(|(index, found)| wrapped(found - 0.7 - 0.08 * index as f64).abs());
        assert!(off.into_iter().all(|off| off < 0.01), "{found:?}");
        // Held in its middle, an ellipse feels alike on both sides.
        assert_eq!(laid(0.004, 0.0, 0.0), None);
    }

    #[test]
    fn what_the_shape_misses_is_not_laid_on_it() {
        let is_laid = |sds: f64| laid(0.002, 0.004, sds).is_some();
        assert!(is_laid(0.98 * MOST_SDS) && !is_laid(1.02 * MOST_SDS));
    }
}
