//! The residuals of contacts, slip and forces of a log, measured forces included, and their normal equations, at some shape, motion, friction and calibration.
//!
//! With σ_k the place of the contact on palm k, from its base point along t̄_k, the material of the object slips along t̄_k by the change of
//! L_k = σ_k − ∫ v dθ: where it sticks, the contact moves as far over the palm as over the boundary. That holds over steps of any size.

use super::normal_forces::NormalForces;
use super::regimes::{Place, Regime, is_beside_a_change};
use super::strips::{LEAST_FRICTION, ends, nearest_end, prior_of_friction};
use crate::estimate::calibration::{CONSTANTS, Vector, changed, constants_off};
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::boundary::Boundary;
use crate::estimate::model::contact::contact_directions;
use crate::estimate::model::prior::{Convexity, Prior};
use crate::estimate::solver::arrow::{Arrow, ArrowBuilder, BandRow};
use crate::estimate::work::Work;
use crate::log::Log;
use crate::math::spline::SUPPORT;
use crate::math::statistics::correlation_time;
use crate::mechanics::coulomb::{Ratios, at_the_edges, moment, moment_by_psi, moment_by_ratio, moment_row};
use crate::sensor::{Calibration, Rig};
use nalgebra::DVector;
use std::borrow::Cow;

/// What is estimated.
#[derive(Clone, Debug)]
pub(crate) struct Unknowns {
    /// Of the support function about the centre of mass.
    pub coefficients: Vec<f64>,
    /// Coefficients of friction of both palms.
    pub friction: [f64; 2],
    /// Of the object, newtons: only measured forces tell it.
    pub weight_n: f64,
    pub calibration: Calibration,
    /// ψ of every sample, radians, unwrapped.
    pub psi: Vec<f64>,
}

/// Places of the dense unknowns behind the coefficients of the shape: friction, logarithm of the weight, constants of the rig in units of their
/// priors.
pub(crate) const BESIDES_SHAPE: usize = 3 + CONSTANTS;
const FRICTION: usize = 0;
pub(crate) const WEIGHT: usize = 2;
const RIG: usize = 3;

/// A log, and which contact sticks when.
pub(crate) struct Problem<'a> {
    log: &'a Log,
    rig: &'a Rig,
    work: Work,
    /// Of both contacts of each sample.
    weights: Vec<[f64; 2]>,
    order: usize,
    pub prior: Prior,
    /// Coefficients of friction that are held where they are.
    held: Option<[f64; 2]>,
    /// Whether intervals beside changes of the contact modes are left out.
    steady_only: bool,
    convexity: Convexity,
    /// Signs of the slips at the ends between which the moment of each sample vanishes; `None` where the motion does not say.
    ends: Vec<Option<[[f64; 2]; 2]>>,
    /// Whether what the forces of each sample miss counts.
    forces_count: Vec<bool>,
    /// Weight of the forces of each sample.
    force_weights: Vec<f64>,
    /// Weight of the normal force that each pad measured; 0 where it measured none.
    pad_weights: Vec<[f64; 2]>,
    /// Palms that are rolled on from a sample to the next, and the weights of these steps.
    rolls: Vec<(usize, usize)>,
    roll_weights: Vec<f64>,
    /// Runs of samples that stick to palm 1 and to palm 2.
    runs: [usize; 2],
    /// Samples at which a jump has just ended.
    starts: Vec<usize>,
}

/// What rig and pads read, corrected by some calibration.
#[derive(Clone)]
pub(crate) struct Corrected {
    pub measurements: Measurements,
    /// How far each base point lies out on its palm from where the lines of the palms meet, metres.
    pub base_shifts_m: Vec<[f64; 2]>,
}

/// The residuals in metres: of every contact with its weight, of every step that rolls, and of every sample whose forces miss something; and those
/// of measured forces in newtons.
pub(crate) struct Residuals {
    contacts_m: Vec<[f64; 2]>,
    rolls_m: Vec<f64>,
    /// Sample, signs of the slips, and the moment there with its weight.
    forces_m: Vec<(usize, [f64; 2], f64)>,
    /// Sample, palm, and what is measured beyond what should be, with its weight.
    pads_n: Vec<(usize, usize, f64)>,
}

/// Sums of squares, square metres and square newtons, and how many forces are missed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Squares {
    pub contacts: f64,
    pub rolls: f64,
    pub forces: f64,
    pub pads: f64,
}

/// Normal equations of each kind at standard deviations of a metre and a newton.
pub(crate) struct Linearised {
    pub contacts: Arrow,
    pub rolls: Arrow,
    pub forces: Arrow,
    pub pads: Arrow,
}

/// Nodes of the convexity penalty: so many for each harmonic, and so many besides.
const NODES: [usize; 2] = [16, 32];

/// Step of the numerical derivatives by the constants of the rig, in units of their priors.
const CONSTANT_STEP: f64 = 1e-3;

