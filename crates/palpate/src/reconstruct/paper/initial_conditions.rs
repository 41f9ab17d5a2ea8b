//! The methods that integrate, with the search for their initial conditions (section 3 of Moll & Erdmann 2001): [`Method::Ode`],
//! the paper's equations 19 to 21 ([`super::equations`]), and [`Method::Quadrature`], the closed forms
//! ([`crate::estimate::closed_form`]).
//!
//! Each piece between two jumps has initial conditions of its own: the height of its centre of mass (balance leaves one
//! unknown of r₁ and r₂) and its orientation, of which one is free. As in the paper, those are
//! taken that minimise the sum of the errors that can be seen in the log itself,
//!
//! 1. the X coordinate of the centre of mass: where the integrated r₁ and r₂ put it, against where the sensors do;
//! 2. the contact points: where the integration puts them on the object, against the one outline that all of them describe.
//!
//! In an exact log the errors fall only within a hair's breadth of the true height: elsewhere the denominator of ψ' vanishes where its
//! numerator does not. Besides a grid of heights, those are tried with which both vanish together ([`Piece::crossing_heights`]).
//!
//! The piece with the longest path comes first; each further piece is aligned with the outline of the ones before it. An error
//! that has entered an integral stays there, so that no result is certified.

use crate::estimate::closed_form::{Contact, feasible_heights};
use crate::estimate::coverage::{NODES, touches};
use crate::estimate::measurements::Measurements;
use crate::estimate::model::contact::residuals;
use crate::estimate::model::layout::Layout;
use crate::estimate::model::noise_from_log::{contact_scatter_m, stated_noise_m, steps_m};
use crate::estimate::model::prior::Prior;
use crate::estimate::motion::unwrap;
use crate::log::{Log, Sample};
use crate::mechanics::{EnergyLandscape, Jump};
use crate::reconstruct::options::error::ReconstructError;
use crate::reconstruct::options::method::Method;
use crate::reconstruct::options::{MOST_HARMONICS, ReconstructOptions};
use crate::reconstruct::paper::given_start::LEAST_NOISE;
use crate::reconstruct::paper::outline_equations::OutlineEquations;
use crate::reconstruct::paper::piece::Piece;
use crate::reconstruct::result::reconstruction::{FoundSymmetry, Pose, Reconstruction};
use crate::reconstruct::search::segments::segments;
use crate::reconstruct::verdict::assemble::{outline, pose};
use crate::reconstruct::verdict::doubt::{Doubt, Verdict};
use crate::shape::SupportFunction;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Harmonics of the outline where the user does not choose.
const ORDER: usize = 12;

/// Trial heights of the first piece, and of the others: an outline that is already known has wider minima.
const HEIGHTS: [usize; 2] = [160, 48];

/// Trial orientations of a piece: 5 degrees apart.
const TURNS: usize = 72;

/// Trial heights that numerator and denominator of ψ' give, at most: those of an exact log are as many as its crossings, noise makes
/// hundreds.
const MOST_CROSSINGS: usize = 160;

/// Steps of a golden section search: they shrink the interval 100 000 times.
const REFINEMENTS: usize = 24;

/// Steps of a descent from a trial height: they shrink the cell of the grid a million times, and more where they need not walk.
const DESCENT: usize = 24;

/// Trials that are refined, the best ones: the best on the grid need not stay the best.
const REFINED: usize = 3;

/// Times that each piece is aligned again with all others: the first ones were aligned with a partial outline.
const SWEEPS: usize = 2;

/// Pieces that are integrated at most, those with the longest paths; the samples of the others are placed one by one.
const MOST_PIECES: usize = 48;

/// Least standard deviation of integrated r and d, as a share of the size of the object: integrals drift.
const INTEGRATION_SD: f64 = 2e-3;

/// Least size of an object, metres.
const LEAST_SIZE_M: f64 = 1e-9;

/// Scale of the prior of the harmonics, as a share of the size of the object.
const PRIOR_SCALE: f64 = 0.5;

