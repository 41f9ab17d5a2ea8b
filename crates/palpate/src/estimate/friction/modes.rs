//! Contact modes as a hidden sequence: which palm the object rolls on from each sample to the next, or that it slides on both.
//!
//! In every mode mechanics says where the object goes: it rolls (the contact moves as far over the palm as over the boundary), or the moment of
//! the forces vanishes at the edges of the friction cones. Viterbi's algorithm with a Kalman filter in each survivor: for each mode at a
//! sample the likeliest sequence that leads there, and ψ at its end with its variance, by what mechanics predicts and the contacts read.

use super::regimes::{Place, Regime};
use super::strips::{ends, nearest_end};
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::boundary::Boundary;
use crate::estimate::model::contact::contact_directions;
use crate::estimate::model::table::BoundaryTable;
use crate::estimate::motion::SHORT_SEGMENT;
use crate::mechanics::coulomb::{at_the_edges, moment, moment_by_psi, moment_by_ratio, moment_row};
use nalgebra::{DMatrix, DVector};

/// What the object is known by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Object<'a> {
    /// Of the support function about the centre of mass.
    pub coefficients: &'a [f64],
    pub friction: [f64; 2],
    /// Covariance of both, in this order.
    pub covariance: Option<&'a DMatrix<f64>>,
}

/// Standard deviations: of a contact position, of the slip of a contact that sticks over one step, and of the moment of the forces, metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sds {
    pub sensor_m: f64,
    pub slip_m: f64,
    pub forces_m: f64,
}

const PLACES: [Place; 5] = [Place::Below, Place::First, Place::Between, Place::Second, Place::Above];

/// −ln of the probability that an object jumps where it is thought to.
pub(crate) const JUMP: f64 = 12.0;

/// −ln of the probability that the mode changes from one sample to the next.
const CHANGE: f64 = 5.0;

/// Standard deviation of a step that slides beyond both rates of rolling, radians: it creeps, or falls from pose to pose.
const BEYOND_RAD: f64 = 0.05;

/// The same of a pose of which nothing is known but where it was thought to be.
const START_RAD: f64 = 0.05;

/// Contacts that stick creep, most where they are about to slide: pads are soft, and engines regularise friction. Standard deviation of that over what
/// slides on the other palm meanwhile; without it exact readings are explained by modes that alternate.
const CREEP: f64 = 0.02;

/// The object sticks on both palms, which do not turn against each other, where it would slide by less than so many standard deviations of the slip
/// over a step on either while it rolls on the other: whichever is said to stick, the forces are then free within both cones.
const ON_BOTH_SDS: f64 = 3.0;

/// Least variance of ψ.
const LEAST_VARIANCE: f64 = 1e-14;

/// Iterations of the quadratic approximations.
const NEWTON: usize = 3;

/// ψ by some evidence.
#[derive(Clone, Copy, Debug)]
struct Belief {
    psi: f64,
    variance: f64,
}

/// A sequence of modes up to a sample.
#[derive(Clone, Copy, Debug)]
struct Survivor {
    cost: f64,
    at: Belief,
    /// The mode before.
    from: usize,
    /// Whether it has just jumped.
    jumped: bool,
}

/// Modes and motion that mechanics finds.
pub(crate) struct Decoded {
    pub regimes: Vec<Regime>,
    /// ψ of every sample by all before it.
    pub psi: Vec<f64>,
    /// Samples at which a jump has just ended.
    pub starts: Vec<usize>,
    /// Samples at which another may have: to slide so far in one step would cost more.
    pub falls: Vec<usize>,
    /// −ln of how likely they are up to each sample, up to a constant of the log.
    pub costs: Vec<f64>,
}

impl Decoded {
    /// −ln of how likely they are, up to a constant of the log.
    pub fn cost(&self) -> f64 {
        self.costs.last().copied().unwrap_or(0.0)
    }
}

