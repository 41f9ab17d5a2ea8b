//! Palm motions planned with the shape known, so that an object is turned without a jump and much of it is felt.
//!
//! The resting poses form a surface in (φ₁, φ₂, ψ): for an orientation ψ and an opening φ₂, balance g = 0 is one equation in
//! φ₁. The part of that surface that is firmly stable and within the limits of the palms is laid out on a grid of (ψ, φ₂).
//! A path on it along which ψ advances by a whole turn, chosen by dynamic programming for little palm movement and much
//! stability, turns the object once around ("the shape of a random smooth convex object is globally observable",
//! Moll & Erdmann 2001, section 3). Where there is none, a path that visits whatever can be felt is gone there and back.

use std::collections::{BinaryHeap, HashMap};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use thiserror::Error;

use super::{SimulateOptions, coverage, simulate};
use crate::palms::{MotionError, PalmMotion, PalmPair};
use crate::sensor::Touchpad;
use crate::shape::SupportFunction;
use crate::statics::EnergyLandscape;

/// Steps of ψ per turn on the grid.
const LAYERS: usize = 180;

/// Steps of ψ beyond a whole turn that a full turn goes on for, so that its end feels again what its start felt.
const OVERLAP: usize = 15;

/// Openings on the grid.
const OPENINGS: usize = 25;

/// Stiffness (relative to the median of all stable poses) below which a pose is not used; tried in this order.
const MARGINS: [f64; 4] = [0.4, 0.2, 0.08, 0.02];

/// Samples that a planned motion is checked with.
const CHECKS: f64 = 1500.0;

/// Where the palms may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PalmLimits {
    /// Smallest angle of palm 1 against the horizontal, radians, positive.
    pub smallest_phi1_rad: f64,
    /// Largest angle φ₁₂ of palm 2, radians, below π.
    pub largest_phi12_rad: f64,
    /// Smallest opening φ₂, radians.
    pub smallest_phi2_rad: f64,
    /// Largest opening φ₂, radians.
    pub largest_phi2_rad: f64,
    /// Length of the palms, metres; may be infinite.
    pub palm_length_m: f64,
}

impl Default for PalmLimits {
    /// Palms at least 8° above the horizontal, opening 45° to 140°, endless.
    fn default() -> Self {
        Self {
            smallest_phi1_rad: 8f64.to_radians(),
            largest_phi12_rad: 172f64.to_radians(),
            smallest_phi2_rad: 45f64.to_radians(),
            largest_phi2_rad: 140f64.to_radians(),
            palm_length_m: f64::INFINITY,
        }
    }
}

/// A motion without jumps, for the object it was planned for.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedMotion {
    /// The motion.
    pub motion: PalmMotion,
    /// Let the object go at this orientation (radians) before the motion starts.
    pub start_psi_rad: f64,
    /// Fraction of the boundary that is felt, 0 to 1.
    pub coverage: f64,
    /// Whether the object turns all the way around.
    pub full_turn: bool,
}

/// Why no motion was planned.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PlanError {
    /// Nothing but jumps, or no stable pose within the limits.
    #[error("no motion without a jump was found for this object within the limits of the palms")]
    NoMotion,
    /// The shape or a limit is out of range.
    #[error("{what} is out of range")]
    OutOfRange {
        /// Which.
        what: &'static str,
    },
    /// From the motion itself.
    #[error(transparent)]
    Motion(#[from] MotionError),
}

/// A motion of `duration_s` seconds that turns `shape` all the way around without a jump and a little further, so that
/// each part is felt by both palms. Where that cannot be, a motion there and back that feels as much as it can.
///
/// # Errors
/// When no motion without a jump exists within `limits`, or a number is out of range.
pub fn plan_turn(shape: &SupportFunction, limits: &PalmLimits, duration_s: f64) -> Result<PlannedMotion, PlanError> {
    plan(shape, limits, duration_s, &Taste::default())
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
        keep_better(checked(shape, motion, start_psi_rad, f64::INFINITY), &mut best);
        if best.as_ref().is_some_and(|best| best.coverage >= ENOUGH) {
            break;
        }
    }
    if best.as_ref().is_none_or(|best| best.coverage < ENOUGH) {
        let part = |multiple: f64| (seed as f64 * multiple + 0.5).rem_euclid(1.0);
        let taste = Taste { first_layer: (part(0.754_878) * LAYERS as f64) as usize, opening: part(0.569_84) };
        keep_better(plan(shape, &PalmLimits::default(), duration_s, &taste).ok(), &mut best);
    }
    best.ok_or(PlanError::NoMotion)
}

