//! The residuals of contacts and forces of a log, and their normal equations, at some shape, motion, inertia and calibration.

use super::palm_path::PalmPath;
use crate::estimate::calibration::{CONSTANTS, Rows, Vector, changed, constants_off};
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::boundary::Boundary;
use crate::estimate::model::contact::{combine, contact_directions};
use crate::estimate::model::prior::{Convexity, Prior};
use crate::estimate::solver::arrow::{Arrow, ArrowBuilder};
use crate::estimate::work::Work;
use crate::log::Log;
use crate::math::spline::{SUPPORT, SplineBasis, SplineRow};
use crate::mechanics::inertial::{Inertia, InertialMoment, MovingPalms};
use crate::sensor::calibration::palm_rates_rad_per_s;
use crate::sensor::{Calibration, Rig};
use crate::shape::SupportFunction;
use nalgebra::DVector;
use std::borrow::Cow;

/// What is estimated.
#[derive(Clone, Debug)]
pub(crate) struct Unknowns {
    /// Of the support function.
    pub coefficients: Vec<f64>,
    /// ln of the square of the radius of gyration in metres.
    pub ln_gyration_m2: f64,
    /// Drag on the rotation over the moment of inertia, 1/s.
    pub damping_per_s: f64,
    pub calibration: Calibration,
    /// Coefficients of the spline ψ(t), radians.
    pub spline: Vec<f64>,
}

impl Unknowns {
    fn inertia(&self) -> Inertia {
        Inertia { gyration_m2: self.ln_gyration_m2.exp(), damping_per_s: self.damping_per_s }
    }
}

/// Places of the dense unknowns behind the coefficients of the shape: gyration, damping, constants of the rig in units of their priors.
pub(crate) const BESIDES_SHAPE: usize = 2 + CONSTANTS;
const GYRATION: usize = 0;
const DAMPING: usize = 1;
const RIG: usize = 2;

/// What is believed of the inertia beforehand; the damping is none, up to its standard deviation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InertiaPrior {
    /// ln of the square of the radius of gyration, metres.
    pub ln_gyration_m2: f64,
    pub ln_gyration_sd: f64,
    pub damping_sd_per_s: f64,
}

/// Prior standard deviations of ln k² (a fifth of the radius of gyration) and of the damping (it brings a swinging object to rest within a few
/// swings).
pub(crate) const LN_GYRATION_SD: f64 = 0.4;
const DAMPING_SD_PER_S: f64 = 10.0;

/// The same of what is held.
const HELD_SD: f64 = 1e-6;

impl InertiaPrior {
    /// Of an object whose mass may be uneven.
    pub fn free(ln_gyration_m2: f64) -> Self {
        Self { ln_gyration_m2, ln_gyration_sd: LN_GYRATION_SD, damping_sd_per_s: DAMPING_SD_PER_S }
    }

    /// Left as it is.
    pub fn held(ln_gyration_m2: f64) -> Self {
        Self { ln_gyration_m2, ln_gyration_sd: HELD_SD, damping_sd_per_s: HELD_SD }
    }
}

/// A log with the times at which its forces are looked at.
pub(crate) struct Problem<'a> {
    log: &'a Log,
    rig: &'a Rig,
    /// Of both contacts of each sample.
    weights: Vec<[f64; 2]>,
    path: PalmPath,
    pub basis: SplineBasis,
    pub samples: Vec<SplineRow>,
    /// Time and weight of each place where the forces are looked at.
    collocations: Vec<(f64, SplineRow, f64)>,
    order: usize,
    pub prior: Prior,
    convexity: Convexity,
    pub work: Work,
}

/// What rig and pads read, corrected by some calibration.
pub(crate) struct Corrected<'a> {
    log: Cow<'a, Log>,
    pub measurements: Measurements,
    rates: Vec<[f64; 2]>,
    palms: Vec<MovingPalms>,
}