/// Standard deviation of a step of the motion, radians: far more than any, but for jumps, and less than what a sample without contacts strays.
const STEP_SD_RAD: f64 = 0.1;

/// Standard deviation of a coefficient of friction that is held.
const HELD_SD: f64 = 1e-4;

/// Information on the logarithm of the weight where no force is measured.
const WEIGHT_INFORMATION: f64 = 1e-6;

/// Largest step of the logarithm of the weight.
const LARGEST_LN_STEP: f64 = 1.0;

/// Information on the motion where nothing else says where it is, rad⁻²: an angle known to a thousand turns.
const MOTION_INFORMATION: f64 = 1e-8;

impl Residuals {
    pub fn squares(&self) -> Squares {
        Squares {
            contacts: self.contacts_m.iter().flatten().map(|value| value * value).sum(),
            rolls: self.rolls_m.iter().map(|value| value * value).sum(),
            forces: self.forces_m.iter().map(|(.., value)| value * value).sum(),
            pads: self.pads_n.iter().map(|(.., value)| value * value).sum(),
        }
    }

    /// Variance of a sum of many of slip or forces over that of as many independent ones, at least 1.
    pub fn inflation(&self, slip_m: f64, forces_m: f64, pads_n: f64) -> f64 {
        let of = |values: &[f64], sd_m: f64| {
            let squares: f64 = values.iter().map(|value| value * value).sum();
            correlation_time(values) * squares / (values.len().max(1) as f64 * sd_m * sd_m)
        };
        let forces: Vec<f64> = self.forces_m.iter().map(|(.., value)| *value).collect();
        let pads: Vec<f64> = self.pads_n.iter().map(|(.., value)| *value).collect();
        of(&self.rolls_m, slip_m).max(of(&forces, forces_m)).max(of(&pads, pads_n)).max(1.0)
    }

    /// Forces that are measured, and compared.
    pub fn measured(&self) -> usize {
        self.pads_n.len()
    }

    /// Samples whose forces miss something.
    pub fn missed(&self) -> usize {
        self.forces_m.len()
    }
}

impl<'a> Problem<'a> {
    /// Of a log and its rig, with the weights of the contacts in `weighted`.
    pub fn new(log: &'a Log, rig: &'a Rig, weighted: &Measurements, order: usize, prior: Prior) -> Self {
        Self {
            log,
            rig,
            work: weighted.work.clone(),
            weights: weighted.instants.iter().map(|instant| [instant.weight1, instant.weight2]).collect(),
            order,
            prior,
            held: None,
            steady_only: false,
            convexity: Convexity::new(order, prior.size_m, NODES[0] * order + NODES[1]),
            ends: vec![None; weighted.len()],
            forces_count: vec![true; weighted.len()],
            force_weights: vec![1.0; weighted.len()],
            pad_weights: log
                .samples
                .iter()
                .map(|sample| sample.forces_n().map(|force| f64::from(force.is_some())))
                .collect(),
            rolls: Vec::new(),
            roll_weights: Vec::new(),
            runs: [0; 2],
            starts: Vec::new(),
        }
    }

    /// The same with the coefficients of friction held here.
    pub fn holding(mut self, held: Option<[f64; 2]>) -> Self {
        self.held = held;
        self
    }

    /// The same without the intervals beside changes of the contact modes: these find arrangement and modes, but push friction.
    pub fn with_steady_intervals_only(mut self, steady_only: bool) -> Self {
        self.steady_only = steady_only;
        self
    }

    /// By how much the coefficients of friction are off where they are held, in standard deviations.
    fn off_held(&self, friction: [f64; 2]) -> [f64; 2] {
        self.held.map_or([0.0; 2], |held| [0, 1].map(|palm| (friction[palm] - held[palm]) / HELD_SD))
    }

    /// The same with these contact modes; at the samples `starts` a jump has just ended.
    pub fn with_regimes(mut self, regimes: &[Regime], starts: &[usize], at: &Unknowns, corrected: &Corrected) -> Self {
        self.ends = (0..regimes.len())
            .map(|i| {
                let instant = &corrected.measurements.instants[i];
                let boundary = Self::boundary(at, instant, at.psi[i]);
                ends(instant, &boundary.at, &regimes[i])
            })
            .collect();
        let is_silent = |index: usize| self.steady_only && is_beside_a_change(regimes, index);
        let counts = |index: usize| self.slides_on_both(index) || !is_silent(index);
        self.forces_count = (0..regimes.len()).map(counts).collect();
        self.rolls.clear();
        for i in 1..regimes.len() {
            let (from, to) = (regimes[i - 1].sticks(), regimes[i].sticks());
            if let Some(palm) = to
                && from == to
                && !starts.contains(&i)
            {
                self.rolls.push((i - 1, palm));
            }
        }
        self.roll_weights = vec![1.0; self.rolls.len()];
        self.starts = starts.to_vec();
        self.runs = super::strips::runs(regimes);
        self
    }