/// What distinguishes planned motions of one object.
#[derive(Clone, Copy, Debug)]
struct Taste {
    first_layer: usize,
    /// Preferred opening, 0 (narrow) to 1 (wide).
    opening: f64,
}

impl Default for Taste {
    fn default() -> Self {
        Self { first_layer: 0, opening: 0.5 }
    }
}

fn plan(
    shape: &SupportFunction,
    limits: &PalmLimits,
    duration_s: f64,
    taste: &Taste,
) -> Result<PlannedMotion, PlanError> {
    check(shape, limits, duration_s)?;
    let sheet = Sheet::new(shape, limits);
    let mut best: Option<PlannedMotion> = None;
    for margin in MARGINS {
        if let Some(path) = sheet.full_turn(margin, taste)
            && let Some(planned) = realised(shape, limits, &path, duration_s, false)
        {
            return Ok(PlannedMotion { full_turn: true, ..planned });
        }
    }
    for margin in MARGINS {
        for path in sheet.visits(margin) {
            if let Some(planned) = realised(shape, limits, &path, duration_s, true)
                && best.as_ref().is_none_or(|best| planned.coverage > best.coverage + 0.02)
            {
                best = Some(planned);
            }
        }
    }
    best.ok_or(PlanError::NoMotion)
}

fn check(shape: &SupportFunction, limits: &PalmLimits, duration_s: f64) -> Result<(), PlanError> {
    let in_order = |low: f64, high: f64| low > 0.0 && low < high && high < PI;
    if shape.has_nonfinite() || shape.mean_radius_m() <= 0.0 || !shape.is_convex() {
        return Err(PlanError::OutOfRange { what: "the shape (not a convex object)" });
    }
    if !in_order(limits.smallest_phi1_rad, limits.largest_phi12_rad)
        || !in_order(limits.smallest_phi2_rad, limits.largest_phi2_rad)
        || limits.palm_length_m.is_nan()
    {
        return Err(PlanError::OutOfRange { what: "a limit of the palms" });
    }
    if !(duration_s > 0.0 && duration_s.is_finite()) {
        return Err(PlanError::OutOfRange { what: "the duration" });
    }
    Ok(())
}

/// A firmly stable pose on the grid.
#[derive(Clone, Copy, Debug)]
struct Place {
    layer: usize,
    opening: usize,
    psi: f64,
    phi1: f64,
    phi2: f64,
    /// g' over the size of the object.
    stiffness: f64,
}

/// The surface of resting poses on the grid.
struct Sheet {
    places: Vec<Place>,
    /// Indices of the places of each layer.
    layers: Vec<Vec<usize>>,
    typical_stiffness: f64,
}

impl Sheet {
    fn new(shape: &SupportFunction, limits: &PalmLimits) -> Self {
        let mut sheet = Self { places: Vec::new(), layers: vec![Vec::new(); LAYERS], typical_stiffness: 1.0 };
        for layer in 0..LAYERS {
            let psi = TAU * layer as f64 / LAYERS as f64;
            for opening in 0..OPENINGS {
                let part = opening as f64 / (OPENINGS - 1) as f64;
                let phi2 = limits.smallest_phi2_rad + (limits.largest_phi2_rad - limits.smallest_phi2_rad) * part;
                for phi1 in balanced_phi1(shape, limits, psi, phi2) {
                    let palms = PalmPair::hinged(phi1, phi2);
                    let stiffness = balance(shape, &palms, psi).slope / shape.mean_radius_m();
                    if stiffness > 0.0 && within(shape, limits, &palms, psi) {
                        sheet.layers[layer].push(sheet.places.len());
                        sheet.places.push(Place { layer, opening, psi, phi1, phi2, stiffness });
                    }
                }
            }
        }
        let mut stiffness: Vec<f64> = sheet.places.iter().map(|place| place.stiffness).collect();
        stiffness.sort_by(f64::total_cmp);
        sheet.typical_stiffness = stiffness.get(stiffness.len() / 2).copied().unwrap_or(1.0);
        sheet
    }