/// The likeliest modes of all samples, each that of the step which ends there, and ψ at the end of them. `psi` is where the motion is thought
/// to be: it counts at the first sample and at the samples `starts`, where a jump may have just ended, and keeps ψ unwrapped.
pub(crate) fn decode(
    measurements: &Measurements,
    base_shifts_m: &[[f64; 2]],
    object: Object,
    sds: Sds,
    psi: &[f64],
    starts: &[usize],
) -> Decoded {
    let count = psi.len();
    measurements.work.add_decoding(count);
    let decoder = Decoder { measurements, base_shifts_m, object, table: BoundaryTable::new(object.coefficients), sds };
    let mut survivors: Vec<[Option<Survivor>; 5]> = Vec::with_capacity(count);
    let mut orders: Vec<Option<([usize; 2], bool)>> = Vec::with_capacity(count);
    for (index, &thought) in psi.iter().enumerate() {
        let before = survivors.last().copied().unwrap_or_default();
        let instant = &measurements.instants[index];
        let mut here = [None; 5];
        let likeliest = before
            .iter()
            .enumerate()
            .filter_map(|(mode, survivor)| Some((mode, (*survivor)?)))
            .min_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
        let around = likeliest.map_or(thought, |(_, survivor)| survivor.at.psi);
        let unknown = decoder.unknown(instant, around);
        let (mut order, mut least) = (None, f64::INFINITY);
        for (from, survivor) in before.iter().enumerate() {
            let Some(survivor) = survivor else { continue };
            let Some(step) = decoder.step(index, survivor.at, thought) else { continue };
            if survivor.cost < least {
                (least, order) = (survivor.cost, Some((step.order, step.sticks_on_both)));
            }
            for (mode, place) in PLACES.into_iter().enumerate() {
                let changes = from != mode;
                let Some((at, cost)) = decoder.moved(index, &step, place, changes, &unknown) else { continue };
                let cost = survivor.cost + cost + if changes { CHANGE } else { 0.0 };
                if here[mode].is_none_or(|other: Survivor| cost < other.cost) {
                    here[mode] = Some(Survivor { cost, at, from, jumped: false });
                }
            }
        }
        let is_lost = here.iter().all(Option::is_none);
        if is_lost || starts.contains(&index) {
            // Any mode: the forces tell from the next step on. Without contacts the motion is where it is thought to be.
            let (at, cost) = decoder.landed(index, psi, &unknown);
            let (from, base) = likeliest.map_or((2, 0.0), |(mode, survivor)| (mode, survivor.cost));
            let survivor = Survivor { cost: base + cost + JUMP, at, from, jumped: index > 0 };
            for other in &mut here {
                if other.is_none_or(|other| survivor.cost < other.cost) {
                    *other = Some(survivor);
                }
            }
        }
        orders.push(order);
        survivors.push(here);
    }
    let cost = |mode: usize| survivors.last().and_then(|last| last[mode]).map_or(f64::INFINITY, |last| last.cost);
    let mut mode = (0..5).min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap_or(2);
    let mut found = Decoded {
        regimes: vec![Regime { order: None, place: Place::Anywhere, sticks_on_both: false }; count],
        psi: psi.to_vec(),
        starts: Vec::new(),
        falls: Vec::new(),
        costs: vec![f64::INFINITY; count],
    };
    for index in (0..count).rev() {
        let Some(survivor) = survivors[index][mode] else { continue };
        found.psi[index] = survivor.at.psi;
        found.costs[index] = survivor.cost;
        if survivor.jumped {
            found.starts.push(index);
        } else if let Some((order, sticks_on_both)) = orders[index] {
            let place = PLACES[mode];
            let sticks_on_both = sticks_on_both && matches!(place, Place::First | Place::Second);
            found.regimes[index] = Regime { order: Some(order), place, sticks_on_both };
            let before = survivors[index - 1][survivor.from];
            if before.is_some_and(|before| 0.5 * ((survivor.at.psi - before.at.psi) / BEYOND_RAD).powi(2) > JUMP) {
                found.falls.push(index);
            }
        }
        mode = survivor.from;
    }
    found.starts.reverse();
    found.falls.reverse();
    found
}