    /// Whether a sample slides on both palms: its moment vanishes at the edges of both cones.
    fn slides_on_both(&self, index: usize) -> bool {
        self.ends[index].is_some_and(|[one, other]| one == other)
    }

    /// Number of unknowns that all samples share.
    pub fn dense(&self) -> usize {
        2 * self.order + 1 + BESIDES_SHAPE
    }

    /// The readings as a rig with this calibration means them.
    pub fn corrected(&self, calibration: &Calibration) -> Corrected {
        let exact = *calibration == Calibration::default();
        let log = if exact { Cow::Borrowed(self.log) } else { Cow::Owned(calibration.corrected(self.log)) };
        let mut measurements = Measurements::new(&log, None);
        for (instant, weights) in measurements.instants.iter_mut().zip(&self.weights) {
            [instant.weight1, instant.weight2] = *weights;
        }
        let samples = log.samples.iter().zip(&measurements.instants);
        let base_shifts_m = samples.map(|(sample, instant)| sample.palms.base_shifts_m(&instant.palms)).collect();
        Corrected { measurements, base_shifts_m }
    }

    fn boundary(at: &Unknowns, instant: &Instant, psi: f64) -> Boundary {
        Boundary::new(&at.coefficients, contact_directions(instant, psi))
    }

    /// L of both palms at a sample, metres.
    fn unrolled_m(at: &Unknowns, corrected: &Corrected, index: usize, boundary: &Boundary) -> [f64; 2] {
        let (instant, shift) = (&corrected.measurements.instants[index], corrected.base_shifts_m[index]);
        let [s1, s2] = instant.palms.positions(boundary.at.r, boundary.at.d);
        let arc = boundary.arc_m(&at.coefficients, instant.contact_angles(at.psi[index]).into());
        [s1 - shift[0] - arc[0], shift[1] - s2 - arc[1]]
    }

    /// The residuals; the forces at the ends of the cones that `held` says, or at the nearest.
    pub fn residuals(&self, at: &Unknowns, corrected: &Corrected, held: Option<&Residuals>) -> Residuals {
        let instants = &corrected.measurements.instants;
        let boundaries: Vec<Boundary> =
            instants.iter().zip(&at.psi).map(|(instant, psi)| Self::boundary(at, instant, *psi)).collect();
        let contact = |(instant, boundary): (&Instant, &Boundary)| {
            let [s1, s2] = instant.palms.positions(boundary.at.r, boundary.at.d);
            [instant.weight1 * (s1 - instant.s1), instant.weight2 * (s2 - instant.s2)]
        };
        let contacts_m = instants.iter().zip(&boundaries).map(contact).collect();
        let unrolled = |index: usize| Self::unrolled_m(at, corrected, index, &boundaries[index]);
        let roll = |((index, palm), weight): (&(usize, usize), &f64)| {
            weight * (unrolled(index + 1)[*palm] - unrolled(*index)[*palm])
        };
        let rolls_m = self.rolls.iter().zip(&self.roll_weights).map(roll).collect();
        let value = |index: usize, signs: [f64; 2]| {
            let tau = at_the_edges(at.friction, signs);
            (index, signs, self.force_weights[index] * moment(&instants[index].palms, &boundaries[index].at, tau))
        };
        let forces_m = match held {
            Some(held) => held.forces_m.iter().map(|(index, signs, _)| value(*index, *signs)).collect(),
            None => {
                let missed = |(index, ends): (usize, &Option<[[f64; 2]; 2]>)| {
                    let of = |signs: [f64; 2]| value(index, signs).2;
                    nearest_end((*ends)?, of).map(|signs| value(index, signs))
                };
                let all = self.ends.iter().enumerate();
                all.filter(|(index, _)| self.forces_count[*index]).filter_map(missed).collect()
            }
        };
        let mut pads_n = Vec::new();
        for (index, weights) in self.pad_weights.iter().enumerate().filter(|(_, weights)| **weights != [0.0; 2]) {
            let Some(forces) = self.normal_forces(at, &instants[index], index, &boundaries[index]) else { continue };
            let measured = self.log.samples[index].forces_n();
            for palm in 0..2 {
                if let Some(force_n) = measured[palm] {
                    let off_n = force_n - at.weight_n * forces.over_weight[palm];
                    pads_n.push((index, palm, weights[palm] * off_n));
                }
            }
        }
        Residuals { contacts_m, rolls_m, forces_m, pads_n }
    }

    /// What pads should measure at a sample, over the weight, where its contact mode says.
    fn normal_forces(
        &self,
        at: &Unknowns,
        instant: &Instant,
        index: usize,
        boundary: &Boundary,
    ) -> Option<NormalForces> {
        NormalForces::new(&instant.palms, &boundary.at, at.friction, self.ends[index]?)
    }