    /// Whether two places are next to each other on one piece of the surface.
    fn joined(&self, from: &Place, to: &Place) -> bool {
        const FARTHEST_RAD: f64 = 7.0 * PI / 180.0;
        (from.phi1 - to.phi1).abs() <= FARTHEST_RAD && (from.phi1 + from.phi2 - to.phi1 - to.phi2).abs() <= FARTHEST_RAD
    }

    /// A path on which ψ grows by a whole turn and the overlap.
    fn full_turn(&self, margin: f64, taste: &Taste) -> Option<Vec<Place>> {
        let firm = |place: &Place| place.stiffness >= margin * self.typical_stiffness;
        let liking = |place: &Place| {
            let opening = place.opening as f64 / (OPENINGS - 1) as f64 - taste.opening;
            0.02 * (margin * self.typical_stiffness / place.stiffness).powi(2) + 0.01 * opening * opening
        };
        let steps = LAYERS + OVERLAP;
        let layer_at = |step: usize| &self.layers[(taste.first_layer + step) % LAYERS];
        // cost[i] of the best way to the i-th place of the current layer, and where each came from.
        let mut cost: Vec<f64> = layer_at(0)
            .iter()
            .map(|&index| if firm(&self.places[index]) { liking(&self.places[index]) } else { f64::INFINITY })
            .collect();
        let mut origins: Vec<Vec<usize>> = Vec::with_capacity(steps);
        for step in 1..=steps {
            let (before, now) = (layer_at(step - 1), layer_at(step));
            let mut next_cost = vec![f64::INFINITY; now.len()];
            let mut origin = vec![0; now.len()];
            for (i, &to) in now.iter().enumerate() {
                let to = &self.places[to];
                if !firm(to) {
                    continue;
                }
                for (j, &from) in before.iter().enumerate() {
                    let from = &self.places[from];
                    if cost[j] == f64::INFINITY || !self.joined(from, to) {
                        continue;
                    }
                    let (turn1, turn2) = (to.phi1 - from.phi1, to.phi2 - from.phi2);
                    let turn12 = turn1 + turn2;
                    let total = cost[j] + 10.0 * (turn1 * turn1 + turn12 * turn12) + liking(to);
                    if total < next_cost[i] {
                        (next_cost[i], origin[i]) = (total, j);
                    }
                }
            }
            origins.push(origin);
            cost = next_cost;
        }
        let (mut at, least) = cost.iter().copied().enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
        if least == f64::INFINITY {
            return None;
        }
        let mut path = Vec::with_capacity(steps + 1);
        for step in (0..=steps).rev() {
            let mut place = self.places[layer_at(step)[at]];
            place.psi = TAU * (taste.first_layer + step) as f64 / LAYERS as f64;
            path.push(place);
            if step > 0 {
                at = origins[step - 1][at];
            }
        }
        path.reverse();
        Some(path)
    }

