//! Shape, pose and centre of mass while the samples come (`docs/theory.md`, online).
//!
//! [`Live`] takes one sample at a time and says what is known after it. Two things work together:
//!
//! * **A filter.** The shape is a Gaussian that each sample sharpens by a Gauss-Newton step of the batch estimator with that Gaussian in place of
//!   the prior; the pose of the newest samples is followed by a few hypotheses.
//! * **Searches.** Now and then the batch estimator is run over the samples so far, in the background. It finds the first shape, corrects a wrong
//!   one, and certifies it. A certified answer is fitted anew to all samples so far in between, as the batch estimator would. When a search or a
//!   fit begins and when its result is taken over is settled by the number of samples, so that the same samples give the same estimates, to the
//!   bit.
//!
//! [`Live::finish`] gives what [`reconstruct`](crate::reconstruct()) gives for the same samples.

mod estimate;
mod follower;
mod kept;
mod optimum;
mod poses;
mod searches;
mod shape_belief;

use std::collections::VecDeque;

pub use estimate::{Estimate, Stage};
pub use follower::OUTLINE_EVERY;
pub(crate) use kept::Halving;

use crate::log::{Log, Sample};
use crate::reconstruct::{ReconstructError, ReconstructOptions, Reconstruction, Reconstructor, check_sample};
use follower::Follower;
use kept::Kept;
use searches::{Ended, Searches};

/// Samples of the time of a search that are followed again with its result, for each new one: as many as are far from a thousandth of a second of
/// work.
const CATCH_UP: usize = 16;

/// Share of the boundary that may be felt after a search before its answer asks for another: it was certified without that.
const NEW_COVERAGE: f64 = 0.1;

/// An online estimator.
///
/// ```
/// use palpate::live::Live;
/// # use palpate::{plan::{PalmLimits, plan_turn}, shape::NamedShape, simulate::{SimulateOptions, simulate}};
/// # let egg = NamedShape::Egg.shape(0.03)?;
/// # let plan = plan_turn(&egg, &PalmLimits::default(), 40.0)?;
/// # let options = SimulateOptions { start_psi_rad: plan.start_psi_rad, ..SimulateOptions::default() };
/// # let samples = simulate(&egg, &plan.motion.sample(10.0)?, &options)?.log.samples;
/// let mut live = Live::default();
/// for sample in samples {
///     let estimate = live.push(&sample);
///     if let Some(pose) = &estimate.pose {
///         println!("{:.2} s: {:.1}°, {:.0} % felt", estimate.time_s, pose.psi_rad.to_degrees(), 100.0 * estimate.coverage);
///     }
/// }
/// assert!(live.estimate().is_certified(), "{}", live.estimate().reason());
/// let found = live.finish()?; // what `reconstruct` gives for these samples
/// assert!(found.is_certified());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Live {
    options: ReconstructOptions,
    kept: Kept,
    searches: Searches,
    follower: Option<Follower>,
    /// From the result of the last search or fit, until it has caught up with the samples that came meanwhile.
    successor: Option<Follower>,
    /// Samples since what is running began (none where nothing is), and those that the successor has not seen.
    since_begun: VecDeque<Sample>,
    behind: VecDeque<Sample>,
    newest: Option<Sample>,
    estimate: Estimate,
}

impl Default for Live {
    /// With readings taken as they are.
    fn default() -> Self {
        Self::new(ReconstructOptions::default())
    }
}

impl Live {
    /// With the options of the batch estimator.
    pub fn new(options: ReconstructOptions) -> Self {
        Self {
            searches: Searches::new(options.clone()),
            options,
            kept: Kept::new(),
            follower: None,
            successor: None,
            since_begun: VecDeque::new(),
            behind: VecDeque::new(),
            newest: None,
            estimate: Estimate::default(),
        }
    }

    /// Takes a sample in, as the rig wrote it, and says what is known after it. One that no palm log can have (a value that is no number, parallel palms, a
    /// time before that of the last) is counted in [`Estimate::refused`], and nothing else.
    pub fn push(&mut self, sample: &Sample) -> &Estimate {
        if check_sample(self.newest.as_ref(), sample).is_err() {
            self.estimate.refused += 1;
            return &self.estimate;
        }
        self.newest = Some(*sample);
        self.kept.push(sample);
        self.searches.push(sample);
        self.estimate.samples = self.kept.seen();
        self.estimate.time_s = sample.time_s;
        if self.searches.is_running() {
            self.since_begun.push_back(*sample);
        }
        self.behind.push_back(*sample);
        self.take_over();
        self.begin();
        self.catch_up();
        if let Some(follower) = &mut self.follower {
            let newest = follower.push(sample);
            follower.tell(&newest, &mut self.estimate);
        }
        &self.estimate
    }

    /// What is known after the last sample.
    pub fn estimate(&self) -> &Estimate {
        &self.estimate
    }

    /// The samples that are kept, from the first: what [`finish`](Self::finish) reconstructs.
    pub fn log(&self) -> &Log {
        self.kept.log()
    }

