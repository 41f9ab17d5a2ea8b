//! Seeds: the state of the object in the middle of a window of about a swing, from a grid and then by least squares: of all ways that the contacts drive
//! (`estimate/inertia/contact_driven.rs`) the one along which both palms feel one and the same shape.

use super::{ORDER, Readings};
use crate::estimate::inertia::contact_driven::{ContactPath, Drive, InMotion, Passed, driven};
use crate::estimate::inertia::problem::LN_GYRATION_SD;
use crate::estimate::model::layout::Layout;
use crate::estimate::solver::shape_given_motion::ShapeGivenMotion;
use crate::mechanics::inertial::Inertia;
use nalgebra::{DVector, Matrix4, Vector4};
use rayon::prelude::*;

/// Half a window, in units of the time of the object: about half a swing.
const HALF_WINDOW: f64 = 3.5;

/// Steps in that unit.
const STEPS: f64 = 6.0;

/// The same in samples, at least; and samples within a window at least.
const HALF_SAMPLES: f64 = 4.0;
const FEWEST_SAMPLES: usize = 6;

/// Places on either way at which the shape is asked for.
const PLACES: usize = 10;

/// Trial values of r₁ and r₂ as shares of the radius of a disc there, and of Ω over the unit of time.
const RADII: (f64, f64, usize) = (0.5, 1.6, 8);
const RATES: (f64, f64, usize) = (-0.8, 0.8, 11);

/// Radius of gyration of a disc over its radius.
const DISC_GYRATION: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Support functions of an object between palms are positive, and smaller than so many times its size.
const LARGEST: f64 = 6.0;

/// Palms may pull by so much of the weight, at places: errors of the way.
const PULL: f64 = 0.05;

/// Starts of the grid that are refined, and steps of each.
const REFINED: usize = 12;
const REFINING_STEPS: usize = 20;

/// Largest misfit of a seed: squares over their number.
const EXPLAINED: f64 = 0.3;

/// A part of the log.
pub(super) struct Window {
    /// Its middle, seconds.
    middle_s: f64,
    half_s: f64,
}

/// What is known of the motion there: (r₁, r₂) over the size, Ω in units of the time, ln of the square of the radius of gyration over the size.
type Start = Vector4<f64>;

/// The state in the middle of a window.
pub(super) struct Seed {
    /// Of the way backwards from there and forwards, ends included.
    pub way: Vec<(f64, f64)>,
    pub coefficients: Vec<f64>,
    pub inertia: Inertia,
}

impl Window {
    /// So many windows at most, evenly through the livelier half of all, in which the contacts move further, the liveliest first: the very liveliest may all be
    /// of one wild moment.
    pub fn liveliest(readings: &Readings, most: usize) -> Vec<Self> {
        let samples = &readings.log.samples;
        let (Some(first), Some(end)) = (samples.first(), samples.last()) else { return Vec::new() };
        let interval_s = (end.time_s - first.time_s) / samples.len() as f64;
        let half_s = (HALF_WINDOW * readings.unit_s()).max(HALF_SAMPLES * interval_s);
        let mut way = vec![0.0];
        let (mut last, mut sum) = ([None::<f64>; 2], 0.0);
        for (sample, instant) in samples.iter().zip(&readings.measurements.instants).skip(1) {
            let seen = [sample.s1_m.filter(|_| instant.weight1 > 0.0), sample.s2_m.filter(|_| instant.weight2 > 0.0)];
            for (last, here) in last.iter_mut().zip(seen) {
                if let Some(here) = here {
                    sum += last.map_or(0.0, |last| (here - last).abs());
                    *last = Some(here);
                }
            }
            way.push(sum);
        }
        let count = ((end.time_s - first.time_s) / half_s) as usize;
        let index = |time_s: f64| samples.partition_point(|sample| sample.time_s < time_s);
        let mut windows: Vec<(f64, usize)> = (1..count)
            .filter_map(|number| {
                let middle_s = first.time_s + half_s * number as f64;
                let (from, to) = (index(middle_s - half_s), index(middle_s + half_s).min(samples.len()) - 1);
                (to >= from + FEWEST_SAMPLES).then(|| (way[to] - way[from], number))
            })
            .collect();
        windows.sort_by(|a, b| b.0.total_cmp(&a.0));
        let lively = windows.len().div_ceil(2);
        let every = lively.div_ceil(most).max(1);
        let chosen = windows[..lively].iter().step_by(every).map(|(_, number)| *number);
        chosen.map(|number| Self { middle_s: first.time_s + half_s * number as f64, half_s }).collect()
    }
}

