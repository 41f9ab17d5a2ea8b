//! The pose of the newest samples: hypotheses that each continue from sample to sample, branch where the best of them explains a sample no longer
//! (the object jumped), and end when they cost too much; a sample is decided on when one hypothesis is left, or it is old (fixed-lag Viterbi
//! decoding; `docs/theory.md`, decoding of the motion).

use std::collections::VecDeque;

use crate::estimate::association::transitions::near;
use crate::estimate::evidence::motion_prior::{CERTAIN, UNPREDICTED_JUMP};
use crate::estimate::measurements::Instant;
use crate::live::shape_belief::{Settled, ShapeBelief};
use crate::math::angle::wrapped_to;

/// Squared standard deviations by which a sample is missed above which it does not bend the shape.
pub(super) const UNEXPLAINED: f64 = 25.0;

/// The same above which other poses are looked for: one in a hundred samples misses its own pose by as much, and an object that jumped may miss the
/// one before by no more for long, where that has boundary at the contacts that is not known well.
const DOUBTFUL: f64 = 12.0;

/// What a sample costs at most: less than a jump there and back, so that a stray reading moves no pose.
const MOST_COST: f64 = 30.0;

/// Hypotheses at most, and those that cost more than the best by so many times what makes a pose certain end.
const MOST_HYPOTHESES: usize = 6;
const ENDS: f64 = 2.0;

/// Samples that wait for a decision at most.
const LAG: usize = 64;

#[derive(Clone)]
struct Hypothesis {
    /// Cost, −2 ln of the likelihood.
    cost: f64,
    newest: Settled,
    /// Orientations of the samples that wait, the newest last.
    psi: VecDeque<f64>,
}

/// The hypotheses.
#[derive(Clone)]
pub(super) struct Poses {
    waiting: VecDeque<Instant>,
    hypotheses: Vec<Hypothesis>,
    decided_psi: f64,
}

/// A sample that was decided on.
pub(super) struct Decided {
    pub instant: Instant,
    pub psi: f64,
}

impl Poses {
    /// Behind a sample at this orientation.
    pub fn from(psi: f64) -> Self {
        Self { waiting: VecDeque::new(), hypotheses: Vec::new(), decided_psi: psi }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.hypotheses.len()
    }

    /// The orientation of the newest sample by the best of them.
    pub fn best(&self) -> Settled {
        self.hypotheses.first().map_or(Settled { psi: self.decided_psi, misfit: 0.0 }, |best| best.newest)
    }

    /// The distance of the furthest other orientation that the newest sample may have, radians; 0 without one.
    pub fn ambiguity_rad(&self) -> f64 {
        let best = self.best().psi;
        self.hypotheses.iter().map(|other| (other.newest.psi - best).abs()).fold(0.0, f64::max)
    }

    /// Takes the next sample in, and gives those that are decided on with it.
    pub fn push(&mut self, instant: Instant, shape: &ShapeBelief) -> Vec<Decided> {
        if self.hypotheses.is_empty() {
            let newest = Settled { psi: self.decided_psi, misfit: 0.0 };
            self.hypotheses.push(Hypothesis { cost: 0.0, newest, psi: VecDeque::new() });
        }
        let (before_psi, before_cost) = (self.hypotheses[0].psi.clone(), self.hypotheses[0].cost);
        for hypothesis in &mut self.hypotheses {
            hypothesis.take(shape.settled(&instant, hypothesis.newest.psi));
        }
        self.waiting.push_back(instant);
        self.sort(shape.period_rad());
        if self.best().misfit > DOUBTFUL {
            let from = self.best().psi;
            for there in shape.elsewhere(&instant, from) {
                // By the shorter way round.
                let psi = from + wrapped_to(there.psi - from, shape.period_rad());
                let newest = Settled { psi, ..there };
                let cost = before_cost + UNPREDICTED_JUMP.deviance();
                let mut other = Hypothesis { cost, newest, psi: before_psi.clone() };
                other.take(newest);
                self.hypotheses.push(other);
            }
            self.sort(shape.period_rad());
        }
        // Costs count from that of the best.
        let least = self.hypotheses.first().map_or(0.0, |best| best.cost);
        self.hypotheses.iter_mut().for_each(|hypothesis| hypothesis.cost -= least);
        self.decide()
    }

    /// The best first; of those at one pose only the best, and none that is far behind.
    fn sort(&mut self, period: f64) {
        self.hypotheses.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let least = self.hypotheses.first().map_or(0.0, |best| best.cost);
        let mut kept: Vec<Hypothesis> = Vec::new();
        for hypothesis in self.hypotheses.drain(..) {
            let is_known = kept.iter().any(|other| near(other.newest.psi, hypothesis.newest.psi, period));
            let is_behind = hypothesis.cost > least + ENDS * CERTAIN.deviance();
            if kept.len() < MOST_HYPOTHESES && !is_known && !is_behind {
                kept.push(hypothesis);
            }
        }
        self.hypotheses = kept;
    }

    fn decide(&mut self) -> Vec<Decided> {
        let keeps = if self.hypotheses.len() > 1 { LAG } else { 0 };
        let mut decided = Vec::new();
        while self.waiting.len() > keeps
            && let Some(instant) = self.waiting.pop_front()
        {
            for (index, hypothesis) in self.hypotheses.iter_mut().enumerate() {
                let psi = hypothesis.psi.pop_front().unwrap_or(hypothesis.newest.psi);
                if index == 0 {
                    self.decided_psi = psi;
                }
            }
            decided.push(Decided { instant, psi: self.decided_psi });
        }
        decided
    }
}

