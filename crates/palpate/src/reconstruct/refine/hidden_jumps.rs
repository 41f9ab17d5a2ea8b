//! What jumps that the contacts do not show leave open of an optimum (`docs/theory.md`, decoding of the motion): a few samples beside an end of the log or
//! beside a jump may be elsewhere, on boundary that nothing else felt. They are then set aside, and tell nothing of the shape.

use crate::estimate::association::alternatives::{Ambiguity, compare_evidence};
use crate::estimate::association::form_copies::at_copies;
use crate::estimate::association::hidden_jumps::motions_with_hidden_jumps;
use crate::estimate::evidence::fit::{Fitted, ROUNDS, fit};
use crate::estimate::evidence::form_symmetry::likeliest_form;
use crate::estimate::measurements::Measurements;
use crate::estimate::model::layout::coefficients_to_order;
use crate::estimate::motion::piece_starts;
use crate::estimate::solver::gauss_newton::{Estimate, Fit};
use crate::reconstruct::refine::job::{Job, PROMISING, Refined};
use crate::reconstruct::verdict::open_poses::open_pieces;

/// Where samples are held against poses on boundary that nothing else felt, a shape has half as many harmonics more, up to this: those that the evidence
/// prefers on what was felt hold the rest of it too firmly.
const FREE_HARMONICS: usize = 36;

fn harmonics_more(order: usize) -> usize {
    (order / 2).min(FREE_HARMONICS.saturating_sub(order))
}

impl Job<'_> {
    /// An optimum with what jumps that the contacts do not show leave open of it, fitted without the pieces that may be elsewhere where these are short.
    /// `None` where that is the same, or the log does not determine it.
    pub(crate) fn with_hidden_jumps(&self, of: &Refined) -> Option<Refined> {
        let (behind, likelier) = self.behind_hidden_jumps(&of.fine, &of.measurements)?;
        if let Some(there) = likelier.and_then(|likelier| self.likelier_at(&likelier, of)) {
            return Some(self.with_hidden_jumps(&there).unwrap_or(there));
        }
        let ambiguity_rad: Vec<f64> = of.ambiguity_rad.iter().zip(behind).map(|(a, b)| a.max(b)).collect();
        let pieces = open_pieces(&ambiguity_rad);
        if pieces.is_empty() && ambiguity_rad == of.ambiguity_rad {
            return None;
        }
        let (mut fine, mut measurements) = (of.fine.clone(), of.measurements.clone());
        if !pieces.is_empty() {
            pieces.into_iter().flatten().for_each(|sample| measurements.instants[sample].set_aside());
            Fitted { fit: fine, weighted: measurements } = self.fitted_again(fine, &measurements, 0)?;
        }
        // Held against others, all samples count.
        let (coarse, symmetry, settled, posterior) = (of.coarse.clone(), of.symmetry, of.settled, of.posterior);
        let (rivals, as_likely) = (Vec::new(), Vec::new());
        Some(Refined { coarse, fine, measurements, ambiguity_rad, symmetry, settled, posterior, rivals, as_likely })
    }

    /// An optimum with another motion, where that is likelier.
    fn likelier_at(&self, there: &Estimate, of: &Refined) -> Option<Refined> {
        let mut estimate = there.clone();
        coefficients_to_order(&mut estimate.coefficients, of.fine.order);
        let mut refitted = self.refitted_from(estimate, of)?;
        // Samples beside its jumps may be where the other motion had them.
        let (decoded, _) = self.decoded_again(&refitted.fine);
        if decoded.relocated > 0 {
            let estimate = Estimate { psi: decoded.psi, ..refitted.fine.estimate.clone() };
            let again =
                self.refitted_from(estimate, of).filter(|again| again.posterior.log_ratio(&refitted.posterior) > 0.0);
            refitted = again.unwrap_or(refitted);
        }
        (refitted.posterior.log_ratio(&of.posterior) > PROMISING).then_some(refitted)
    }

    /// How far away each sample may be behind a jump that the contacts do not show, radians, 0 where it is not; and the motion behind such a jump that is
    /// likelier, if one is.
    fn behind_hidden_jumps(&self, fine: &Fit, measurements: &Measurements) -> Option<(Vec<f64>, Option<Estimate>)> {
        let Fitted { mut fit, weighted: measurements } =
            self.fitted_again(fine.clone(), measurements, harmonics_more(fine.order))?;
        let prior = likeliest_form(&measurements, &fit);
        if prior != fit.prior {
            let nearly_symmetric = self.fitted_again(Fit { prior, ..fit.clone() }, &measurements, 0)?.fit;
            if nearly_symmetric.evidence.log() > fit.evidence.log() {
                fit = nearly_symmetric;
            }
        }
        let period = prior.symmetry.period_rad();
        let jumps_of = |estimate: &Estimate| self.jumps(estimate, period);
        let starts: Vec<usize> = jumps_of(&fit.estimate).iter().map(|jump| jump.sample).collect();
        let starts = piece_starts(&starts, &fit.estimate.psi, period);
        let mut alternatives = motions_with_hidden_jumps(&measurements, &fit, &starts);
        alternatives.extend(at_copies(&measurements, &fit, &starts));
        let mut ambiguity = Ambiguity::new(vec![f64::INFINITY; measurements.len()]);
        alternatives.iter().for_each(|alternative| ambiguity.doubt(&alternative.samples));
        let compared = compare_evidence(&measurements, &fit, &alternatives, &jumps_of, &mut ambiguity);
        Some((ambiguity.ambiguity_rad(), compared.likelier))
    }

    /// A fit to all samples from another one, with so many harmonics more.
    fn fitted_again(&self, from: Fit, measurements: &Measurements, more: usize) -> Option<Fitted> {
        let Fit { estimate, order, noise, prior, .. } = from;
        fit(measurements, order + more, estimate, noise, prior, self.variance_components_of_all(), ROUNDS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_as_many_harmonics_more_leave_boundary_that_nothing_felt_free() {
        assert_eq!([8, 24, 30, 36, 48].map(harmonics_more), [4, 12, 6, 0, 0]);
    }
}