    /// One in so many samples is kept: 1 up to 65 536 samples, then 2, 4 and so on.
    pub fn kept_every(&self) -> u64 {
        self.kept.every()
    }

    /// What the batch estimator finds for the samples that are kept: byte for byte what [`reconstruct`](crate::reconstruct()) gives with these options.
    ///
    /// # Errors
    /// As [`Reconstructor::run`].
    pub fn finish(self) -> Result<Reconstruction, ReconstructError> {
        Reconstructor::from(self.options).run(self.kept.log())
    }

    /// The result of a search or a fit that ends here.
    fn take_over(&mut self) {
        let found = match self.searches.ended(self.estimate.samples) {
            Some(Ended::Search(found)) => found,
            Some(Ended::Fit(Some(successor))) => {
                self.successor = Some(*successor);
                self.behind = std::mem::take(&mut self.since_begun);
                return;
            }
            Some(Ended::Fit(None)) | None => return,
        };
        self.estimate.searched = self.searches.begun_at();
        let limits = &self.options.limits;
        let successor = found.and_then(|optimum| Follower::new(*optimum, limits).ok_or(ReconstructError::NotSolvable));
        match successor {
            // Neither is it where the first way alone explains nothing: others may have explained it before.
            Ok(successor)
                if self.follower.is_some() && !self.searches.was_whole() && !successor.optimum().is_explained() => {}
            Ok(successor) => {
                self.successor = Some(successor);
                self.behind = std::mem::take(&mut self.since_begun);
                self.estimate.failure = None;
            }
            // What was known before is worth no less.
            Err(failure) => self.estimate.failure = Some(failure),
        }
    }

    /// A search, or a fit of what is certified.
    fn begin(&mut self) {
        let samples = self.estimate.samples;
        let all_are_placed = self.follower.as_ref().is_some_and(Follower::all_are_placed);
        let searched = self.follower.as_ref().map_or(0.0, |follower| follower.optimum().found.coverage);
        let is_settled = all_are_placed && is_settled(&self.estimate, searched);
        if self.searches.is_due(samples, is_settled) {
            self.since_begun.clear();
            self.searches.begin(samples);
            self.estimate.stage = self.estimate.stage.max(Stage::Searching);
            return;
        }
        let may_fit = all_are_placed
            && self.successor.is_none()
            && self.estimate.is_certified()
            && self.searches.fit_is_due(samples);
        if let Some(follower) = self.follower.as_ref().filter(|follower| may_fit && follower.optimum().balance_counts) {
            // It has not seen the newest sample.
            self.since_begun = self.newest.into_iter().collect();
            self.searches.begin_fit(samples, follower.clone());
        }
    }

    /// Lets the successor follow a few of the samples that it has not seen; when the newest is the only one left, it takes over.
    fn catch_up(&mut self) {
        let Some(successor) = &mut self.successor else {
            self.behind.clear();
            return;
        };
        for _ in 0..CATCH_UP {
            if self.behind.len() <= 1 {
                break;
            }
            if let Some(sample) = self.behind.pop_front() {
                successor.push(&sample);
            }
        }
        if self.behind.len() <= 1 {
            self.behind.clear();
            self.follower = self.successor.take();
            self.renew();
        }
    }

    /// What the last search or fit says, now that the filter goes on from it.
    fn renew(&mut self) {
        let Some(follower) = &self.follower else { return };
        let optimum = follower.optimum();
        let estimate = &mut self.estimate;
        estimate.outline.clear();
        estimate.verdict = Some(optimum.found.verdict.clone());
        estimate.alternatives = optimum.found.alternatives;
        estimate.sensor_sd_m = optimum.noise.sensor_m;
        estimate.symmetry = optimum.found.symmetry;
        estimate.calibration = optimum.found.calibration.clone();
        estimate.friction = optimum.found.friction;
    }
}

/// Whether another search would hardly change the answer: it is certified, the newest samples agree with it, and little was felt besides what the last
/// search knew of.
fn is_settled(estimate: &Estimate, searched_coverage: f64) -> bool {
    estimate.is_still_certified() && estimate.coverage < searched_coverage + NEW_COVERAGE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reconstruct::Verdict;

    #[test]
    fn a_certified_answer_is_settled_until_it_is_contradicted_or_much_was_felt_since() {
        let estimate = |coverage: f64| Estimate { coverage, verdict: Some(Verdict::default()), ..Estimate::default() };
        assert!(is_settled(&estimate(0.59), 0.5) && !is_settled(&estimate(0.61), 0.5));
        assert!(!is_settled(&Estimate { contradicted: true, ..estimate(0.5) }, 0.5));
        assert!(!is_settled(&Estimate { verdict: None, ..estimate(0.5) }, 0.5));
        // The newest pose may be in doubt.
        let ambiguous = Estimate { ambiguous: true, ..estimate(0.5) };
        assert!(is_settled(&ambiguous, 0.5) && !ambiguous.is_certified());
    }
}
