//! Is a sample where it was put? The way through the log ([`super::track`]) asks this of a shape that is given; here the shape may give
//! way to either answer. Each rival way is smoothed to its own optimum, and the evidence decides.

use std::ops::Range;

use rayon::prelude::*;

use super::evidence::{Fit, log_evidence};
use super::grow::common_turn;
use super::problem::Problem;
use super::smooth::{Effort, Estimate, Smoother};
use super::track::{CERTAIN, LONGEST_STEP, Rival, WORTH_CHANGING, near};
use crate::angle::wrapped;

const EFFORT: Effort = Effort { iterations: 20, tolerance: 1e-7 };

/// How sure the pose of each sample is.
pub(super) struct Doubts {
    /// How much more it costs to put it elsewhere (squared standard deviations).
    margin: Vec<f64>,
    /// How far away elsewhere is, radians.
    way: Vec<f64>,
}

/// The standard deviation of an angle of which nothing is known: that of a uniform distribution over the circle, radians.
const ANYWHERE: f64 = 1.813_8;

impl Doubts {
    pub fn new(margin: Vec<f64>) -> Self {
        Self { way: vec![ANYWHERE; margin.len()], margin }
    }

    fn is_open(&self, sample: usize) -> bool {
        self.margin[sample] < CERTAIN
    }

    /// For each sample, how far from its pose another is that explains it about as well, radians; 0 where there is none.
    pub fn astray(&self) -> Vec<f64> {
        (0..self.margin.len()).map(|sample| if self.is_open(sample) { self.way[sample] } else { 0.0 }).collect()
    }

    /// Doubts the samples of a fit that another way puts elsewhere, without the fit having followed it yet: that way, as a rival.
    pub fn unsettled(&mut self, fitted: &[f64], other: &[f64]) -> Option<Rival> {
        let samples: Vec<usize> = (0..fitted.len()).filter(|&sample| !near(fitted[sample], other[sample])).collect();
        samples.iter().for_each(|&sample| self.lower(sample..sample + 1, 0.0));
        (!samples.is_empty()).then(|| Rival { psi: other.to_vec(), samples, leaps: 0.0 })
    }

    /// Adds a doubt of a run of samples.
    pub fn lower(&mut self, samples: Range<usize>, margin: f64) {
        self.margin[samples].iter_mut().for_each(|known| *known = known.min(margin));
    }
}

/// Weighs the rivals of the poses of a fit, and settles the doubts of the samples that they were looked up for. The estimate of the
/// best of them where it is the better one.
pub(super) fn weigh(problem: &Problem, fit: &Fit, rivals: &[Rival], doubts: &mut Doubts) -> Option<Estimate> {
    if rivals.is_empty() {
        return None;
    }
    let smoother = Smoother::new(problem, fit.order, fit.noise, fit.prior).strictly_convex();
    let evidence = |estimate: &Estimate| {
        let normal = smoother.linearise(&estimate.coefficients, &estimate.psi);
        Some(log_evidence(&smoother, estimate, &normal, &smoother.factor(&normal)?))
    };
    let Estimate { coefficients, psi, .. } = fit.estimate.clone();
    let here = smoother.run(coefficients, psi, EFFORT);
    let here_evidence = evidence(&here)?;
    let weighed: Vec<(Estimate, f64)> = rivals
        .par_iter()
        .map(|Rival { psi, leaps, .. }| {
            let there = smoother.run_near(here.coefficients.clone(), psi.clone(), EFFORT);
            let margin = evidence(&there).map_or(f64::INFINITY, |evidence| 2.0 * (here_evidence - evidence) + leaps);
            (there, if margin.is_nan() { f64::INFINITY } else { margin })
        })
        .collect();
    let open: Vec<usize> = (0..here.psi.len()).filter(|&sample| doubts.is_open(sample)).collect();
    for &sample in rivals.iter().flat_map(|rival| &rival.samples) {
        (doubts.margin[sample], doubts.way[sample]) = (f64::INFINITY, 0.0);
    }
    for (there, margin) in &weighed {
        let turned = common_turn(&here.psi, &there.psi);
        for &sample in &open {
            let way = wrapped(there.psi[sample] + turned - here.psi[sample]).abs();
            // What slid back to where it was is no rival.
            if way >= LONGEST_STEP {
                doubts.margin[sample] = doubts.margin[sample].min(*margin);
                doubts.way[sample] = if *margin < CERTAIN { doubts.way[sample].max(way) } else { doubts.way[sample] };
            }
        }
    }
    let best = weighed.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
    best.filter(|(_, margin)| *margin < -WORTH_CHANGING).map(|(estimate, _)| estimate)
}
