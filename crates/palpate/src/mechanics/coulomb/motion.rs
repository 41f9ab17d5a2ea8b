//! The quasistatic motion of an object between palms with Coulomb friction, contact mode by contact mode.
//!
//! As a function of ψ' the moment W of the friction forces falls in two steps, at the rates x₋ < x₊ at which one of the palms is rolled on
//! ([`slip`](super::slip)): there τ of that contact goes from one edge of its cone to the other. Between the steps both contacts slide, with
//! τ_k = −μ_k sign u_k. So there are three moments W₋ ≥ W₀ ≥ W₊, and the object
//!
//! * rolls at x₋ where W₋ > 0 > W₀, and at x₊ where W₀ > 0 > W₊;
//! * slides on both palms along W = 0 for one of the three;
//! * jumps where W₋ < 0 or W₊ > 0: no forces within the cones hold it. It then slides, between palms that stand still, until they do.
//!
//! A mode is followed until what it asks is no longer true; that place is located to [`SMALLEST_STEP_RAD`] of palm rotation. Rolling is
//! integrated by the classical Runge-Kutta method, sliding solved for by Newton's.

use super::cone::{Ratios, at_the_edges, balancing_ratio, moment, moment_by_palms, moment_by_psi};
use super::mode::ContactMode;
use super::slip::{PalmRates, Slip, slip_signs};
use crate::mechanics::frictionless::EnergyLandscape;
use crate::mechanics::jump::Jump;
use crate::palms::{Contacts, PalmAngles, PalmPair};
use crate::shape::SupportFunction;

/// Palm rotation to which a change of the contact mode is located, radians.
const SMALLEST_STEP_RAD: f64 = 1e-11;

/// Largest palm rotation in one step, radians: the fourth-order method is then exact to 1e-12 over a radian.
const LARGEST_STEP_RAD: f64 = 4e-3;

/// Step of a slide between palms that stand still, radians of ψ; events on the way are located by halving.
const SLIDE_STEP_RAD: f64 = 1e-3;

/// Such a slide ends here: whole turns bring no object to rest.
const LONGEST_SLIDE_RAD: f64 = 20.0;

/// A slide of more than this is a jump, radians.
const SMALLEST_JUMP_RAD: f64 = 1e-3;

/// Moments below this share of the mean radius are zero: what a change of the contact mode is missed by.
const NOTHING: f64 = 1e-10;

/// Where a mode ends, moments up to so many times that are zero: what is left after the last step must not decide what comes next.
const NOTHING_AT_ENDS: f64 = 4.0;

/// Newton's steps to a sliding pose at most.
const MOST_NEWTON_STEPS: usize = 12;

/// A sliding pose that Newton's method finds further from where its rate leads, as a share of the way, may be another one.
const OTHER_BRANCH: f64 = 0.2;

/// A slide between palms that stand still begins with a step of this, radians: it may start where W = 0.
const KICK_RAD: f64 = 1e-7;

/// Rates of the two rolls that differ by less, radians for each radian that the palms turn, are one: the object sticks to both palms.
const SAME_RATE: f64 = 1e-12;

/// What the object does.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Motion {
    /// Rests on both palms, or moves with them.
    Rest,
    /// Rolls on a palm (0 or 1).
    Roll(usize),
    /// Slides on both, with these signs of the slips.
    Slide([f64; 2]),
    /// Nothing holds it: it slides in this direction of ψ while the palms stand still.
    Jump(f64),
}

/// An object that is followed from one pair of palms to the next.
#[derive(Clone, Debug)]
pub(crate) struct FrictionPursuit<'a> {
    shape: &'a SupportFunction,
    friction: [f64; 2],
    time_s: f64,
    palms: PalmPair,
    psi: f64,
    motion: Motion,
}

/// The object at one instant of the motion of the palms.
struct Instant {
    angles: PalmAngles,
    at: Contacts,
    rates: PalmRates,
    slip: Slip,
    /// The palm that is rolled on at the smaller rate and that at the larger, and these rates.
    order: [usize; 2],
    rolling: [f64; 2],
    /// Signs of the slips below, between and above these rates.
    signs: [[f64; 2]; 3],
    /// W there, metres.
    moments_m: [f64; 3],
}

/// What an observer of the motion is told.
pub(crate) struct Seen<'a> {
    pub time_s: f64,
    pub palms: &'a PalmPair,
    pub angles: PalmAngles,
    pub psi_rad: f64,
    /// Tangential over normal force at both contacts.
    pub tau: Ratios,
    pub modes: [ContactMode; 2],
}