/// Residuals of contacts and forces in metres: the sums of their squares, each with its weight, and how many there are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Squares {
    pub contacts: f64,
    pub forces: f64,
}

/// Normal equations of contacts and forces at standard deviations of a metre.
pub(crate) struct Linearised {
    pub contacts: Arrow,
    pub forces: Arrow,
}

/// Places at which the forces are looked at between two knots.
const PER_PIECE: usize = 4;

/// Nodes of the convexity penalty: so many for each harmonic, and so many besides.
const NODES: [usize; 2] = [16, 32];

/// Steps of the numerical derivatives of W by the palms: radians, and seconds.
const ANGLE_STEP: f64 = 1e-5;
const CLOCK_STEP_S: f64 = 1e-5;

impl<'a> Problem<'a> {
    /// Of a log, its rig and the path of the palms as it was read; with knots at these times (seconds), and the weights of the contacts in
    /// `weighted`.
    pub fn new(
        (log, rig, path): (&'a Log, &'a Rig, PalmPath),
        weighted: &Measurements,
        (order, prior): (usize, Prior),
        knots_s: &[f64],
    ) -> Self {
        let basis = SplineBasis::new(knots_s);
        let samples = log.samples.iter().map(|sample| basis.at(sample.time_s)).collect();
        let between = |pair: &[f64]| {
            let (from, to) = (pair[0], pair[1]);
            (0..PER_PIECE).map(move |i| from + (to - from) * (i as f64 + 0.5) / PER_PIECE as f64)
        };
        let collocations = knots_s.windows(2).flat_map(between).map(|time| (time, basis.at(time), 1.0)).collect();
        let weights = weighted.instants.iter().map(|instant| [instant.weight1, instant.weight2]).collect();
        let convexity = Convexity::new(order, prior.size_m, NODES[0] * order + NODES[1]);
        let work = weighted.work.clone();
        Self { log, rig, weights, path, basis, samples, collocations, order, prior, convexity, work }
    }

    /// Number of places where the forces are looked at.
    pub fn collocations(&self) -> usize {
        self.collocations.len()
    }

    /// Number of unknowns that all samples share.
    pub fn dense(&self) -> usize {
        2 * self.order + 1 + BESIDES_SHAPE
    }

