//! Parts of the log that lie at another copy of their pose: contacts of an object of nearly n-fold symmetry are as good as the same where it is
//! turned by 2π/n, so that no contact shows such a jump, and none shows that there was none. Forces and slip tell the copies apart.
//!
//! The log is decoded with the motion as it is, and with all of it turned. Between any two samples the likelihoods differ by what mechanics makes of
//! that part alone, so that the likeliest part is the run with the largest sum (Kadane's algorithm), less what its jumps cost.

use super::{Setting, Settled};
use crate::estimate::association::relative_rotation::{LOOSE, Trial};
use crate::estimate::evidence::motion_prior::CERTAIN;
use crate::estimate::friction::modes::JUMP;
use crate::estimate::friction::problem::Unknowns;
use crate::estimate::motion::SHORT_SEGMENT;
use crate::shape::SupportFunction;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::ops::Range;

/// Numbers of copies.
const ORDERS: [u32; 6] = [2, 3, 4, 5, 6, 8];

/// The part that is likelier at each of the other copies, where there is any.
pub(super) fn likelier_copies(setting: &Setting, present: &Settled) -> Vec<Trial> {
    let optimum = &present.optimum;
    let Unknowns { coefficients, psi, .. } = &optimum.unknowns;
    let omegas = copies(&SupportFunction::from_coefficients(coefficients));
    if omegas.is_empty() {
        return Vec::new();
    }
    let covariance = optimum.covariance_of_object();
    let costs = |omega: f64| {
        let turned = psi.iter().map(|psi| psi + omega).collect();
        let at = Unknowns { psi: turned, ..optimum.unknowns.clone() };
        setting.decoded(&optimum.corrected, &at, covariance.as_ref(), optimum.noise, &present.starts).costs
    };
    let here = costs(0.0);
    let trial = |omega: f64| {
        let there = costs(omega);
        let (gain, part) = likeliest_part(here.iter().zip(&there).map(|(here, there)| here - there))?;
        (gain > -CERTAIN.0).then(|| Trial { cost: -gain, part: part.into(), omega, coefficients: coefficients.clone() })
    };
    omegas.into_par_iter().filter_map(trial).collect()
}

/// Turns after which the contacts of a shape are the same within the noise of the trials.
fn copies(shape: &SupportFunction) -> Vec<f64> {
    let mut omegas: Vec<f64> = Vec::new();
    for order in ORDERS {
        for copy in 1..order {
            let omega = TAU * f64::from(copy) / f64::from(order);
            let is_new = omegas.iter().all(|other| (other - omega).abs() > 1e-6);
            if is_new && changed_contacts_m(shape, omega) < LOOSE * shape.mean_radius_m() {
                omegas.push(omega);
            }
        }
    }
    omegas
}

/// Root mean square by which r and d of a shape change where it is turned, but for where its origin is.
fn changed_contacts_m(shape: &SupportFunction, omega: f64) -> f64 {
    let harmonics = (1..).zip(shape.harmonics_m()).skip(1);
    let squares = harmonics.map(|(k, [a, b])| {
        let k = f64::from(k);
        let turned = 2.0 - 2.0 * (k * omega).cos();
        0.5 * (1.0 + k * k) * turned * (a * a + b * b)
    });
    squares.sum::<f64>().sqrt()
}

/// The run that gains most, less what jumps cost where it begins or ends within the log, of what is gained up to each sample. `None` where that is all of
/// the log.
fn likeliest_part(gained: impl Iterator<Item = f64>) -> Option<(f64, Range<usize>)> {
    let sums: Vec<f64> = std::iter::once(0.0).chain(gained).collect();
    let count = sums.len() - 1;
    // Where a run begins at its best for each end.
    let (mut best, mut start, mut least) = (None, 0, f64::INFINITY);
    for end in SHORT_SEGMENT..=count {
        let first = end - SHORT_SEGMENT;
        let of_first = sums[first] + if first > 0 { JUMP } else { 0.0 };
        if of_first < least {
            (least, start) = (of_first, first);
        }
        let gain = sums[end] - least - if end < count { JUMP } else { 0.0 };
        if (start, end) != (0, count) && best.as_ref().is_none_or(|(most, _)| gain > *most) {
            best = Some((gain, start..end));
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::rounded_polygon;

    #[test]
    fn the_run_that_gains_most_is_found_and_jumps_cost_something() {
        let likeliest_part = |gains: &[f64]| {
            let gained = gains.iter().scan(0.0, |sum, gain| {
                *sum += gain;
                Some(*sum)
            });
            likeliest_part(gained)
        };
        let mut gains = vec![-0.2; 300];
        gains[100..180].fill(1.0);
        let (gain, part) = likeliest_part(&gains).expect("a part");
        assert_eq!(part, 100..180);
        assert!((gain - (80.0 - 2.0 * JUMP)).abs() < 1e-9);
        // At an end there is one jump only.
        gains[180..].fill(0.5);
        assert_eq!(likeliest_part(&gains).expect("a part"), (80.0 + 60.0 - JUMP, 100..300));
        assert!(likeliest_part(&gains[..SHORT_SEGMENT - 1]).is_none());
    }

    #[test]
    fn an_object_has_copies_where_its_contacts_hardly_change() {
        let polygon =
            |order: u32| rounded_polygon(order, 0.4, 0.25).expect("a shape").scaled(0.03).translated(3e-3, 1e-3);
        let has = |shape: &SupportFunction, omega: f64| copies(shape).iter().any(|other| (other - omega).abs() < 1e-9);
        for order in [3, 4, 5] {
            assert!(has(&polygon(order), TAU / f64::from(order)), "{order}");
            assert!(!has(&polygon(order), TAU / 8.0), "{order}");
        }
        // A mark of one per cent is too much, one of a thousandth is not.
        let marked = |mark: f64| {
            let mut coefficients = polygon(4).coefficients();
            coefficients[3] += mark * coefficients[0];
            has(&SupportFunction::from_coefficients(&coefficients), TAU / 4.0)
        };
        assert!(marked(1e-3) && !marked(1e-2));
    }
}
