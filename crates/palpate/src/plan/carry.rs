//! Motions that carry an object round between palms with friction: it sticks to one palm while the other slides past it, and then the other way
//! about. No surface of poses says where it goes, for that depends on where it came from; so paths of the palms are searched with the mechanics
//! of Coulomb friction itself (best first, as A* with a heuristic that counts more than it should: I. Pohl, *Artificial Intelligence* 1, 193,
//! 1970), for several coefficients of friction at once: those that are likely all must carry it.

use std::collections::{BinaryHeap, HashSet};
use std::f64::consts::{FRAC_PI_2, TAU};

use rayon::prelude::*;

use super::error::PlanError;
use super::limits::PalmLimits;
use super::planned::PlannedMotion;
use super::queue::Waiting;
use super::surface::Place;
use super::timing::{subdivided, timed};
use crate::mechanics::coulomb::{FrictionPursuit, normal_forces};
use crate::palms::PalmPair;
use crate::sensor::Touchpad;
use crate::shape::SupportFunction;
use crate::simulate::{SimulateOptions, coverage, simulate};

/// What is known of the friction on the palms: the coefficients of palm 1 and palm 2 and their standard deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PalmFriction {
    /// Coefficients of palm 1 and palm 2.
    pub coefficients: [f64; 2],
    /// Their standard deviations; 0 where they are known.
    pub coefficient_sds: [f64; 2],
}

/// Standard deviations of friction that a motion bears on either side.
const BORNE_SDS: f64 = 2.0;

/// Palms move on a lattice of this, radians: a twentieth of what they have between them.
const STEP_RAD: f64 = 0.1;

/// Orientations that count as one, radians.
const SAME_RAD: f64 = 0.1;

/// Palm rotation that a radian of the turn still to go is taken to cost: more than what rolling costs, so that what turns the object is
/// tried first.
const COST_TO_GO: f64 = 3.0;

/// Nodes that are looked at in all, and at once.
const MOST_NODES: usize = 20_000;
const AT_ONCE: usize = 16;

/// Orientations that the object may be let go at.
const STARTS: usize = 12;

/// A whole turn and this share more, so that what the motion loses when its corners are rounded is no loss.
const BEYOND: f64 = 1.03;

/// Ends of paths that are tried in simulation, and by how much less each turns the object than the one before, radians.
const MOST_TRIED: usize = 16;
const APART_RAD: f64 = 0.2;

/// A motion that turns the object by less than this share of what it was to do is another one.
const MOST_OF_IT: f64 = 0.8;

/// A motion that turns the object by less than this is none, radians.
const LEAST_TURN_RAD: f64 = 0.5;

/// Normal forces over the weight that each palm shall carry: with less the object leaves it, and with much more it nearly jams.
const LEAST_FORCE: f64 = 0.02;
const MOST_FORCE: f64 = 4.0;

/// Samples that a planned motion is checked with.
const CHECKS: f64 = 3000.0;

impl PalmFriction {
    /// Known coefficients.
    pub fn known(coefficients: [f64; 2]) -> Self {
        Self { coefficients, coefficient_sds: [0.0; 2] }
    }

    fn is_in_order(&self) -> bool {
        let all = self.coefficients.into_iter().chain(self.coefficient_sds);
        all.into_iter().all(|value| (0.0..10.0).contains(&value))
    }

    /// What a motion has to bear: the likeliest, and all less and all more.
    fn borne(&self) -> Vec<[f64; 2]> {
        let at = |sds: f64| [0, 1].map(|k: usize| (self.coefficients[k] + sds * self.coefficient_sds[k]).max(0.0));
        match self.coefficient_sds {
            [0.0, 0.0] => vec![self.coefficients],
            _ => vec![self.coefficients, at(-BORNE_SDS), at(BORNE_SDS)],
        }
    }
}

/// A place on the lattice of palm angles.
type Lattice = (i32, i32);

/// Where a path has come to.
struct Node<'a> {
    at: Lattice,
    /// The object with each friction that is borne.
    pursuits: Vec<FrictionPursuit<'a>>,
    start_psi: f64,
    cost: f64,
    from: Option<usize>,
}

impl Node<'_> {
    /// By how much the object has turned, with the friction that turns it least.
    fn turned(&self) -> f64 {
        let turns = self.pursuits.iter().map(|pursuit| pursuit.psi_rad() - self.start_psi);
        let (least, most) = turns.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), turn| (a.min(turn), b.max(turn)));
        if least > 0.0 { least } else { most.min(0.0) }
    }

    /// Nodes with the same key are one.
    fn key(&self) -> (Lattice, i64) {
        (self.at, (self.pursuits[0].psi_rad() / SAME_RAD).round() as i64)
    }
}