/// Largest trial height where none is feasible, as a multiple of the size of the object.
const LARGEST_HEIGHT: f64 = 8.0;

/// Trial orientations of a sample that is placed alone: 2 degrees apart.
const TRIALS_ALONE: u32 = 180;

/// Reconstructs by integration with initial conditions that are searched for; `done` is given the share of the work done.
pub(crate) fn reconstruct(
    log: &Log,
    options: &ReconstructOptions,
    done: &dyn Fn(f64),
) -> Result<Reconstruction, ReconstructError> {
    let job = Job::new(log, options);
    let mut placed: Vec<Option<Placed>> = vec![None; job.pieces.len()];
    for sweep in 0..=SWEEPS {
        for index in 0..job.pieces.len() {
            let searched = (sweep * job.pieces.len() + index) as f64;
            done(searched / ((SWEEPS + 1) * job.pieces.len()) as f64);
            // A single piece has no others to be aligned with.
            if sweep > 0 && job.pieces.len() == 1 {
                continue;
            }
            let others = placed.iter().enumerate().filter(|(other, _)| *other != index);
            let mut outline = job.prior.clone();
            let mut alone = true;
            for (_, other) in others {
                if let Some(other) = other {
                    outline = outline.and(&other.equations);
                    alone = false;
                }
            }
            let found = job.search(&job.pieces[index], &outline, alone);
            if found.is_some() {
                placed[index] = found;
            }
        }
    }
    job.finish(placed)
}

/// Reconstructs by integration from known initial conditions: those of a shape and a motion at the start of each piece.
pub(crate) fn reconstruct_from(
    log: &Log,
    shape: &SupportFunction,
    psi_rad: &[f64],
    options: &ReconstructOptions,
) -> Result<Reconstruction, ReconstructError> {
    let job = Job::new(log, options);
    let placed = job
        .pieces
        .iter()
        .map(|piece| {
            let first = *piece.samples.first()?;
            let psi = *psi_rad.get(first)?;
            let (theta1, theta2) = piece.measurements.instants.first()?.contact_angles(psi);
            let contacts = piece.integrate((shape.at(theta1).r, shape.at(theta2).r))?;
            Some(job.place(piece, contacts, psi))
        })
        .collect();
    job.finish(placed)
}

/// A piece with initial conditions.
#[derive(Clone)]
struct Placed {
    contacts: Vec<Contact>,
    /// Its normal equations of the shape, at that orientation.
    equations: OutlineEquations,
}

struct Job<'a> {
    log: &'a Log,
    method: Method,
    measurements: Measurements,
    pieces: Vec<Piece>,
    order: usize,
    size_m: f64,
    /// Standard deviation of integrated r and d.
    integration_sd_m: f64,
    expected_m: f64,
    prior: OutlineEquations,
}

impl<'a> Job<'a> {
    fn new(log: &'a Log, options: &ReconstructOptions) -> Self {
        let stated_m = options.sensor_sd_m.or_else(|| stated_noise_m(log));
        let measurements = Measurements::new(log, stated_m);
        let scatter_m = contact_scatter_m(&measurements, steps_m(log));
        let size_m = measurements.size_m().max(LEAST_SIZE_M);
        let expected_m = stated_m.unwrap_or(scatter_m).max(LEAST_NOISE * size_m);
        let mut found: Vec<Piece> = segments(&measurements, scatter_m)
            .into_iter()
            .filter_map(|range| Piece::new(log, &measurements, range, options.method, expected_m))
            .collect();
        found.sort_by(|a, b| b.path_length_m().total_cmp(&a.path_length_m()));
        found.truncate(MOST_PIECES);
        let order = options.harmonics.unwrap_or(ORDER).clamp(1, MOST_HARMONICS);
        Self {
            log,
            method: options.method,
            measurements,
            pieces: found,
            order,
            size_m,
            integration_sd_m: expected_m.hypot(INTEGRATION_SD * size_m),
            expected_m,
            prior: OutlineEquations::prior(order, Prior::new(size_m, PRIOR_SCALE * size_m)),
        }
    }

