//! Palm motions planned with the shape known, so that an object is turned without a jump and much of it is felt.
//!
//! The stable poses form a surface over the palm angles (φ₁, φ₁₂), in places several sheets of it (Moll & Erdmann 2001,
//! section 3: "the stable poses induce a two-dimensional subset of the (φ₁, φ₂, ψ)-configuration space"). It is laid out on
//! a grid of palm angles; two poses at neighbouring palm angles are joined when the pose can be followed from one to the
//! other without a jump. A shortest closed path on it along which ψ grows by 2π turns the object once around, and so feels
//! all of the boundary, with either palm. Where there is none, a path that visits whatever can be felt is gone there and
//! back.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use thiserror::Error;

use super::{SimulateOptions, coverage, simulate};
use crate::math::angle::wrapped;
use crate::mechanics::EnergyLandscape;
use crate::mechanics::frictionless::followed;
use crate::palms::{MotionError, PalmMotion, PalmPair};
use crate::sensor::Touchpad;
use crate::shape::SupportFunction;

/// Spacing of the grid of palm angles, radians.
const SPACING_RAD: f64 = 4.0 * PI / 180.0;

/// Stiffness (relative to the median of all stable poses) below which a pose is not used; tried in this order.
const MARGINS: [f64; 4] = [0.4, 0.2, 0.08, 0.01];

/// Samples that a planned motion is checked with.
const CHECKS: f64 = 1500.0;

