//! What is known of shape and motion before a log is reconstructed.

use super::refine::job::Job;
use super::search::schedule::Found;
use super::search::segments::segments;
use crate::estimate::association::candidates::best_orientation;
use crate::estimate::association::decode::decode;
use crate::estimate::evidence::order::ORDERS;
use crate::estimate::measurements::Measurements;
use crate::estimate::model::evidence::Evidence;
use crate::estimate::model::layout::coefficients_to_order;
use crate::estimate::model::noise::Noise;
use crate::estimate::solver::gauss_newton::{Estimate, Fit};
use crate::shape::SupportFunction;

/// Fewest harmonics that the estimator begins with from a given start.
const FEWEST: usize = 8;

/// What is known of shape and motion beforehand.
///
/// Nothing is searched for from a start, so that the answer is as good as the start: there is no other arrangement to compare it with, and
/// `alternatives` of the result is 1 whatever the log. Of the harmonics of a given shape those are kept that the noise of the log leaves
/// visible (8 to 48 of them); how many the result has is then chosen as always. Methods that integrate take their initial conditions from
/// the start, one for each piece between jumps, and nothing else.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Start {
    /// Nothing: a start is searched for.
    #[default]
    Nothing,
    /// The object is known, more or less; its motion is not. Every sample is placed by the orientation that explains its contacts best,
    /// on the most likely way of that shape through the log; in the size given, or else in others up to six per cent away from it.
    Shape(SupportFunction),
    /// Shape and motion are known, more or less: of a log that was solved before, or from a simulation, to see what the estimator could
    /// reach.
    Motion {
        /// The shape, about its centre of mass.
        shape: SupportFunction,
        /// Orientation at each sample of the log, radians, as many as it has samples.
        psi_rad: Vec<f64>,
    },
}

/// The coefficients that the estimator begins with: those that matter beside contact positions of the standard deviation `sensor_sd_m`.
fn starting_coefficients(shape: &SupportFunction, sensor_sd_m: f64) -> Vec<f64> {
    let order = shape.visible_order(sensor_sd_m).clamp(FEWEST, ORDERS[ORDERS.len() - 1]);
    let mut coefficients = shape.coefficients();
    coefficients_to_order(&mut coefficients, order);
    coefficients
}

/// A known shape and its orientations at the instants `at` as an arrangement of the readings of a job.
pub(crate) fn arrangement_of(job: &Job, at: Measurements, shape: &SupportFunction, psi: Vec<f64>) -> Found {
    let coefficients = starting_coefficients(shape, job.scatter_m);
    Found {
        calibration: job.calibration,
        tolerance_m: job.readings().tolerances_m[0],
        thin: at,
        ranges: segments(&job.measurements, job.scatter_m),
        estimates: vec![Estimate { coefficients, psi, cost: f64::INFINITY }],
    }
}

/// The most likely way of a known shape through a log, one orientation per sample.
pub(crate) fn way_of(shape: &SupportFunction, job: &Job) -> Vec<f64> {
    let coefficients = starting_coefficients(shape, job.scatter_m);
    let sensor_m = job.scatter_m.max(1e-5 * coefficients[0].abs());
    let mut nearest = 0.0;
    let mut psi = Vec::with_capacity(job.measurements.len());
    for instant in &job.measurements.instants {
        nearest = best_orientation(instant, &coefficients, nearest, sensor_m * sensor_m);
        psi.push(nearest);
    }
    let fit = Fit {
        order: coefficients.len() / 2,
        estimate: Estimate { coefficients, psi, cost: 0.0 },
        noise: Noise { sensor_m, balance_m: sensor_m },
        prior: job.prior,
        evidence: Evidence::NONE,
    };
    decode(&job.measurements, &fit, job.floor_m(), None).psi
}
