//! Jumps that the contacts do not show. Where an object falls to a copy of its pose, as one with a nearly symmetric form does, its contacts may go on as
//! if it had not. So the samples beside an end of the log or beside a jump may be behind one more jump, on boundary that nothing else felt: windows
//! of them are searched for motions that the shape which all other samples leave explains about as well ([`super::rival_pieces`]). What the other samples
//! leave is taken from the normal equations of all, to first order. Behind an edge such a motion may last longer than any window: until statics ends it.

use crate::estimate::association::alternatives::Alternative;
use crate::estimate::association::motion_grid::first_distinct;
use crate::estimate::association::predictive::PredictiveShape;
use crate::estimate::association::rival_pieces::{Predicted, Rival, likeliest_motions, loose_m};
use crate::estimate::association::transitions::near;
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::layout::Layout;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Convexity;
use crate::estimate::motion::segments_between;
use crate::estimate::solver::convex_step::Penalised;
use crate::estimate::solver::gauss_newton::{Estimate, Fit, Smoother};
use crate::estimate::solver::normal_equations::Normal;
use crate::estimate::solver::posterior::Posterior;
use crate::mechanics::Forces;
use crate::mechanics::passage::carried;
use crate::palms::PalmPair;
use crate::shape::SupportFunction;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::ops::Range;

/// Samples of the windows: each a third more than the one before, so that of those at a wrong pose few are left outside, which would hold the shape there.
const WINDOWS: [usize; 8] = [6, 7, 9, 12, 16, 21, 28, 38];

/// A motion that costs more than this by the predictive likelihood (−2 ln) is not held against the present one: twice what a certain one may cost, for the
/// likelihood is that of a linearised shape.
const WORTH_A_FIT: f64 = 20.0;

/// Heights of the centre of mass that are tried for each: the motions of a few samples hardly differ by it.
const HEIGHTS: usize = 6;

/// The motions of all samples with those of one window elsewhere that the others explain about as well. `starts` are the samples after jumps, and others at
/// which a piece may begin.
pub(crate) fn motions_with_hidden_jumps(measurements: &Measurements, fit: &Fit, starts: &[usize]) -> Vec<Alternative> {
    let of_others = OfOthers::new(measurements, fit);
    let period = fit.prior.symmetry.period_rad();
    let shape = SupportFunction::from_coefficients(&fit.estimate.coefficients);
    let beside = |(edge, windows): (usize, Vec<Range<usize>>)| {
        // Where the shortest window cannot be elsewhere, no longer one can.
        let rivals = |window: Range<usize>| (window.clone(), of_others.rivals(measurements, window));
        let of_windows = windows.into_iter().map(rivals).take_while(|(_, rivals)| !rivals.is_empty());
        let each =
            |(window, rivals): (Range<usize>, Vec<Rival>)| rivals.into_iter().map(move |rival| (window.clone(), rival));
        let mut found: Vec<(Range<usize>, Rival)> = of_windows.flat_map(each).collect();
        found.retain(|(_, rival)| rival.cost < WORTH_A_FIT);
        found.sort_by(|(_, a), (_, b)| a.cost.total_cmp(&b.cost));
        // Of the windows with one pose at the edge, the likeliest.
        let poses: Vec<[f64; 1]> = found.iter().map(|(window, rival)| [rival.psi[edge - window.start]]).collect();
        let is_same = |a: &[f64], b: &[f64]| near(a[0], b[0], period);
        let distinct =
            first_distinct(poses.iter().zip(found).collect(), usize::MAX, |(pose, _)| pose.as_slice(), is_same);
        let segment_end = starts.iter().copied().find(|start| *start > edge).unwrap_or(measurements.len());
        let begins = segment_before(starts, edge, &fit.estimate.psi, period);
        let longer = |(window, rival): &(Range<usize>, Rival)| {
            if window.start != edge {
                return None;
            }
            let last = carried_on(measurements, &shape, &rival.psi, window.end..segment_end)?;
            let turn = rival.psi[0] - fit.estimate.psi[edge];
            let before = fit.estimate.psi[begins..edge].iter().map(|psi| psi + turn);
            let psi: Vec<f64> = before.chain(last).collect();
            Some((begins..begins + psi.len(), Rival { psi, cost: rival.cost }))
        };
        let each = distinct.into_iter().flat_map(|(_, found)| longer(&found).into_iter().chain([found]));
        each.map(|(window, rival)| of_motion(&fit.estimate.psi, window, &rival)).collect::<Vec<_>>()
    };
    windows(starts, measurements.len()).into_par_iter().flat_map_iter(beside).collect()
}

/// Where a motion from a sample on begins that takes along what is before it: a segment that is too short for a window, and from which no jump leads there.
fn segment_before(starts: &[usize], edge: usize, psi: &[f64], period: f64) -> usize {
    let start = starts.iter().copied().rfind(|start| *start < edge).unwrap_or(0);
    let goes_on = || (start + 1..=edge).all(|sample| near(psi[sample - 1], psi[sample], period));
    if edge - start < WINDOWS[0] && goes_on() { start } else { edge }
}