    /// Half the cost of the prior: −ln of its density, up to a constant.
    pub fn prior_cost(&self, at: &Unknowns) -> f64 {
        let sd = self.prior.standard_deviations(self.order);
        let of_shape: f64 = at.coefficients.iter().zip(&sd).map(|(value, sd)| (value / sd).powi(2)).sum();
        let of_convexity: f64 = self.convexity.violations(&at.coefficients).map(|(_, residual)| residual.powi(2)).sum();
        let of_friction: f64 = (0..2).map(|palm| prior_of_friction(at.friction[palm], self.runs[palm]).cost).sum();
        let of_held: f64 = self.off_held(at.friction).iter().map(|off| 0.5 * off * off).sum();
        let (off, _) = constants_off(&at.calibration, self.rig);
        let of_motion: f64 = self.steps(at).map(|(_, step)| (step / STEP_SD_RAD).powi(2)).sum();
        0.5 * (of_shape + of_convexity + off.norm_squared() + of_motion) + of_friction + of_held
    }

    /// Steps of the motion without a jump, with the sample at which each begins.
    fn steps(&self, at: &Unknowns) -> impl Iterator<Item = (usize, f64)> {
        let steps = at.psi.windows(2).enumerate().map(|(from, pair)| (from, pair[1] - pair[0]));
        steps.filter(|(from, _)| !self.starts.contains(&(from + 1)))
    }

    /// Adds the normal equations of the prior.
    pub fn add_prior(&self, at: &Unknowns, arrow: &mut Arrow) {
        let shape = at.coefficients.len();
        let mut add = |index: usize, slope: f64, information: f64| {
            arrow.dense[(index, index)] += information;
            arrow.dense_gradient[index] += slope;
        };
        for (index, sd) in self.prior.standard_deviations(self.order).into_iter().enumerate() {
            add(index, at.coefficients[index] / (sd * sd), 1.0 / (sd * sd));
        }
        for palm in 0..2 {
            let prior = prior_of_friction(at.friction[palm], self.runs[palm]);
            add(shape + FRICTION + palm, prior.slope, prior.information);
            if self.held.is_some() {
                let off = self.off_held(at.friction)[palm];
                add(shape + FRICTION + palm, off / HELD_SD, 1.0 / (HELD_SD * HELD_SD));
            }
        }
        add(shape + WEIGHT, 0.0, WEIGHT_INFORMATION);
        let (off, _) = constants_off(&at.calibration, self.rig);
        (0..CONSTANTS).for_each(|c| add(shape + RIG + c, off[c], 1.0));
        let mut row = DVector::zeros(self.dense());
        for (node, residual) in self.convexity.violations(&at.coefficients) {
            self.convexity.row(node, &mut row.as_mut_slice()[..shape]);
            arrow.dense.syger(1.0, &row, &row, 1.0);
            arrow.dense_gradient.axpy(residual, &row, 1.0);
        }
        arrow.dense.fill_upper_triangle_with_lower_triangle();
        arrow.band.map_diagonal(|entry| entry + MOTION_INFORMATION);
        let information = 1.0 / (STEP_SD_RAD * STEP_SD_RAD);
        for (from, step) in self.steps(at) {
            let (first, row) = of_samples(at.psi.len(), [(from, -1.0), (from + 1, 1.0)]);
            arrow.band.add_outer_product(first, &row, information);
            arrow.band_gradient[from] -= information * step;
            arrow.band_gradient[from + 1] += information * step;
        }
    }

    /// The unknowns after a step of the dense ones and of the motion.
    pub fn stepped(&self, from: &Unknowns, dense: &DVector<f64>, motion: &[f64]) -> Unknowns {
        let shape = from.coefficients.len();
        let mut to = from.clone();
        to.coefficients.iter_mut().zip(dense.iter()).for_each(|(value, step)| *value += step);
        for (palm, friction) in to.friction.iter_mut().enumerate() {
            // At most halved at once, and never negative.
            let least = (0.5 * *friction).max(LEAST_FRICTION);
            *friction = (*friction + dense[shape + FRICTION + palm]).max(least);
        }
        to.weight_n *= dense[shape + WEIGHT].clamp(-LARGEST_LN_STEP, LARGEST_LN_STEP).exp();
        let (_, sd) = constants_off(&from.calibration, self.rig);
        if sd.amax() > 0.0 {
            let step = Vector::from_fn(|c, _| sd[c] * dense[shape + RIG + c]);
            to.calibration = changed(&from.calibration, &self.rig.tolerances, &step);
        }
        to.psi.iter_mut().zip(motion).for_each(|(value, step)| *value += step);
        to
    }

