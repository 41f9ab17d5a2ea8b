//! Other rotations of what lies behind a jump, or between two, against the rest: rolling and forces say how a part of the log moves, and only what
//! the parts share of the boundary, and the fall between them, say how they lie to each other.
//!
//! The rotation is profiled as without friction ([`turned_parts`]), with the forces at the edges of the cones where the contacts slide. What some
//! shape explains is taken to its own optimum, contact modes and all; there the fits are compared. So are parts between jumps that no contact shows
//! ([`nearly_symmetric`](super::nearly_symmetric)).

use super::nearly_symmetric::likelier_copies;
use super::{EXPLAINED, Setting, Settled};
use crate::estimate::association::part::Part;
use crate::estimate::association::relative_rotation::{LOOSE, Trial, parts, turned_parts};
use crate::estimate::evidence::motion_prior::{CERTAIN, EXCLUDED};
use crate::estimate::friction::falls::falls;
use crate::estimate::friction::problem::Unknowns;
use crate::estimate::friction::regimes::Regime;
use crate::estimate::friction::smoother::{FrictionNoise, Optimum};
use crate::estimate::model::layout::Layout;
use crate::estimate::model::noise::Noise;
use crate::estimate::motion::same_motion;
use crate::estimate::solver::shape_given_motion::ShapeGivenMotion;
use crate::math::angle::wrapped;
use crate::palms::PalmPair;
use crate::reconstruct::search::segments::segments;
use crate::shape::SupportFunction;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Trials that are taken to their optimum at most.
const MOST_TRIED: usize = 16;

/// Trials of one part closer than this lead to one optimum, radians.
const APART_RAD: f64 = 0.2;

/// Rounds of fit and modes for each, and updates of the standard deviations in each: from loose ones they fall fivefold in one.
const ROUNDS: usize = 3;
const UPDATES: usize = 6;

/// Optima that are looked for at once, before it is asked whether the log is worth more.
const AT_ONCE: usize = 8;

/// Times that a likelier rotation takes the place of the present one, at most: one part after the other.
const REPLACED: usize = 4;

/// The likeliest rotations of the parts, and others that are about as likely. `None` where the log is worth no more before all are known.
pub(super) fn likeliest(setting: &Setting, mut settled: Settled) -> Option<(Settled, Vec<Settled>)> {
    let mut replaced = 0;
    loop {
        let (likelier, others): (Vec<_>, Vec<_>) =
            rivals(setting, &settled)?.into_iter().partition(|(gain, _)| *gain > 0.0 && replaced < REPLACED);
        replaced += 1;
        match likelier.into_iter().next() {
            Some((_, rival)) => settled = rival,
            None => return Some((settled, others.into_iter().map(|(_, rival)| rival).collect())),
        }
    }
}

/// Optima with one part turned that are not much less likely than the present one, with the logarithm of by how much they are more; the likeliest
/// first.
fn rivals(setting: &Setting, present: &Settled) -> Option<Vec<(f64, Settled)>> {
    let mut trials = trials(setting, present);
    trials.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let is_near = |a: &Trial, b: &Trial| a.part == b.part && wrapped(a.omega - b.omega).abs() < APART_RAD;
    let mut apart: Vec<Trial> = Vec::new();
    for trial in trials {
        if apart.len() < MOST_TRIED && !apart.iter().any(|other| is_near(other, &trial)) {
            apart.push(trial);
        }
    }
    apart.extend(likelier_copies(setting, present));
    // What falls as no object does gives way to any that explains the log.
    let impossible = if present.falls(&setting.job.palms()) { 0.0 } else { EXCLUDED.0 };
    let here = setting.continued_cost(present);
    let weighed = |rival: Settled| {
        let gain = impossible + here - setting.continued_cost(&rival);
        (gain > -CERTAIN.0).then_some((gain, rival))
    };
    let with_parts_turned = apart.into_iter().map(|trial| with_part_turned(present, trial));
    let arranged: Vec<Arranged> = with_parts_turned.chain(without_a_jump(setting, present)).collect();
    let mut rivals: Vec<(f64, Settled)> = Vec::new();
    let mut left = arranged.into_iter();
    while left.len() > 0 {
        if setting.job.is_spent() {
            return None;
        }
        let some: Vec<Arranged> = left.by_ref().take(AT_ONCE).collect();
        rivals.par_extend(
            some.into_par_iter().filter_map(|arranged| arranged.optimum(setting, present).and_then(weighed)),
        );
    }
    let same = |other: &Settled| same_motion(&other.optimum.unknowns.psi, &present.optimum.unknowns.psi, TAU);
    // Where they differ by a few samples only, the likelier takes the place of the present one; so does one with fewer jumps.
    let asked = |rival: &Settled| if rival.starts.len() < present.starts.len() { 0.0 } else { CERTAIN.0 };
    rivals.retain(|(gain, rival)| !same(rival) || *gain > asked(rival));
    rivals.sort_by(|a, b| b.0.total_cmp(&a.0));
    Some(rivals)
}

