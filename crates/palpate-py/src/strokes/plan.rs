//! `plan_strokes`: strokes that feel as much of an object as they can.

use palpate::pivot::{
    PadPose, PivotPosterior, PivotRig, PivotSimulateError, PivotSimulateOptions, StrokeLimits, plan_next_strokes,
    plan_strokes as plan,
};
use palpate::sensor::Touchpad;
use pyo3::prelude::*;

use crate::interop::errors;
use crate::interop::whole::Whole;
use crate::object::shape::Shape;
use crate::strokes::result::StrokesResult;

/// What strokes are planned for.
#[derive(FromPyObject)]
pub enum Known {
    Shape(Py<Shape>),
    Result(Py<StrokesResult>),
}

/// Plan strokes of a pivoting grasp, each where it feels most of what those before it did not.
///
/// For a known shape, or for what a log of earlier strokes leaves open: then what nearly all shapes feel that agree with the log counts.
///
/// Parameters
/// ----------
/// known : SupportFunction or StrokesResult
///     The object about its pivot, or the result of the strokes so far.
/// center_of_mass_m : (float, float), optional
///     Centre of mass from the pivot, in the frame of the object, metres. Default: of a result what it says, of a shape (0.0, -0.009).
/// along_m : (float, float), default (0.4, 0.6)
///     Part of the pad over which the foot of the pivot may go, metres from the base point of the pad.
/// longest_m : float, default 0.3
///     Longest way of one stroke along the pad, metres.
/// press : float, default 3.0
///     Force with which the arm presses, in weights of the object.
/// most_strokes : int, default 12
///     Most strokes.
/// friction : float, default 0.4
///     Coefficient of friction between object and pad.
/// pad_length_m : float, optional
///     Length of the pad, metres. Default: unlimited.
///
/// Returns
/// -------
/// (list of list of float, list of float)
///     For each stroke the places along the pad through which the pivot goes, as `simulate_strokes` takes them, and the fraction of the boundary that is
///     expected to be felt once that stroke is done, 0 to 1.
///
/// Raises
/// ------
/// InputError
///     If a number is out of range, the shape is no convex object around its pivot, or a result does not say where the centre of mass is.
///
/// Examples
/// --------
/// >>> import palpate
/// >>> egg = palpate.SupportFunction.named("egg", 0.03).translated(0.004, 0.003)
/// >>> strokes, coverage = palpate.plan_strokes(egg, center_of_mass_m=(0.004, 0.003))
/// >>> log, truth = palpate.simulate_strokes(egg, strokes, center_of_mass_m=(0.004, 0.003))
/// >>> abs(palpate.reconstruct_strokes(log, calibrated=True).coverage - coverage[-1]) < 0.03
/// True
#[expect(clippy::too_many_arguments, reason = "each is a keyword of the Python function")]
#[pyfunction]
#[pyo3(
    signature = (known, *, center_of_mass_m=None, along_m=[0.4, 0.6], longest_m=0.3, press=3.0, most_strokes=Whole(12), friction=0.4,
        pad_length_m=None),
    text_signature = "(known, *, center_of_mass_m=None, along_m=(0.4, 0.6), longest_m=0.3, press=3.0, most_strokes=12, friction=0.4, \
        pad_length_m=None)"
)]
pub fn plan_strokes(
    py: Python<'_>,
    known: Known,
    center_of_mass_m: Option<[f64; 2]>,
    along_m: [f64; 2],
    longest_m: f64,
    press: f64,
    most_strokes: Whole,
    friction: f64,
    pad_length_m: Option<f64>,
) -> PyResult<(Vec<Vec<f64>>, Vec<f64>)> {
    let (tilt_rad, told_m) = match &known {
        Known::Shape(_) => (0.0, Some([0.0, -0.009])),
        Known::Result(result) => (result.get().tilt_rad(), result.get().center_of_mass_m()),
    };
    let center_of_mass_m = center_of_mass_m.or(told_m).ok_or_else(|| {
        errors::input(
            "the result does not say where the centre of mass is; give center_of_mass_m, from the pivot".to_owned(),
        )
    })?;
    let options = PivotSimulateOptions {
        rig: PivotRig::exact(PadPose { tilt_rad, ..PadPose::default() }),
        touchpad: Touchpad { length_m: pad_length_m.unwrap_or(f64::INFINITY), ..Touchpad::ideal() },
        center_of_mass_m,
        friction,
        ..PivotSimulateOptions::default()
    };
    let limits = StrokeLimits { along_m, longest_m, press, most_strokes: most_strokes.count() };
    let planned = py.detach(|| match &known {
        Known::Shape(shape) => plan(&PivotPosterior::known(&shape.get().0), &options, &limits),
        Known::Result(result) => {
            let (found, posterior) = result.get().known();
            plan_next_strokes(found, posterior, &options, &limits)
        }
    });
    let planned = planned.map_err(|error: PivotSimulateError| errors::input(error.to_string()))?;
    Ok((planned.strokes.into_iter().map(|stroke| stroke.along_m).collect(), planned.coverage))
}
