//! A stable pose followed while the palms move, and the jump where it vanishes.
//!
//! The pose is a branch ψ(φ₁, φ₂) of g = 0 with g' > 0. It ends in a fold, g' = 0 (section 6 of Moll & Erdmann 2001: "a
//! discrete change in orientation"); there the object goes downhill to the next minimum of its energy. A step is taken only
//! when Newton and Kantorovich's condition proves, both forward and backward, that the poses at its two ends are the
//! same branch; otherwise it is halved. Near a fold such a step covers a fixed part of the way that is left, so the fold is
//! met to [`SMALLEST_STEP_RAD`] after a few dozen steps.

use std::convert::Infallible;

use super::EnergyLandscape;
use crate::mechanics::jump::Jump;
use crate::palms::{PalmAngles, PalmPair};
use crate::shape::SupportFunction;

/// Palm rotation to which a fold is located, radians.
pub const SMALLEST_STEP_RAD: f64 = 1e-11;

/// The same where only the pose at the end is asked for: near enough that the step over the fold, which moves the object by some 3e-4 rad where it
/// is none, cannot be taken for a jump.
const COARSE_STEP_RAD: f64 = 1e-8;

/// Largest palm rotation in one step, radians.
const LARGEST_STEP_RAD: f64 = 0.02;

/// Palms that turn further than this are not followed step by step: no palms do, radians.
const LARGEST_TURN_RAD: f64 = 100.0;

/// Rotation of the object beyond which the passage of a fold is a jump, radians; a pose that goes on through a nearly
/// vanishing stability moves by some 1e-5 in the step over it.
const SMALLEST_JUMP_RAD: f64 = 1e-3;

/// Follows the stable pose `psi_rad` of `shape` while the palms move evenly from `from` to `to`, both given with their time in seconds.
///
/// `psi_rad` should be stable at `from`; if it is not, the object first goes downhill. `visit` is called with the time (seconds),
/// the palms and ψ after each step and each jump, and may stop the pursuit with an error. Returns ψ at the end (unwrapped)
/// and the jumps on the way; of palms that turn by more than 100 rad, only where the object would go from its pose between
/// the last ones.
///
/// # Errors
/// Those of `visit`.
pub fn follow<E>(
    shape: &SupportFunction,
    from: (f64, PalmPair),
    to: (f64, PalmPair),
    psi_rad: f64,
    visit: impl FnMut(f64, &PalmPair, f64) -> Result<(), E>,
) -> Result<(f64, Vec<Jump>), E> {
    let pursuit = Pursuit::new(shape, from, psi_rad);
    pursuit.followed_to(to, visit)
}

/// A stable pose that is being followed, from one pair of palms to the next.
#[derive(Clone, Debug)]
pub(crate) struct Pursuit<'a> {
    shape: &'a SupportFunction,
    time_s: f64,
    palms: PalmPair,
    landscape: EnergyLandscape,
    psi: f64,
    smallest_step_rad: f64,
}

impl<'a> Pursuit<'a> {
    /// At the stable pose `psi_rad` between palms at their time in seconds, or where the object goes downhill from there.
    pub(crate) fn new(shape: &'a SupportFunction, (time_s, palms): (f64, PalmPair), psi_rad: f64) -> Self {
        let landscape = EnergyLandscape::new(shape, &palms);
        let psi = landscape.continued(psi_rad).unwrap_or_else(|| landscape.descend(psi_rad));
        Self { shape, time_s, palms, landscape, psi, smallest_step_rad: SMALLEST_STEP_RAD }
    }

    /// ψ at `to`, and the jumps on the way.
    fn followed_to<E>(
        mut self,
        to: (f64, PalmPair),
        mut visit: impl FnMut(f64, &PalmPair, f64) -> Result<(), E>,
    ) -> Result<(f64, Vec<Jump>), E> {
        let jumps = self.go_on(to, &mut |time_s, palms, _, psi| visit(time_s, palms, psi))?;
        Ok((self.psi, jumps))
    }