    /// Derivatives of all residuals by the constants, each in units of its prior; none for those that are exact.
    fn by_constants(&self, at: &Unknowns, here: &Residuals) -> Vec<Option<Residuals>> {
        let (_, sd) = constants_off(&at.calibration, self.rig);
        let there = |c: usize, step: f64| {
            let step = Vector::from_fn(|other, _| if other == c { sd[c] * step } else { 0.0 });
            let calibration = changed(&at.calibration, &self.rig.tolerances, &step);
            self.residuals(at, &self.corrected(&calibration), Some(here))
        };
        let slope = |forwards: f64, backwards: f64| (forwards - backwards) / (2.0 * CONSTANT_STEP);
        (0..CONSTANTS)
            .map(|c| {
                (sd[c] > 0.0).then(|| {
                    let (forwards, backwards) = (there(c, CONSTANT_STEP), there(c, -CONSTANT_STEP));
                    let contacts = forwards.contacts_m.iter().zip(&backwards.contacts_m);
                    let rolls = forwards.rolls_m.iter().zip(&backwards.rolls_m);
                    let forces = forwards.forces_m.iter().zip(&backwards.forces_m);
                    Residuals {
                        contacts_m: contacts.map(|(a, b)| [slope(a[0], b[0]), slope(a[1], b[1])]).collect(),
                        rolls_m: rolls.map(|(a, b)| slope(*a, *b)).collect(),
                        forces_m: forces.map(|(a, b)| (a.0, a.1, slope(a.2, b.2))).collect(),
                        // Those of both that are compared at the place itself.
                        pads_n: matching(here, &forwards, &backwards, slope),
                    }
                })
            })
            .collect()
    }

    /// The normal equations.
    pub fn linearise(&self, at: &Unknowns, corrected: &Corrected, here: &Residuals) -> Linearised {
        let (shape, samples) = (at.coefficients.len(), at.psi.len());
        self.work.add_banded_step(samples, self.dense());
        let by_constants = self.by_constants(at, here);
        let instants = &corrected.measurements.instants;
        let boundaries: Vec<Boundary> =
            instants.iter().zip(&at.psi).map(|(instant, psi)| Self::boundary(at, instant, *psi)).collect();
        let mut dense = vec![0.0; self.dense()];
        let mut contacts = ArrowBuilder::new(self.dense(), samples);
        for (index, (instant, boundary)) in instants.iter().zip(&boundaries).enumerate() {
            let (r_by_psi, d_by_psi) = boundary.at.by_psi();
            let by_psi = instant.palms.positions(r_by_psi, d_by_psi);
            for (palm, weight) in [instant.weight1, instant.weight2].into_iter().enumerate() {
                if weight == 0.0 {
                    continue;
                }
                let mut share = [0.0; 2];
                share[palm] = weight;
                dense.fill(0.0);
                boundary.row_of(&instant.palms.positions_row(share), &mut dense[..shape]);
                set_constants(&mut dense, shape, &by_constants, |slopes| slopes.contacts_m[index][palm]);
                let motion = of_samples(samples, [(index, weight * by_psi[palm])]);
                contacts.add(here.contacts_m[index][palm], &dense, motion);
            }
        }
        let mut rolls = ArrowBuilder::new(self.dense(), samples);
        for (place, (from, palm)) in self.rolls.iter().enumerate() {
            dense.fill(0.0);
            let mut by_psi = [0.0; 2];
            let weight = self.roll_weights[place];
            for (end, sign) in [(0, -weight), (1, weight)] {
                let index = from + end;
                let (instant, boundary) = (&instants[index], &boundaries[index]);
                let along = if *palm == 0 { sign } else { -sign };
                let mut share = [0.0; 2];
                share[*palm] = along;
                let mut row = vec![0.0; shape];
                boundary.row_of(&instant.palms.positions_row(share), &mut row);
                let theta: [f64; 2] = instant.contact_angles(at.psi[index]).into();
                boundary.add_arc_row(theta[*palm], *palm, -sign, &mut row);
                dense[..shape].iter_mut().zip(&row).for_each(|(sum, by)| *sum += by);
                let (r_by_psi, d_by_psi) = boundary.at.by_psi();
                let position = instant.palms.positions(r_by_psi, d_by_psi)[*palm];
                by_psi[end] = along * position + sign * boundary.at.v[*palm];
            }
            set_constants(&mut dense, shape, &by_constants, |slopes| slopes.rolls_m[place]);
            let motion = of_samples(samples, [(*from, by_psi[0]), (from + 1, by_psi[1])]);
            rolls.add(here.rolls_m[place], &dense, motion);
        }
        let mut forces = ArrowBuilder::new(self.dense(), samples);
        for (place, (index, signs, value)) in here.forces_m.iter().enumerate() {
            let (palms, boundary, weight) = (&instants[*index].palms, &boundaries[*index], self.force_weights[*index]);
            let tau: Ratios = at_the_edges(at.friction, *signs);
            dense.fill(0.0);
            boundary.row_of(&moment_row(palms, tau), &mut dense[..shape]);
            dense[..shape].iter_mut().for_each(|by| *by *= weight);
            for palm in 0..2 {
                let by_ratio = moment_by_ratio(palms, &boundary.at, tau, palm);
                dense[shape + FRICTION + palm] = -weight * signs[palm] * by_ratio;
            }
            set_constants(&mut dense, shape, &by_constants, |slopes| slopes.forces_m[place].2);
            let by_psi = weight * moment_by_psi(palms, &boundary.at, tau);
            forces.add(*value, &dense, of_samples(samples, [(*index, by_psi)]));
        }
        let mut pads = ArrowBuilder::new(self.dense(), samples);
        for (place, (index, palm, value)) in here.pads_n.iter().enumerate() {
            let (instant, boundary) = (&instants[*index], &boundaries[*index]);
            let Some(forces) = self.normal_forces(at, instant, *index, boundary) else { continue };
            let by = forces.by_unknowns(&instant.palms, &boundary.at, *palm);
            let weight_n = -self.pad_weights[*index][*palm] * at.weight_n;
            dense.fill(0.0);
            boundary.row_of(&by.contacts, &mut dense[..shape]);
            dense[..shape].iter_mut().for_each(|by| *by *= weight_n);
            for k in 0..2 {
                dense[shape + FRICTION + k] = weight_n * by.friction[k];
            }
            dense[shape + WEIGHT] = weight_n * forces.over_weight[*palm];
            set_constants(&mut dense, shape, &by_constants, |slopes| slopes.pads_n[place].2);
            pads.add(*value, &dense, of_samples(samples, [(*index, weight_n * by.psi)]));
        }
        Linearised { contacts: contacts.finish(), rolls: rolls.finish(), forces: forces.finish(), pads: pads.finish() }
    }