impl Instant {
    fn new(shape: &SupportFunction, friction: [f64; 2], palms: &PalmPair, rates: PalmRates, psi: f64) -> Self {
        let angles = palms.angles();
        let (theta1, theta2) = palms.contact_angles(psi);
        let at = Contacts::from([shape.at(theta1), shape.at(theta2)]);
        let slip = Slip::new(palms, &angles, &at, &rates);
        let rolling = [slip.rolling_rate(0), slip.rolling_rate(1)];
        // Between palms that turn as one both rates are that of the palms: rounding must not decide their order.
        let order = if rolling[0] <= rolling[1] + SAME_RATE { [0, 1] } else { [1, 0] };
        let signs = slip_signs(slip.by_psi_rate, order);
        let moments_m = signs.map(|signs| moment(&angles, &at, at_the_edges(friction, signs)));
        Self { angles, at, rates, slip, order, rolling: order.map(|k| rolling[k]), signs, moments_m }
    }

    /// How fast W with the signs of a level changes when ψ changes at some rate, metres.
    fn change(&self, friction: [f64; 2], level: usize, rate: f64) -> f64 {
        let (by_palms, by_psi) = self.slopes(friction, self.signs[level]);
        by_palms + by_psi * rate
    }

    /// How fast W with these signs changes with the palms, and its slope by ψ.
    fn slopes(&self, friction: [f64; 2], signs: [f64; 2]) -> (f64, f64) {
        let tau = at_the_edges(friction, signs);
        let [by_palm1, by_palm2] = moment_by_palms(&self.angles, &self.at, tau);
        let [w1, w2] = self.rates.angles;
        (by_palm1 * w1 + by_palm2 * w2, moment_by_psi(&self.angles, &self.at, tau))
    }

    /// Whether the object may slide along W = 0 of a level: stably, and with the slips of that level.
    fn may_slide(&self, friction: [f64; 2], level: usize) -> bool {
        let (by_palms, by_psi) = self.slopes(friction, self.signs[level]);
        let rate = -by_palms / by_psi;
        let [first, second] = self.rolling;
        let has_its_slips = match level {
            0 => rate <= first,
            1 => first <= rate && rate <= second,
            _ => second <= rate,
        };
        by_psi < 0.0 && has_its_slips
    }
}

impl<'a> FrictionPursuit<'a> {
    /// At `psi_rad` between palms at their time in seconds, or where the object slides to from there.
    pub fn new(shape: &'a SupportFunction, friction: [f64; 2], (time_s, palms): (f64, PalmPair), psi_rad: f64) -> Self {
        let mut pursuit = Self { shape, friction, time_s, palms, psi: psi_rad, motion: Motion::Rest };
        let still = pursuit.instant(&palms, PalmRates::between(&palms, &palms), psi_rad);
        // The levels below and above the one rate at which both contacts stick.
        if still.moments_m[0] < 0.0 {
            pursuit.psi = pursuit.slid(&palms, psi_rad, -1.0);
        } else if still.moments_m[2] > 0.0 {
            pursuit.psi = pursuit.slid(&palms, psi_rad, 1.0);
        }
        pursuit
    }

    /// The orientation now, radians, unwrapped.
    pub fn psi_rad(&self) -> f64 {
        self.psi
    }

    /// Goes on while the palms move evenly to `to`, given with its time in seconds. `visit` is told of each step and each jump, and may stop
    /// the pursuit with an error. Returns the jumps on the way.
    pub fn go_on<E>(
        &mut self,
        (to_s, to): (f64, PalmPair),
        visit: &mut impl FnMut(&Seen) -> Result<(), E>,
    ) -> Result<Vec<Jump>, E> {
        let mut jumps = Vec::new();
        let from = std::mem::replace(&mut self.palms, to);
        let from_s = std::mem::replace(&mut self.time_s, to_s);
        let time_at = |done: f64| from_s + (to_s - from_s) * done;
        let rates = PalmRates::between(&from, &to);
        let turn = rates.angles[0].abs().max(rates.angles[1].abs());
        let travel_m = rates.bases_m.iter().flatten().fold(0.0_f64, |most, along| most.max(along.abs()));
        // Base points that move count by the turn that they amount to, seen from the object.
        let way = turn + travel_m / self.shape.mean_radius_m();
        if way == 0.0 || !way.is_finite() {
            self.motion = Motion::Rest;
            visit(&self.seen(to_s, &to, rates))?;
            return Ok(jumps);
        }
        let largest = (LARGEST_STEP_RAD / way).min(1.0);
        let smallest = (SMALLEST_STEP_RAD / way).max(4.0 * f64::EPSILON);
        let (mut done, mut step, mut forced) = (0.0, largest, smallest);
        self.motion = self.decided(&self.instant(&from, rates, self.psi));
        while done < 1.0 {
            let here = from.towards(&to, done);
            if let Motion::Jump(direction) = self.motion {
                let landed = self.slid(&here, self.psi, direction);
                if (landed - self.psi).abs() > SMALLEST_JUMP_RAD {
                    jumps.push(self.jump(time_at(done), &here, landed));
                }
                self.psi = landed;
                visit(&self.seen(time_at(done), &here, rates))?;
            } else {
                let next = if done + step >= 1.0 { 1.0 } else { done + step };
                if let Some(psi) = self.advanced(&from, &to, rates, done, next) {
                    (self.psi, done) = (psi, next);
                    (step, forced) = ((2.0 * step).min(largest), smallest);
                    visit(&self.seen(time_at(done), &from.towards(&to, done), rates))?;
                    continue;
                }
                if step > forced {
                    step = (0.5 * step).max(forced);
                    continue;
                }
            }
            // Here the mode changes: what comes next is decided just behind.
            let over = (done + forced).min(1.0);
            let beyond = from.towards(&to, over);
            self.psi += self.rate(&self.instant(&here, rates, self.psi)) * (over - done);
            (done, step) = (over, forced);
            self.motion = self.decided(&self.instant(&beyond, rates, self.psi));
            forced *= 2.0;
            visit(&self.seen(time_at(done), &beyond, rates))?;
        }
        Ok(jumps)
    }

