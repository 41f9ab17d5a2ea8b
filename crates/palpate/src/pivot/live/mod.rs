//! What is known of an object while its strokes are felt, sample by sample.
//!
//! [`LiveStrokes`] takes one sample at a time and says what is known after it. [`reconstruct_strokes`](crate::pivot::reconstruct_strokes) is run over
//! the samples so far each time these have grown by half, on a thread of its own; its shape, error bars and doubts are those that are told. In between
//! each sample is decoded against that shape, by the forward half of the Viterbi algorithm that the reconstruction decodes angles with
//! (`pivot/decode.rs`). When a search begins and when its result is taken over is settled by the number of samples alone, so that the same samples give
//! the same estimates, to the bit.

mod estimate;
mod follower;
mod searches;

use std::collections::VecDeque;

pub use estimate::StrokesEstimate;

use crate::live::{Halving, Stage};
use crate::pivot::error::PivotReconstructError;
use crate::pivot::log::{PivotLog, PivotSample};
use crate::pivot::reconstruct::{PivotOptions, fault_of, reconstruct_strokes};
use crate::pivot::result::PivotReconstruction;
use follower::Follower;
use searches::{Found, Searches};

/// Samples that are kept at most: 13 minutes at 20 Hz.
const MOST_KEPT: usize = 16_384;

/// Samples that are decoded anew when another shape is taken over: where the contact was longer ago says nothing of where it is.
const REPLAYED: usize = 200;

/// An online estimator for the strokes of a pivoting grasp.
///
/// A push takes 0.03 ms, and a few milliseconds where a search begins or its result is taken over (`docs/live.md`). A search takes as long as
/// [`reconstruct_strokes`](crate::pivot::reconstruct_strokes) does for the samples so far, a second or so and ten at times; it has the time of a quarter of
/// these. Where samples come faster than that, the push that takes its result over waits for it.
///
/// ```
/// use palpate::pivot::{LiveStrokes, PivotOptions, PivotSimulateOptions, Stroke, simulate_strokes};
/// use palpate::shape::NamedShape;
///
/// let egg = NamedShape::Egg.shape(0.030)?.translated(0.004, 0.003);
/// let strokes: Vec<Stroke> =
///     [0.65, 0.35, 0.7, 0.3].map(|to_m| Stroke { along_m: vec![0.5, to_m], press: 3.0 }).to_vec();
/// let felt = simulate_strokes(&egg, &strokes, &PivotSimulateOptions::default())?;
/// let mut live = LiveStrokes::new(PivotOptions::default());
/// for sample in &felt.log.samples {
///     let estimate = live.push(sample);
///     if let Some(psi_rad) = estimate.psi_rad {
///         println!("{:.2} s: {:.1}°, {:.0} % felt", estimate.time_s, psi_rad.to_degrees(), 100.0 * estimate.coverage);
///     }
/// }
/// assert!(live.estimate().is_certified(), "{}", live.estimate().reason());
/// let found = live.finish()?; // what `reconstruct_strokes` gives for these samples
/// assert!(found.is_certified());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct LiveStrokes {
    options: PivotOptions,
    log: PivotLog,
    halving: Halving,
    searches: Searches,
    follower: Option<Follower>,
    /// The newest samples, the newest last.
    recent: VecDeque<PivotSample>,
    estimate: StrokesEstimate,
}

impl LiveStrokes {
    /// With the options of the reconstruction. Whether these are in order is told by the first search, and by [`finish`](Self::finish).
    pub fn new(options: PivotOptions) -> Self {
        Self {
            options,
            log: PivotLog::default(),
            halving: Halving::default(),
            searches: Searches::default(),
            follower: None,
            recent: VecDeque::with_capacity(REPLAYED + 1),
            estimate: StrokesEstimate::default(),
        }
    }

    /// With the period of small swings of the lifted object, seconds, where somebody measured it: it tells how far its centre of mass is from the pivot.
    pub fn swing_period_s(mut self, period_s: Option<f64>) -> Self {
        self.log.swing_period_s = period_s;
        self
    }

