//! `plan_turn` and `plan_jump_free`: motions planned with the shape known.

use std::collections::HashMap;
use std::sync::Arc;

use palpate::plan::{PalmFriction, PalmLimits, PlanError, PlannedMotion};
use palpate::shape::SupportFunction;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;

use crate::interop::errors::OrRaise;
use crate::interop::pickled::{self, Pickled};
use crate::interop::whole::Whole;
use crate::interop::work;
use crate::measured::simulate::Friction;
use crate::object::shape::Shape;
use crate::palms_motion::motion::{Made, Motion};

/// Where the palms may go.
///
/// Parameters
/// ----------
/// smallest_phi1_rad : float, default 4 degrees
///     Smallest angle of palm 1 against the horizontal, radians, positive.
/// largest_phi12_rad : float, default 176 degrees
///     Largest angle of palm 2 against the horizontal, radians, below pi.
/// smallest_phi2_rad : float, default 25 degrees
///     Smallest opening, radians.
/// largest_phi2_rad : float, default 160 degrees
///     Largest opening, radians.
/// palm_length_m : float, default infinite
///     Length of the palms, metres.
#[pyclass(frozen, eq, module = "palpate", name = "PalmLimits")]
#[derive(Clone, Copy, PartialEq)]
pub struct Limits(pub PalmLimits);

#[pymethods]
impl Limits {
    #[new]
    #[pyo3(signature = (*, smallest_phi1_rad=None, largest_phi12_rad=None, smallest_phi2_rad=None, largest_phi2_rad=None, palm_length_m=None))]
    fn new(
        smallest_phi1_rad: Option<f64>,
        largest_phi12_rad: Option<f64>,
        smallest_phi2_rad: Option<f64>,
        largest_phi2_rad: Option<f64>,
        palm_length_m: Option<f64>,
    ) -> Self {
        let usual = PalmLimits::default();
        Self(PalmLimits {
            smallest_phi1_rad: smallest_phi1_rad.unwrap_or(usual.smallest_phi1_rad),
            largest_phi12_rad: largest_phi12_rad.unwrap_or(usual.largest_phi12_rad),
            smallest_phi2_rad: smallest_phi2_rad.unwrap_or(usual.smallest_phi2_rad),
            largest_phi2_rad: largest_phi2_rad.unwrap_or(usual.largest_phi2_rad),
            palm_length_m: palm_length_m.unwrap_or(usual.palm_length_m),
        })
    }

    /// float: smallest angle of palm 1 against the horizontal, radians.
    #[getter]
    fn smallest_phi1_rad(&self) -> f64 {
        self.0.smallest_phi1_rad
    }

    /// float: largest angle of palm 2 against the horizontal, radians.
    #[getter]
    fn largest_phi12_rad(&self) -> f64 {
        self.0.largest_phi12_rad
    }

    /// float: smallest opening, radians.
    #[getter]
    fn smallest_phi2_rad(&self) -> f64 {
        self.0.smallest_phi2_rad
    }

    /// float: largest opening, radians.
    #[getter]
    fn largest_phi2_rad(&self) -> f64 {
        self.0.largest_phi2_rad
    }

    /// float: length of the palms, metres; may be infinite.
    #[getter]
    fn palm_length_m(&self) -> f64 {
        self.0.palm_length_m
    }

    fn __repr__(&self) -> String {
        format!(
            "PalmLimits(smallest_phi1_rad={}, largest_phi12_rad={}, smallest_phi2_rad={}, largest_phi2_rad={}, palm_length_m={})",
            self.0.smallest_phi1_rad,
            self.0.largest_phi12_rad,
            self.0.smallest_phi2_rad,
            self.0.largest_phi2_rad,
            self.0.palm_length_m
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        let PalmLimits { smallest_phi1_rad, largest_phi12_rad, smallest_phi2_rad, largest_phi2_rad, palm_length_m } =
            self.0;
        let arguments = (smallest_phi1_rad, largest_phi12_rad, smallest_phi2_rad, largest_phi2_rad, palm_length_m);
        pickled::by_method::<Self>(py, "_made", arguments)
    }

    #[staticmethod]
    fn _made(phi1: f64, phi12: f64, smallest_phi2: f64, largest_phi2: f64, length: f64) -> Self {
        Self::new(Some(phi1), Some(phi12), Some(smallest_phi2), Some(largest_phi2), Some(length))
    }
}

/// What a motion is planned from.
#[derive(Clone)]
pub struct Plan {
    pub shape: SupportFunction,
    pub limits: Option<PalmLimits>,
    /// A motion that depends on this seed, instead of the turn.
    pub seed: Option<u64>,
    /// Coefficients of friction of both palms and their standard deviations.
    pub friction: Option<[f64; 4]>,
    pub duration_s: f64,
}

impl Plan {
    /// Plans.
    pub fn carried_out(&self) -> Result<PlannedMotion, PlanError> {
        let limits = self.limits.unwrap_or_default();
        if let Some([mu1, mu2, mu1_sd, mu2_sd]) = self.friction {
            let friction = PalmFriction { coefficients: [mu1, mu2], coefficient_sds: [mu1_sd, mu2_sd] };
            return palpate::plan::plan_turn_with_friction(&self.shape, &limits, self.duration_s, &friction);
        }
        match self.seed {
            Some(seed) => palpate::plan::plan_jump_free(&self.shape, seed, self.duration_s),
            None => palpate::plan::plan_turn(&self.shape, &limits, self.duration_s),
        }
    }
}

impl Made for Plan {
    fn call<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        let arguments = (Shape(self.shape.clone()), self.limits.map(Limits), self.seed, self.duration_s, self.friction);
        pickled::by_method::<Planned>(py, "_motion", arguments)
    }
}