/// The ways from the middle of a window to both its ends.
struct Ways<'a> {
    readings: &'a Readings<'a>,
    backward: Vec<Drive>,
    forward: Vec<Drive>,
    step_s: f64,
    /// Radius of a disc in the middle, metres.
    disc_m: f64,
}

/// What a start leads to.
struct Outcome {
    residuals: Vec<f64>,
    coefficients: Vec<f64>,
}

/// Whether no palm pulls.
fn pushes(passed: &Passed) -> bool {
    passed.normal_forces.iter().all(|force| *force > -PULL)
}

impl Outcome {
    fn cost(&self) -> f64 {
        self.residuals.iter().map(|residual| residual * residual).sum()
    }
}

impl Seed {
    /// The best of a window; `None` where none is explained.
    pub fn new(readings: &Readings, path: &ContactPath, window: &Window) -> Option<Self> {
        let step_s = readings.unit_s() / STEPS;
        let steps = (window.half_s / step_s) as usize;
        let forward = path.along(window.middle_s, step_s, steps);
        let backward = path.along(window.middle_s, -step_s, steps);
        let disc_m = forward[0].disc_radius_m();
        let ways = Ways { readings, backward, forward, step_s, disc_m };
        let (_, start, outcome) = ways.best().filter(|(misfit, ..)| *misfit <= EXPLAINED)?;
        let (state, inertia) = ways.state(&start);
        let [back, forth] = [(&ways.backward, -step_s), (&ways.forward, step_s)].map(|(drives, step_s)| {
            let way = driven(drives, step_s, state, inertia);
            let at = move |(index, passed): (usize, &Passed)| {
                (window.middle_s + step_s * index as f64, passed.state.psi_rad)
            };
            way.iter().enumerate().map(at).collect::<Vec<_>>()
        });
        let way = back.into_iter().skip(1).rev().chain(forth).collect();
        Some(Self { way, coefficients: outcome.coefficients, inertia })
    }
}

