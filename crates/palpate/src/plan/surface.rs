//! The surface of palm angles on which the object rests without a jump.
//!
//! The stable poses form a surface over the palm angles (φ₁, φ₁₂), in places several sheets of it (Moll & Erdmann 2001,
//! section 3: "the stable poses induce a two-dimensional subset of the (φ₁, φ₂, ψ)-configuration space"). It is laid out on
//! a grid of palm angles; two poses at neighbouring palm angles are joined when the pose can be followed from one to the
//! other without a jump.

use std::collections::HashMap;
use std::f64::consts::PI;

use super::limits::PalmLimits;
use crate::math::angle::wrapped;
use crate::mechanics::EnergyLandscape;
use crate::mechanics::frictionless::followed;
use crate::palms::PalmPair;
use crate::shape::SupportFunction;

/// Spacing of the grid of palm angles, radians.
const SPACING_RAD: f64 = 4.0 * PI / 180.0;

/// A stable pose at one point of the grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) phi1: f64,
    pub(super) phi12: f64,
    pub(super) psi: f64,
    /// g' over the size of the object.
    pub(super) stiffness: f64,
}

impl Place {
    pub(super) fn contact_angles(&self) -> (f64, f64) {
        PalmPair::hinged(self.phi1, self.phi12 - self.phi1).contact_angles(self.psi)
    }
}

/// The way from one place to a neighbour, with how far the object turns on it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub(super) to: usize,
    pub(super) turn: f64,
}

/// The surface of stable poses on the grid.
pub(super) struct Surface {
    pub(super) places: Vec<Place>,
    edges: Vec<Vec<Edge>>,
    typical_stiffness: f64,
    /// Which places may be used.
    usable: Vec<bool>,
}

impl Surface {
    /// The surface of all stable poses within the limits.
    pub(super) fn new(shape: &SupportFunction, limits: &PalmLimits) -> Self {
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

    /// Leaves only places at least this stiff (relative to the typical one) to be used.
    pub(super) fn keep_firmer_than(&mut self, margin: f64) {
        self.usable = self.places.iter().map(|place| place.stiffness >= margin * self.typical_stiffness).collect();
    }

    /// The ways on from a place.
    pub(super) fn neighbours(&self, place: usize) -> impl Iterator<Item = &Edge> {
        self.edges[place].iter().filter(|edge| self.usable[edge.to])
    }

    /// What an edge costs: how far palms and object turn, more where the object hardly rests.
    pub(super) fn cost(&self, from: usize, edge: &Edge, opening_rad: Option<f64>) -> f64 {
        let (a, b) = (&self.places[from], &self.places[edge.to]);
        let (turn1, turn12) = (b.phi1 - a.phi1, b.phi12 - a.phi12);
        let looseness = self.typical_stiffness / b.stiffness.max(1e-6 * self.typical_stiffness).max(1e-300);
        let opening = opening_rad.map_or(0.0, |wanted| (b.phi12 - b.phi1 - wanted).powi(2));
        (turn1 * turn1 + turn12 * turn12 + edge.turn * edge.turn).sqrt() * (1.0 + 0.3 * looseness.min(100.0) + opening)
    }

    /// The places of each connected piece, with ψ unwrapped along a tree, and the edges that do not agree with that by a
    /// whole turn: the object can be turned around along them.
    pub(super) fn pieces(&self) -> Vec<Piece> {
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
}

/// A connected piece of the surface.
pub(super) struct Piece {
    pub(super) members: Vec<usize>,
    /// Places from which an edge closes a path with a whole turn.
    pub(super) turning: Vec<usize>,
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

fn within(shape: &SupportFunction, limits: &PalmLimits, palms: &PalmPair, psi: f64) -> bool {
    let (s1, s2) = palms.contact_positions_m(shape, psi);
    let reach = 0.0..=limits.palm_length_m;
    reach.contains(&s1) && reach.contains(&s2)
}