impl Hypothesis {
    fn take(&mut self, newest: Settled) {
        self.newest = newest;
        // No number is no explanation.
        self.cost += if newest.misfit < MOST_COST { newest.misfit } else { MOST_COST };
        self.psi.push_back(newest.psi);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    use crate::estimate::measurements::Measurements;
    use crate::estimate::model::layout::Layout;
    use crate::estimate::model::noise::Noise;
    use crate::estimate::model::prior::Prior;
    use crate::estimate::solver::posterior::Posterior;
    use crate::math::angle::wrapped;
    use crate::plan::{PalmLimits, plan_turn};
    use crate::sensor::Touchpad;
    use crate::shape::NamedShape;
    use crate::simulate::{SimulateOptions, simulate};
    use nalgebra::{DMatrix, DVector};

    const NOISE: Noise = Noise { sensor_m: 1e-4, balance_m: 1e-5 };

    /// A known shape, and exact samples of it with their orientations while palms turn it round without a jump.
    fn setting() -> (ShapeBelief, Vec<(Instant, f64)>) {
        setting_with(Touchpad::ideal())
    }

    fn setting_with(touchpad: Touchpad) -> (ShapeBelief, Vec<(Instant, f64)>) {
        setting_known_to(1e-6, touchpad)
    }

    /// Each coefficient of the shape is known to this standard deviation, metres.
    fn setting_known_to(sd_m: f64, touchpad: Touchpad) -> (ShapeBelief, Vec<(Instant, f64)>) {
        let shape = NamedShape::Pebble.shape(0.03).expect("a positive size");
        let plan = plan_turn(&shape, &PalmLimits::default(), 40.0).expect("a motion without a jump");
        let options = SimulateOptions { touchpad, start_psi_rad: plan.start_psi_rad, ..SimulateOptions::default() };
        let run = simulate(&shape, &plan.motion.sample(20.0).expect("possible"), &options).expect("possible");
        let psi = run.truth.motion.iter().map(|pose| pose.psi_rad);
        let samples = Measurements::new(&run.log, None).instants.into_iter().zip(psi).collect();
        let mean = DVector::from_vec(shape.coefficients());
        let layout = Layout::of_coefficients(mean.as_slice());
        let belief = Posterior { layout, information: DMatrix::identity(mean.len(), mean.len()) / (sd_m * sd_m), mean };
        (ShapeBelief::new(belief, NOISE, Prior::new(0.03, 0.015)).expect("determined"), samples)
    }

    fn all(poses: &mut Poses, shape: &ShapeBelief, samples: &[(Instant, f64)]) -> Vec<Decided> {
        samples.iter().flat_map(|(instant, _)| poses.push(*instant, shape)).collect()
    }

    #[test]
    fn a_motion_is_followed_and_each_sample_decided_on_at_once() {
        let (shape, here) = setting();
        let mut poses = Poses::from(here[0].1);
        let decided = all(&mut poses, &shape, &here[..50]);
        assert_eq!((decided.len(), poses.count()), (50, 1));
        assert!(decided.iter().zip(&here).all(|(decided, (_, psi))| (decided.psi - psi).abs() < 1e-3));
        assert!(poses.best().misfit < 1.0 && poses.ambiguity_rad() == 0.0);
    }

    #[test]
    fn a_stray_reading_moves_no_pose() {
        let (shape, here) = setting();
        let mut poses = Poses::from(here[0].1);
        let mut samples = here[..80].to_vec();
        samples[40].0.s1 += 0.01;
        let decided = all(&mut poses, &shape, &samples);
        let waits = decided.len();
        assert!(waits + LAG >= 80, "{waits}");
        let before = &decided[..decided.len().min(40)];
        assert!(before.iter().zip(&here).all(|(decided, (_, psi))| (decided.psi - psi).abs() < 1e-3));
        assert!((poses.best().psi - here[79].1).abs() < 1e-3);
    }

    #[test]
    fn a_jump_is_found_and_decided_on() {
        assert_jump_is_found(&setting());
    }

    #[test]
    fn a_jump_is_found_in_noisy_samples_too() {
        let noisy = Touchpad { noise_sd_m: NOISE.sensor_m, ..Touchpad::ideal() };
        assert_jump_is_found(&setting_with(noisy));
    }

    #[test]
    fn a_jump_is_found_where_the_pose_before_nearly_explains_the_samples() {
        let missed =
            |(shape, here): &(ShapeBelief, Vec<(Instant, f64)>)| shape.settled(&here[300].0, here[39].1).misfit;
        let known_to = (0..60).map(|step| setting_known_to(1e-5 * 1.1_f64.powi(step), Touchpad::ideal()));
        let setting = known_to.into_iter().find(|setting| missed(setting) < UNEXPLAINED).expect("a shape hardly known");
        assert!(missed(&setting) > DOUBTFUL);
        assert_jump_is_found(&setting);
    }

    fn assert_jump_is_found((shape, here): &(ShapeBelief, Vec<(Instant, f64)>)) {
        assert!((here[300].1 - here[39].1).abs() > 0.5);
        let mut poses = Poses::from(here[0].1);
        // The palms are at once where they were a quarter of a turn later.
        let samples: Vec<(Instant, f64)> = here[..40].iter().chain(&here[300..400]).copied().collect();
        let decided = all(&mut poses, shape, &samples);
        assert!(decided.len() + LAG >= 140 && poses.count() <= MOST_HYPOTHESES);
        // By the shorter way round: less than half a turn.
        assert!(decided.windows(2).all(|pair| (pair[1].psi - pair[0].psi).abs() < PI));
        let is_there = |(decided, (_, psi)): (&Decided, &(Instant, f64))| wrapped(decided.psi - psi).abs() < 1e-2;
        let found = decided.iter().zip(&samples).filter(|pair| is_there(*pair)).count();
        assert!(found + 2 >= decided.len(), "{found} of {}", decided.len());
    }
}
