//! `simulate_strokes`: an arm that drags an object over a pad.

use palpate::pivot::{PivotSimulateError, PivotSimulateOptions, Stroke, simulate_strokes as simulate};
use palpate::sensor::Touchpad;
use pyo3::prelude::*;

use crate::interop::errors;
use crate::measured::truth::TrueData;
use crate::object::shape::Shape;
use crate::strokes::log::StrokesData;

/// Simulate the strokes of a pivoting grasp over a level pad.
///
/// Before each stroke the object hangs at rest; then it is set down, pressed, and dragged.
///
/// Parameters
/// ----------
/// shape : SupportFunction
///     The object about its pivot. Its centre of mass is at `center_of_mass_m`.
/// strokes : sequence of sequence of float
///     For each stroke the places along the pad through which the pivot goes, metres from the base point of the pad; at least two.
/// center_of_mass_m : (float, float), default (0.0, -0.009)
///     Centre of mass from the pivot, in the frame of the object, metres.
/// press : float, default 3.0
///     Force with which the arm presses, in weights of the object.
/// friction : float, default 0.4
///     Coefficient of friction between object and pad.
/// noise_sd_m : float, default 0.0
///     Standard deviation of a contact position, metres.
/// arm_noise_sd_m : float, default 0.0
///     Standard deviation of each coordinate of the pivot, metres.
/// rate_hz : float, default 30.0
///     Samples per second, Hz.
/// seed : int, default 0
///     Seed of the noise.
///
/// Returns
/// -------
/// (Strokes, Truth)
///     The log and what is true.
///
/// Raises
/// ------
/// InputError
///     If a number is out of range, or the object is lost on the way.
///
/// Examples
/// --------
/// >>> import palpate
/// >>> egg = palpate.SupportFunction.named("egg", 0.03).translated(0.004, 0.003)
/// >>> log, truth = palpate.simulate_strokes(egg, [[0.5, 0.65], [0.5, 0.35], [0.5, 0.7], [0.5, 0.3]], center_of_mass_m=(0.004, 0.003))
/// >>> found = palpate.reconstruct_strokes(log, calibrated=True)
/// >>> found.certified
/// True
/// >>> abs(found.shape.mean_radius_m - 0.03) < 1e-6
/// True
#[expect(clippy::too_many_arguments, reason = "each is a keyword of the Python function")]
#[pyfunction]
#[pyo3(
    signature = (shape, strokes, *, center_of_mass_m=[0.0, -0.009], press=3.0, friction=0.4, noise_sd_m=0.0, arm_noise_sd_m=0.0,
        rate_hz=30.0, seed=0),
    text_signature = "(shape, strokes, *, center_of_mass_m=(0.0, -0.009), press=3.0, friction=0.4, noise_sd_m=0.0, arm_noise_sd_m=0.0, \
        rate_hz=30.0, seed=0)"
)]
pub fn simulate_strokes(
    py: Python<'_>,
    shape: &Shape,
    strokes: Vec<Vec<f64>>,
    center_of_mass_m: [f64; 2],
    press: f64,
    friction: f64,
    noise_sd_m: f64,
    arm_noise_sd_m: f64,
    rate_hz: f64,
    seed: u64,
) -> PyResult<(StrokesData, TrueData)> {
    let strokes: Vec<Stroke> = strokes.into_iter().map(|along_m| Stroke { along_m, press }).collect();
    let options = PivotSimulateOptions {
        touchpad: Touchpad { noise_sd_m, ..Touchpad::ideal() },
        center_of_mass_m,
        friction,
        arm_noise_sd_m,
        rate_hz,
        seed,
        ..PivotSimulateOptions::default()
    };
    let simulated = py.detach(|| simulate(&shape.0, &strokes, &options));
    let simulation = simulated.map_err(|error: PivotSimulateError| errors::input(error.to_string()))?;
    Ok((StrokesData::of(py, simulation.log, None), TrueData::of(py, simulation.truth)))
}