impl Ways<'_> {
    fn state(&self, start: &Start) -> (InMotion, Inertia) {
        let size_m = self.readings.prior.size_m;
        let state = InMotion {
            r_m: [size_m * start[0], size_m * start[1]],
            psi_rad: 0.0,
            psi_rate: start[2] / self.readings.unit_s(),
        };
        (state, Inertia { gyration_m2: size_m * size_m * start[3].exp(), damping_per_s: 0.0 })
    }

    fn ln_disc_gyration(&self) -> f64 {
        2.0 * (DISC_GYRATION * self.disc_m / self.readings.prior.size_m).ln()
    }

    /// Both ways of a start. `None` where they lead out of all bounds.
    fn passed(&self, start: &Start) -> Option<[Vec<Passed>; 2]> {
        let (state, inertia) = self.state(start);
        let bounds = 0.0..LARGEST * self.readings.prior.size_m;
        let is_within = |passed: &Passed| passed.state.r_m.iter().all(|r| bounds.contains(r));
        let ways =
            [driven(&self.backward, -self.step_s, state, inertia), driven(&self.forward, self.step_s, state, inertia)];
        ways.iter().all(|way| way.len() == self.forward.len().div_ceil(2) && way.iter().all(is_within)).then_some(ways)
    }

    /// Misfit of a start with the shape that suits its ways best. `None` where they lead out of all bounds.
    fn outcome(&self, start: &Start) -> Option<Outcome> {
        self.outcome_of(&self.passed(start)?, start)
    }

    fn outcome_of(&self, ways: &[Vec<Passed>; 2], start: &Start) -> Option<Outcome> {
        let Readings { prior, measurements, .. } = *self.readings;
        let sd_m = self.readings.tolerance_m();
        let layout = Layout::of_shape(ORDER);
        let mut rows: Vec<(DVector<f64>, f64)> = Vec::with_capacity(8 * (PLACES + 1));
        for (way, drives) in ways.iter().zip([&self.backward, &self.forward]) {
            let stride = (way.len() / PLACES).max(1);
            for (index, passed) in way.iter().enumerate().step_by(stride) {
                let pair = drives[2 * index].palms.pair;
                let (theta1, theta2) = pair.contact_angles(passed.state.psi_rad);
                for (k, theta) in [theta1, theta2].into_iter().enumerate() {
                    rows.push((layout.support_row(theta), passed.contacts.r[k]));
                    // d = −r'.
                    rows.push((-layout.slope_row(theta), passed.contacts.d[k]));
                }
            }
        }
        measurements.work.add_step(rows.len() / 3, layout.unknowns());
        let mut equations = ShapeGivenMotion::of_prior(prior, ORDER);
        rows.iter().for_each(|(row, value)| equations.add_row(row, *value, 1.0 / sd_m));
        let (_, coefficients) = equations.minimum()?;
        let vector = DVector::from_column_slice(&coefficients);
        let mut residuals: Vec<f64> = rows.iter().map(|(row, value)| (row.dot(&vector) - value) / sd_m).collect();
        let sds = prior.standard_deviations(ORDER);
        residuals.extend(coefficients.iter().zip(sds).map(|(value, sd)| value / sd));
        residuals.push((start[3] - self.ln_disc_gyration()) / LN_GYRATION_SD);
        Some(Outcome { residuals, coefficients })
    }

    /// The best start with its misfit.
    fn best(&self) -> Option<(f64, Start, Outcome)> {
        let values = |(from, to, count): (f64, f64, usize)| {
            (0..count).map(move |i| from + (to - from) * i as f64 / (count - 1) as f64)
        };
        let share = self.disc_m / self.readings.prior.size_m;
        let starts: Vec<Start> = values(RADII)
            .flat_map(|r1| values(RADII).map(move |r2| (r1, r2)))
            .flat_map(|(r1, r2)| values(RATES).map(move |rate| (r1, r2, rate)))
            .map(|(r1, r2, rate)| Vector4::new(share * r1, share * r2, rate, self.ln_disc_gyration()))
            .collect();
        let mut costs: Vec<(f64, usize)> = starts
            .par_iter()
            .enumerate()
            .filter_map(|(index, start)| {
                let ways = self.passed(start).filter(|ways| ways.iter().flatten().all(pushes))?;
                Some((self.outcome_of(&ways, start)?.cost(), index))
            })
            .collect();
        costs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        costs.truncate(REFINED);
        let refined: Vec<(Start, Outcome)> =
            costs.par_iter().filter_map(|(_, index)| self.refined(starts[*index])).collect();
        let best = refined.into_iter().min_by(|a, b| a.1.cost().total_cmp(&b.1.cost()))?;
        let (start, outcome) = best;
        Some((outcome.cost() / outcome.residuals.len() as f64, start, outcome))
    }

    /// The minimum next to a start (Levenberg and Marquardt, differences for derivatives).
    fn refined(&self, start: Start) -> Option<(Start, Outcome)> {
        const STEP: f64 = 1e-4;
        let (mut at, mut here) = (start, self.outcome(&start)?);
        let mut damping = 0.1;
        for _ in 0..REFINING_STEPS {
            let mut columns = Vec::with_capacity(4);
            for unknown in 0..4 {
                let mut there = at;
                there[unknown] += STEP;
                let outcome = self.outcome(&there)?;
                let column: Vec<f64> =
                    outcome.residuals.iter().zip(&here.residuals).map(|(there, here)| (there - here) / STEP).collect();
                columns.push(column);
            }
            let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
            let information = Matrix4::from_fn(|i, j| dot(&columns[i], &columns[j]));
            let gradient = Vector4::from_fn(|i, _| dot(&columns[i], &here.residuals));
            let mut fall = 0.0;
            while damping < 1e6 {
                let damped = information + Matrix4::from_diagonal(&(damping * information.diagonal()));
                let there = damped.cholesky().map(|factor| at - factor.solve(&gradient));
                let outcome = there.and_then(|there| Some((there, self.outcome(&there)?)));
                if let Some((there, outcome)) = outcome.filter(|(_, outcome)| outcome.cost() < here.cost()) {
                    fall = here.cost() - outcome.cost();
                    (at, here) = (there, outcome);
                    damping = f64::max(damping / 6.0, 1e-8);
                    break;
                }
                damping *= 4.0;
            }
            if fall <= 1e-3 * here.cost() {
                break;
            }
        }
        Some((at, here))
    }
}
