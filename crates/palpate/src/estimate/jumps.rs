//! Detection of jumps in a motion, and whether statics predicts them (`docs/theory.md`, jumps): at a jump the potential energy
//! falls, and the new pose is the minimum that the object descends to from the old one.

use crate::estimate::motion::{LONGEST_STEP, SMALLEST_STEP, outlying_steps};
use crate::log::Log;
use crate::math::angle::wrapped;
use crate::mechanics::passage::{barrier_m, carried, is_same_pose};
use crate::mechanics::{EnergyLandscape, Forces, STANDARD_GRAVITY_M_PER_S2};
use crate::palms::PalmPair;
use crate::shape::SupportFunction;

/// Energy barrier that errors of the shape may cause where there is none, as a rise of the centre of mass and a share of the mean
/// radius. Larger values certify physically impossible jumps, smaller ones refuse true ones a few samples early.
pub(crate) const BARRIER_ALLOWANCE: f64 = 3e-3;

/// Longest ringing after a jump, samples: a longer one would hide a second jump.
const LONGEST_RINGING: usize = 60;

/// A step of the ringing may exceed the jump itself by this at most, radians.
const LONGEST_SWING: f64 = 0.5;

/// A step back against the jump is no part of its ringing where it takes more than all of its energy: an object of no less than this share of the radius of
/// gyration of an even mass turns no faster than the fall drives it.
const LEAST_GYRATION: f64 = 0.5;

/// Ringing has ended after so many small steps.
const QUIET_STEPS: usize = 4;

/// A jump is reversed when the next one comes back to within this share of its turn.
pub(crate) const REVERSED: f64 = 0.5;

/// The object went from one pose to another between two samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DetectedJump {
    /// First sample after it.
    pub sample: usize,
    /// Orientations before and after, radians.
    pub psi_before: f64,
    pub psi_after: f64,
    /// Heights of the centre of mass over the same palms, metres.
    pub height_before_m: f64,
    pub height_after_m: f64,
    /// Whether an object at rest would jump like this, up to errors of the shape.
    pub physical: bool,
    /// Whether statics predicts it exactly: no barrier had to be attributed to errors of the shape.
    pub predicted: bool,
}

impl DetectedJump {
    /// By how much the object turned, radians.
    pub fn turn(&self) -> f64 {
        self.psi_after - self.psi_before
    }

    /// The fastest that the fall lets the object swing, rad/s: ½ k² ω² = g Δh.
    fn fastest_swing_rad_per_s(&self, shape: &SupportFunction) -> f64 {
        let fall_m = (self.height_before_m - self.height_after_m).max(0.0);
        let gyration_m = LEAST_GYRATION * shape.uniform_gyration_radius_m();
        (2.0 * STANDARD_GRAVITY_M_PER_S2 * fall_m).sqrt() / gyration_m
    }

    /// Whether none of these steps, each with its seconds, leads back against the jump faster than so many rad/s. (Towards its end an object without inertia
    /// goes at once.)
    fn swings_by(&self, steps: impl IntoIterator<Item = (f64, f64)>, fastest_rad_per_s: f64) -> bool {
        steps.into_iter().all(|(step, interval_s)| {
            step * self.turn() > 0.0 || step.abs() < LONGEST_STEP + fastest_rad_per_s * interval_s
        })
    }

    /// Whether a step from one sample to the next, by so many radians, may be part of the ringing about this jump: not much longer than it. Half a
    /// turn there and half a turn on, back to the pose before, is no jump that anything rings about.
    fn rings_with(&self, step: f64) -> bool {
        step < wrapped(self.turn()).abs() + LONGEST_SWING
    }
}