    /// The orientation now, radians, unwrapped.
    pub(crate) fn psi_rad(&self) -> f64 {
        self.psi
    }

    /// Goes on while the palms move evenly to `to`, as [`follow`] does; `visit` is given the angles of the palms as well.
    pub(crate) fn go_on<E>(
        &mut self,
        (to_s, to): (f64, PalmPair),
        visit: &mut impl FnMut(f64, &PalmPair, &PalmAngles, f64) -> Result<(), E>,
    ) -> Result<Vec<Jump>, E> {
        let mut jumps = Vec::new();
        let from = std::mem::replace(&mut self.palms, to);
        let from_s = std::mem::replace(&mut self.time_s, to_s);
        let time_at = |done: f64| from_s + (to_s - from_s) * done;
        let turn = (to.phi1_rad - from.phi1_rad).abs().max((to.phi12_rad() - from.phi12_rad()).abs());
        if turn == 0.0 {
            visit(time_at(1.0), &to, &to.angles(), self.psi)?;
            return Ok(jumps);
        }
        if self.landscape.is_flat() || turn > LARGEST_TURN_RAD || !turn.is_finite() {
            self.landscape = EnergyLandscape::new(self.shape, &to);
            self.psi = self.landscape.descend(self.psi);
            visit(time_at(1.0), &to, &to.angles(), self.psi)?;
            return Ok(jumps);
        }
        let largest = (LARGEST_STEP_RAD / turn).min(1.0);
        let smallest = (self.smallest_step_rad / turn).max(4.0 * f64::EPSILON);
        let mut forced = smallest;
        let (mut done, mut step) = (0.0, largest);
        while done < 1.0 {
            let next = if done + step >= 1.0 { 1.0 } else { done + step };
            let palms = from.towards(&to, next);
            let angles = palms.angles();
            let ahead = EnergyLandscape::between(self.shape, &palms, &angles);
            let same_branch = ahead.continued(self.psi).filter(|&new| self.landscape.continues_to(new, self.psi));
            if let Some(new) = same_branch {
                (self.psi, self.landscape, done) = (new, ahead, next);
                step = (2.0 * step).min(largest);
                forced = smallest;
                visit(time_at(done), &palms, &angles, self.psi)?;
                continue;
            }
            if step > forced {
                step = (0.5 * step).max(forced);
                continue;
            }
            // At a fold, or at a pose of hardly any stability: step over it and let the object go downhill.
            let over = (done + 10.0 * forced).min(1.0);
            let palms = from.towards(&to, over);
            let angles = palms.angles();
            let beyond = EnergyLandscape::between(self.shape, &palms, &angles);
            let landed = beyond.descend(self.psi);
            if (landed - self.psi).abs() > SMALLEST_JUMP_RAD {
                jumps.push(Jump {
                    time_s: time_at(done),
                    psi_before_rad: self.psi,
                    psi_after_rad: landed,
                    height_before_m: beyond.height_m(self.psi),
                    height_after_m: beyond.height_m(landed),
                    physical: true,
                });
                forced = smallest;
            } else {
                forced *= 2.0;
            }
            (self.psi, self.landscape, done) = (landed, beyond, over);
            step = forced;
            visit(time_at(done), &palms, &angles, self.psi)?;
        }
        Ok(jumps)
    }
}

/// [`follow`] when nobody watches, from time 0 to 1: where it jumps is known to [`COARSE_STEP_RAD`] only.
pub(crate) fn followed(shape: &SupportFunction, from: &PalmPair, to: &PalmPair, psi_rad: f64) -> (f64, Vec<Jump>) {
    let pursuit = Pursuit { smallest_step_rad: COARSE_STEP_RAD, ..Pursuit::new(shape, (0.0, *from), psi_rad) };
    let Ok(end) = pursuit.followed_to((1.0, *to), |_, _, _| Ok::<(), Infallible>(()));
    end
}
