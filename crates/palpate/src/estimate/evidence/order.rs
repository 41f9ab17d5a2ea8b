//! The number of harmonics by the evidence (MacKay 1992; `docs/theory.md`, what the log says of itself).

use crate::estimate::evidence::fit::{Fitted, ROUNDS, fit};
use crate::estimate::evidence::variance_components::VarianceComponents;
use crate::estimate::measurements::Measurements;
use crate::estimate::model::evidence::Evidence;
use crate::estimate::model::layout::Layout;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::{Estimate, Fit};

/// Numbers of harmonics that are tried: in steps of about a quarter, fine enough for the evidence, which is flat at its maximum.
pub(crate) const ORDERS: [usize; 12] = [3, 4, 6, 8, 10, 12, 16, 20, 24, 32, 40, 48];

/// Consecutive numbers of harmonics without a gain in evidence after which a climb ends: more cost
/// fits, fewer may end it at a local maximum.
pub(crate) const PATIENCE: usize = 2;

/// The number of harmonics with the largest evidence: up from the number of the start while the evidence grows, then down
/// from it. Every fit begins at the optimum of its neighbour, never at a shape with too few harmonics for the motion. Of `samples_per_error`
/// samples that share an error more harmonics would explain every one: they count once.
pub(crate) fn choose_order(
    measurements: &Measurements,
    start: Estimate,
    noise: Noise,
    prior: Prior,
    variance_components: VarianceComponents,
    samples_per_error: f64,
) -> Option<Fitted> {
    let here = Layout::of_coefficients(&start.coefficients).order;
    let orders = orders(prior.symmetry.order);
    let middle = orders.iter().position(|&order| order >= here).unwrap_or(orders.len() - 1);
    let Fitted { fit: first, mut weighted } =
        fit(measurements, orders[middle], start, noise, prior, variance_components, ROUNDS)?;
    let again = |weighted: &Measurements, order: usize, from: &Fit| {
        fit(weighted, order, from.estimate.clone(), from.noise, from.prior, variance_components, ROUNDS)
    };
    let sharing = |fit: &Fit| Evidence { samples_per_error, ..fit.evidence };
    let mut best = first.clone();
    let climbs: [&mut dyn Iterator<Item = usize>; 2] =
        [&mut orders[middle + 1..].iter().copied(), &mut orders[..middle].iter().rev().copied()];
    for climb in climbs {
        let mut from = first.clone();
        let mut worse = 0;
        for order in climb {
            let Some(next) = again(&weighted, order, &from) else { break };
            (from, weighted) = (next.fit, next.weighted);
            if sharing(&from).log_ratio(&sharing(&best)) > 0.0 {
                best = from.clone();
                worse = 0;
            } else {
                worse += 1;
                if worse == PATIENCE {
                    break;
                }
            }
        }
    }
    // One step more than the maximum of the evidence, so that the error bars include harmonics that were not resolved.
    let richer = orders.iter().copied().find(|&order| order > best.order).unwrap_or(best.order);
    again(&weighted, richer, &best).or(Some(Fitted { fit: best, weighted }))
}

/// The numbers of harmonics that are tried for a symmetry of this order: those that let the object have a harmonic more than the one
/// before.
pub(super) fn orders(symmetry: u32) -> Vec<usize> {
    let symmetry = symmetry.max(1) as usize;
    let mut allowed = 0;
    let more = |order: &usize| {
        let any = order / symmetry > allowed;
        allowed = order / symmetry;
        any
    };
    ORDERS.into_iter().filter(more).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_number_of_harmonics_has_one_more_that_the_symmetry_allows() {
        assert_eq!(orders(1), ORDERS);
        assert_eq!(orders(2), [3, 4, 6, 8, 10, 12, 16, 20, 24, 32, 40, 48]);
        assert_eq!(orders(6), [6, 12, 20, 24, 32, 40, 48]);
        assert_eq!(orders(8), [8, 16, 24, 32, 40, 48]);
    }
}