/// Steps (of 3°) in which the boundary counts as felt while planning.
const BINS: usize = 120;

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
    /// Palms at least 4° above the horizontal, opening 25° to 160°, endless. Of random pebbles about half can be turned all
    /// the way around within these limits; of nearly all others at least 80 % of the boundary can be felt. With 8° and 40° to 140°
    /// it is one in ten, and half of the boundary.
    fn default() -> Self {
        Self {
            smallest_phi1_rad: 4f64.to_radians(),
            largest_phi12_rad: 176f64.to_radians(),
            smallest_phi2_rad: 25f64.to_radians(),
            largest_phi2_rad: 160f64.to_radians(),
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

/// What distinguishes planned motions of one object.
#[derive(Clone, Copy, Debug)]
struct Taste {
    /// Where on the closed path the motion starts, 0 to 1.
    start: f64,
    /// Whether ψ decreases.
    backwards: bool,
    /// Preferred opening.
    opening_rad: f64,
}

impl Default for Taste {
    fn default() -> Self {
        Self { start: 0.0, backwards: false, opening_rad: FRAC_PI_2 }
    }
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

/// A stable pose at one point of the grid.
#[derive(Clone, Copy, Debug)]
struct Place {
    phi1: f64,
    phi12: f64,
    psi: f64,
    /// g' over the size of the object.
    stiffness: f64,
}

impl Place {
    fn contact_angles(&self) -> (f64, f64) {
        PalmPair::hinged(self.phi1, self.phi12 - self.phi1).contact_angles(self.psi)
    }
}

/// The way from one place to a neighbour, with how far the object turns on it.
#[derive(Clone, Copy, Debug)]
struct Edge {
    to: usize,
    turn: f64,
}

/// The surface of stable poses on the grid.
struct Surface {
    places: Vec<Place>,
    edges: Vec<Vec<Edge>>,
    typical_stiffness: f64,
    /// Which places may be used.
    usable: Vec<bool>,
}

impl Surface {
    fn new(shape: &SupportFunction, limits: &PalmLimits) -> Self {
        let mut places = Vec::new();
        let mut cells: HashMap<(i64, i64), Vec<usize>> = HashMap::new();
        let steps = ((limits.largest_phi12_rad - limits.smallest_phi1_rad) / SPACING_RAD).floor() as i64;
        for row in 0..=steps {
            for column in 0..=steps {
                let phi1 = limits.smallest_phi1_rad + SPACING_RAD * row as f64;
                let phi12 = limits.largest_phi12_rad - SPACING_RAD * column as f64;
                let palms = PalmPair::hinged(phi1, phi12 - phi1);
                if !(limits.smallest_phi2_rad..=limits.largest_phi2_rad).contains(&palms.phi2_rad) {
                    continue;
                }
                let landscape = EnergyLandscape::new(shape, &palms);
                let mut poses: Vec<f64> = landscape.stable_poses().iter().map(|pose| pose.psi_rad).collect();
                if landscape.is_flat() {
                    poses.push(0.0);
                }
                for psi in poses.into_iter().filter(|psi| within(shape, limits, &palms, *psi)) {
                    cells.entry((row, column)).or_default().push(places.len());
                    let stiffness = landscape.balance_slope_m(psi) / shape.mean_radius_m();
                    places.push(Place { phi1, phi12, psi, stiffness });
                }
            }
        }
        let mut edges = vec![Vec::new(); places.len()];
        for ((row, column), here) in &cells {
            for (down, right) in [(1, 0), (0, 1), (1, 1), (1, -1)] {
                let Some(there) = cells.get(&(row + down, column + right)) else { continue };
                for &from in here {
                    if let Some((to, turn)) = joined(shape, &places, from, there) {
                        edges[from].push(Edge { to, turn });
                        edges[to].push(Edge { to: from, turn: -turn });
                    }
                }
            }
        }
        // The map has no order of its own.
        edges.iter_mut().for_each(|edges: &mut Vec<Edge>| edges.sort_by_key(|edge| edge.to));
        let mut stiffness: Vec<f64> = places.iter().map(|place| place.stiffness).collect();
        stiffness.sort_by(f64::total_cmp);
        let typical_stiffness = stiffness.get(stiffness.len() / 2).copied().unwrap_or(0.0);
        let usable = vec![true; places.len()];
        Self { places, edges, typical_stiffness, usable }
    }

    fn keep_firmer_than(&mut self, margin: f64) {
        self.usable = self.places.iter().map(|place| place.stiffness >= margin * self.typical_stiffness).collect();
    }

    fn neighbours(&self, place: usize) -> impl Iterator<Item = &Edge> {
        self.edges[place].iter().filter(|edge| self.usable[edge.to])
    }

    /// What an edge costs: how far palms and object turn, more where the object hardly rests.
    fn cost(&self, from: usize, edge: &Edge, opening_rad: Option<f64>) -> f64 {
        let (a, b) = (&self.places[from], &self.places[edge.to]);
        let (turn1, turn12) = (b.phi1 - a.phi1, b.phi12 - a.phi12);
        let looseness = self.typical_stiffness / b.stiffness.max(1e-6 * self.typical_stiffness).max(1e-300);
        let opening = opening_rad.map_or(0.0, |wanted| (b.phi12 - b.phi1 - wanted).powi(2));
        (turn1 * turn1 + turn12 * turn12 + edge.turn * edge.turn).sqrt() * (1.0 + 0.3 * looseness.min(100.0) + opening)
    }

    /// The places of each connected piece, with ψ unwrapped along a tree, and the edges that do not agree with that by a
    /// whole turn: the object can be turned around along them.
    fn pieces(&self) -> Vec<Piece> {
        let mut unwrapped: Vec<Option<f64>> = vec![None; self.places.len()];
        let mut pieces = Vec::new();
        for start in (0..self.places.len()).filter(|&place| self.usable[place]) {
            if unwrapped[start].is_some() {
                continue;
            }
            unwrapped[start] = Some(self.places[start].psi);
            let mut piece = Piece { members: vec![start], turning: Vec::new() };
            let mut next = 0;
            while let Some(&here) = piece.members.get(next) {
                next += 1;
                let Some(psi) = unwrapped[here] else { continue };
                for edge in self.neighbours(here) {
                    match unwrapped[edge.to] {
                        None => {
                            unwrapped[edge.to] = Some(psi + edge.turn);
                            piece.members.push(edge.to);
                        }
                        Some(there) if psi + edge.turn - there > PI => piece.turning.push(here),
                        Some(_) => {}
                    }
                }
            }
            pieces.push(piece);
        }
        pieces
    }

    /// A closed path along which ψ changes by a whole turn.
    fn full_turn(&self, taste: &Taste) -> Option<Vec<Place>> {
        let mut best: Option<(f64, Vec<Place>)> = None;
        for piece in self.pieces() {
            let apart = piece.turning.len().div_ceil(6).max(1);
            for &start in piece.turning.iter().step_by(apart) {
                if let Some((cost, path)) = self.loop_through(start, taste.opening_rad)
                    && best.as_ref().is_none_or(|(least, _)| cost < *least)
                {
                    best = Some((cost, path));
                }
            }
        }
        let mut path = best?.1;
        if taste.backwards {
            let first = path.first()?.psi;
            path.reverse();
            path.iter_mut().for_each(|place| place.psi += first);
        }
        // Start elsewhere on the closed path, and go on a little beyond its end.
        let (count, turn) = (path.len() - 1, path.last()?.psi - path.first()?.psi);
        let first = (taste.start * count as f64) as usize;
        let place = |index: usize| {
            let mut place = path[index % count];
            place.psi += turn * (index / count) as f64;
            place
        };
        Some((first..=first + count + count / 12 + 1).map(place).collect())
    }

    /// The cheapest closed path through `start` with one turn forwards (Dijkstra, on the surface unrolled over some turns).
    fn loop_through(&self, start: usize, opening_rad: f64) -> Option<(f64, Vec<Place>)> {
        type Node = (usize, i64);
        // How many whole turns ψ is beyond the ψ in [0, 2π) of the place.
        let laps = |from: usize, edge: &Edge| {
            ((self.places[from].psi + edge.turn - self.places[edge.to].psi) / TAU).round() as i64
        };
        let mut best: HashMap<Node, (f64, Node)> = HashMap::from([((start, 0), (0.0, (start, 0)))]);
        let mut queue = BinaryHeap::from([Waiting { cost: 0.0, node: (start, 0) }]);
        while let Some(Waiting { cost, node }) = queue.pop() {
            let (here, lap) = node;
            if best.get(&node).is_some_and(|(least, _)| cost > *least) {
                continue;
            }
            if node == (start, 1) {
                let mut nodes = vec![node];
                while let Some(&last) = nodes.last()
                    && last != (start, 0)
                {
                    nodes.push(best.get(&last)?.1);
                }
                let place =
                    |(place, lap): Node| Place { psi: self.places[place].psi + TAU * lap as f64, ..self.places[place] };
                return Some((cost, nodes.into_iter().rev().map(place).collect()));
            }
            for edge in self.neighbours(here) {
                let next = (edge.to, lap + laps(here, edge));
                let total = cost + self.cost(here, edge, Some(opening_rad));
                if next.1.abs() <= 2 && best.get(&next).is_none_or(|(least, _)| total < *least) {
                    best.insert(next, (total, node));
                    queue.push(Waiting { cost: total, node: next });
                }
            }
        }
        None
    }

    /// Paths that visit what can be felt from the three richest pieces of the surface.
    fn visits(&self) -> Vec<Vec<Place>> {
        let mut pieces = self.pieces();
        pieces.sort_by_key(|piece| {
            let mut felt = FeltBins::default();
            for &here in &piece.members {
                self.neighbours(here).for_each(|edge| felt.add(&self.places[here], edge.turn, &self.places[edge.to]));
            }
            Reverse((felt.count(), piece.members.len()))
        });
        pieces.iter().take(3).filter(|piece| piece.members.len() > 1).map(|piece| self.visit(&piece.members)).collect()
    }

    /// One path through a piece: to the nearest edge that feels something new, until there is none.
    fn visit(&self, members: &[usize]) -> Vec<Place> {
        // Start at one end: where the first contact lies lowest on the object.
        let lowest = |place: &&usize| self.places[**place].phi1;
        let Some(&start) = members.iter().min_by(|a, b| lowest(a).total_cmp(&lowest(b))) else { return Vec::new() };
        let mut felt = FeltBins::default();
        let mut path = vec![self.places[start]];
        let (mut here, mut psi) = (start, self.places[start].psi);
        while let Some(way) = self.nearest_new(here, &felt) {
            for edge in way {
                felt.add(&self.places[here], edge.turn, &self.places[edge.to]);
                psi += edge.turn;
                here = edge.to;
                path.push(Place { psi, ..self.places[here] });
            }
        }
        path
    }

    /// The cheapest way from `start` that ends with an edge that feels something new.
    fn nearest_new(&self, start: usize, felt: &FeltBins) -> Option<Vec<Edge>> {
        let mut best: HashMap<usize, (f64, usize, Edge)> = HashMap::new();
        let mut queue = BinaryHeap::from([Waiting { cost: 0.0, node: (start, 0) }]);
        while let Some(Waiting { cost, node: (here, _) }) = queue.pop() {
            if best.get(&here).is_some_and(|(least, ..)| cost > *least) {
                continue;
            }
            let new =
                self.neighbours(here).find(|edge| felt.is_new(&self.places[here], edge.turn, &self.places[edge.to]));
            if let Some(&last) = new {
                let mut way = vec![last];
                let mut at = here;
                while at != start {
                    let &(_, before, edge) = best.get(&at)?;
                    way.push(edge);
                    at = before;
                }
                way.reverse();
                return Some(way);
            }
            for &edge in self.neighbours(here) {
                let total = cost + self.cost(here, &edge, None);
                if edge.to != start && best.get(&edge.to).is_none_or(|(least, ..)| total < *least) {
                    best.insert(edge.to, (total, here, edge));
                    queue.push(Waiting { cost: total, node: (edge.to, 0) });
                }
            }
        }
        None
    }
}

/// A connected piece of the surface.
struct Piece {
    members: Vec<usize>,
    /// Places from which an edge closes a path with a whole turn.
    turning: Vec<usize>,
}

/// The place among `there` that the pose `from` becomes, if it does so without a jump, and how far the object turns.
fn joined(shape: &SupportFunction, places: &[Place], from: usize, there: &[usize]) -> Option<(usize, f64)> {
    let palms = |place: &Place| PalmPair::hinged(place.phi1, place.phi12 - place.phi1);
    let (here, target) = (&places[from], &places[*there.first()?]);
    let (psi, jumps) = followed(shape, &palms(here), &palms(target), here.psi);
    if !jumps.is_empty() {
        return None;
    }
    let apart = |other: &Place| wrapped(psi - other.psi).abs();
    let to = there.iter().copied().find(|&other| apart(&places[other]) < 1e-6)?;
    Some((to, psi - here.psi))
}

/// An entry of the queue of a shortest-path search; the greatest is the cheapest.
struct Waiting {
    cost: f64,
    node: (usize, i64),
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
        other.cost.total_cmp(&self.cost).then(other.node.cmp(&self.node))
    }
}

/// Which parts of the boundary have been felt.
#[derive(Clone, Debug)]
struct FeltBins([bool; BINS]);

impl Default for FeltBins {
    fn default() -> Self {
        Self([false; BINS])
    }
}

impl FeltBins {
    /// The parts that the contacts go over from one place to the next, where the object turns by `turn`.
    fn passed(from: &Place, turn: f64, to: &Place) -> impl Iterator<Item = usize> {
        let (from1, from2) = from.contact_angles();
        let (to1, to2) = Place { psi: from.psi + turn, ..*to }.contact_angles();
        [(from1, to1), (from2, to2)].into_iter().flat_map(|(a, b)| {
            let bin = |theta: f64| (theta / TAU * BINS as f64).floor();
            let (low, high) = (bin(a.min(b)), bin(a.max(b)));
            let count = ((high - low) as usize).min(BINS);
            (0..=count).map(move |step| ((low + step as f64).rem_euclid(BINS as f64) as usize).min(BINS - 1))
        })
    }

    fn add(&mut self, from: &Place, turn: f64, to: &Place) {
        Self::passed(from, turn, to).for_each(|bin| self.0[bin] = true);
    }

    fn is_new(&self, from: &Place, turn: f64, to: &Place) -> bool {
        Self::passed(from, turn, to).any(|bin| !self.0[bin])
    }

    fn count(&self) -> usize {
        self.0.iter().filter(|felt| **felt).count()
    }
}

fn within(shape: &SupportFunction, limits: &PalmLimits, palms: &PalmPair, psi: f64) -> bool {
    let (s1, s2) = palms.contact_positions_m(shape, psi);
    let reach = 0.0..=limits.palm_length_m;
    reach.contains(&s1) && reach.contains(&s2)
}

/// The path as a smooth motion that holds in simulation; smoothed as much as it bears.
fn realised(shape: &SupportFunction, limits: &PalmLimits, path: &[Place], duration_s: f64) -> Option<PlannedMotion> {
    let (first, last) = (path.first()?, path.last()?);
    // At last along the straight edges that were proved to hold, only the corners cut a little.
    let rounded = [4, 3, 2, 1].into_iter().map(|width| smoothed(path, width));
    rounded.chain([smoothed(&subdivided(path), 1), subdivided(path)]).find_map(|path| {
        let motion = timed(&path, duration_s)?;
        let planned = checked(shape, motion, first.psi, limits.palm_length_m)?;
        // Without a jump, but not where it was to go: another path.
        let turned = planned.end_psi_rad - planned.motion.start_psi_rad;
        ((turned - (last.psi - first.psi)).abs() < 0.5).then_some(planned.motion)
    })
}

/// The path with four places put in between any two.
fn subdivided(path: &[Place]) -> Vec<Place> {
    let mut fine = Vec::with_capacity(5 * path.len());
    for pair in path.windows(2) {
        for step in 0..5 {
            let between = |a: f64, b: f64| a + (b - a) * f64::from(step) / 5.0;
            let (a, b) = (&pair[0], &pair[1]);
            let (phi1, phi12) = (between(a.phi1, b.phi1), between(a.phi12, b.phi12));
            fine.push(Place { phi1, phi12, psi: between(a.psi, b.psi), stiffness: a.stiffness });
        }
    }
    fine.extend(path.last());
    fine
}

/// The path with its palm angles averaged over `width` places to either side, twice. The ends stay.
fn smoothed(path: &[Place], width: usize) -> Vec<Place> {
    let mut smooth = path.to_vec();
    for _ in 0..2 {
        let rough = smooth.clone();
        for (index, place) in smooth.iter_mut().enumerate() {
            let reach = width.min(index).min(rough.len() - 1 - index);
            let around = &rough[index - reach..=index + reach];
            let count = around.len() as f64;
            place.phi1 = around.iter().map(|near| near.phi1).sum::<f64>() / count;
            place.phi12 = around.iter().map(|near| near.phi12).sum::<f64>() / count;
        }
    }
    smooth
}

/// The path run through in `duration_s`, at a pace that turns palms and object evenly and starts and ends gently.
fn timed(path: &[Place], duration_s: f64) -> Option<PalmMotion> {
    let mut lengths = vec![0.0];
    for pair in path.windows(2) {
        let (turn1, turn12, psi) =
            (pair[1].phi1 - pair[0].phi1, pair[1].phi12 - pair[0].phi12, pair[1].psi - pair[0].psi);
        // A floor keeps times apart where nothing moves.
        let step = (turn1 * turn1 + turn12 * turn12 + psi * psi).sqrt().max(1e-4);
        lengths.push(lengths.last().copied().unwrap_or(0.0) + step);
    }
    let total = lengths.last().copied().filter(|total| *total > 0.0)?;
    // Over the first and last twentieth of the time the pace grows evenly from 0.
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
    let points: Vec<(f64, f64, f64)> = path
        .iter()
        .zip(&lengths)
        .map(|(place, length)| (duration_s * time(length / total), place.phi1, place.phi12 - place.phi1))
        .collect();
    PalmMotion::through(&points).ok()
}

/// A motion that holds, and where the object is at its end.
struct Checked {
    motion: PlannedMotion,
    end_psi_rad: f64,
}

/// The motion with what it feels, if the object follows it without a jump.
fn checked(shape: &SupportFunction, motion: PalmMotion, start_psi_rad: f64, palm_length_m: f64) -> Option<Checked> {
    let path = motion.sample(CHECKS / motion.duration_s()).ok()?;
    let start_psi_rad = EnergyLandscape::new(shape, &path.first()?.1).descend(start_psi_rad);
    let touchpad = Touchpad { length_m: palm_length_m, ..Touchpad::ideal() };
    let options = SimulateOptions { start_psi_rad, touchpad, ..SimulateOptions::default() };
    let simulation = simulate(shape, &path, &options).ok()?;
    let coverage = coverage(&simulation, &path);
    let end_psi_rad = simulation.truth.motion.last()?.psi_rad;
    let full_turn = (end_psi_rad - start_psi_rad).abs() >= TAU - 1e-6;
    let planned = PlannedMotion { motion, start_psi_rad, coverage, full_turn };
    simulation.jumps.is_empty().then_some(Checked { motion: planned, end_psi_rad })
}
