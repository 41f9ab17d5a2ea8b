//! Palm motions planned with the shape known, so that an object is turned without a jump and much of it is felt.
//!
//! The stable poses of the object form a `surface` over the palm angles (Moll & Erdmann 2001, section 3). A shortest closed
//! path on it along which ψ grows by 2π turns the object once around (`turn`), and so feels all of the boundary, with either
//! palm. Where there is none, a path that visits whatever can be felt (`visit`) is gone there and back. Either becomes a
//! smooth motion (`timing`) that is tried in simulation before it is handed out (`planned`). With friction the object is carried round (`carry`).

mod carry;
mod error;
mod limits;
mod planned;
mod queue;
mod surface;
mod timing;
mod turn;
mod visit;

use std::f64::consts::TAU;

pub use carry::PalmFriction;
pub use error::PlanError;
pub use limits::PalmLimits;
pub use planned::PlannedMotion;

use crate::palms::PalmMotion;
use crate::shape::SupportFunction;
use carry::Carrying;
use planned::{checked, realised};
use surface::Surface;
use turn::Taste;

/// Stiffness (relative to the median of all stable poses) below which a pose is not used; tried in this order.
const MARGINS: [f64; 4] = [0.4, 0.2, 0.08, 0.01];

/// A motion of `duration_s` seconds that turns `shape` all the way around without a jump and a little further, so that
/// each part is felt by both palms. Where that cannot be, a motion there and back that feels as much as it can.
///
/// # Errors
/// When no motion without a jump exists within `limits`, or a number is out of range.
pub fn plan_turn(shape: &SupportFunction, limits: &PalmLimits, duration_s: f64) -> Result<PlannedMotion, PlanError> {
    plan(shape, limits, duration_s, &Taste::default())
}

/// The same between palms with friction: a motion that carries the object round, as it sticks to one palm while the other slides past it. It holds
/// for all friction within two standard deviations of what is known. Where no whole turn is found, a motion that turns the object as far as one
/// does. Takes some seconds.
///
/// ```
/// use palpate::plan::{PalmFriction, PalmLimits, plan_turn_with_friction};
/// use palpate::shape::SupportFunction;
///
/// let egg = SupportFunction::new(0.03, vec![[2e-3, 0.0], [2e-3, 0.0], [4e-4, 0.0]]);
/// let friction = PalmFriction::known([0.2, 0.3]);
/// let planned = plan_turn_with_friction(&egg, &PalmLimits::default(), 60.0, &friction)?;
/// assert!(planned.full_turn);
/// # Ok::<(), palpate::plan::PlanError>(())
/// ```
///
/// # Errors
/// When friction holds the object wherever the palms go, or a number is out of range.
pub fn plan_turn_with_friction(
    shape: &SupportFunction,
    limits: &PalmLimits,
    duration_s: f64,
    friction: &PalmFriction,
) -> Result<PlannedMotion, PlanError> {
    check(shape, limits, duration_s)?;
    if friction.coefficients == [0.0; 2] && friction.coefficient_sds == [0.0; 2] {
        return plan_turn(shape, limits, duration_s);
    }
    Carrying::new(shape, limits, friction).planned(duration_s)
}

/// A motion of `duration_s` seconds without jumps that depends on `seed`: of random motions of several widths the one
/// that feels the most, and where these feel less than 60 % of the boundary, a planned turn that starts anywhere.
///
/// # Errors
/// When no motion without a jump is found, or a number is out of range.
pub fn plan_jump_free(shape: &SupportFunction, seed: u64, duration_s: f64) -> Result<PlannedMotion, PlanError> {
    const ENOUGH: f64 = 0.6;
    let mut best: Option<PlannedMotion> = None;
    let keep_better = |candidate: Option<PlannedMotion>, best: &mut Option<PlannedMotion>| {
        if let Some(candidate) = candidate
            && best.as_ref().is_none_or(|best| candidate.coverage > best.coverage)
        {
            *best = Some(candidate);
        }
    };
    for attempt in 0..18_u64 {
        let amplitude = [1.0, 0.75, 0.5][(attempt % 3) as usize];
        let motion = PalmMotion::random(seed.wrapping_mul(1000).wrapping_add(attempt), duration_s, amplitude)?;
        let start_psi_rad = TAU * (attempt as f64 * 0.381_966 + seed as f64 * 0.618_034).rem_euclid(1.0);
        keep_better(checked(shape, motion, start_psi_rad, f64::INFINITY).map(|checked| checked.motion), &mut best);
        if best.as_ref().is_some_and(|best| best.coverage >= ENOUGH) {
            break;
        }
    }
    if best.as_ref().is_none_or(|best| best.coverage < ENOUGH) {
        let part = |multiple: f64| (seed as f64 * multiple + 0.5).rem_euclid(1.0);
        let taste = Taste { start: part(0.754_878), backwards: seed % 2 == 1, opening_rad: 1.0 + 0.9 * part(0.569_84) };
        keep_better(plan(shape, &PalmLimits::default(), duration_s, &taste).ok(), &mut best);
    }
    best.ok_or(PlanError::NoMotion)
}

fn plan(
    shape: &SupportFunction,
    limits: &PalmLimits,
    duration_s: f64,
    taste: &Taste,
) -> Result<PlannedMotion, PlanError> {
    check(shape, limits, duration_s)?;
    let mut surface = Surface::new(shape, limits);
    for margin in MARGINS {
        surface.keep_firmer_than(margin);
        // A path close to a fold may not hold once its corners are rounded; another taste finds another path.
        let tastes = [*taste, Taste { opening_rad: Taste::default().opening_rad, ..*taste }, Taste::default()];
        let turn = |taste: &Taste| realised(shape, limits, &surface.full_turn(taste)?, duration_s);
        if let Some(planned) = tastes.iter().find_map(turn) {
            return Ok(planned);
        }
    }
    let mut best: Option<PlannedMotion> = None;
    for margin in MARGINS {
        surface.keep_firmer_than(margin);
        for mut path in surface.visits() {
            path.extend(path.clone().into_iter().rev().skip(1));
            if let Some(planned) = realised(shape, limits, &path, duration_s)
                && best.as_ref().is_none_or(|best| planned.coverage > best.coverage + 0.02)
            {
                best = Some(planned);
            }
        }
    }
    best.ok_or(PlanError::NoMotion)
}

fn check(shape: &SupportFunction, limits: &PalmLimits, duration_s: f64) -> Result<(), PlanError> {
    if shape.has_nonfinite() || shape.mean_radius_m() <= 0.0 || !shape.is_convex() {
        return Err(PlanError::OutOfRange { what: "the shape (not a convex object)" });
    }
    if !limits.are_in_order() {
        return Err(PlanError::OutOfRange { what: "a limit of the palms" });
    }
    if !(duration_s > 0.0 && duration_s.is_finite()) {
        return Err(PlanError::OutOfRange { what: "the duration" });
    }
    Ok(())
}