    /// Takes a sample in and says what is known after it. One that no log of strokes can have (a value that is no number or far too large, a time before
    /// that of the last) is counted in [`StrokesEstimate::refused`], and nothing else.
    pub fn push(&mut self, sample: &PivotSample) -> &StrokesEstimate {
        if fault_of(self.recent.back(), sample).is_some() {
            self.estimate.refused += 1;
            return &self.estimate;
        }
        self.halving.push(&mut self.log.samples, MOST_KEPT, *sample);
        let samples = self.halving.seen();
        (self.estimate.samples, self.estimate.time_s) = (samples, sample.time_s);
        if let Some(found) = self.searches.ended(samples) {
            self.take_over(found);
        }
        if self.searches.is_due(samples) {
            self.searches.begin(samples, self.log.clone(), self.options);
            self.estimate.stage = self.estimate.stage.max(Stage::Searching);
        }
        if let Some(follower) = &mut self.follower {
            let followed = follower.push(sample);
            self.estimate.take(followed);
        }
        self.recent.push_back(*sample);
        if self.recent.len() > REPLAYED {
            self.recent.pop_front();
        }
        &self.estimate
    }

    /// What is known after the last sample.
    pub fn estimate(&self) -> &StrokesEstimate {
        &self.estimate
    }

    /// The samples that are kept, from the first: what [`finish`](Self::finish) reconstructs.
    pub fn log(&self) -> &PivotLog {
        &self.log
    }

    /// One in so many samples is kept: 1 up to 16 384 samples, then 2, 4 and so on. A stroke of which fewer than eight are kept is left out, and a lift of
    /// which fewer than three are kept is not seen.
    pub fn kept_every(&self) -> u64 {
        self.halving.every()
    }

    /// What [`reconstruct_strokes`](crate::pivot::reconstruct_strokes) gives for the samples that are kept, byte for byte.
    ///
    /// # Errors
    /// As of that.
    pub fn finish(self) -> Result<PivotReconstruction, PivotReconstructError> {
        reconstruct_strokes(&self.log, &self.options)
    }

