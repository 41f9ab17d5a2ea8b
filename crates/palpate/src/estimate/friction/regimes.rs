//! Which contact sticks and which slides at each sample, from the motion: between the rates at which the object would roll on one palm and on
//! the other lies that of the object, at an end where it rolls, and between them where both contacts slide.

use super::rolling::rolling_motion;
use crate::estimate::measurements::Measurements;

/// What the motion says of the contacts of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Regime {
    /// The palm (0 or 1) that is rolled on at the smaller rate of ψ, and that at the larger; `None` where the rates cannot be told apart.
    pub order: Option<[usize; 2]>,
    /// Where the rate of the object lies: 0 at the smaller of the two, 1 at the larger.
    pub place: Place,
    /// Whether these rates are the same as far as slip is told: the object may then stick on both palms.
    pub sticks_on_both: bool,
}

/// Where the rate of the object lies between those of rolling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// Below both: the object slides on both palms.
    Below,
    /// At the smaller, or so near that it may be there.
    First,
    /// Between them: it slides on both palms.
    Between,
    /// At the larger, or so near that it may be there.
    Second,
    /// Above both: it slides on both palms.
    Above,
    /// The motion does not say.
    Anywhere,
}

/// Standard deviations of the place between the rates at which it is told from an end; and the largest standard deviation of it at which it
/// is told at all.
const APART_SDS: f64 = 4.0;
const LARGEST_SD: f64 = 0.1;

/// A place this near to an end, as a share of the distance between the rates, is at the end: soft pads creep.
const NEAR: f64 = 0.05;

/// Samples on either side that the rates are taken over at most.
const LONGEST: usize = 40;

/// Samples on either side of a change of the contact modes whose intervals tell nothing: modes found with a friction that was off by six tenths had
/// changed two samples early or late.
const BESIDE_A_CHANGE: usize = 3;

/// Whether the contact modes change near a sample. Where they do was found with the very friction that is asked for, and a contact that is about to
/// slide is at the edge of its cone: noise takes it beyond, and pushes the edge out.
pub(crate) fn is_beside_a_change(regimes: &[Regime], index: usize) -> bool {
    let beside = index.saturating_sub(BESIDE_A_CHANGE)..(index + BESIDE_A_CHANGE + 1).min(regimes.len());
    regimes[beside].iter().any(|other| other.place != regimes[index].place)
}

/// The regimes of all samples. `psi_sd` is the standard deviation of ψ at each, of errors that samples do not share; at the samples `starts` a
/// jump has just ended.
pub(crate) fn regimes(measurements: &Measurements, psi: &[f64], psi_sd: &[f64], starts: &[usize]) -> Vec<Regime> {
    let rolling = [rolling_motion(measurements, 0), rolling_motion(measurements, 1)];
    let count = psi.len();
    let unknown = Regime { order: None, place: Place::Anywhere, sticks_on_both: false };
    let regime = |index: usize| {
        let mut reach = 0;
        while reach < LONGEST {
            reach += 1;
            let (from, to) = (index.saturating_sub(reach), (index + reach).min(count - 1));
            if starts.iter().any(|start| from < *start && *start <= to) {
                break;
            }
            let ends = [0, 1].map(|palm: usize| rolling[palm][to] - rolling[palm][from]);
            let order = if ends[0] <= ends[1] { [0, 1] } else { [1, 0] };
            let (first, second) = (&rolling[order[0]], &rolling[order[1]]);
            let run = from..=to;
            if let Some((place, sd)) = slope(run.map(|i| (second[i] - first[i], psi[i] - first[i], psi_sd[i])))
                && sd < LARGEST_SD
            {
                return (
                    Regime { order: Some(order), place: placed(place, APART_SDS * sd + NEAR), sticks_on_both: false },
                    reach,
                );
            }
        }
        (unknown, reach)
    };
    let seen: Vec<(Regime, usize)> = (0..count).map(regime).collect();
    // Over a change from one palm to the other the rate is a mean of both, and not that of a slide.
    let slides = |index: usize| {
        let (Regime { order, .. }, reach) = seen[index];
        let around = index.saturating_sub(reach)..(index + reach + 1).min(count);
        around
            .into_iter()
            .all(|other| seen[other].0.order == order && !matches!(seen[other].0.place, Place::First | Place::Second))
    };
    let settled = |index: usize| match seen[index].0 {
        Regime { place: Place::Between, .. } if !slides(index) => unknown,
        regime => regime,
    };
    (0..count).map(settled).collect()
}

/// Slope of the straight line through points (x, y, standard deviation of y), and its standard deviation.
fn slope(points: impl Iterator<Item = (f64, f64, f64)> + Clone) -> Option<(f64, f64)> {
    let weighted = points.map(|(x, y, sd)| (x, y, 1.0 / (sd * sd)));
    let sum = |value: fn((f64, f64, f64)) -> f64| weighted.clone().map(value).sum::<f64>();
    let total = sum(|(_, _, w)| w);
    let (x, y) = (sum(|(x, _, w)| w * x) / total, sum(|(_, y, w)| w * y) / total);
    let (mut squares, mut products) = (0.0, 0.0);
    for (of_x, of_y, w) in weighted {
        squares += w * (of_x - x).powi(2);
        products += w * (of_x - x) * (of_y - y);
    }
    let (slope, sd) = (products / squares, squares.powf(-0.5));
    (slope.is_finite() && sd.is_finite()).then_some((slope, sd))
}

fn placed(place: f64, tolerance: f64) -> Place {
    match place {
        _ if place.is_nan() => Place::Anywhere,
        _ if place < -tolerance => Place::Below,
        _ if place <= tolerance => Place::First,
        _ if place < 1.0 - tolerance => Place::Between,
        _ if place <= 1.0 + tolerance => Place::Second,
        _ => Place::Above,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_through_exact_points_has_their_slope() {
        let points = [(0.0, 1.0, 0.1), (1.0, 3.0, 0.1), (3.0, 7.0, 0.1)];
        let (slope, sd) = slope(points.into_iter()).expect("a line");
        // Σ (x − x̄)² = 14/3.
        assert!((slope - 2.0).abs() < 1e-12 && (sd - 0.1 / (14.0_f64 / 3.0).sqrt()).abs() < 1e-12);
        assert_eq!(super::slope([(1.0, 2.0, 0.1); 3].into_iter()), None);
    }

    #[test]
    fn modes_change_within_three_samples() {
        let regime = |place| Regime { order: Some([0, 1]), place, sticks_on_both: false };
        let regimes: Vec<Regime> =
            (0..20).map(|index| regime(if index < 10 { Place::First } else { Place::Between })).collect();
        let beside: Vec<usize> = (0..20).filter(|index| is_beside_a_change(&regimes, *index)).collect();
        assert_eq!(beside, (7..13).collect::<Vec<_>>());
    }

    #[test]
    fn places_are_told_at_their_limits() {
        let at = |place| placed(place, 0.1);
        assert_eq!(
            [at(-0.11), at(-0.09), at(0.09), at(0.11)],
            [Place::Below, Place::First, Place::First, Place::Between]
        );
        assert_eq!(
            [at(0.89), at(0.91), at(1.09), at(1.11)],
            [Place::Between, Place::Second, Place::Second, Place::Above]
        );
        assert_eq!(at(f64::NAN), Place::Anywhere);
    }
}