/// The jumps in an unwrapped motion of `shape`, each at a later sample than the one before; a fast slide along one branch of poses is none.
pub(crate) fn detect_jumps(shape: &SupportFunction, log: &Log, psi: &[f64]) -> Vec<DetectedJump> {
    let palms = &log.palms();
    let mut jumps = Vec::new();
    // The motion up to this sample is accounted for: the ringing about a later jump does not reach back over an earlier one.
    let mut settled = 0;
    for sample in outlying_steps(psi) {
        if sample <= settled {
            continue;
        }
        let direct = passage(shape, palms, (sample - 1, psi[sample - 1]), (sample, psi[sample]));
        if direct.physical {
            if direct.jumped {
                jumps.push(direct.jump);
                settled = sample;
            }
            continue;
        }
        // Not from one equilibrium to another: perhaps from before the ringing to after it.
        let rest_before = (settled.max(sample.saturating_sub(LONGEST_RINGING))..sample)
            .rev()
            .find(|&i| i == settled || (psi[i] - psi[i - 1]).abs() < SMALLEST_STEP)
            .unwrap_or(sample - 1);
        let last = (sample + LONGEST_RINGING).min(psi.len() - 1);
        let quiet = |i: usize| {
            (i + 1..(i + 1 + QUIET_STEPS).min(psi.len())).all(|j| (psi[j] - psi[j - 1]).abs() < SMALLEST_STEP)
        };
        let rest_after = (sample..last).find(|&i| quiet(i)).unwrap_or(last);
        let whole = passage(shape, palms, (rest_before, psi[rest_before]), (rest_after, psi[rest_after]));
        // The jump is the longest step of the ringing.
        let step = |i: usize| (psi[i] - psi[i - 1]).abs();
        let longest = (rest_before + 1..=rest_after).max_by(|a, b| step(*a).total_cmp(&step(*b))).unwrap_or(sample);
        let steps = (rest_before + 1..=rest_after).map(|i| (psi[i] - psi[i - 1], log.interval_s(i)));
        let is_driven = || !whole.jumped || whole.jump.swings_by(steps, whole.jump.fastest_swing_rad_per_s(shape));
        if whole.physical && whole.contains(step(longest)) && is_driven() {
            jumps.extend(whole.jumped.then_some(DetectedJump { sample: longest, ..whole.jump }));
            settled = rest_after;
        } else {
            jumps.push(direct.jump);
            settled = sample;
        }
    }
    jumps
}

/// Number of jumps that the next one reverses at once, without statics predicting both exactly: such an object alternates between
/// equilibria that next to no energy barrier separates, and its pose follows the noise.
pub(crate) fn jump_reversals(jumps: &[DetectedJump]) -> usize {
    jumps
        .windows(2)
        .filter(|pair| {
            let [one, two] = [pair[0], pair[1]];
            let at_once = two.sample - one.sample <= LONGEST_RINGING;
            let undone = (two.psi_after - one.psi_before).abs() < REVERSED * one.turn().abs();
            at_once && undone && !(one.predicted && two.predicted)
        })
        .count()
}

/// The comparison of a step with statics.
struct Passage {
    jump: DetectedJump,
    /// Whether the object left its branch of equilibria.
    jumped: bool,
    /// Whether statics allows it, up to errors of the shape.
    physical: bool,
}

impl Passage {
    /// Whether a step from one sample to the next, by so many radians, may be part of this: of the ringing about a jump, or of a slide along one
    /// branch, about which nothing rings, so that it is hardly longer than all of the slide: noise alone turns a pose that is not well known.
    fn contains(&self, step: f64) -> bool {
        if self.jumped { self.jump.rings_with(step) } else { step < wrapped(self.jump.turn()).abs() + LONGEST_STEP }
    }
}

/// Compares the step from the pose at sample `from` to that at sample `to` with what statics predicts.
fn passage(shape: &SupportFunction, palms: &[PalmPair], from: (usize, f64), to: (usize, f64)) -> Passage {
    let ((from, before), (to, after)) = (from, to);
    let landscape = EnergyLandscape::new(shape, &palms[to]);
    let height = |psi: f64| landscape.height_m(psi);
    let (end, jumped) = carried(&Forces::default(), shape, &palms[from..=to], before);
    let predicted = is_same_pose(end, after);
    let allowance_m = BARRIER_ALLOWANCE * shape.mean_radius_m();
    // With errors of the shape the old pose may still seem stable: the barrier in between must be negligible.
    let over_a_negligible_barrier = !predicted && {
        let bottom = landscape.descend(after);
        barrier_m(height, before, after) <= allowance_m
            && (is_same_pose(bottom, after) || height(after) <= height(bottom) + allowance_m)
    };
    let physical = predicted || over_a_negligible_barrier;
    let jump = DetectedJump {
        sample: to,
        psi_before: before,
        psi_after: after,
        height_before_m: height(before),
        height_after_m: height(after),
        physical,
        predicted,
    };
    Passage { jump, jumped: if predicted { jumped } else { !is_same_pose(before, after) }, physical }
}

#[cfg(test)]
mod tests;
