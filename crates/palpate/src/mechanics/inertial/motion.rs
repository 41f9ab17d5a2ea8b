//! The exact motion of an object with inertia between frictionless palms that move along a smooth curve.
//!
//! W of [`moment`](super::moment) is linear in ψ'', so that ψ'' = −W(ψ'' = 0)/W_ψ''. That is integrated by extrapolating the modified midpoint rule
//! (Gragg, Bulirsch and Stoer; order 12), with steps as short as the difference of its last two columns asks.

use super::moment::Inertia;
use super::moving_palms::{MovingPalms, PalmCurve};
use crate::mechanics::EnergyLandscape;
use crate::mechanics::force_model::{ForceModel, MotionState};
use crate::mechanics::frictionless::Frictionless;
use crate::palms::{Contacts, Palm, PalmPair};
use crate::shape::SupportFunction;

/// An object on its way.
#[derive(Clone, Debug)]
pub(crate) struct InertialPursuit<'a> {
    shape: &'a SupportFunction,
    inertia: Inertia,
    curve: PalmCurve,
    time_s: f64,
    /// ψ and ψ'.
    state: State,
    /// Seconds that the next step is tried with.
    step_s: f64,
}

type State = [f64; 2];

/// A palm would have to pull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LostContact {
    pub time_s: f64,
    pub palm: Palm,
}

/// Columns of the extrapolation: order 12.
const COLUMNS: usize = 6;

/// Largest error of a step: radians, and radians per second.
const ERROR: f64 = 1e-11;

/// Steps grow where they are that much more exact than they need to be; shorter ones than the least, in seconds, gain nothing.
const GROWS_BELOW: f64 = 1e-3;
const LEAST_STEP_S: f64 = 1e-7;

impl<'a> InertialPursuit<'a> {
    /// At rest between the first palms of a motion, next to some orientation, and moving along with them.
    pub fn new(shape: &'a SupportFunction, inertia: Inertia, motion: &[(f64, PalmPair)], psi_rad: f64) -> Self {
        let (time_s, first) = motion[0];
        let landscape = EnergyLandscape::new(shape, &first);
        let psi = landscape.continued(psi_rad).unwrap_or_else(|| landscape.descend(psi_rad));
        let mut pursuit =
            Self { shape, inertia, curve: PalmCurve::new(motion), time_s, state: [psi, 0.0], step_s: f64::INFINITY };
        let palms = pursuit.curve.at(time_s);
        let at_rest = MotionState::at_rest(palms.angles, pursuit.contacts(&palms, psi));
        let [by_palm1, by_palm2] = Frictionless.by_palms(&at_rest);
        let rate = -(by_palm1 * palms.rates[0] + by_palm2 * palms.rates[1]) / Frictionless.residual(&at_rest).by_psi;
        pursuit.state[1] = if rate.is_finite() { rate } else { 0.0 };
        pursuit
    }

    pub fn psi_rad(&self) -> f64 {
        self.state[0]
    }

    /// Goes on to a later time; returns the normal forces there over the weight.
    ///
    /// # Errors
    /// When a palm would have to pull on the way.
    pub fn go_on(&mut self, to_s: f64) -> Result<[f64; 2], LostContact> {
        while self.time_s < to_s {
            let step_s = self.step_s.min(to_s - self.time_s);
            let (state, error) = self.step(step_s);
            let is_exact = error <= ERROR;
            if !is_exact && step_s > LEAST_STEP_S {
                self.step_s = 0.5 * step_s;
                continue;
            }
            (self.time_s, self.state) = (self.time_s + step_s, state);
            if to_s - self.time_s < LEAST_STEP_S {
                self.time_s = to_s;
            }
            if error < GROWS_BELOW * ERROR {
                self.step_s *= 2.0;
            }
            self.pushing()?;
        }
        self.pushing()
    }

    /// The normal forces over the weight, if both palms push.
    fn pushing(&self) -> Result<[f64; 2], LostContact> {
        let (psi_acceleration, still) = self.acceleration(self.time_s, self.state);
        let forces = self.inertia.moment(&MotionState { psi_acceleration, ..still }, [0.0; 2]).normal_forces;
        let pulls = |palm: usize| forces[palm] < 0.0 || forces[palm].is_nan();
        if pulls(0) || pulls(1) {
            let palm = if pulls(0) { Palm::One } else { Palm::Two };
            return Err(LostContact { time_s: self.time_s, palm });
        }
        Ok(forces)
    }

    fn contacts(&self, palms: &MovingPalms, psi: f64) -> Contacts {
        let ([cos1, cos2], [sin1, sin2]) = palms.contact_directions(psi);
        Contacts::from([self.shape.towards(cos1, sin1), self.shape.towards(cos2, sin2)])
    }

    /// ψ'', and the motion there without it.
    fn acceleration(&self, time_s: f64, [psi, psi_rate]: State) -> (f64, MotionState) {
        let palms = self.curve.at(time_s);
        let still = palms.carrying(self.contacts(&palms, psi), [psi_rate, 0.0]);
        let moment = self.inertia.moment(&still, [0.0; 2]);
        (-moment.value_m / moment.by_psi_acceleration, still)
    }

    fn slope(&self, time_s: f64, state: State) -> State {
        [state[1], self.acceleration(time_s, state).0]
    }

    /// The state after a step, and its error.
    fn step(&self, step_s: f64) -> (State, f64) {
        let mut table: Vec<State> = Vec::with_capacity(COLUMNS);
        let mut error = f64::INFINITY;
        for column in 0..COLUMNS {
            // Aitken and Neville in the square of the step.
            let mut extrapolated = vec![self.midpoint(step_s, 2 * (column + 1))];
            for k in 1..=column {
                let ratio = ((column + 1) as f64 / (column + 1 - k) as f64).powi(2);
                let (finer, coarser) = (extrapolated[k - 1], table[k - 1]);
                extrapolated.push([0, 1].map(|i| finer[i] + (finer[i] - coarser[i]) / (ratio - 1.0)));
            }
            if column > 0 {
                let (best, before) = (extrapolated[column], extrapolated[column - 1]);
                error = (best[0] - before[0]).abs().max((best[1] - before[1]).abs());
            }
            table = extrapolated;
        }
        (table[COLUMNS - 1], if error.is_finite() { error } else { f64::INFINITY })
    }

    /// Gragg's modified midpoint rule with so many steps, an even number.
    fn midpoint(&self, step_s: f64, steps: usize) -> State {
        let h = step_s / steps as f64;
        let along = |from: State, by: f64, slope: State| [0, 1].map(|i| from[i] + by * slope[i]);
        let mut before = self.state;
        let mut here = along(before, h, self.slope(self.time_s, before));
        for step in 1..steps {
            let next = along(before, 2.0 * h, self.slope(self.time_s + h * step as f64, here));
            (before, here) = (here, next);
        }
        let end = self.slope(self.time_s + step_s, here);
        [0, 1].map(|i| 0.5 * (here[i] + before[i] + h * end[i]))
    }
}