    /// Gives slip and forces the weights that they have under Student's t: here and there the modes are others.
    pub fn reweigh(
        &mut self,
        at: &Unknowns,
        corrected: &Corrected,
        [slip_m, forces_m, pads_n]: [f64; 3],
        freedom: f64,
    ) {
        let weight = |value: f64, sd_m: f64| ((freedom + 1.0) / (freedom + (value / sd_m).powi(2))).sqrt();
        self.force_weights.fill(1.0);
        self.roll_weights.fill(1.0);
        self.pad_weights.iter_mut().flatten().filter(|weight| **weight > 0.0).for_each(|weight| *weight = 1.0);
        let residuals = self.residuals(at, corrected, None);
        for (index, _, value) in residuals.forces_m {
            self.force_weights[index] = weight(value, forces_m);
        }
        for (index, palm, value) in residuals.pads_n {
            self.pad_weights[index][palm] = weight(value, pads_n);
        }
        self.roll_weights = residuals.rolls_m.iter().map(|value| weight(*value, slip_m)).collect();
    }

    /// Those of the residuals whose forces are at the edges of both cones: what else is missed is missed on one side alone, and tells less than
    /// its normal equations say.
    pub fn sliding(&self, here: &Residuals) -> Residuals {
        let slides = |(index, ..): &&(usize, [f64; 2], f64)| self.slides_on_both(*index);
        Residuals {
            contacts_m: here.contacts_m.clone(),
            rolls_m: here.rolls_m.clone(),
            forces_m: here.forces_m.iter().filter(slides).copied().collect(),
            pads_n: here.pads_n.clone(),
        }
    }

    /// The moment at a sample that slides on both palms, which vanishes, as a function of the coefficients; `None` of any other sample.
    pub fn sliding_row(&self, at: &Unknowns, corrected: &Corrected, index: usize) -> Option<DVector<f64>> {
        let [signs, other] = self.ends[index]?;
        let instant = &corrected.measurements.instants[index];
        let mut row = DVector::zeros(at.coefficients.len());
        let tau = at_the_edges(at.friction, signs);
        Self::boundary(at, instant, at.psi[index]).row_of(&moment_row(&instant.palms, tau), row.as_mut_slice());
        (signs == other).then_some(row)
    }

    /// Steps that roll.
    pub fn steps_that_roll(&self) -> usize {
        self.rolls.len()
    }
}

impl Regime {
    /// The palm that is rolled on.
    pub fn sticks(&self) -> Option<usize> {
        let order = self.order?;
        match self.place {
            Place::First => Some(order[0]),
            Place::Second => Some(order[1]),
            _ => None,
        }
    }
}

