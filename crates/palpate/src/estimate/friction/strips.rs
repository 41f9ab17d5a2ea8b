//! Centre of mass and coefficients of friction, by what the balance of forces asks of every sample.
//!
//! With the centre of mass at c from the origin of the form, in its frame, and D of [`cone`](crate::mechanics::coulomb), the moment about it is
//! W(τ) − D(τ) (c_x cos ψ − c_y sin ψ), linear in c and in each τ. Where both contacts slide it is 0 with τ at the edges of the cones; where the
//! object rolls on a palm it is 0 for some τ of that contact within its cone, so that 0 lies between its values at the two edges. What a sample
//! misses this by is its residual. The samples in a row that roll on one palm share what holds them, so that μ has one prior of a ratio within
//! the cone, −ln 2μ, for each such run: without it nothing would bound μ from above.

use super::regimes::{Place, Regime};
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::contact::contacts;
use crate::mechanics::ContactMode;
use crate::mechanics::coulomb::{Ratios, at_the_edges, moment, moment_by_psi, opening, slip_signs};
use crate::palms::Contacts;
use nalgebra::{Matrix4, Vector4};
use std::ops::Range;

/// Centre of mass and friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Friction {
    /// The centre of mass from the origin of the form, in its frame, metres.
    pub center_m: [f64; 2],
    /// Coefficients of friction of both palms.
    pub coefficients: [f64; 2],
    /// Covariance of the four.
    pub covariance: Matrix4<f64>,
    /// Root mean square of what the samples with a residual miss, in standard deviations.
    pub misfit: f64,
    /// Samples that slide on both palms, and runs of samples that stick to palm 1 and to palm 2.
    pub slides: usize,
    pub runs: [usize; 2],
}

/// Coefficients of friction that the fit begins with.
const STARTS: [f64; 4] = [0.02, 0.1, 0.2, 0.4];

/// What is believed of a coefficient of friction beforehand: mean and standard deviation.
const PRIOR: (f64, f64) = (0.2, 0.5);

/// Least coefficient of friction of the fit: without any there are no cones.
pub(crate) const LEAST_FRICTION: f64 = 1e-4;

/// The same of the centre of mass: from the origin of the form, as a share of its size.
pub(super) const CENTER_SD: f64 = 0.5;

/// Error of W that the form is allowed, as a share of the size: that of the smallest moments is else taken to be exact.
pub(super) const FORM_ALLOWANCE: f64 = 1e-3;

/// Rounds of the fit, and the change (in standard deviations) at which it ends.
const ROUNDS: usize = 60;
const ENOUGH: f64 = 1e-4;

/// Parts of the log that are left out in turn, for error bars: errors of the form and of a regime are common to many samples.
const PARTS: usize = 16;

/// Signs of the slips at the ends between which the moment vanishes at a sample; equal where it vanishes at them.
pub(super) fn ends(instant: &Instant, at: &Contacts, regime: &Regime) -> Option<[[f64; 2]; 2]> {
    let [s1, s2] = instant.palms.positions(at.r, at.d);
    // u_k grows with ψ' by (s₂ − s₁ cos φ₂)/sin φ₂ and its mirror image.
    let by_psi_rate = [s2 - s1 * instant.palms.cos2, s1 - s2 * instant.palms.cos2];
    let [below, between, above] = slip_signs(by_psi_rate, regime.order?);
    Some(match regime.place {
        Place::First | Place::Second if regime.sticks_on_both => [below, above],
        Place::Below => [below; 2],
        Place::First => [below, between],
        Place::Between => [between; 2],
        Place::Second => [between, above],
        Place::Above => [above; 2],
        Place::Anywhere => [below, above],
    })
}

impl Regime {
    /// The contact modes; `None` where the motion does not say.
    pub fn modes(&self, instant: &Instant, at: &Contacts) -> Option<[ContactMode; 2]> {
        let ends = ends(instant, at, self)?;
        let of = |palm: usize| {
            let [one, other] = ends.map(|signs| signs[palm]);
            if one == other { ContactMode::sliding(one) } else { ContactMode::Stick }
        };
        (self.place != Place::Anywhere).then(|| [of(0), of(1)])
    }
}

/// The end whose moment is missed by least, where it does not vanish between them.
pub(super) fn nearest_end(ends: [[f64; 2]; 2], moment_m: impl Fn([f64; 2]) -> f64) -> Option<[f64; 2]> {
    let values = ends.map(&moment_m);
    if ends[0] != ends[1] && values[0] * values[1] < 0.0 {
        return None;
    }
    Some(ends[usize::from(values[1].abs() < values[0].abs())])
}