    /// The readings as a rig with this calibration means them.
    pub fn corrected(&self, calibration: &Calibration) -> Corrected<'a> {
        let exact = *calibration == Calibration::default();
        let log = if exact { Cow::Borrowed(self.log) } else { Cow::Owned(calibration.corrected(self.log)) };
        let mut measurements = Measurements::new(&log, None);
        for (instant, weights) in measurements.instants.iter_mut().zip(&self.weights) {
            [instant.weight1, instant.weight2] = *weights;
        }
        let palms = self.collocations.iter().map(|(time_s, ..)| self.palms_at(*time_s, calibration)).collect();
        let rates = palm_rates_rad_per_s(&log);
        Corrected { log, measurements, rates, palms }
    }

    fn palms_at(&self, time_s: f64, calibration: &Calibration) -> MovingPalms {
        let read = self.path.at(time_s - calibration.clock_offset_s);
        let [zero1, zero2] = calibration.angle_zero_rad;
        let mut palms = read.turned([-zero1, -zero1 - zero2]);
        // A surface in front of the line of its palm is a base point that lies as much nearer.
        let shift = palms.angles.positions(calibration.surface_m, [0.0; 2]);
        palms.base_shifts_m = [0, 1].map(|k| palms.base_shifts_m[k] - shift[k]);
        palms
    }

    /// The unknowns after a step of the dense ones and of the spline.
    pub fn stepped(&self, from: &Unknowns, dense: &DVector<f64>, spline: &[f64]) -> Unknowns {
        let shape = from.coefficients.len();
        let mut to = from.clone();
        to.coefficients.iter_mut().zip(dense.iter()).for_each(|(value, step)| *value += step);
        to.ln_gyration_m2 += dense[shape + GYRATION];
        to.damping_per_s += dense[shape + DAMPING];
        let (_, sd) = constants_off(&from.calibration, self.rig);
        if sd.amax() > 0.0 {
            let step = Vector::from_fn(|c, _| sd[c] * dense[shape + RIG + c]);
            to.calibration = changed(&from.calibration, &self.rig.tolerances, &step);
        }
        to.spline.iter_mut().zip(spline).for_each(|(value, step)| *value += step);
        to
    }

    fn psi(row: &SplineRow, at: &Unknowns) -> [f64; 3] {
        row.of(&at.spline)
    }

    /// ψ of every sample.
    pub fn motion(&self, at: &Unknowns) -> Vec<f64> {
        self.samples.iter().map(|row| Self::psi(row, at)[0]).collect()
    }

    /// The contact residuals of every sample, with their weights: metres.
    fn contact_residuals_m(&self, at: &Unknowns, corrected: &Corrected) -> Vec<[f64; 2]> {
        let residual = |(instant, row): (&Instant, &SplineRow)| {
            let boundary = Boundary::new(&at.coefficients, contact_directions(instant, Self::psi(row, at)[0]));
            let value = combine(instant, boundary.at).value;
            [instant.weight1 * value[0], instant.weight2 * value[1]]
        };
        corrected.measurements.instants.iter().zip(&self.samples).map(residual).collect()
    }

    /// The moment of the forces at every place, without its weight.
    pub fn moments(&self, at: &Unknowns, corrected: &Corrected) -> Vec<InertialMoment> {
        let inertia = at.inertia();
        self.collocations
            .iter()
            .zip(&corrected.palms)
            .map(|((_, row, _), palms)| {
                let motion = Self::psi(row, at);
                let boundary = Boundary::new(&at.coefficients, palms.contact_directions(motion[0]));
                inertia.moment(&palms.carrying(boundary.at, [motion[1], motion[2]]), [0.0; 2])
            })
            .collect()
    }

    /// Gives every place the weight that its residual has under Student's t.
    pub fn reweigh(&mut self, moments: &[InertialMoment], forces_m: f64, freedom: f64) {
        for ((.., weight), moment) in self.collocations.iter_mut().zip(moments) {
            *weight = ((freedom + 1.0) / (freedom + (moment.value_m / forces_m).powi(2))).sqrt();
        }
    }

    pub fn squares(&self, at: &Unknowns, corrected: &Corrected) -> Squares {
        let contacts = self.contact_residuals_m(at, corrected).iter().flatten().map(|value| value * value).sum();
        let forces = self.weighted_moments_m(at, corrected).iter().map(|value| value * value).sum();
        Squares { contacts, forces }
    }

    /// The moment of the forces at every place, with its weight: metres.
    pub(super) fn weighted_moments_m(&self, at: &Unknowns, corrected: &Corrected) -> Vec<f64> {
        let moments = self.moments(at, corrected);
        self.collocations.iter().zip(&moments).map(|((.., weight), moment)| weight * moment.value_m).collect()
    }

    /// Half the cost of the prior: −ln of its density, up to a constant.
    pub fn prior_cost(&self, at: &Unknowns, inertia: InertiaPrior) -> f64 {
        let sd = self.prior.standard_deviations(self.order);
        let of_shape: f64 = at.coefficients.iter().zip(&sd).map(|(value, sd)| (value / sd).powi(2)).sum();
        let of_convexity: f64 = self.convexity.violations(&at.coefficients).map(|(_, residual)| residual.powi(2)).sum();
        let of_inertia = ((at.ln_gyration_m2 - inertia.ln_gyration_m2) / inertia.ln_gyration_sd).powi(2)
            + (at.damping_per_s / inertia.damping_sd_per_s).powi(2);
        let (off, _) = constants_off(&at.calibration, self.rig);
        0.5 * (of_shape + of_convexity + of_inertia + off.norm_squared())
    }

    /// The sum of ln of the prior standard deviations of the shape, by which numbers of harmonics differ.
    pub(super) fn ln_prior_sds(&self) -> f64 {
        self.prior.standard_deviations(self.order).iter().map(|sd| sd.ln()).sum()
    }

    /// Adds the normal equations of the prior.
    pub fn add_prior(&self, at: &Unknowns, inertia: InertiaPrior, arrow: &mut Arrow) {
        let shape = at.coefficients.len();
        let mut add = |index: usize, off: f64, sd: f64| {
            arrow.dense[(index, index)] += 1.0 / (sd * sd);
            arrow.dense_gradient[index] += off / (sd * sd);
        };
        for (index, sd) in self.prior.standard_deviations(self.order).into_iter().enumerate() {
            add(index, at.coefficients[index], sd);
        }
        add(shape + GYRATION, at.ln_gyration_m2 - inertia.ln_gyration_m2, inertia.ln_gyration_sd);
        add(shape + DAMPING, at.damping_per_s, inertia.damping_sd_per_s);
        let (off, _) = constants_off(&at.calibration, self.rig);
        (0..CONSTANTS).for_each(|c| add(shape + RIG + c, off[c], 1.0));
        let mut row = DVector::zeros(self.dense());
        for (node, residual) in self.convexity.violations(&at.coefficients) {
            self.convexity.row(node, &mut row.as_mut_slice()[..shape]);
            arrow.dense.syger(1.0, &row, &row, 1.0);
            arrow.dense_gradient.axpy(residual, &row, 1.0);
        }
        arrow.dense.fill_upper_triangle_with_lower_triangle();
        // Where neither contacts nor forces say anything the motion stays as it is.
        arrow.band.map_diagonal(|entry| entry + SPLINE_INFORMATION);
    }

    /// The normal equations.
    pub fn linearise(&self, at: &Unknowns, corrected: &Corrected) -> Linearised {
        self.work.add_step(self.samples.len() + self.collocations.len(), self.dense());
        Linearised { contacts: self.linearise_contacts(at, corrected), forces: self.linearise_forces(at, corrected) }
    }

    fn linearise_contacts(&self, at: &Unknowns, corrected: &Corrected) -> Arrow {
        let shape = at.coefficients.len();
        let support = SupportFunction::from_coefficients(&at.coefficients);
        let (_, sd) = constants_off(&at.calibration, self.rig);
        let is_open = sd.amax() > 0.0;
        let mut builder = ArrowBuilder::new(self.dense(), self.basis.len());
        let mut dense = vec![0.0; self.dense()];
        for (index, (instant, row)) in corrected.measurements.instants.iter().zip(&self.samples).enumerate() {
            let psi = Self::psi(row, at)[0];
            let boundary = Boundary::new(&at.coefficients, contact_directions(instant, psi));
            let residuals = combine(instant, boundary.at);
            let by_constants = is_open.then(|| {
                let sample = &corrected.log.samples[index];
                let positions = [sample.s1_m, sample.s2_m].map(Option::unwrap_or_default);
                let rows = Rows {
                    calibration: &at.calibration,
                    tolerances: &self.rig.tolerances,
                    palms: &sample.palms,
                    positions,
                };
                rows.by_constants(&support, psi, [0.0; 2], corrected.rates[index])
            });
            for (palm, weight) in [instant.weight1, instant.weight2].into_iter().enumerate() {
                if weight == 0.0 {
                    continue;
                }
                let mut share = [0.0; 2];
                share[palm] = weight;
                boundary.row_of(&instant.palms.positions_row(share), &mut dense[..shape]);
                if let Some(by_constants) = &by_constants {
                    (0..CONSTANTS).for_each(|c| dense[shape + RIG + c] = weight * sd[c] * by_constants[palm][c]);
                }
                let by_psi = weight * residuals.by_psi[palm];
                let spline = row.derivatives[0].map(|by| by * by_psi);
                builder.add(weight * residuals.value[palm], &dense, (row.first, spline));
            }
        }
        builder.finish()
    }

    fn linearise_forces(&self, at: &Unknowns, corrected: &Corrected) -> Arrow {
        let shape = at.coefficients.len();
        let inertia = at.inertia();
        let (_, sd) = constants_off(&at.calibration, self.rig);
        let mut builder = ArrowBuilder::new(self.dense(), self.basis.len());
        let mut dense = vec![0.0; self.dense()];
        for ((time_s, row, weight), palms) in self.collocations.iter().zip(&corrected.palms) {
            let motion = Self::psi(row, at);
            let boundary = Boundary::new(&at.coefficients, palms.contact_directions(motion[0]));
            let moment = inertia.moment(&palms.carrying(boundary.at, [motion[1], motion[2]]), [0.0; 2]);
            boundary.row_of(&moment.row, &mut dense[..shape]);
            dense[..shape].iter_mut().for_each(|by| *by *= weight);
            dense[shape + GYRATION] = weight * moment.by_gyration_m2 * inertia.gyration_m2;
            dense[shape + DAMPING] = weight * moment.by_damping;
            if sd.amax() > 0.0 {
                let turned = |by: [f64; 2]| {
                    let palms = palms.turned(by);
                    inertia.moment(&palms.carrying(boundary.turned(by), [motion[1], motion[2]]), [0.0; 2]).value_m
                };
                let later = |later_s: f64| {
                    let there = self.palms_at(time_s + later_s, &at.calibration);
                    let [from, to] = [palms.pair, there.pair].map(|pair| [pair.phi1_rad, pair.phi12_rad()]);
                    let contacts = boundary.turned([0, 1].map(|k| to[k] - from[k]));
                    inertia.moment(&there.carrying(contacts, [motion[1], motion[2]]), [0.0; 2]).value_m
                };
                let slope = |forwards: f64, backwards: f64, step: f64| (forwards - backwards) / (2.0 * step);
                // A zero of φ₁ turns both palms back, one of φ₂ the second; a late clock means earlier palms.
                let both = slope(turned([-ANGLE_STEP; 2]), turned([ANGLE_STEP; 2]), ANGLE_STEP);
                let second = slope(turned([0.0, -ANGLE_STEP]), turned([0.0, ANGLE_STEP]), ANGLE_STEP);
                let clock =
                    if sd[6] > 0.0 { slope(later(-CLOCK_STEP_S), later(CLOCK_STEP_S), CLOCK_STEP_S) } else { 0.0 };
                for (c, by) in [(3, both), (4, second), (6, clock)] {
                    dense[shape + RIG + c] = weight * sd[c] * by;
                }
            }
            let by_psi = moment.by_psi(&boundary.at, boundary.v_by_theta);
            let by_motion = [by_psi, moment.by_psi_rate, moment.by_psi_acceleration].map(|by| by * weight);
            let spline: [f64; SUPPORT] =
                std::array::from_fn(|i| (0..3).map(|order| by_motion[order] * row.derivatives[order][i]).sum());
            builder.add(weight * moment.value_m, &dense, (row.first, spline));
        }
        builder.finish()
    }
}

/// Information on the motion where nothing else says where it is, rad⁻²: an angle known to a thousand turns.
const SPLINE_INFORMATION: f64 = 1e-8;

/// How far a radius of gyration and a damping are from what is believed of them beforehand, the radius as a multiple of that of an even mass: the larger of
/// both, in prior standard deviations.
pub(crate) fn off_prior_sds(gyration_share: f64, damping_per_s: f64) -> f64 {
    let of_gyration = 2.0 * gyration_share.ln() / LN_GYRATION_SD;
    of_gyration.abs().max((damping_per_s / DAMPING_SD_PER_S).abs())
}