/// The rotations of each part that some shape explains about as well as the present one.
fn trials(setting: &Setting, present: &Settled) -> Vec<Trial> {
    let Settled { optimum, regimes, starts } = present;
    let Unknowns { coefficients, psi, .. } = &optimum.unknowns;
    let sd_m = (LOOSE * coefficients[0]).max(optimum.noise.sensor_m);
    let contacts = Noise { sensor_m: sd_m, balance_m: f64::INFINITY };
    let order = Layout::of_coefficients(coefficients).order;
    let problem = setting.problem().with_regimes(regimes, starts, &optimum.unknowns, &optimum.corrected);
    let given = |samples: &[usize]| {
        let mut sum = ShapeGivenMotion::of_samples(&optimum.corrected.measurements, psi, samples, order, contacts);
        for row in samples.iter().filter_map(|&index| problem.sliding_row(&optimum.unknowns, &optimum.corrected, index))
        {
            sum.add_row(&row, 0.0, 1.0 / sd_m);
        }
        sum
    };
    let all: Vec<usize> = (0..psi.len()).collect();
    let parts = parts(&optimum.corrected.measurements, psi, starts, TAU);
    turned_parts(parts, &all, psi.len(), (setting.prior, order), &given)
}

/// The log arranged otherwise.
struct Arranged {
    coefficients: Vec<f64>,
    psi: Vec<f64>,
    regimes: Vec<Regime>,
    /// Samples at which a jump has just ended.
    starts: Vec<usize>,
}

/// The present motion with one part turned, between jumps.
fn with_part_turned(present: &Settled, Trial { part, omega, coefficients, .. }: Trial) -> Arranged {
    let psi = part.turned(&present.optimum.unknowns.psi, omega);
    let mut starts = present.starts.clone();
    let edges = part.ranges().iter().flat_map(|range| [range.start, range.end]);
    starts.extend(edges.filter(|edge| (1..psi.len()).contains(edge)));
    starts.sort_unstable();
    starts.dedup();
    Arranged { coefficients, psi, regimes: present.regimes.clone(), starts }
}

/// The motion without one of the jumps that no contact shows: the part before it, all before it, or the part behind it turned to where it goes on.
fn without_a_jump(setting: &Setting, present: &Settled) -> Vec<Arranged> {
    let Settled { optimum: Optimum { corrected, unknowns, .. }, regimes, starts } = present;
    let shown: Vec<usize> =
        segments(&corrected.measurements, setting.job.scatter_m).iter().map(|segment| segment.start).collect();
    let mut arranged = Vec::new();
    for (index, &start) in starts.iter().enumerate().filter(|(_, start)| !shown.contains(start)) {
        let leap = unknowns.psi[start] - unknowns.psi[start - 1];
        let before = index.checked_sub(1).map_or(0, |before| starts[before]);
        let end = starts.get(index + 1).copied().unwrap_or(unknowns.psi.len());
        let mut parts = vec![(before..start, leap), (start..end, -leap)];
        if before > 0 {
            parts.push((0..start, leap));
        }
        for (part, omega) in parts {
            let psi = Part::from(part).turned(&unknowns.psi, omega);
            let mut regimes = regimes.clone();
            regimes[start] = regimes[start - 1];
            let starts = starts.iter().copied().filter(|other| *other != start).collect();
            arranged.push(Arranged { coefficients: unknowns.coefficients.clone(), psi, regimes, starts });
        }
    }
    arranged
}

impl Arranged {
    /// Its optimum, where friction explains that and its jumps.
    fn optimum(self, setting: &Setting, present: &Settled) -> Option<Settled> {
        let Self { coefficients, psi, regimes, starts } = self;
        let Unknowns { friction, weight_n, calibration, .. } = present.optimum.unknowns;
        let size_m = coefficients[0];
        let noise = FrictionNoise {
            sensor_m: (LOOSE * size_m).max(present.optimum.noise.sensor_m),
            forces_m: LOOSE * size_m,
            ..present.optimum.noise
        };
        let unknowns = Unknowns { coefficients, friction, weight_n, calibration, psi };
        let setting = Setting { starts: &starts, ..*setting };
        let settled = setting.settled((unknowns, regimes), noise, (ROUNDS, UPDATES))?;
        let explains = settled.misses_at_most(setting.bounds, EXPLAINED) && settled.falls(&setting.job.palms());
        explains.then_some(settled)
    }
}

impl Setting<'_> {
    /// −ln of the posterior, up to a constant of the log: of prior, measured forces and contacts, the motion as mechanics continues it from sample
    /// to sample. Standard deviations of slip and forces, which a wrong rotation inflates, hardly count.
    fn continued_cost(&self, settled: &Settled) -> f64 {
        let Optimum { corrected, unknowns, noise, .. } = &settled.optimum;
        let decoded = self.decoded(corrected, unknowns, None, *noise, &settled.starts);
        // Its densities are those of a contact in standard deviations. Of the forces that are measured, not all are compared.
        let measured = self.log.samples.iter().flat_map(|sample| sample.forces_n()).flatten().count();
        let of_scales =
            corrected.measurements.seen() as f64 * noise.sensor_m.ln() + measured as f64 * noise.pads_n.ln();
        settled.optimum.prior_cost() + of_scales + decoded.cost()
    }
}

impl Settled {
    /// Whether the object may have fallen as it jumps.
    fn falls(&self, palms: &[PalmPair]) -> bool {
        let Unknowns { coefficients, psi, .. } = &self.optimum.unknowns;
        let shape = SupportFunction::from_coefficients(coefficients);
        falls(&shape, palms, psi, &self.starts).iter().all(|jump| jump.physical)
    }
}