/// Differences of measured forces, for those of `here`; none where only some are compared.
fn matching(
    here: &Residuals,
    forwards: &Residuals,
    backwards: &Residuals,
    slope: impl Fn(f64, f64) -> f64,
) -> Vec<(usize, usize, f64)> {
    let at = |there: &Residuals, index: usize, palm: usize| {
        let place = there.pads_n.binary_search_by_key(&(index, palm), |(index, palm, _)| (*index, *palm)).ok()?;
        Some(there.pads_n[place].2)
    };
    let differences = here.pads_n.iter().map(|&(index, palm, _)| {
        let difference =
            at(forwards, index, palm).zip(at(backwards, index, palm)).map_or(0.0, |(more, less)| slope(more, less));
        (index, palm, difference)
    });
    differences.collect()
}

fn set_constants(
    dense: &mut [f64],
    shape: usize,
    by_constants: &[Option<Residuals>],
    slope: impl Fn(&Residuals) -> f64,
) {
    for (c, slopes) in by_constants.iter().enumerate() {
        dense[shape + RIG + c] = slopes.as_ref().map_or(0.0, &slope);
    }
}

/// ψ of a sample as a row of the band.
pub(crate) fn of_sample(samples: usize, index: usize) -> BandRow {
    of_samples(samples, [(index, 1.0)])
}

