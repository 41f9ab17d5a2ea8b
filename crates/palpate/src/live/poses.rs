//! The pose of the newest samples: hypotheses that each continue from sample to sample, branch where the best of them explains a sample no longer
//! (the object jumped), and end when they cost too much; a sample is decided on when one hypothesis is left, or it is old (fixed-lag Viterbi
//! decoding; `docs/theory.md`, decoding of the motion).

use std::collections::VecDeque;

use crate::estimate::association::transitions::near;
use crate::estimate::evidence::motion_prior::{CERTAIN, UNPREDICTED_JUMP};
use crate::estimate::measurements::Instant;
use crate::live::shape_belief::{Settled, ShapeBelief};

/// Squared standard deviations by which a sample is missed above which other poses are looked for, and it does not bend the shape.
pub(super) const UNEXPLAINED: f64 = 25.0;

/// What a sample costs at most: less than a jump there and back, so that a stray reading moves no pose.
const MOST_COST: f64 = 30.0;

/// Hypotheses at most, and those that cost more than the best by so many times what makes a pose certain end.
const MOST_HYPOTHESES: usize = 6;
const ENDS: f64 = 2.0;

/// Samples that wait for a decision at most.
const LAG: usize = 64;

struct Hypothesis {
    /// Cost, −2 ln of the likelihood.
    cost: f64,
    newest: Settled,
    /// Orientations of the samples that wait, the newest last.
    psi: VecDeque<f64>,
}

/// The hypotheses.
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
        if self.best().misfit > UNEXPLAINED {
            for newest in shape.elsewhere(&instant, self.best().psi) {
                let cost = before_cost + UNPREDICTED_JUMP.deviance();
                let mut other = Hypothesis { cost, newest, psi: before_psi.clone() };
                other.take(newest);
                self.hypotheses.push(other);
            }
            self.sort(shape.period_rad());
        }
        self.decide()
    }

    /// The best first; of those at one pose only the best, and none that is far behind.
    fn sort(&mut self, period: f64) {
        self.hypotheses.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let least = self.hypotheses.first().map_or(0.0, |best| best.cost);
        let mut kept: Vec<Hypothesis> = Vec::new();
        for mut hypothesis in self.hypotheses.drain(..) {
            let is_known = kept.iter().any(|other| near(other.newest.psi, hypothesis.newest.psi, period));
            let is_behind = hypothesis.cost > least + ENDS * CERTAIN.deviance();
            if kept.len() < MOST_HYPOTHESES && !is_known && !is_behind {
                hypothesis.cost -= least;
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