/// −ln of the prior of a coefficient of friction, with so many runs of samples that stick, its slope and its information.
pub(super) struct OfFriction {
    pub cost: f64,
    pub slope: f64,
    pub information: f64,
}

pub(super) fn prior_of_friction(friction: f64, runs: usize) -> OfFriction {
    let ((mean, sd), runs) = (PRIOR, runs as f64);
    let information = 1.0 / (sd * sd);
    OfFriction {
        cost: 0.5 * information * (friction - mean).powi(2) + runs * (2.0 * friction).ln(),
        slope: information * (friction - mean) + runs / friction,
        information,
    }
}

/// One sample.
struct Strip {
    instant: Instant,
    at: Contacts,
    /// Cosine and sine of ψ.
    direction: [f64; 2],
    /// Signs of the slips at the ends between which the moment vanishes; equal where it vanishes at them.
    ends: [[f64; 2]; 2],
    psi_sd: f64,
}

/// A residual, in standard deviations, and its derivatives by centre of mass and friction.
type Row = (f64, Vector4<f64>);

impl Strip {
    fn new(instant: &Instant, coefficients: &[f64], psi: f64, psi_sd: f64, regime: &Regime) -> Option<Self> {
        let at = contacts(instant, coefficients, psi);
        let ends = ends(instant, &at, regime)?;
        Some(Self { instant: *instant, at, direction: [psi.cos(), psi.sin()], ends, psi_sd })
    }

    /// W − D (c_x cos ψ − c_y sin ψ).
    fn moment(&self, center: [f64; 2], tau: Ratios) -> f64 {
        let x = center[0] * self.direction[0] - center[1] * self.direction[1];
        moment(&self.instant.palms, &self.at, tau) - opening(&self.instant.palms, tau) * x
    }

    /// What the sample misses, where it misses something.
    fn row(&self, unknowns: &Vector4<f64>, allowance_m: f64) -> Option<Row> {
        let center = [unknowns[0], unknowns[1]];
        let tau = |signs: [f64; 2]| at_the_edges([unknowns[2], unknowns[3]], signs);
        let signs = nearest_end(self.ends, |signs| self.moment(center, tau(signs)))?;
        let at = tau(signs);
        let value = self.moment(center, at);
        // Linear in each ratio.
        let by_ratio = |k: usize| {
            let (mut with, mut without) = (at, at);
            (with[k], without[k]) = (1.0, 0.0);
            self.moment(center, with) - self.moment(center, without)
        };
        let opening = opening(&self.instant.palms, at);
        let sd = (moment_by_psi(&self.instant.palms, &self.at, at) * self.psi_sd).hypot(allowance_m);
        let slope = Vector4::new(
            -opening * self.direction[0],
            opening * self.direction[1],
            -signs[0] * by_ratio(0),
            -signs[1] * by_ratio(1),
        );
        Some((value / sd, slope / sd))
    }
}

/// Centre of mass and friction of a form (`coefficients`) and its motion; `size_m` is that of the object. `None` where too little is told.
pub(crate) fn center_and_friction(
    measurements: &Measurements,
    coefficients: &[f64],
    psi: &[f64],
    psi_sd: &[f64],
    regimes: &[Regime],
    size_m: f64,
) -> Option<Friction> {
    let samples = measurements.instants.iter().zip(psi).zip(psi_sd.iter().zip(regimes));
    let strips: Vec<Strip> = samples
        .filter(|((instant, _), _)| instant.both_seen())
        .filter_map(|((instant, psi), (sd, regime))| Strip::new(instant, coefficients, *psi, *sd, regime))
        .collect();
    let runs = runs(regimes);
    let slides = regimes.iter().filter(|regime| regime.place == Place::Between).count();
    let problem = Problem { strips: &strips, runs, size_m, left_out: 0..0 };
    let start = |friction: f64| problem.fitted(Vector4::new(0.0, 0.0, friction, friction));
    let (_, best) = STARTS.iter().filter_map(|friction| start(*friction)).min_by(|a, b| a.0.total_cmp(&b.0))?;
    let normal = problem.normal(&best);
    let inverse = normal.information.try_inverse()?;
    let misfit = (normal.squares / normal.rows.max(1) as f64).sqrt();
    let [x, y, first, second] = best.into();
    let covariance = inverse + problem.scatter_of_parts(&best)?;
    Some(Friction { center_m: [x, y], coefficients: [first, second], covariance, misfit, slides, runs })
}