/// A motion at the beginning of a segment carried on by statics over the rest of it, to where its pose ends and the object jumps: there it may come to the
/// present one. `None` where that is no further, or the segment ends before.
fn carried_on(
    measurements: &Measurements,
    shape: &SupportFunction,
    begun: &[f64],
    rest: Range<usize>,
) -> Option<Vec<f64>> {
    let palms = |sample: usize| {
        let Instant { phi1, phi2, .. } = measurements.instants[sample];
        PalmPair::hinged(phi1, phi2)
    };
    let mut psi = begun.to_vec();
    for sample in rest {
        let (next, jumped) = carried(&Forces::default(), shape, &[palms(sample - 1), palms(sample)], *psi.last()?);
        if jumped {
            return (psi.len() > begun.len()).then_some(psi);
        }
        psi.push(next);
    }
    None
}

/// The motion with a window elsewhere.
fn of_motion(present: &[f64], window: Range<usize>, rival: &Rival) -> Alternative {
    let mut psi = present.to_vec();
    psi[window.clone()].copy_from_slice(&rival.psi);
    Alternative { psi, samples: window.collect(), motion_cost: None, is_predicted: false }
}

/// The samples beside both ends of each segment, and the windows there.
fn windows(starts: &[usize], samples: usize) -> Vec<(usize, Vec<Range<usize>>)> {
    let beside = |Range { start, end }: Range<usize>| {
        let counts = || WINDOWS.into_iter().filter(move |count| start + count < end);
        let first = (start, counts().map(|count| start..start + count).collect());
        let last = (end.saturating_sub(1), counts().map(|count| end - count..end).collect());
        [first, last]
    };
    segments_between(starts, samples).flat_map(beside).collect()
}

/// What all samples but those of a window tell of the shape, from the normal equations of all.
struct OfOthers<'a> {
    fit: &'a Fit,
    convexity: Convexity,
    /// The normal equations of all samples and the prior at the fit; the information at the noise of the trials, and that noise.
    of_all: Normal,
    loosely_of_all: DMatrix<f64>,
    trials: Noise,
}

impl<'a> OfOthers<'a> {
    fn new(measurements: &Measurements, fit: &'a Fit) -> Self {
        let Estimate { coefficients, psi, .. } = &fit.estimate;
        let smoother = |noise: Noise| Smoother::new(measurements, fit.order, noise, fit.prior).strictly_convex();
        let sd_m = loose_m(fit.prior, fit.noise);
        let trials = Noise { sensor_m: sd_m, balance_m: sd_m };
        let loosely_of_all = smoother(trials).linearise_without_convexity(coefficients, psi).matrix;
        let smoother = smoother(fit.noise);
        let of_all = smoother.linearise_without_convexity(coefficients, psi);
        Self { fit, convexity: smoother.convexity, of_all, loosely_of_all, trials }
    }

    /// The likeliest other motions of a window.
    fn rivals(&self, measurements: &Measurements, window: Range<usize>) -> Vec<Rival> {
        let alone = measurements.of(measurements.instants[window.clone()].to_vec());
        let present = &self.fit.estimate.psi[window];
        let predicted = self.without(&alone, present);
        predicted
            .map_or(Vec::new(), |by_others| likeliest_motions(&alone, present, HEIGHTS, self.fit.prior, &by_others))
    }

    fn without(&self, window: &Measurements, psi: &[f64]) -> Option<Predicted> {
        let Fit { estimate: Estimate { coefficients, .. }, noise, .. } = self.fit;
        let of_window = of_samples(window, self.fit, *noise, psi);
        let posterior = |information: DMatrix<f64>, mean: DVector<f64>| {
            let layout = Layout::of_coefficients(mean.as_slice());
            Posterior { layout, mean, information }.holding_rotation()
        };
        let sharp = &self.of_all.matrix - of_window.matrix;
        let at_fit = posterior(sharp.clone(), DVector::from_row_slice(coefficients))?;
        let others = Normal {
            matrix: at_fit.information,
            gradient: &self.of_all.gradient - of_window.gradient,
            psi_offset: Vec::new(),
            psi_slope: Vec::new(),
            psi_information: Vec::new(),
        };
        let (step, _) = Penalised::new(&self.convexity, coefficients, &others).minimum(0.0)?;
        let mean = at_fit.mean + step;
        let predictive = |information: DMatrix<f64>, noise: Noise| {
            let covariance = posterior(information, mean.clone())?.covariance()?;
            Some(PredictiveShape::new(mean.as_slice(), &covariance, noise))
        };
        let loosely_of_window = of_samples(window, self.fit, self.trials, psi).matrix;
        Some(Predicted {
            loose: predictive(&self.loosely_of_all - loosely_of_window, self.trials)?,
            sharp: predictive(sharp, *noise)?,
        })
    }
}

/// What some samples alone add to the normal equations.
fn of_samples(samples: &Measurements, fit: &Fit, noise: Noise, psi: &[f64]) -> Normal {
    let smoother = Smoother::new(samples, fit.order, noise, fit.prior);
    let coefficients = &fit.estimate.coefficients;
    let mut normal = smoother.linearise_without_convexity(coefficients, psi);
    for (index, precision) in smoother.precision.iter().enumerate() {
        normal.matrix[(index, index)] -= precision;
        normal.gradient[index] -= precision * coefficients[index];
    }
    normal
}

#[cfg(test)]
mod tests;