    fn instant(&self, palms: &PalmPair, rates: PalmRates, psi: f64) -> Instant {
        Instant::new(self.shape, self.friction, palms, rates, psi)
    }

    fn nothing_m(&self) -> f64 {
        NOTHING * self.shape.mean_radius_m()
    }

    /// What the object does from here on: what it did, where that is possible.
    fn decided(&self, instant: &Instant) -> Motion {
        let nothing_m = NOTHING_AT_ENDS * self.nothing_m();
        // The sign that W of a level has, or takes on while ψ changes at this rate.
        let sign = |level: usize, rate: f64| {
            let moment_m = instant.moments_m[level];
            if moment_m.abs() > nothing_m { moment_m } else { instant.change(self.friction, level, rate) }
        };
        let rolls = |place: usize| {
            let rate = instant.rolling[place];
            rate.is_finite() && sign(place, rate) >= 0.0 && sign(place + 1, rate) <= 0.0
        };
        let slides =
            |level: usize| instant.moments_m[level].abs() <= nothing_m && instant.may_slide(self.friction, level);
        let motions = [
            (rolls(0), Motion::Roll(instant.order[0])),
            (rolls(1), Motion::Roll(instant.order[1])),
            (slides(1), Motion::Slide(instant.signs[1])),
            (slides(0), Motion::Slide(instant.signs[0])),
            (slides(2), Motion::Slide(instant.signs[2])),
        ];
        let mut possible = motions.into_iter().filter_map(|(is_possible, motion)| is_possible.then_some(motion));
        if possible.clone().any(|motion| motion == self.motion) {
            return self.motion;
        }
        possible.next().unwrap_or(Motion::Jump(if instant.moments_m[0] < nothing_m { -1.0 } else { 1.0 }))
    }

    /// ψ' by the share of the way of the palms.
    fn rate(&self, instant: &Instant) -> f64 {
        let rate = match self.motion {
            Motion::Roll(k) => instant.slip.rolling_rate(k),
            Motion::Slide(signs) => {
                let (by_palms, by_psi) = instant.slopes(self.friction, signs);
                -by_palms / by_psi
            }
            Motion::Rest | Motion::Jump(_) => 0.0,
        };
        if rate.is_finite() { rate } else { 0.0 }
    }