    /// Goes on from the result of a search.
    fn take_over(&mut self, found: Found) {
        self.estimate.searched = self.searches.begun_at();
        match found {
            Ok(found) => {
                let (found, posterior) = *found;
                let mut follower = Follower::new(&found, &posterior, &self.options.rig.pad);
                self.recent.iter().for_each(|sample| {
                    follower.push(sample);
                });
                self.follower = Some(follower);
                self.estimate.renew(found);
            }
            // What was known before is worth no less.
            Err(failure) => self.estimate.failure = Some(failure),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::angle::wrapped;
    use crate::pivot::simulate::{PivotSimulateOptions, PivotSimulation, Stroke, simulate_strokes};
    use crate::sensor::Touchpad;
    use crate::shape::{NamedShape, SupportFunction};

    fn egg() -> SupportFunction {
        NamedShape::Egg.shape(0.03).expect("a shape").translated(0.004, 0.003)
    }

    fn felt(shape: &SupportFunction) -> PivotSimulation {
        let strokes = [0.65, 0.35, 0.7, 0.3].map(|to_m| Stroke { along_m: vec![0.5, to_m], press: 3.0 });
        let touchpad = Touchpad { noise_sd_m: 1e-4, length_m: 1.0, ..Touchpad::ideal() };
        let options = PivotSimulateOptions { touchpad, arm_noise_sd_m: 2e-5, ..PivotSimulateOptions::default() };
        simulate_strokes(shape, &strokes, &options).expect("it runs")
    }

    #[test]
    fn an_object_is_followed_certified_and_finished_as_the_reconstruction_has_it() {
        let simulation = felt(&egg());
        let mut live = LiveStrokes::new(PivotOptions::default());
        assert_eq!(live.estimate().reason(), "too few samples for a first search");
        let (mut placed, mut certified, mut within) = (0, 0, 0);
        let mut off = None;
        let contacts = simulation.theta_rad.iter().zip(&simulation.truth.motion);
        for (sample, (theta, truth)) in simulation.log.samples.iter().zip(contacts) {
            let estimate = live.push(sample);
            assert!(estimate.psi_rad.is_none() || sample.s_m.is_some(), "no angle without a contact");
            assert!(estimate.samples <= 60 || !estimate.reason().is_empty() || estimate.is_certified());
            let told = theta.and(estimate.psi_rad.zip(estimate.psi_sd_rad)).filter(|_| estimate.is_certified());
            certified += u32::from(estimate.is_certified());
            if let Some((psi_rad, sd_rad)) = told {
                // The frame of the result is turned by a constant.
                let turned = wrapped(psi_rad - truth.psi_rad);
                let off = wrapped(turned - *off.get_or_insert(turned));
                placed += 1;
                within += u32::from(off.abs() < 3.0 * sd_rad.hypot(0.01));
            }
        }
        assert!(certified > 300 && placed > 200, "{certified} certified, {placed} placed");
        assert!(f64::from(within) > 0.98 * f64::from(placed), "{within} of {placed}");
        let batch = reconstruct_strokes(&simulation.log, &PivotOptions::default()).expect("a result");
        assert!(live.estimate().is_certified() && live.estimate().coverage > 0.9 * batch.coverage);
        assert_eq!(live.finish().expect("a result"), batch);
    }

    #[test]
    fn the_same_samples_give_the_same_estimates_however_fast_they_come() {
        let samples = &felt(&egg()).log.samples[..400];
        let told = |pause: bool| -> Vec<String> {
            let mut live = LiveStrokes::new(PivotOptions::default());
            let all = samples.iter().map(|sample| {
                if pause {
                    std::thread::sleep(std::time::Duration::from_millis(2));
                }
                format!("{:?}", live.push(sample))
            });
            all.collect()
        };
        assert!(told(false) == told(true));
    }

    #[test]
    fn what_no_log_has_is_refused_and_bad_options_are_told() {
        let samples = felt(&egg()).log.samples;
        let mut live = LiveStrokes::new(PivotOptions::default().harmonics(Some(1)));
        for sample in &samples[..120] {
            live.push(sample);
        }
        assert!(live.estimate().reason().contains("harmonics"), "{}", live.estimate().reason());
        let late = PivotSample { time_s: -1.0, ..samples[120] };
        let wrong = PivotSample { pivot_y_m: f64::NAN, ..samples[120] };
        assert_eq!((live.push(&late).refused, live.push(&wrong).refused, live.log().samples.len()), (1, 2, 120));
        assert!(live.finish().is_err());
    }

    #[test]
    fn a_long_stream_is_thinned() {
        let sample = |index: usize| PivotSample { time_s: index as f64, pivot_x_m: 0.5, pivot_y_m: 0.03, s_m: None };
        let mut live = LiveStrokes::new(PivotOptions::default());
        for index in 0..MOST_KEPT {
            live.push(&sample(index));
        }
        assert_eq!((live.kept_every(), live.log().samples.len()), (1, MOST_KEPT));
        live.push(&sample(MOST_KEPT));
        assert_eq!((live.kept_every(), live.log().samples.len()), (2, MOST_KEPT / 2 + 1));
        assert!(live.estimate().reason().contains("samples with a contact"), "{}", live.estimate().reason());
    }

    #[test]
    fn the_newest_samples_are_decoded_anew_and_no_others() {
        let sample = |index: usize| PivotSample { time_s: index as f64, pivot_x_m: 0.5, pivot_y_m: 0.03, s_m: None };
        let mut live = LiveStrokes::new(PivotOptions::default());
        let kept: Vec<usize> = (0..=REPLAYED)
            .map(|index| {
                live.push(&sample(index));
                live.recent.len()
            })
            .collect();
        assert_eq!((kept[REPLAYED - 2], kept[REPLAYED - 1], kept[REPLAYED]), (REPLAYED - 1, REPLAYED, REPLAYED));
        assert_eq!(live.recent.front().map(|sample| sample.time_s), Some(1.0));
    }
}