    /// The piece at the orientation `turn` more than it was integrated with.
    fn place(&self, piece: &Piece, mut contacts: Vec<Contact>, turn: f64) -> Placed {
        contacts.iter_mut().for_each(|contact| contact.psi += turn);
        let equations = OutlineEquations::new(&piece.measurements, &contacts, self.order, self.integration_sd_m);
        Placed { contacts, equations }
    }

    /// The piece with the initial conditions that have the smallest errors against an outline.
    fn search(&self, piece: &Piece, outline: &OutlineEquations, alone: bool) -> Option<Placed> {
        let (low, high) = feasible_heights(&piece.measurements, &piece.relative, self.size_m)
            .unwrap_or((0.0, LARGEST_HEIGHT * self.size_m));
        let count = if alone { HEIGHTS[0] } else { HEIGHTS[1] };
        let cell = (high - low) / count as f64;
        let grid = (0..count).map(|index| low + cell * (index as f64 + 0.5));
        let crossings = piece.crossing_heights.iter().copied().filter(|height| low < *height && *height < high);
        let mut heights: Vec<f64> = grid.chain(thinned(crossings.collect())).collect();
        heights.sort_by(f64::total_cmp);
        // Errors and orientation for a trial height, near an orientation or anywhere.
        let trial = |height_m: f64, near: Option<f64>| -> (f64, f64) {
            let Some(contacts) = piece.integrate(piece.start(height_m)) else { return (f64::INFINITY, 0.0) };
            let drift =
                piece.x_error_m2(&contacts) * contacts.len() as f64 / (self.integration_sd_m * self.integration_sd_m);
            let equations = OutlineEquations::new(&piece.measurements, &contacts, self.order, self.integration_sd_m);
            let misfit = |turn: f64| outline.and(&equations.turned(turn)).misfit();
            if alone {
                return (drift + misfit(0.0), 0.0);
            }
            let step = TAU / TURNS as f64;
            let best = near.unwrap_or_else(|| {
                let turns = (0..TURNS).map(|index| step * index as f64);
                turns.map(|turn| (misfit(turn), turn)).min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |best| best.1)
            });
            let (turn, cost) = golden_section(best - step, best + step, misfit);
            (drift + cost, turn)
        };
        let trials: Vec<(f64, f64)> = heights.par_iter().map(|&height_m| trial(height_m, None)).collect();
        let cost = |index: usize| trials.get(index).map_or(f64::INFINITY, |trial| trial.0);
        let mut minima: Vec<usize> = (0..heights.len())
            .filter(|&i| cost(i).is_finite() && cost(i) <= cost(i.wrapping_sub(1)) && cost(i) <= cost(i + 1))
            .collect();
        minima.sort_by(|a, b| cost(*a).total_cmp(&cost(*b)));
        minima.truncate(REFINED);
        let refined: Vec<(f64, f64)> = minima
            .into_par_iter()
            .map(|index| {
                let turn = trials[index].1;
                descend((heights[index], trials[index].0), 0.5 * cell, |height_m| trial(height_m, Some(turn)).0)
            })
            .collect();
        let (height_m, _) = refined.into_iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let (_, turn) = trial(height_m, None);
        let contacts = piece.integrate(piece.start(height_m))?;
        Some(self.place(piece, contacts, turn))
    }

    /// The reported result.
    fn finish(&self, placed: Vec<Option<Placed>>) -> Result<Reconstruction, ReconstructError> {
        let mut all = self.prior.clone();
        let mut psi: Vec<Option<f64>> = vec![None; self.measurements.len()];
        let mut starts: Vec<usize> = Vec::new();
        let mut paths = Vec::new();
        for (piece, placed) in self.pieces.iter().zip(&placed) {
            let Some(placed) = placed else { continue };
            all = all.and(&placed.equations);
            starts.extend(piece.samples.first());
            for (&sample, contact) in piece.samples.iter().zip(&placed.contacts) {
                psi[sample] = Some(contact.psi);
            }
        }
        if starts.is_empty() {
            return Err(ReconstructError::NotSolvable);
        }
        let (coefficients, _) = all.solve().ok_or(ReconstructError::NotSolvable)?;
        let mut psi = self.placed_alone(&coefficients, psi);
        unwrap(&mut psi);
        // The gauge: ψ = 0 at the first sample.
        let turned = psi[0];
        psi.iter_mut().for_each(|psi| *psi -= turned);
        let shape = SupportFunction::from_coefficients(&coefficients).rotated(turned);
        if shape.has_nonfinite() || psi.iter().any(|psi| !psi.is_finite()) {
            return Err(ReconstructError::NotSolvable);
        }
        let coefficients = shape.coefficients();
        for (piece, placed) in self.pieces.iter().zip(&placed).filter(|(_, placed)| placed.is_some()) {
            let contacts = placed.iter().flat_map(|placed| &placed.contacts);
            let angles =
                piece.measurements.instants.iter().zip(contacts).map(|(i, c)| i.contact_angles(c.psi - turned));
            let (one, two): (Vec<f64>, Vec<f64>) = angles.unzip();
            paths.extend([one, two]);
        }
        let counts = touches(&paths);
        starts.sort_unstable();
        let jumps: Vec<usize> =
            starts[1..].iter().copied().filter(|&at| (psi[at] - psi[at - 1]).abs() > SMALLEST_JUMP_RAD).collect();
        let motion: Vec<Pose> = (0..self.measurements.len())
            .map(|index| {
                let (sample, instant) = (&self.log.samples[index], &self.measurements.instants[index]);
                let piece = jumps.iter().filter(|jump| **jump <= index).count() as u32;
                Pose { piece, ..pose(sample, instant, &shape, &coefficients, psi[index]) }
            })
            .collect();
        let outline = outline(&shape, &counts, |_| f64::NAN);
        let squares: Vec<f64> = motion
            .iter()
            .zip(&self.measurements.instants)
            .flat_map(|(pose, i)| {
                [
                    pose.residual1_m.map(|residual| residual * i.weight1),
                    pose.residual2_m.map(|residual| residual * i.weight2),
                ]
            })
            .flatten()
            .map(|residual| (residual / self.expected_m).powi(2))
            .collect();
        let dof = squares.len().saturating_sub(Layout::of_shape(self.order).unknowns()).max(1) as f64;
        let balance: Vec<f64> = self
            .measurements
            .instants
            .iter()
            .zip(&psi)
            .filter(|(instant, _)| instant.both_seen())
            .map(|(instant, psi)| residuals(instant, &coefficients, *psi).value[2].powi(2))
            .collect();
        Ok(Reconstruction {
            jumps: jumps.into_iter().map(|at| jump(&shape, &self.log.samples[at], [psi[at - 1], psi[at]])).collect(),
            shape,
            coverage: counts.iter().filter(|count| **count > 0).count() as f64 / NODES as f64,
            outline,
            motion,
            symmetry: FoundSymmetry::default(),
            verdict: Verdict::new(vec![Doubt::UncertifiedMethod { method: self.method }]),
            findings: None,
            chi2_per_dof: squares.iter().sum::<f64>() / dof,
            alternatives: 1,
            others: Vec::new(),
            sensor_sd_m: self.expected_m,
            balance_sd_m: (balance.iter().sum::<f64>() / balance.len().max(1) as f64).sqrt(),
            calibration: None,
            friction: None,
            inertia: None,
        })
    }

    /// ψ of every sample: as integrated; else the one that explains its contacts best; else that of a neighbour.
    fn placed_alone(&self, coefficients: &[f64], psi: Vec<Option<f64>>) -> Vec<f64> {
        let mut last = psi.iter().flatten().next().copied().unwrap_or(0.0);
        psi.into_iter()
            .zip(&self.measurements.instants)
            .map(|(psi, instant)| {
                let misfit = |psi: f64| residuals(instant, coefficients, psi).value.iter().map(|e| e * e).sum::<f64>();
                last = psi.unwrap_or_else(|| {
                    if !instant.both_seen() {
                        return last;
                    }
                    let step = TAU / f64::from(TRIALS_ALONE);
                    let trials = (0..TRIALS_ALONE).map(|index| last + step * f64::from(index));
                    let best = trials.map(|psi| (misfit(psi), psi)).min_by(|a, b| a.0.total_cmp(&b.0));
                    best.map_or(last, |(_, psi)| golden_section(psi - step, psi + step, misfit).0)
                });
                last
            })
            .collect()
    }
}