    /// Paths that visit what can be felt from the largest pieces of the surface, by going to the nearest place that feels
    /// something new until there is none.
    fn visits(&self, margin: f64) -> Vec<Vec<Place>> {
        let firm: Vec<usize> = (0..self.places.len())
            .filter(|&index| self.places[index].stiffness >= margin * self.typical_stiffness)
            .collect();
        let mut at_grid: HashMap<(usize, usize), Vec<usize>> = HashMap::new();
        for &index in &firm {
            at_grid.entry((self.places[index].layer, self.places[index].opening)).or_default().push(index);
        }
        let neighbours = |index: usize| -> Vec<usize> {
            let place = self.places[index];
            let mut cells = vec![
                ((place.layer + 1) % LAYERS, place.opening),
                ((place.layer + LAYERS - 1) % LAYERS, place.opening),
                (place.layer, place.opening + 1),
            ];
            if place.opening > 0 {
                cells.push((place.layer, place.opening - 1));
            }
            let there = cells.into_iter().filter_map(|cell| at_grid.get(&cell)).flatten().copied();
            there.filter(|&other| self.joined(&place, &self.places[other])).collect()
        };
        // Pieces of the surface.
        let mut piece_of = vec![usize::MAX; self.places.len()];
        let mut pieces: Vec<Vec<usize>> = Vec::new();
        for &start in &firm {
            if piece_of[start] != usize::MAX {
                continue;
            }
            let mut members = vec![start];
            piece_of[start] = pieces.len();
            let mut next = 0;
            while next < members.len() {
                for other in neighbours(members[next]) {
                    if piece_of[other] == usize::MAX {
                        piece_of[other] = pieces.len();
                        members.push(other);
                    }
                }
                next += 1;
            }
            pieces.push(members);
        }
        // Those that can feel the most.
        pieces.sort_by_key(|members| {
            let mut felt = FeltBins::default();
            members.iter().for_each(|&index| felt.add(&self.places[index]));
            std::cmp::Reverse((felt.count(), members.len()))
        });
        pieces.iter().take(3).map(|members| self.visit(members, &neighbours)).collect()
    }

    /// One path through a piece.
    fn visit(&self, members: &[usize], neighbours: &dyn Fn(usize) -> Vec<usize>) -> Vec<Place> {
        // Start at one end: where the first contact lies lowest on the object.
        let lowest = |index: &&usize| self.places[**index].phi1 - self.places[**index].psi;
        let Some(&start) = members.iter().min_by(|a, b| lowest(a).total_cmp(&lowest(b))) else { return Vec::new() };
        let mut felt = FeltBins::default();
        let mut path = vec![self.places[start]];
        felt.add(&self.places[start]);
        let mut here = start;
        while let Some(way) = self.nearest(here, neighbours, |index| felt.is_new(&self.places[index])) {
            for index in way {
                let mut place = self.places[index];
                let last = path.last().map_or(place.psi, |last| last.psi);
                place.psi = last + (place.psi - last + PI).rem_euclid(TAU) - PI;
                felt.add(&place);
                path.push(place);
                here = index;
            }
        }
        path
    }

    /// The shortest way (without its start) to a place that is `wanted`, by the angles that palms and object turn.
    fn nearest(
        &self,
        start: usize,
        neighbours: &dyn Fn(usize) -> Vec<usize>,
        wanted: impl Fn(usize) -> bool,
    ) -> Option<Vec<usize>> {
        let mut best: HashMap<usize, (f64, usize)> = HashMap::from([(start, (0.0, start))]);
        let mut queue = BinaryHeap::from([Waiting { cost: 0.0, index: start }]);
        while let Some(Waiting { cost, index }) = queue.pop() {
            if best.get(&index).is_some_and(|(least, _)| cost > *least) {
                continue;
            }
            if wanted(index) {
                let mut way = vec![index];
                let mut at = index;
                while let Some(&(_, before)) = best.get(&at) {
                    if before == at || before == start {
                        break;
                    }
                    way.push(before);
                    at = before;
                }
                way.reverse();
                return Some(way);
            }
            for other in neighbours(index) {
                let (a, b) = (&self.places[index], &self.places[other]);
                let psi = (b.psi - a.psi + PI).rem_euclid(TAU) - PI;
                let (turn1, turn12) = (b.phi1 - a.phi1, b.phi1 + b.phi2 - a.phi1 - a.phi2);
                let firmness = 1.0 + 0.3 * self.typical_stiffness / b.stiffness;
                let total = cost + firmness * (turn1 * turn1 + turn12 * turn12 + psi * psi).sqrt();
                if best.get(&other).is_none_or(|(least, _)| total < *least) {
                    best.insert(other, (total, index));
                    queue.push(Waiting { cost: total, index: other });
                }
            }
        }
        None
    }
}

/// An entry of the queue of a shortest-path search; the greatest is the cheapest.
struct Waiting {
    cost: f64,
    index: usize,
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Waiting {}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        other.cost.total_cmp(&self.cost).then(other.index.cmp(&self.index))
    }
}

/// Which parts of the boundary have been felt, in steps of 3°.
#[derive(Clone, Debug)]
struct FeltBins([bool; 120]);

