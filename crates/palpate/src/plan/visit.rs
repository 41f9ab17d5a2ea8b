//! Paths over the surface of stable poses that visit whatever can be felt, where the object cannot be turned once around.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};
use std::f64::consts::TAU;

use super::queue::Waiting;
use super::surface::{Edge, Place, Surface};

/// Steps (of 3°) in which the boundary counts as felt while planning.
const BINS: usize = 120;

impl Surface {
    /// Paths that visit what can be felt from the three richest pieces of the surface.
    pub(super) fn visits(&self) -> Vec<Vec<Place>> {
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