/// A turn by less than this between two pieces, in radians, is a false cut and no jump.
const SMALLEST_JUMP_RAD: f64 = 0.05;

/// The jump before a sample.
fn jump(shape: &SupportFunction, sample: &Sample, [before, after]: [f64; 2]) -> Jump {
    let landscape = EnergyLandscape::new(shape, &sample.palms);
    let (height_before_m, height_after_m) = (landscape.height_m(before), landscape.height_m(after));
    Jump {
        time_s: sample.time_s,
        psi_before_rad: before,
        psi_after_rad: after,
        height_before_m,
        height_after_m,
        physical: height_after_m < height_before_m,
    }
}

/// As many of these heights as are tried, evenly taken, so that they are dense where they were.
fn thinned(mut heights: Vec<f64>) -> Vec<f64> {
    heights.sort_by(f64::total_cmp);
    let stride = heights.len().div_ceil(MOST_CROSSINGS).max(1);
    heights.into_iter().step_by(stride).collect()
}

/// From a place and the value there down to a minimum nearby, with steps that are halved where both neighbours are higher. Unlike a
/// section of an interval it keeps the best place seen, however narrow the minimum is.
fn descend((mut place, mut least): (f64, f64), mut step: f64, value: impl Fn(f64) -> f64) -> (f64, f64) {
    for _ in 0..DESCENT {
        let lower = [place - step, place + step].map(|place| (place, value(place)));
        let lower = if lower[0].1 < lower[1].1 { lower[0] } else { lower[1] };
        if lower.1 < least {
            (place, least) = lower;
        } else {
            step *= 0.5;
        }
    }
    (place, least)
}