/// Palms, object and friction.
pub(super) struct Carrying<'a> {
    shape: &'a SupportFunction,
    limits: &'a PalmLimits,
    friction: &'a PalmFriction,
}

impl<'a> Carrying<'a> {
    pub(super) fn new(shape: &'a SupportFunction, limits: &'a PalmLimits, friction: &'a PalmFriction) -> Self {
        Self { shape, limits, friction }
    }

    /// A motion that turns the object once around, or as far as it is found to go.
    pub(super) fn planned(&self, duration_s: f64) -> Result<PlannedMotion, PlanError> {
        if !self.friction.is_in_order() {
            return Err(PlanError::OutOfRange { what: "a coefficient of friction" });
        }
        let nodes = self.searched();
        let turned = |index: usize| nodes[index].turned().abs();
        let mut furthest: Vec<usize> = (0..nodes.len()).collect();
        furthest.sort_by(|a, b| turned(*b).total_cmp(&turned(*a)));
        // Paths that end much alike fail alike.
        let mut last = f64::INFINITY;
        furthest.retain(|index| {
            let apart = last - turned(*index) >= APART_RAD;
            if apart {
                last = turned(*index);
            }
            apart && last >= LEAST_TURN_RAD
        });
        let realised = furthest.iter().take(MOST_TRIED).find_map(|end| self.realised(&nodes, *end, duration_s));
        realised.ok_or(PlanError::Sticks { coefficients: self.friction.coefficients })
    }

    fn palms(&self, (i, j): Lattice) -> Option<PalmPair> {
        let (phi1, phi12) = (f64::from(i) * STEP_RAD, f64::from(j) * STEP_RAD);
        let phi2 = phi12 - phi1;
        let PalmLimits { smallest_phi1_rad, largest_phi12_rad, smallest_phi2_rad, largest_phi2_rad, .. } = *self.limits;
        let within = phi1 >= smallest_phi1_rad
            && phi12 <= largest_phi12_rad
            && (smallest_phi2_rad..=largest_phi2_rad).contains(&phi2);
        within.then(|| PalmPair::hinged(phi1, phi2))
    }

