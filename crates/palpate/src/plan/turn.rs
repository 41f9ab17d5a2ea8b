//! Closed paths over the surface of stable poses that turn the object once around: ψ grows by 2π along them, so that all of
//! the boundary is felt, with either palm.

use std::collections::{BinaryHeap, HashMap};
use std::f64::consts::{FRAC_PI_2, TAU};

use super::queue::Waiting;
use super::surface::{Edge, Place, Surface};

/// What distinguishes planned motions of one object.
#[derive(Clone, Copy, Debug)]
pub(super) struct Taste {
    /// Where on the closed path the motion starts, 0 to 1.
    pub(super) start: f64,
    /// Whether ψ decreases.
    pub(super) backwards: bool,
    /// Preferred opening.
    pub(super) opening_rad: f64,
}

impl Default for Taste {
    fn default() -> Self {
        Self { start: 0.0, backwards: false, opening_rad: FRAC_PI_2 }
    }
}

impl Surface {
    /// A closed path along which ψ changes by a whole turn.
    pub(super) fn full_turn(&self, taste: &Taste) -> Option<Vec<Place>> {
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
}
