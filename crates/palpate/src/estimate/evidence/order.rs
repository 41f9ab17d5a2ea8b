//! The number of harmonics by the evidence (MacKay 1992; `docs/theory.md`, what the log says of itself).

use crate::estimate::evidence::fit::{Fitted, ROUNDS, fit};
use crate::estimate::evidence::variance_components::VarianceComponents;
use crate::estimate::measurements::Measurements;
use crate::estimate::model::layout::Layout;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::{Estimate, Fit};

/// Numbers of harmonics that are tried: in steps of about a quarter, fine enough for the evidence, which is flat at its maximum.
pub(crate) const ORDERS: [usize; 12] = [3, 4, 6, 8, 10, 12, 16, 20, 24, 32, 40, 48];

/// Consecutive numbers of harmonics without a gain in evidence after which a climb ends: more cost
/// fits, fewer may end it at a local maximum.
const PATIENCE: usize = 2;

/// The number of harmonics with the largest evidence: up from the number of the start while the evidence grows, then down
/// from it. Every fit begins at the optimum of its neighbour, never at a shape with too few harmonics for the motion.
pub(crate) fn choose_order(
    measurements: &Measurements,
    start: Estimate,
    noise: Noise,
    prior: Prior,
    variance_components: VarianceComponents,
) -> Option<Fitted> {
    let here = Layout::of_coefficients(&start.coefficients).order;
    let middle = ORDERS.iter().position(|&order| order >= here).unwrap_or(ORDERS.len() - 1);
    let Fitted { fit: first, mut weighted } =
        fit(measurements, ORDERS[middle], start, noise, prior, variance_components, ROUNDS)?;
    let again = |weighted: &Measurements, order: usize, from: &Fit| {
        fit(weighted, order, from.estimate.clone(), from.noise, from.prior, variance_components, ROUNDS)
    };
    let mut best = first.clone();
    let climbs: [&mut dyn Iterator<Item = usize>; 2] =
        [&mut ORDERS[middle + 1..].iter().copied(), &mut ORDERS[..middle].iter().rev().copied()];
    for orders in climbs {
        let mut from = first.clone();
        let mut worse = 0;
        for order in orders {
            let Some(next) = again(&weighted, order, &from) else { break };
            (from, weighted) = (next.fit, next.weighted);
            if from.log_evidence > best.log_evidence {
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
    let richer = ORDERS.iter().copied().find(|&order| order > best.order).unwrap_or(best.order);
    again(&weighted, richer, &best).or(Some(Fitted { fit: best, weighted }))
}