/// The place of a minimum between `low` and `high`, and the value there.
fn golden_section(mut low: f64, mut high: f64, value: impl Fn(f64) -> f64) -> (f64, f64) {
    // (√5 − 1)/2.
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let (mut left, mut right) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
    let (mut at_left, mut at_right) = (value(left), value(right));
    for _ in 0..REFINEMENTS {
        if at_left < at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - GOLDEN * (high - low);
            at_left = value(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + GOLDEN * (high - low);
            at_right = value(right);
        }
    }
    if at_left < at_right { (left, at_left) } else { (right, at_right) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_of_crossings_are_thinned_where_noise_makes_too_many() {
        let heights = |count: usize| (0..count).rev().map(|index| index as f64).collect::<Vec<f64>>();
        assert_eq!(thinned(heights(MOST_CROSSINGS)).len(), MOST_CROSSINGS);
        assert_eq!(thinned(heights(MOST_CROSSINGS + 2))[..3], [0.0, 2.0, 4.0]);
        assert!(thinned(Vec::new()).is_empty());
    }

    #[test]
    fn a_descent_follows_a_narrow_minimum_from_inside_it() {
        // Flat beyond a hair's breadth, where a section of the interval would find nothing.
        let value = |x: f64| (x - 0.3).abs().min(1e-4);
        let start = 0.3 + 5e-5;
        let (place, least) = descend((start, value(start)), 0.5, value);
        assert!((place - 0.3).abs() < 1e-6 && least < 1e-6, "{place}");
    }
}