impl Default for FeltBins {
    fn default() -> Self {
        Self([false; 120])
    }
}

impl FeltBins {
    fn bins(place: &Place) -> [usize; 2] {
        let theta1 = place.phi1 - place.psi - FRAC_PI_2;
        [theta1, theta1 + place.phi2 - PI].map(|theta| ((theta.rem_euclid(TAU) / TAU * 120.0) as usize).min(119))
    }

    fn add(&mut self, place: &Place) {
        Self::bins(place).into_iter().for_each(|bin| self.0[bin] = true);
    }

    fn is_new(&self, place: &Place) -> bool {
        Self::bins(place).into_iter().any(|bin| !self.0[bin])
    }

    fn count(&self) -> usize {
        self.0.iter().filter(|felt| **felt).count()
    }
}

/// g with its slopes in ψ and in φ₁, metres.
struct Balance {
    g: f64,
    slope: f64,
    slope_phi1: f64,
}

fn balance(shape: &SupportFunction, palms: &PalmPair, psi: f64) -> Balance {
    let (theta1, theta2) = palms.contact_angles(psi);
    let (contact1, contact2) = (shape.at(theta1), shape.at(theta2));
    let ((sin1, cos1), (sin12, cos12)) = (palms.phi1_rad.sin_cos(), palms.phi12_rad().sin_cos());
    let slope = (contact1.v - contact1.r) * sin12 + (contact2.v - contact2.r) * sin1;
    Balance {
        g: contact1.d * sin12 + contact2.d * sin1,
        slope,
        slope_phi1: contact1.d * cos12 + contact2.d * cos1 - slope,
    }
}

/// The angles φ₁ within the limits at which the object is balanced at ψ.
fn balanced_phi1(shape: &SupportFunction, limits: &PalmLimits, psi: f64, phi2: f64) -> Vec<f64> {
    const STEPS: usize = 48;
    let (low, high) = (limits.smallest_phi1_rad, limits.largest_phi12_rad - phi2);
    if high <= low {
        return Vec::new();
    }
    let g = |phi1: f64| balance(shape, &PalmPair::hinged(phi1, phi2), psi).g;
    let at = |step: usize| low + (high - low) * step as f64 / STEPS as f64;
    let mut found = Vec::new();
    let mut before = g(low);
    for step in 1..=STEPS {
        let after = g(at(step));
        if (before < 0.0) != (after < 0.0) {
            let (mut left, mut right) = (at(step - 1), at(step));
            for _ in 0..40 {
                let middle = 0.5 * (left + right);
                if (g(middle) < 0.0) == (before < 0.0) { left = middle } else { right = middle }
            }
            found.push(0.5 * (left + right));
        }
        before = after;
    }
    found
}

fn within(shape: &SupportFunction, limits: &PalmLimits, palms: &PalmPair, psi: f64) -> bool {
    let (s1, s2) = palms.contact_positions_m(shape, psi);
    let reach = 0.0..=limits.palm_length_m;
    reach.contains(&s1)
        && reach.contains(&s2)
        && palms.phi1_rad >= limits.smallest_phi1_rad - 1e-9
        && palms.phi12_rad() <= limits.largest_phi12_rad + 1e-9
}

/// The path as a smooth motion, if it holds in simulation; smoothed as much as it bears.
fn realised(
    shape: &SupportFunction,
    limits: &PalmLimits,
    path: &[Place],
    duration_s: f64,
    there_and_back: bool,
) -> Option<PlannedMotion> {
    for width in [8, 5, 3, 1, 0] {
        let Some(smooth) = smoothed(shape, limits, path, width) else { continue };
        let mut palms: Vec<(f64, f64, f64)> = smooth.iter().map(|place| (place.phi1, place.phi2, place.psi)).collect();
        if there_and_back {
            palms.extend(palms.clone().into_iter().rev().skip(1));
        }
        let Some(motion) = timed(&palms, duration_s) else { continue };
        let start = smooth.first().map_or(0.0, |place| place.psi);
        let planned = checked(shape, motion, start, limits.palm_length_m);
        // Where the object went another way than planned it has left the path, even without a jump.
        if planned.is_some() {
            return planned;
        }
    }
    None
}