    /// ψ after a step in the present mode, where that lasts until its end.
    fn advanced(&self, from: &PalmPair, to: &PalmPair, rates: PalmRates, done: f64, next: f64) -> Option<f64> {
        let step = next - done;
        let instant = |share: f64, psi: f64| self.instant(&from.towards(to, share), rates, psi);
        let nothing_m = self.nothing_m();
        match self.motion {
            Motion::Rest | Motion::Jump(_) => None,
            Motion::Roll(k) => {
                let rate = |share: f64, psi: f64| instant(share, psi).slip.rolling_rate(k);
                let middle = done + 0.5 * step;
                let first = rate(done, self.psi);
                let second = rate(middle, self.psi + 0.5 * step * first);
                let third = rate(middle, self.psi + 0.5 * step * second);
                let fourth = rate(next, self.psi + step * third);
                let psi = self.psi + step * (first + 2.0 * (second + third) + fourth) / 6.0;
                let end = instant(next, psi);
                let place = usize::from(end.order[1] == k);
                let lasts = end.moments_m[place] > -nothing_m && end.moments_m[place + 1] < nothing_m;
                (psi.is_finite() && lasts).then_some(psi)
            }
            Motion::Slide(signs) => {
                let rate = self.rate(&instant(done, self.psi));
                let (palms, tau) = (from.towards(to, next), at_the_edges(self.friction, signs));
                let predicted = self.psi + rate * step;
                let mut psi = predicted;
                let angles = palms.angles();
                for _ in 0..MOST_NEWTON_STEPS {
                    let (theta1, theta2) = palms.contact_angles(psi);
                    let at = Contacts::from([self.shape.at(theta1), self.shape.at(theta2)]);
                    let change = moment(&angles, &at, tau) / moment_by_psi(&angles, &at, tau);
                    psi -= change;
                    if change.abs() <= 4.0 * f64::EPSILON * (1.0 + psi.abs()) {
                        break;
                    }
                }
                let end = instant(next, psi);
                let level = end.signs.iter().position(|of_level| *of_level == signs)?;
                let is_it = (psi - predicted).abs() <= OTHER_BRANCH * (rate * step).abs() + 10.0 * NOTHING;
                let lasts = end.moments_m[level].abs() <= nothing_m && end.may_slide(self.friction, level);
                (is_it && lasts).then_some(psi)
            }
        }
    }

    /// Where the object comes to rest that slides from `psi` in a direction between palms that stand still.
    fn slid(&self, palms: &PalmPair, psi: f64, direction: f64) -> f64 {
        let still = PalmRates::between(palms, palms);
        let level = if direction < 0.0 { 0 } else { 2 };
        let goes_on = |psi: f64| direction * self.instant(palms, still, psi).moments_m[level] > 0.0;
        let (mut travelled, mut step) = (KICK_RAD, SLIDE_STEP_RAD);
        while travelled < LONGEST_SLIDE_RAD && goes_on(psi + direction * travelled) {
            travelled += step;
        }
        // Where it rests lies within the last step.
        travelled -= step;
        while step > f64::EPSILON * (1.0 + psi.abs()) {
            step *= 0.5;
            if goes_on(psi + direction * (travelled + step)) {
                travelled += step;
            }
        }
        psi + direction * travelled.max(0.0)
    }

    fn jump(&self, time_s: f64, palms: &PalmPair, landed: f64) -> Jump {
        let landscape = EnergyLandscape::new(self.shape, palms);
        Jump {
            time_s,
            psi_before_rad: self.psi,
            psi_after_rad: landed,
            height_before_m: landscape.height_m(self.psi),
            height_after_m: landscape.height_m(landed),
            physical: true,
        }
    }

    fn seen<'b>(&self, time_s: f64, palms: &'b PalmPair, rates: PalmRates) -> Seen<'b> {
        let instant = self.instant(palms, rates, self.psi);
        let (tau, modes) = match self.motion {
            Motion::Slide(signs) => (at_the_edges(self.friction, signs), signs.map(ContactMode::sliding)),
            Motion::Roll(k) if (instant.rolling[1] - instant.rolling[0]).abs() > SAME_RATE => {
                let other = 1 - k;
                let slip = instant.slip.at(other, instant.slip.rolling_rate(k));
                let mut tau = [0.0; 2];
                tau[other] = -self.friction[other] * slip.signum();
                tau[k] = balancing_ratio(&instant.angles, &instant.at, tau, k).unwrap_or(0.0);
                let mut modes = [ContactMode::Stick; 2];
                modes[other] = ContactMode::sliding(slip);
                (tau, modes)
            }
            Motion::Rest | Motion::Roll(_) | Motion::Jump(_) => {
                (at_rest(&instant, self.friction), [ContactMode::Stick; 2])
            }
        };
        Seen { time_s, palms, angles: instant.angles, psi_rad: self.psi, tau, modes }
    }
}

/// Ratios that balance an object that sticks to both palms: any within the cones do, so both contacts use the same share of theirs.
fn at_rest(instant: &Instant, friction: [f64; 2]) -> Ratios {
    let moment_m = |tau| moment(&instant.angles, &instant.at, tau);
    let without_m = moment_m([0.0; 2]);
    let edge = at_the_edges(friction, instant.signs[if without_m < 0.0 { 0 } else { 2 }]);
    let (mut share, mut step) = (0.0, 1.0);
    while step > f64::EPSILON {
        step *= 0.5;
        if moment_m(edge.map(|tau| tau * (share + step))) * without_m > 0.0 {
            share += step;
        }
    }
    edge.map(|tau| tau * share)
}