    /// Nodes that are reached until one has turned the object once around.
    fn searched(&self) -> Vec<Node<'a>> {
        let mut nodes: Vec<Node> = self.starts();
        let goal = BEYOND * TAU;
        let mut seen: HashSet<(Lattice, i64)> = nodes.iter().map(Node::key).collect();
        let waiting = |node: &Node, index: usize| Waiting {
            cost: node.cost + COST_TO_GO * (goal - node.turned().abs()),
            node: (index, 0),
        };
        let mut queue: BinaryHeap<Waiting> = nodes.iter().enumerate().map(|(i, node)| waiting(node, i)).collect();
        let mut is_there = false;
        while nodes.len() < MOST_NODES && !is_there {
            let some: Vec<usize> = (0..AT_ONCE).filter_map(|_| queue.pop()).map(|waiting| waiting.node.0).collect();
            if some.is_empty() {
                break;
            }
            let reached: Vec<Vec<Node>> = some.par_iter().map(|&from| self.moved(&nodes[from], from)).collect();
            for node in reached.into_iter().flatten() {
                if !seen.insert(node.key()) {
                    continue;
                }
                let index = nodes.len();
                queue.push(waiting(&node, index));
                is_there |= node.turned().abs() >= goal;
                nodes.push(node);
            }
        }
        nodes
    }

    /// The object let go in the middle of what the palms may do.
    fn starts(&self) -> Vec<Node<'a>> {
        let middle = |phi: f64| (phi / STEP_RAD).round() as i32;
        let places = [FRAC_PI_2, 0.6 * FRAC_PI_2, 1.3 * FRAC_PI_2]
            .map(|opening| (middle(FRAC_PI_2 - 0.5 * opening), middle(FRAC_PI_2 + 0.5 * opening)));
        let place = places.into_iter().find_map(|at| Some((at, self.palms(at)?)));
        let Some((at, palms)) = place else { return Vec::new() };
        let start = |index: usize| {
            let psi = TAU * index as f64 / STARTS as f64;
            let pursuit = |friction: [f64; 2]| FrictionPursuit::new(self.shape, friction, (0.0, palms), psi);
            let pursuits: Vec<FrictionPursuit> = self.friction.borne().into_iter().map(pursuit).collect();
            // Where it slides to as it is let go must not depend on what is not known.
            let start_psi = pursuits[0].psi_rad();
            let same = pursuits.iter().all(|pursuit| (pursuit.psi_rad() - start_psi).abs() < SAME_RAD);
            same.then_some(Node { at, pursuits, start_psi, cost: 0.0, from: None })
        };
        (0..STARTS).filter_map(start).collect()
    }

    /// Where the object is after each move of the palms that does not lose it.
    fn moved(&self, node: &Node<'a>, index: usize) -> Vec<Node<'a>> {
        let (i, j) = node.at;
        let moves = (-1..=1).flat_map(|by1| (-1..=1).map(move |by2| (by1, by2)));
        let reached = moves.filter(|by| *by != (0, 0)).filter_map(|(by1, by2)| {
            let at = (i + by1, j + by2);
            let palms = self.palms(at)?;
            let mut pursuits = node.pursuits.clone();
            for pursuit in &mut pursuits {
                self.followed(pursuit, palms, node.cost)?;
            }
            let cost = node.cost + STEP_RAD * f64::from(by1 * by1 + by2 * by2).sqrt();
            Some(Node { at, pursuits, start_psi: node.start_psi, cost, from: Some(index) })
        });
        reached.collect()
    }

    /// `None` where the object jumps, jams, leaves a palm or runs off it.
    fn followed(&self, pursuit: &mut FrictionPursuit, palms: PalmPair, time_s: f64) -> Option<()> {
        let jumps = pursuit.go_on((time_s, palms), &mut |seen| {
            let forces = normal_forces(&seen.angles, seen.tau).ok_or(())?;
            let (s1, s2) = seen.palms.contact_positions_m(self.shape, seen.psi_rad);
            let holds = forces.iter().all(|force| (LEAST_FORCE..MOST_FORCE).contains(force))
                && [s1, s2].iter().all(|s| (0.0..=self.limits.palm_length_m).contains(s));
            if holds { Ok(()) } else { Err(()) }
        });
        jumps.ok().filter(Vec::is_empty).map(|_| ())
    }

    /// The path to a node as a motion that holds in simulation, with every friction that is borne.
    fn realised(&self, nodes: &[Node], end: usize, duration_s: f64) -> Option<PlannedMotion> {
        let turned = nodes[end].turned();
        let mut path = Vec::new();
        let mut here = Some(end);
        while let Some(index) = here {
            let Node { at: (i, j), pursuits, from, .. } = &nodes[index];
            let (phi1, phi12) = (f64::from(*i) * STEP_RAD, f64::from(*j) * STEP_RAD);
            path.push(Place { phi1, phi12, psi: pursuits[0].psi_rad(), stiffness: 0.0 });
            here = *from;
        }
        path.reverse();
        let start_psi_rad = nodes[end].start_psi;
        // First with rounded corners.
        [path.clone(), subdivided(&path), subdivided(&subdivided(&path))].into_iter().find_map(|path| {
            let motion = timed(&path, duration_s)?;
            let samples = motion.sample(CHECKS / duration_s).ok()?;
            let mut least: Option<(f64, f64)> = None;
            for friction in self.friction.borne() {
                let touchpad = Touchpad { length_m: self.limits.palm_length_m, ..Touchpad::ideal() };
                let options = SimulateOptions { start_psi_rad, touchpad, friction, ..SimulateOptions::default() };
                let simulation = simulate(self.shape, &samples, &options).ok()?;
                let truth = &simulation.truth;
                let turned = truth.motion.last()?.psi_rad - truth.motion.first()?.psi_rad;
                if !simulation.jumps.is_empty() {
                    return None;
                }
                let felt = coverage(&simulation, &samples);
                least = Some(
                    least.map_or((turned, felt), |(t, f)| if turned.abs() < t.abs() { (turned, felt) } else { (t, f) }),
                );
            }
            let (least_turned, coverage) = least?;
            let full_turn = least_turned.abs() >= TAU - 1e-6;
            // Without a jump, but not where it was to go: another path.
            let holds = full_turn || (least_turned.abs() < TAU && least_turned / turned > MOST_OF_IT);
            holds.then_some(PlannedMotion { motion, start_psi_rad, coverage, full_turn })
        })
    }
}