struct Decoder<'a> {
    measurements: &'a Measurements,
    base_shifts_m: &'a [[f64; 2]],
    object: Object<'a>,
    /// Its boundary.
    table: BoundaryTable,
    sds: Sds,
}

/// Variances at a sample by what is unknown of the object, square metres: of both contacts, and of the moment with slips of these signs.
struct Unknown {
    contacts_m2: [f64; 2],
    forces_m2: [[f64; 2]; 2],
}

impl Unknown {
    /// Of the moment with slips of these signs.
    fn of_forces(&self, signs: [f64; 2]) -> f64 {
        self.forces_m2[usize::from(signs[0] > 0.0)][usize::from(signs[1] > 0.0)]
    }
}

/// A step from some pose: where the object would be if it rolled, the palm of the smaller ψ first.
struct Step {
    order: [usize; 2],
    /// ψ at the end for each of `order`, and its variance.
    rolled: [Belief; 2],
    /// Whether these are the same as far as slip is told.
    sticks_on_both: bool,
}

impl Decoder<'_> {
    /// What is unknown at a sample, about some ψ.
    fn unknown(&self, instant: &Instant, psi: f64) -> Unknown {
        let Some(covariance) = self.object.covariance else {
            return Unknown { contacts_m2: [0.0; 2], forces_m2: [[0.0; 2]; 2] };
        };
        let boundary = Boundary::new(self.object.coefficients, contact_directions(instant, psi));
        let shape = self.object.coefficients.len();
        let mut row = DVector::zeros(shape + 2);
        let variance = |row: &DVector<f64>| (covariance * row).dot(row).max(0.0);
        let contacts_m2 = [[1.0, 0.0], [0.0, 1.0]].map(|share| {
            boundary.row_of(&instant.palms.positions_row(share), &mut row.as_mut_slice()[..shape]);
            variance(&row)
        });
        let forces_m2 = [-1.0, 1.0].map(|sign1| {
            [-1.0, 1.0].map(|sign2| {
                let signs = [sign1, sign2];
                let tau = at_the_edges(self.object.friction, signs);
                boundary.row_of(&moment_row(&instant.palms, tau), &mut row.as_mut_slice()[..shape]);
                for palm in 0..2 {
                    row[shape + palm] = -signs[palm] * moment_by_ratio(&instant.palms, &boundary.at, tau, palm);
                }
                variance(&row)
            })
        });
        Unknown { contacts_m2, forces_m2 }
    }

    /// L of both palms (see [`problem`](super::problem)) and its derivative by ψ.
    fn unrolled(&self, index: usize, psi: f64) -> [(f64, f64); 2] {
        let (instant, shift) = (&self.measurements.instants[index], self.base_shifts_m[index]);
        let at = self.table.contacts(instant, psi);
        let [s1, s2] = instant.palms.positions(at.r, at.d);
        let arc = <[f64; 2]>::from(instant.contact_angles(psi)).map(|theta| self.table.arc_m(theta));
        let (r_by_psi, d_by_psi) = at.by_psi();
        let [by1, by2] = instant.palms.positions(r_by_psi, d_by_psi);
        let v = at.v;
        [(s1 - shift[0] - arc[0], by1 + v[0]), (shift[1] - s2 - arc[1], v[1] - by2)]
    }

    fn step(&self, index: usize, from: Belief, near: f64) -> Option<Step> {
        let start = self.unrolled(index - 1, from.psi);
        let mut slopes = [0.0; 2];
        let rolled = [0, 1].map(|palm: usize| {
            let mut psi = from.psi;
            let mut slope = start[palm].1;
            for _ in 0..NEWTON {
                let (value, by_psi) = self.unrolled(index, psi)[palm];
                slope = by_psi;
                psi -= (value - start[palm].0) / by_psi;
            }
            let carried = start[palm].1 / slope;
            let variance = from.variance * carried * carried + (self.sds.slip_m / slope).powi(2);
            slopes[palm] = slope;
            Belief { psi, variance: variance.max(LEAST_VARIANCE) }
        });
        // What slides on a palm while the object rolls on the other.
        let slips_m = slopes.map(|slope| slope * (rolled[1].psi - rolled[0].psi));
        let rolled = [0, 1].map(|palm: usize| {
            let crept = CREEP * slips_m[1 - palm] / slopes[palm];
            Belief { variance: rolled[palm].variance + crept * crept, ..rolled[palm] }
        });
        let possible = rolled.iter().all(|belief| (belief.psi - near).abs() < 1.0 && belief.variance.is_finite());
        let order = if rolled[0].psi <= rolled[1].psi { [0, 1] } else { [1, 0] };
        let sticks_on_both = slips_m.iter().all(|slip_m| slip_m.abs() < ON_BOTH_SDS * self.sds.slip_m);
        possible.then(|| Step { order, rolled: order.map(|palm| rolled[palm]), sticks_on_both })
    }

    /// Where a jump that ends at a sample leads: to where the motion is thought to be there, or a little later, for a fit may draw the samples next to a
    /// jump after it.
    fn landed(&self, index: usize, psi: &[f64], unknown: &Unknown) -> (Belief, f64) {
        let later = (index + SHORT_SEGMENT).min(psi.len() - 1);
        let thought = |psi: f64| Belief { psi, variance: START_RAD * START_RAD };
        let seen = |near: f64| self.seen(&self.measurements.instants[index], thought(near), unknown);
        let likeliest = [psi[index], psi[later]].into_iter().filter_map(seen).min_by(|a, b| a.1.total_cmp(&b.1));
        likeliest.unwrap_or((thought(psi[index]), 0.0))
    }

    /// ψ after a step in some mode, and what that costs.
    fn moved(
        &self,
        index: usize,
        step: &Step,
        place: Place,
        changes: bool,
        unknown: &Unknown,
    ) -> Option<(Belief, f64)> {
        let instant = &self.measurements.instants[index];
        let [first, second] = step.rolled;
        let range = second.psi - first.psi;
        let uniform = range * range / 12.0;
        let widened =
            |belief: Belief| Belief { variance: belief.variance + if changes { uniform } else { 0.0 }, ..belief };
        let regime = Regime { order: Some(step.order), place, sticks_on_both: step.sticks_on_both };
        let predicted = match place {
            Place::First => widened(first),
            Place::Second => widened(second),
            Place::Between => {
                Belief { psi: 0.5 * (first.psi + second.psi), variance: first.variance.max(second.variance) + uniform }
            }
            Place::Below => Belief { variance: first.variance + BEYOND_RAD * BEYOND_RAD, ..first },
            Place::Above => Belief { variance: second.variance + BEYOND_RAD * BEYOND_RAD, ..second },
            Place::Anywhere => return None,
        };
        let (predicted, of_forces) = self.with_forces(instant, predicted, &regime, unknown)?;
        let (at, of_contacts) = self.seen(instant, predicted, unknown)?;
        // On the side that the mode is about.
        let beyond = match place {
            Place::Below => at.psi - first.psi,
            Place::Above => second.psi - at.psi,
            _ => 0.0,
        };
        let of_side = 0.5 * beyond.max(0.0).powi(2) / (at.variance + first.variance);
        Some((at, of_forces + of_contacts + of_side))
    }

    /// What the forces make of a prediction: where the object slides their moment vanishes.
    fn with_forces(
        &self,
        instant: &Instant,
        predicted: Belief,
        regime: &Regime,
        unknown: &Unknown,
    ) -> Option<(Belief, f64)> {
        let variance_m2 = |signs: [f64; 2]| self.sds.forces_m * self.sds.forces_m + unknown.of_forces(signs);
        let at = self.table.contacts(instant, predicted.psi);
        let ends = ends(instant, &at, regime)?;
        let tau = |signs: [f64; 2]| at_the_edges(self.object.friction, signs);
        if ends[0] != ends[1] {
            let missed = nearest_end(ends, |signs| moment(&instant.palms, &at, tau(signs)));
            let Some(signs) = missed else { return Some((predicted, 0.0)) };
            let value = moment(&instant.palms, &at, tau(signs));
            let by_psi = moment_by_psi(&instant.palms, &at, tau(signs));
            let variance = variance_m2(signs) + by_psi * by_psi * predicted.variance;
            return Some((predicted, 0.5 * value * value / variance));
        }
        let (tau, variance_m2) = (tau(ends[0]), variance_m2(ends[0]));
        let mut psi = predicted.psi;
        let mut found = None;
        for _ in 0..NEWTON {
            let at = self.table.contacts(instant, psi);
            let value = moment(&instant.palms, &at, tau);
            let by_psi = moment_by_psi(&instant.palms, &at, tau);
            let information = 1.0 / predicted.variance + by_psi * by_psi / variance_m2;
            let slope = (psi - predicted.psi) / predicted.variance + by_psi * value / variance_m2;
            psi -= slope / information;
            found = Some((Belief { psi, variance: (1.0 / information).max(LEAST_VARIANCE) }, value));
        }
        let (belief, _) = found?;
        let value = moment(&instant.palms, &self.table.contacts(instant, psi), tau);
        let cost = 0.5 * (psi - predicted.psi).powi(2) / predicted.variance + 0.5 * value * value / variance_m2;
        belief.psi.is_finite().then_some((belief, cost))
    }

    /// What the contacts make of a prediction, and −ln of how likely they were.
    fn seen(&self, instant: &Instant, predicted: Belief, unknown: &Unknown) -> Option<(Belief, f64)> {
        let sensor_m2 = self.sds.sensor_m * self.sds.sensor_m;
        let weights = [0, 1].map(|k: usize| {
            let weight = [instant.weight1, instant.weight2][k];
            if weight > 0.0 { 1.0 / (sensor_m2 / (weight * weight) + unknown.contacts_m2[k]) } else { 0.0 }
        });
        let mut psi = predicted.psi;
        let mut information = 1.0 / predicted.variance;
        let residuals = |psi: f64| {
            let at = self.table.contacts(instant, psi);
            let (r_by_psi, d_by_psi) = at.by_psi();
            let [s1, s2] = instant.palms.positions(at.r, at.d);
            ([s1 - instant.s1, s2 - instant.s2], instant.palms.positions(r_by_psi, d_by_psi))
        };
        for _ in 0..NEWTON {
            let (value, by_psi) = residuals(psi);
            information = 1.0 / predicted.variance;
            let mut slope = (psi - predicted.psi) / predicted.variance;
            for k in 0..2 {
                information += weights[k] * by_psi[k] * by_psi[k];
                slope += weights[k] * by_psi[k] * value[k];
            }
            psi -= slope / information;
        }
        let (value, _) = residuals(psi);
        let squares: f64 = (0..2).map(|k| weights[k] * value[k] * value[k]).sum();
        let of_readings: f64 =
            weights.iter().filter(|weight| **weight > 0.0).map(|weight| (weight * sensor_m2).ln()).sum();
        let cost = 0.5 * ((psi - predicted.psi).powi(2) / predicted.variance + squares)
            + 0.5 * ((predicted.variance * information).ln() - of_readings);
        cost.is_finite().then(|| (Belief { psi, variance: (1.0 / information).max(LEAST_VARIANCE) }, cost))
    }
}

#[cfg(test)]
mod tests;