/// The path with ψ and φ₂ averaged over `width` places to either side, and φ₁ put back on balance.
fn smoothed(shape: &SupportFunction, limits: &PalmLimits, path: &[Place], width: usize) -> Option<Vec<Place>> {
    let mut smooth = path.to_vec();
    for _ in 0..2 {
        let rough = smooth.clone();
        for (index, place) in smooth.iter_mut().enumerate() {
            let reach = width.min(index).min(rough.len() - 1 - index);
            let around = &rough[index - reach..=index + reach];
            let count = around.len() as f64;
            place.psi = around.iter().map(|near| near.psi).sum::<f64>() / count;
            place.phi2 = around.iter().map(|near| near.phi2).sum::<f64>() / count;
            place.phi1 = around.iter().map(|near| near.phi1).sum::<f64>() / count;
        }
    }
    for place in &mut smooth {
        for _ in 0..20 {
            let balance = balance(shape, &PalmPair::hinged(place.phi1, place.phi2), place.psi);
            let step = balance.g / balance.slope_phi1;
            if !step.is_finite() {
                return None;
            }
            place.phi1 -= step.clamp(-0.05, 0.05);
            if step.abs() < 1e-10 {
                break;
            }
        }
        let palms = PalmPair::hinged(place.phi1, place.phi2);
        let balance = balance(shape, &palms, place.psi);
        let balanced = balance.g.abs() < 1e-8 * shape.mean_radius_m() && balance.slope > 0.0;
        if !balanced || !within(shape, limits, &palms, place.psi) {
            return None;
        }
    }
    Some(smooth)
}

/// The palms' way (φ₁, φ₂, ψ) run through in `duration_s`, at a pace that turns palms and object evenly and starts and ends
/// gently.
fn timed(way: &[(f64, f64, f64)], duration_s: f64) -> Option<PalmMotion> {
    let mut lengths = vec![0.0];
    for pair in way.windows(2) {
        let (turn1, turn2, psi) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1, pair[1].2 - pair[0].2);
        let turn12 = turn1 + turn2;
        // A floor keeps times apart where nothing moves.
        let step = (turn1 * turn1 + turn12 * turn12 + psi * psi).sqrt().max(1e-4);
        lengths.push(lengths.last().copied().unwrap_or(0.0) + step);
    }
    let total = lengths.last().copied().filter(|total| *total > 0.0)?;
    // Gentle ends: over the first and last twentieth the pace grows evenly from 0.
    let ease = 0.05;
    let time = |u: f64| -> f64 {
        let top = 1.0 / (1.0 - ease);
        let ramp = 0.5 * top * ease;
        if u < ramp {
            (2.0 * u * ease / top).sqrt()
        } else if u > 1.0 - ramp {
            1.0 - (2.0 * (1.0 - u).max(0.0) * ease / top).sqrt()
        } else {
            0.5 * ease + u / top
        }
    };
    let points: Vec<(f64, f64, f64)> =
        way.iter().zip(&lengths).map(|(palms, length)| (duration_s * time(length / total), palms.0, palms.1)).collect();
    PalmMotion::through(&points).ok()
}

/// The motion with what it feels, if the object follows it without a jump.
fn checked(
    shape: &SupportFunction,
    motion: PalmMotion,
    start_psi_rad: f64,
    palm_length_m: f64,
) -> Option<PlannedMotion> {
    let path = motion.sample(CHECKS / motion.duration_s()).ok()?;
    let start_psi_rad = EnergyLandscape::new(shape, &path.first()?.1).descend(start_psi_rad);
    let touchpad = Touchpad { length_m: palm_length_m, ..Touchpad::ideal() };
    let options = SimulateOptions { start_psi_rad, touchpad, ..SimulateOptions::default() };
    let simulation = simulate(shape, &path, &options).ok()?;
    let coverage = coverage(&simulation, &path);
    let turned = simulation.truth.motion.last()?.psi_rad - start_psi_rad;
    simulation.jumps.is_empty().then_some(PlannedMotion {
        motion,
        start_psi_rad,
        coverage,
        full_turn: turned.abs() >= TAU,
    })
}