/// A motion without jumps, for the object it was planned for.
#[pyclass(frozen, module = "palpate", name = "PlannedMotion")]
pub struct Planned {
    /// PalmMotion: the motion.
    #[pyo3(get)]
    pub motion: Py<Motion>,
    /// float: let the object go at this orientation before the motion starts, radians.
    #[pyo3(get)]
    pub start_psi_rad: f64,
    /// float: fraction of the boundary that is felt, 0 to 1.
    #[pyo3(get)]
    coverage: f64,
    /// bool: whether the object turns all the way around.
    #[pyo3(get)]
    full_turn: bool,
}

#[pymethods]
impl Planned {
    fn __eq__(&self, other: &Self) -> bool {
        self.motion.get() == other.motion.get()
            && self.start_psi_rad == other.start_psi_rad
            && self.coverage == other.coverage
            && self.full_turn == other.full_turn
    }

    fn __repr__(&self) -> String {
        let turn = if self.full_turn { "a full turn" } else { "there and back" };
        format!("<PlannedMotion: {turn}, {:.0} % of the boundary felt>", 100.0 * self.coverage)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        let arguments = (self.motion.clone_ref(py), self.start_psi_rad, self.coverage, self.full_turn);
        pickled::by_method::<Self>(py, "_made", arguments)
    }

    #[staticmethod]
    fn _made(motion: Py<Motion>, start_psi_rad: f64, coverage: f64, full_turn: bool) -> Self {
        Self { motion, start_psi_rad, coverage, full_turn }
    }

    #[staticmethod]
    #[pyo3(signature = (shape, limits, seed, duration_s, friction=None))]
    fn _motion(
        shape: &Shape,
        limits: Option<PyRef<Limits>>,
        seed: Option<u64>,
        duration_s: f64,
        friction: Option<[f64; 4]>,
    ) -> PyResult<Motion> {
        let plan = Plan { shape: shape.0.clone(), limits: limits.map(|limits| limits.0), seed, friction, duration_s };
        let planned = plan.carried_out().or_raise()?;
        Ok(Motion::planned(planned.motion, Arc::new(plan)))
    }
}

fn planned(py: Python<'_>, plan: Plan) -> PyResult<Planned> {
    let task = plan.clone();
    let found = work::run(py, None, None, move |_| task.carried_out())?.or_raise()?;
    Ok(Planned {
        motion: Py::new(py, Motion::planned(found.motion, Arc::new(plan)))?,
        start_psi_rad: found.start_psi_rad,
        coverage: found.coverage,
        full_turn: found.full_turn,
    })
}

/// Plan a motion that turns a known object all the way around without a jump.
///
/// Where that cannot be, a motion there and back that feels as much as it can.
///
/// Parameters
/// ----------
/// shape : SupportFunction
///     The object.
/// duration_s : float
///     How long the motion takes, seconds.
/// limits : PalmLimits, optional
///     Where the palms may go.
/// friction : float, pair of float or dict, optional
///     Coefficient of friction of both palms or of each, or `Result.friction`, whose standard deviations the motion then bears twice over. The object
///     is carried round: it sticks to one palm while the other slides past it. Takes some seconds. Without, palms are slick.
///
/// Returns
/// -------
/// PlannedMotion
///     The motion, and the orientation to let the object go at.
///
/// Raises
/// ------
/// MotionError
///     If there is no motion without a jump within the limits, or a number is out of range.
#[pyfunction]
#[pyo3(signature = (shape, duration_s, *, limits=None, friction=None))]
pub fn plan_turn(
    py: Python<'_>,
    shape: &Shape,
    duration_s: f64,
    limits: Option<PyRef<Limits>>,
    friction: Option<KnownFriction>,
) -> PyResult<Planned> {
    let limits = limits.map(|limits| limits.0);
    let friction = friction.map(KnownFriction::numbers).transpose()?;
    planned(py, Plan { shape: shape.0.clone(), limits, seed: None, friction, duration_s })
}

/// Friction on the palms, in any of the ways it is given.
#[derive(FromPyObject)]
pub enum KnownFriction {
    #[pyo3(transparent)]
    Stated(Friction),
    #[pyo3(transparent, annotation = "dict")]
    Found(HashMap<String, f64>),
}

impl KnownFriction {
    fn numbers(self) -> PyResult<[f64; 4]> {
        match self {
            Self::Stated(friction) => {
                let [mu1, mu2] = friction.of_palms();
                Ok([mu1, mu2, 0.0, 0.0])
            }
            Self::Found(by_name) => {
                let of = |name: &str, usual: Option<f64>| {
                    let value = by_name.get(name).copied().or(usual);
                    value.ok_or_else(|| {
                        PyKeyError::new_err(format!(
                            "friction lacks {name:?}: give mu1 and mu2, as Result.friction has them"
                        ))
                    })
                };
                Ok([of("mu1", None)?, of("mu2", None)?, of("mu1_sd", Some(0.0))?, of("mu2_sd", Some(0.0))?])
            }
        }
    }
}

/// Plan a motion without jumps that depends on a seed, for studies over many motions.
///
/// Parameters
/// ----------
/// shape : SupportFunction
///     The object.
/// seed : int
///     From 0 on.
/// duration_s : float
///     How long the motion takes, seconds.
///
/// Returns
/// -------
/// PlannedMotion
///     The motion, and the orientation to let the object go at.
///
/// Raises
/// ------
/// MotionError
///     If no motion without a jump is found, or a number is out of range.
#[pyfunction]
pub fn plan_jump_free(py: Python<'_>, shape: &Shape, seed: Whole, duration_s: f64) -> PyResult<Planned> {
    planned(py, Plan { shape: shape.0.clone(), limits: None, seed: Some(seed.0), friction: None, duration_s })
}
