//! Where the object jumped to another pose, and whether it would: at a jump the potential energy falls, and the new pose is
//! the one that the object reaches downhill from the old one.

use crate::estimate::motion::{SMALLEST_STEP, outlying_steps};
use crate::mechanics::passage::{barrier_m, carried, is_same_pose};
use crate::mechanics::{EnergyLandscape, Forces};
use crate::palms::PalmPair;
use crate::shape::SupportFunction;

/// A rise of the centre of mass on the way down that errors of the shape may feign, as a share of the mean radius.
const BARRIER_ALLOWANCE: f64 = 3e-3;

/// Longest ringing after a jump, samples; and how far an object turns between two samples that was only shaken,
/// radians.
const LONGEST_RINGING: usize = 60;

const LONGEST_SWING: f64 = 0.5;

/// The object went from one pose to another between two samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DetectedJump {
    /// First sample after it.
    pub sample: usize,
    pub psi_before: f64,
    pub psi_after: f64,
    /// Heights of the centre of mass over the same palms, metres.
    pub height_before_m: f64,
    pub height_after_m: f64,
    /// Whether an object at rest would have gone this way.
    pub physical: bool,
    /// Whether statics foretells it to the letter: no hill had to be laid to errors of the shape.
    pub predicted: bool,
}

impl DetectedJump {
    /// By how much the object turned, radians.
    pub fn turn(&self) -> f64 {
        self.psi_after - self.psi_before
    }

    /// Whether a step from one sample to the next may be part of the ringing about this jump: not much longer than it.
    fn rings_with(&self, step: &Self) -> bool {
        step.turn().abs() < self.turn().abs() + LONGEST_SWING
    }
}

/// The jumps in an unwrapped motion of `shape`; a fast slide along one branch of poses is none.
pub(crate) fn detect_jumps(shape: &SupportFunction, palms: &[PalmPair], psi: &[f64]) -> Vec<DetectedJump> {
    let mut jumps = Vec::new();
    let mut settled = 0;
    for sample in outlying_steps(psi) {
        if sample < settled {
            continue;
        }
        let direct = passage(shape, palms, (sample - 1, psi[sample - 1]), (sample, psi[sample]));
        if direct.physical {
            jumps.extend(direct.jumped.then_some(direct.jump));
            continue;
        }
        // Not from one rest to another: perhaps from before the unrest to after it.
        let calm_before = (sample.saturating_sub(LONGEST_RINGING)..sample)
            .rev()
            .find(|&i| i == 0 || (psi[i] - psi[i - 1]).abs() < SMALLEST_STEP)
            .unwrap_or(sample - 1);
        let last = (sample + LONGEST_RINGING).min(psi.len() - 1);
        let quiet = |i: usize| (i + 1..(i + 5).min(psi.len())).all(|j| (psi[j] - psi[j - 1]).abs() < SMALLEST_STEP);
        let calm_after = (sample..last).find(|&i| quiet(i)).unwrap_or(last);
        let whole = passage(shape, palms, (calm_before, psi[calm_before]), (calm_after, psi[calm_after]));
        settled = calm_after + 1;
        if whole.physical && whole.jump.rings_with(&direct.jump) {
            // In the unrest the jump is its longest step.
            let step = |i: &usize| (psi[*i] - psi[*i - 1]).abs();
            let longest = (calm_before + 1..=calm_after).max_by(|a, b| step(a).total_cmp(&step(b))).unwrap_or(sample);
            jumps.extend(whole.jumped.then_some(DetectedJump { sample: longest, ..whole.jump }));
        } else {
            jumps.push(direct.jump);
        }
    }
    jumps
}

/// Jumps that are undone at once, though statics foretells neither to the letter: an object that goes to and fro between poses is
/// too round for hills to part them, and seems to be wherever the noise has it.
pub(crate) fn jump_reversals(jumps: &[DetectedJump]) -> usize {
    jumps
        .windows(2)
        .filter(|pair| {
            let [one, two] = [pair[0], pair[1]];
            let at_once = two.sample - one.sample <= LONGEST_RINGING;
            let undone = (two.psi_after - one.psi_before).abs() < 0.5 * one.turn().abs();
            at_once && undone && !(one.predicted && two.predicted)
        })
        .count()
}

struct Passage {
    jump: DetectedJump,
    jumped: bool,
    physical: bool,
}

/// What statics says of the way from the pose at sample `from` to that at sample `to`.
fn passage(shape: &SupportFunction, palms: &[PalmPair], from: (usize, f64), to: (usize, f64)) -> Passage {
    let ((from, before), (to, after)) = (from, to);
    let landscape = EnergyLandscape::new(shape, &palms[to]);
    let height = |psi: f64| landscape.height_m(psi);
    let (end, jumped) = carried(&Forces::default(), shape, &palms[from..=to], before);
    let predicted = is_same_pose(end, after);
    let allowance_m = BARRIER_ALLOWANCE * shape.mean_radius_m();
    // Where the shape, not quite right, would still hold the old pose: the barrier in between must be next to nothing.
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
