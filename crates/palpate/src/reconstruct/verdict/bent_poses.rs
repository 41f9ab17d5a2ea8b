//! Samples beside a jump that may be at rest, one of their readings a gross outlier (`docs/theory.md`, what the log says of itself): in a log with such
//! readings the pose that explains both, between the poses before and after, is no likelier than that.

use crate::estimate::jumps::DetectedJump;
use crate::math::angle::wrapped;
use crate::mechanics::EnergyLandscape;
use crate::mechanics::passage::is_same_pose;
use crate::palms::PalmPair;
use crate::shape::SupportFunction;

/// A reading agrees with a pose at rest within so many standard deviations of most readings: errors of the pose add to those of the sensor.
const AGREES_SDS: f64 = 10.0;

/// The samples on either side of the jumps that are not at rest where their neighbours are, and how far from there, radians, where one of their readings
/// agrees with that as well. `left_m` is what the fit leaves of the readings of both palms, and `typical_m` the standard deviation of most of them, metres.
pub(crate) fn bent_poses(
    shape: &SupportFunction,
    palms: &[PalmPair],
    psi: &[f64],
    left_m: &[(Option<f64>, Option<f64>)],
    typical_m: f64,
    jumps: &[DetectedJump],
) -> Vec<(usize, f64)> {
    let limit_m = AGREES_SDS * typical_m;
    let bent_rad = |sample: usize| {
        let landscape = EnergyLandscape::new(shape, &palms[sample]);
        let neighbours = [sample.checked_sub(1), Some(sample + 1)].into_iter().flatten();
        let rests: Vec<f64> = neighbours.filter_map(|other| Some(landscape.descend(*psi.get(other)?))).collect();
        if rests.iter().any(|rest| is_same_pose(*rest, psi[sample])) {
            return None;
        }
        let here = (psi[sample], left_m[sample].into());
        let agrees = |rest: f64| {
            let off_m = off_elsewhere_m(&palms[sample], shape, here, rest);
            off_m.into_iter().flatten().any(|off_m| off_m.abs() <= limit_m)
        };
        let apart = |rest: f64| wrapped(rest - psi[sample]).abs();
        rests.into_iter().filter(|rest| agrees(*rest)).map(apart).max_by(f64::total_cmp)
    };
    let mut beside: Vec<usize> = jumps.iter().flat_map(|jump| [jump.sample - 1, jump.sample]).collect();
    beside.dedup();
    beside.into_iter().filter_map(|sample| Some((sample, bent_rad(sample)?))).collect()
}

/// By how much the readings of a sample are off where its contacts are at another orientation, metres: `left_m` at this one.
pub(crate) fn off_elsewhere_m(
    palms: &PalmPair,
    shape: &SupportFunction,
    (psi_rad, left_m): (f64, [Option<f64>; 2]),
    elsewhere_rad: f64,
) -> [Option<f64>; 2] {
    let [here, there] = [psi_rad, elsewhere_rad].map(|psi| <[f64; 2]>::from(palms.contact_positions_m(shape, psi)));
    [0, 1].map(|palm| left_m[palm].map(|left_m| left_m + here[palm] - there[palm]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOISE_M: f64 = 1e-4;

    /// What is found where an ellipse is at rest but for sample 4, which is away from there, its first reading so far from where it is at rest.
    fn found(away_rad: f64, first_off_m: f64, jump: usize) -> Vec<(usize, f64)> {
        let shape = crate::shape::ellipse(0.03, 0.024).expect("possible").translated(2e-3, 1e-3);
        let palms = [PalmPair::hinged(0.5, 1.9); 8];
        let rest = EnergyLandscape::new(&shape, &palms[0]).descend(0.3);
        let mut psi = [rest; 8];
        psi[4] = rest + away_rad;
        let at = |psi: f64| <[f64; 2]>::from(palms[0].contact_positions_m(&shape, psi));
        let (here, there) = (at(psi[4]), at(rest));
        let mut left_m = [(Some(NOISE_M), Some(-NOISE_M)); 8];
        left_m[4] = (Some(there[0] + first_off_m - here[0]), Some(0.0));
        let jump = DetectedJump {
            sample: jump,
            psi_before: rest,
            psi_after: rest,
            height_before_m: 0.03,
            height_after_m: 0.03,
            physical: true,
            predicted: true,
        };
        bent_poses(&shape, &palms, &psi, &left_m, NOISE_M, &[jump])
    }

    #[test]
    fn a_pose_beside_a_jump_may_be_bent_where_one_reading_agrees_with_rest() {
        let limit_m = AGREES_SDS * NOISE_M;
        for jump in [4, 5] {
            let [(sample, away_rad)] = found(0.5, 0.99 * limit_m, jump)[..] else { panic!("one pose") };
            assert!(sample == 4 && (away_rad - 0.5).abs() < 1e-9, "{away_rad}");
        }
        assert_eq!(found(0.5, 1.01 * limit_m, 4), []);
        assert_eq!(found(0.5, 0.0, 6), [], "not beside the jump");
        assert_eq!(found(0.05, 0.0, 4), [], "the same pose");
    }
}
