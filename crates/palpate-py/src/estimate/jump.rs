//! `Jump`: the object goes from one resting pose to another.

use palpate::mechanics::Jump;
use pyo3::prelude::*;

use crate::interop::pickled::{self, Pickled};

/// The object jumped from one resting pose to another, at practically one instant.
///
/// In a `Result` as in a `Simulation`, and on the way that `follow` goes.
#[pyclass(frozen, eq, module = "palpate", name = "Jump")]
#[derive(Clone, PartialEq)]
pub struct JumpData(pub Jump);

#[pymethods]
impl JumpData {
    /// float: the last instant of the old pose, seconds; of a log that was reconstructed, its first sample after the jump.
    #[getter]
    fn time_s(&self) -> f64 {
        self.0.time_s
    }

    /// float: orientation before, radians.
    #[getter]
    fn psi_before_rad(&self) -> f64 {
        self.0.psi_before_rad
    }

    /// float: orientation after, radians, unwrapped.
    #[getter]
    fn psi_after_rad(&self) -> f64 {
        self.0.psi_after_rad
    }

    /// float: height of the centre of mass in the old pose over the palms as they are after the jump, metres.
    ///
    /// After `Result.load` it is counted from the height after the jump, as a folder holds their difference alone.
    #[getter]
    fn height_before_m(&self) -> f64 {
        self.0.height_before_m
    }

    /// float: height of the centre of mass in the new pose over the same palms, metres; 0 after `Result.load`.
    #[getter]
    fn height_after_m(&self) -> f64 {
        self.0.height_after_m
    }

    /// float: how much lower the centre of mass is afterwards, metres.
    #[getter]
    fn height_drop_m(&self) -> f64 {
        self.0.height_drop_m()
    }

    /// bool: whether the object would make this jump, downhill all the way; a shape that was found may contradict its own jumps.
    #[getter]
    fn physical(&self) -> bool {
        self.0.physical
    }

    /// The potential energy that is lost.
    ///
    /// Parameters
    /// ----------
    /// mass_kg : float
    ///     Mass of the object, kilograms.
    ///
    /// Returns
    /// -------
    /// float
    ///     The energy, joules.
    fn energy_lost_j(&self, mass_kg: f64) -> f64 {
        self.0.energy_lost_j(mass_kg)
    }

    fn __repr__(&self) -> String {
        let Jump { time_s, psi_before_rad, psi_after_rad, .. } = self.0;
        format!(
            "<Jump: at {time_s:.3} s from psi {psi_before_rad:.4} to {psi_after_rad:.4} rad, {:.3} mm down>",
            1e3 * self.height_drop_m()
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        let Jump { time_s, psi_before_rad, psi_after_rad, height_before_m, height_after_m, physical } = self.0;
        let arguments = (time_s, psi_before_rad, psi_after_rad, height_before_m, height_after_m, physical);
        pickled::by_method::<Self>(py, "_made", arguments)
    }

    #[staticmethod]
    fn _made(time_s: f64, before: f64, after: f64, height_before_m: f64, height_after_m: f64, physical: bool) -> Self {
        let (psi_before_rad, psi_after_rad) = (before, after);
        Self(Jump { time_s, psi_before_rad, psi_after_rad, height_before_m, height_after_m, physical })
    }
}