/// Derivatives by ψ of neighbouring samples as a row of the band.
fn of_samples<const COUNT: usize>(samples: usize, by: [(usize, f64); COUNT]) -> BandRow {
    let first = by[0].0.min(samples.saturating_sub(SUPPORT));
    let mut row = [0.0; SUPPORT];
    by.into_iter().for_each(|(index, value)| row[index - first] = value);
    (first, row)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::friction::modes::{Object, Sds, decode};
    use crate::mechanics::ContactMode;
    use crate::palms::PalmPair;
    use crate::shape::SupportFunction;
    use crate::simulate::{SimulateOptions, Simulation, simulate};

    fn shape() -> SupportFunction {
        SupportFunction::new(0.03, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]])
    }

    fn sticky(friction: [f64; 2]) -> Simulation {
        let at = |index: u32| {
            let t = 0.05 * f64::from(index);
            (t, PalmPair::hinged(0.9 + 0.3 * (0.7 * t).sin(), 1.2 + 0.4 * (0.9 * t + 0.5).sin()))
        };
        let motion: Vec<(f64, PalmPair)> = (0..400).map(at).collect();
        let options = SimulateOptions { friction, start_psi_rad: 0.4, ..SimulateOptions::default() };
        simulate(&shape(), &motion, &options).expect("possible")
    }

    fn truth(run: &Simulation, friction: [f64; 2]) -> Unknowns {
        Unknowns {
            coefficients: shape().coefficients(),
            friction,
            weight_n: 9.80665 * 0.05,
            calibration: Calibration::default(),
            psi: run.truth.motion.iter().map(|pose| pose.psi_rad).collect(),
        }
    }

    /// The modes of a simulation: at each sample those of the step that ends there.
    fn regimes(run: &Simulation, at: &Unknowns, corrected: &Corrected) -> Vec<Regime> {
        let sds = Sds { sensor_m: 1e-6, slip_m: 1e-8, forces_m: 1e-7 };
        let object = Object { coefficients: &at.coefficients, friction: at.friction, covariance: None };
        assert_eq!(run.modes.len(), at.psi.len());
        decode(&corrected.measurements, &corrected.base_shifts_m, object, sds, &at.psi, &[]).regimes
    }

    #[test]
    fn the_modes_of_a_simulation_are_found_and_leave_nothing() {
        for friction in [[0.1, 0.2], [0.05, 0.05], [0.3, 0.0]] {
            let run = sticky(friction);
            let at = truth(&run, friction);
            let rig = Rig::default();
            let weighted = Measurements::new(&run.log, None);
            let problem = Problem::new(&run.log, &rig, &weighted, 3, Prior::new(0.03, 0.015));
            let corrected = problem.corrected(&at.calibration);
            let regimes = regimes(&run, &at, &corrected);
            let sticks = |index: usize, palm: usize| run.modes[index][palm] == ContactMode::Stick;
            let wrong = (2..regimes.len()).filter(|&index| {
                let found = regimes[index].sticks();
                (0..2).any(|palm| (found == Some(palm)) != sticks(index, palm))
                    && !(sticks(index, 0) && sticks(index, 1))
            });
            // Steps in which the mode changes are either.
            assert!(wrong.count() <= 12, "{friction:?}");
            let problem = problem.with_regimes(&regimes, &[], &at, &corrected);
            let residuals = problem.residuals(&at, &corrected, None);
            let within = |values: &[f64], limit_m: f64| {
                let missed = values.iter().filter(|value| value.abs() > limit_m).count();
                assert!(missed <= 6, "{friction:?}: {missed} of {}", values.len());
            };
            within(&residuals.rolls_m, 1e-7);
            within(&residuals.forces_m.iter().map(|(.., value)| *value).collect::<Vec<_>>(), 1e-6);
        }
    }

    #[test]
    fn what_sticks_beside_a_change_of_the_modes_does_not_push_the_cones_out() {
        let run = sticky([0.1, 0.2]);
        // Cones that are too narrow, so that many contacts that stick miss them.
        let at = truth(&run, [0.05, 0.1]);
        let rig = Rig::default();
        let weighted = Measurements::new(&run.log, None);
        let problem = Problem::new(&run.log, &rig, &weighted, 3, Prior::new(0.03, 0.015));
        let corrected = problem.corrected(&at.calibration);
        let regimes = regimes(&run, &truth(&run, [0.1, 0.2]), &corrected);
        let missed = |steady_only: bool| {
            let problem = Problem::new(&run.log, &rig, &weighted, 3, Prior::new(0.03, 0.015));
            let problem = problem.with_steady_intervals_only(steady_only);
            let problem = problem.with_regimes(&regimes, &[], &at, &corrected);
            let missed = problem.residuals(&at, &corrected, None).forces_m;
            [(true, true), (true, false), (false, true), (false, false)].map(|(slides, beside)| {
                let is = |index: usize| {
                    problem.slides_on_both(index) == slides && is_beside_a_change(&regimes, index) == beside
                };
                missed.iter().filter(|(index, ..)| is(*index)).count()
            })
        };
        let (all, steady) = (missed(false), missed(true));
        assert!(all.iter().all(|count| *count > 0), "{all:?}");
        assert_eq!(steady, [all[0], all[1], 0, all[3]]);
    }

    #[test]
    fn normal_equations_match_finite_differences() {
        let run = sticky([0.1, 0.2]);
        let mut at = truth(&run, [0.11, 0.18]);
        let uncalibrated = Rig::uncalibrated();
        let weighted = Measurements::new(&run.log, None);
        let problem = Problem::new(&run.log, &uncalibrated, &weighted, 3, Prior::new(0.03, 0.015));
        let corrected = problem.corrected(&at.calibration);
        let regimes = regimes(&run, &at, &corrected);
        let problem = problem.with_regimes(&regimes, &[], &at, &corrected);
        at.coefficients[2] += 3e-4;
        at.psi.iter_mut().enumerate().for_each(|(index, psi)| *psi += 1e-3 * (index as f64).sin());
        at.weight_n *= 1.1;
        let here = problem.residuals(&at, &corrected, None);
        let linearised = problem.linearise(&at, &corrected, &here);
        let dense = problem.dense();
        let squares = |step: &DVector<f64>, motion: &[f64]| {
            let there = problem.stepped(&at, step, motion);
            problem.residuals(&there, &problem.corrected(&there.calibration), Some(&here)).squares()
        };
        let none = vec![0.0; at.psi.len()];
        let check = |numeric: f64, exact: f64, scale: f64| {
            assert!((numeric - exact).abs() <= 1e-4 * scale.max(exact.abs()), "{numeric:e} {exact:e}");
        };
        for unknown in 0..dense {
            let size = if unknown < 7 { 1e-6 } else { 1e-4 };
            let step = |sign: f64| DVector::from_fn(dense, |i, _| if i == unknown { sign * size } else { 0.0 });
            let (more, less) = (squares(&step(1.0), &none), squares(&step(-1.0), &none));
            let slope = |more: f64, less: f64| 0.25 * (more - less) / size;
            let scale = |gradient: &DVector<f64>| 1e-2 * gradient.amax();
            check(
                slope(more.contacts, less.contacts),
                linearised.contacts.dense_gradient[unknown],
                scale(&linearised.contacts.dense_gradient),
            );
            check(
                slope(more.rolls, less.rolls),
                linearised.rolls.dense_gradient[unknown],
                scale(&linearised.rolls.dense_gradient),
            );
            check(
                slope(more.forces, less.forces),
                linearised.forces.dense_gradient[unknown],
                scale(&linearised.forces.dense_gradient),
            );
            check(
                slope(more.pads, less.pads),
                linearised.pads.dense_gradient[unknown],
                scale(&linearised.pads.dense_gradient),
            );
        }
        for sample in [0, 57, 200, 399] {
            let step = |sign: f64| {
                let mut motion = none.clone();
                motion[sample] = sign * 1e-6;
                motion
            };
            let still = DVector::zeros(dense);
            let (more, less) = (squares(&still, &step(1.0)), squares(&still, &step(-1.0)));
            let slope = |more: f64, less: f64| 0.25 * (more - less) / 1e-6;
            check(slope(more.contacts, less.contacts), linearised.contacts.band_gradient[sample], 1e-9);
            check(slope(more.rolls, less.rolls), linearised.rolls.band_gradient[sample], 1e-9);
            check(slope(more.forces, less.forces), linearised.forces.band_gradient[sample], 1e-9);
            check(slope(more.pads, less.pads), linearised.pads.band_gradient[sample], 1e-6);
        }
    }
}