/// Runs of samples that stick to palm 1 and to palm 2; what the motion does not say ends none.
pub(crate) fn runs(regimes: &[Regime]) -> [usize; 2] {
    let mut runs = [0; 2];
    let mut before = None;
    for regime in regimes {
        let stuck = match (regime.place, regime.order) {
            _ if regime.sticks_on_both => continue,
            (Place::First, Some(order)) => Some(order[0]),
            (Place::Second, Some(order)) => Some(order[1]),
            (Place::Anywhere, _) => continue,
            _ => None,
        };
        if let Some(palm) = stuck
            && before != Some(Some(palm))
        {
            runs[palm] += 1;
        }
        before = Some(stuck);
    }
    runs
}

struct Problem<'a> {
    strips: &'a [Strip],
    runs: [usize; 2],
    size_m: f64,
    /// Strips that do not count.
    left_out: Range<usize>,
}

/// The normal equations at some unknowns.
struct Normal {
    cost: f64,
    gradient: Vector4<f64>,
    information: Matrix4<f64>,
    squares: f64,
    rows: usize,
}

impl Problem<'_> {
    fn normal(&self, unknowns: &Vector4<f64>) -> Normal {
        let inverse_center = 1.0 / (CENTER_SD * self.size_m).powi(2);
        let prior = Vector4::new(inverse_center, inverse_center, 0.0, 0.0);
        let mut normal = Normal {
            cost: 0.5 * unknowns.component_mul(unknowns).dot(&prior),
            gradient: prior.component_mul(unknowns),
            information: Matrix4::from_diagonal(&prior),
            squares: 0.0,
            rows: 0,
        };
        for (palm, runs) in self.runs.into_iter().enumerate() {
            let of_friction = prior_of_friction(unknowns[2 + palm], runs);
            normal.cost += of_friction.cost;
            normal.gradient[2 + palm] += of_friction.slope;
            normal.information[(2 + palm, 2 + palm)] += of_friction.information;
        }
        let allowance_m = FORM_ALLOWANCE * self.size_m;
        let strips = self.strips.iter().enumerate().filter(|(place, _)| !self.left_out.contains(place));
        for (residual, slope) in strips.filter_map(|(_, strip)| strip.row(unknowns, allowance_m)) {
            // Soft L1: quadratic near zero, linear far out.
            let root = (1.0 + residual * residual).sqrt();
            normal.cost += root - 1.0;
            let weight = 1.0 / root;
            normal.gradient += weight * residual * slope;
            normal.information += weight * slope * slope.transpose();
            normal.squares += weight * residual * residual;
            normal.rows += 1;
        }
        normal
    }

    /// Covariance of the optimum by leaving out one part of the log after the other (the jackknife).
    fn scatter_of_parts(&self, best: &Vector4<f64>) -> Option<Matrix4<f64>> {
        let without = |part: usize| {
            let edge = |part: usize| self.strips.len() * part / PARTS;
            let left_out = edge(part)..edge(part + 1);
            Some(Self { left_out, ..*self }.fitted(*best)?.1)
        };
        let optima: Vec<Vector4<f64>> = (0..PARTS).map(without).collect::<Option<_>>()?;
        let mean = optima.iter().sum::<Vector4<f64>>() / PARTS as f64;
        let squares = |sum: Matrix4<f64>, optimum: &Vector4<f64>| sum + (optimum - mean) * (optimum - mean).transpose();
        let count = PARTS as f64;
        Some(optima.iter().fold(Matrix4::zeros(), squares) * ((count - 1.0) / count))
    }

    /// The optimum next to some unknowns, with its cost (Levenberg-Marquardt).
    fn fitted(&self, start: Vector4<f64>) -> Option<(f64, Vector4<f64>)> {
        let (mut unknowns, mut damping) = (start, 1e-3);
        let mut normal = self.normal(&unknowns);
        for _ in 0..ROUNDS {
            let damped = normal.information + damping * Matrix4::from_diagonal(&normal.information.diagonal());
            let step = -(damped.try_inverse()? * normal.gradient);
            let mut next = unknowns + step;
            // A coefficient of friction is at most halved at once, and never negative.
            for palm in 2..4 {
                next[palm] = next[palm].max(0.5 * unknowns[palm]).max(LEAST_FRICTION);
            }
            let there = self.normal(&next);
            if there.cost.is_finite() && there.cost <= normal.cost {
                let moved = (next - unknowns).component_mul(&normal.information.diagonal().map(f64::sqrt)).norm();
                (unknowns, normal, damping) = (next, there, (0.2 * damping).max(1e-9));
                if moved < ENOUGH {
                    break;
                }
            } else {
                damping *= 5.0;
                if damping > 1e12 {
                    break;
                }
            }
        }
        Some((normal.cost, unknowns))
    }
}
