//! `simulate`: a known shape between two moving palms.

use palpate::palms::PalmPair;
use palpate::simulate::{ObjectInertia, SimulateError, SimulateOptions};
use palpate_io::LogFile;
use pyo3::prelude::*;

use crate::estimate::jump::JumpData;
use crate::interop::arrays::{self, Table};
use crate::interop::errors::{self, OrRaise};
use crate::interop::pickled::{self, Pickled};
use crate::interop::whole::Whole;
use crate::interop::work;
use crate::measured::log::LogData;
use crate::measured::sensor::Pad;
use crate::measured::truth::TrueData;
use crate::object::shape::Shape;
use crate::palms_motion::motion::{self, Motion};
use crate::palms_motion::palms::require_few_turns;
use crate::palms_motion::plan::Planned;

/// What the robot would know, what is true, and where the object jumped.
///
/// Unpacks as `log, truth = simulate(...)`.
#[pyclass(frozen, module = "palpate", name = "Simulation")]
pub struct Simulated {
    /// Log: the palm log.
    #[pyo3(get)]
    log: Py<LogData>,
    /// Truth: true shape and motion, a pose for each sample of the log.
    #[pyo3(get)]
    truth: Py<TrueData>,
    /// list of Jump: the jumps in order of time.
    #[pyo3(get)]
    jumps: Vec<JumpData>,
    /// float: fraction of the boundary that either palm went over, 0 to 1.
    #[pyo3(get)]
    coverage: f64,
}

#[pymethods]
impl Simulated {
    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, pyo3::types::PyIterator>> {
        (&self.log, &self.truth).into_pyobject(py)?.try_iter()
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.log.get().file.log == other.log.get().file.log
            && self.truth.get().truth == other.truth.get().truth
            && self.jumps == other.jumps
    }

    fn __repr__(&self) -> String {
        let samples = self.log.get().file.log.samples.len();
        format!("<Simulation: {samples} samples, {} jumps, {:.0} % felt>", self.jumps.len(), 100.0 * self.coverage)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        let arguments = (&self.log, &self.truth, self.jumps.clone(), self.coverage);
        pickled::by_method::<Self>(py, "_made", arguments)
    }

    #[staticmethod]
    fn _made(log: Py<LogData>, truth: Py<TrueData>, jumps: Vec<PyRef<JumpData>>, coverage: f64) -> Self {
        Self { log, truth, jumps: jumps.iter().map(|jump| (*jump).clone()).collect(), coverage }
    }
}

/// How the palms move, as it comes from Python.
#[derive(FromPyObject)]
pub enum Moved<'py> {
    Planned(Py<Planned>),
    Motion(Py<Motion>),
    Sampled(Table<'py>),
}

/// Coefficients of friction, as they come from Python.
#[derive(FromPyObject)]
pub enum Friction {
    Both(f64),
    Each(f64, f64),
}

impl Friction {
    pub fn of_palms(&self) -> [f64; 2] {
        match *self {
            Self::Both(friction) => [friction; 2],
            Self::Each(first, second) => [first, second],
        }
    }
}

/// Simulate the palm log of a known object.
///
/// At every instant the object rests in a minimum of its potential energy; where a pose vanishes, it goes downhill to the next. With friction
/// it rolls on a palm or slides on both, and jumps where no forces within the friction cones hold it. With a speed the palms run through the motion
/// that many times faster, and the object moves by its inertia.
///
/// Parameters
/// ----------
/// shape : SupportFunction
///     The object, convex.
/// motion : PalmMotion or PlannedMotion or array_like of float, shape (n, 3) or (n, 7)
///     How the palms move. An array has the columns time (seconds), phi1 and phi2 (radians), and maybe x and y of base 1 and of
///     base 2 (metres).
/// touchpad : Touchpad, optional
///     The pads. Default: without any fault.
/// rate_hz : float, optional
///     Samples per second; for a motion that is sampled already of no effect. Default: the rate of the touchpad.
/// seed : int, default 0
///     Seed of noise and drop-outs.
/// start_psi_rad : float, optional
///     The object is let go at this orientation before the palms move, radians. Default: as planned, or 0.
/// friction : float or tuple of float, default 0.0
///     Coefficient of friction between palms and object, or those of palm 1 and palm 2.
/// speed : float, optional
///     The palms run through the motion so many times faster, and the inertia of the object counts; the rate and all times are those of the fast
///     palms. Not together with friction. Default: palms so slow that the object is at rest at all times.
/// gyration_radius_m : float, optional
///     Radius of gyration of the object about its centre of mass, metres; of consequence with a speed. Default: that of an even mass.
/// damping_per_s : float, default 0.0
///     Drag on the rotation over the moment of inertia, 1/s; of consequence with a speed.
/// mass_kg : float, default 0.1
///     Mass, kilograms; of consequence for forces and energies only.
/// with_forces : bool, default False
///     Whether the log has the normal forces.
/// with_stated_noise : bool, default False
///     Whether the log states the standard deviation of its readings.
///
/// Returns
/// -------
/// Simulation
///     Log, truth and jumps.
///
/// Raises
/// ------
/// SimulateError
///     If the shape is not convex, the motion is faulty, or the object leaves the palms; the message says when.
/// MotionError
///     If the motion cannot be sampled at that rate.
///
/// Examples
/// --------
/// >>> import palpate
/// >>> egg = palpate.SupportFunction.named("egg")
/// >>> log, truth = palpate.simulate(egg, palpate.plan_turn(egg, 40.0), rate_hz=10)
/// >>> len(log)
/// 401
#[pyfunction]
#[pyo3(signature = (shape, motion, *, touchpad=None, rate_hz=None, seed=Whole(0), start_psi_rad=None,
    friction=Friction::Both(0.0), speed=None, gyration_radius_m=None, damping_per_s=0.0, mass_kg=0.1, with_forces=false, with_stated_noise=false),
    text_signature = "(shape, motion, *, touchpad=None, rate_hz=None, seed=0, start_psi_rad=None, friction=0.0, \
    speed=None, gyration_radius_m=None, damping_per_s=0.0, mass_kg=0.1, with_forces=False, with_stated_noise=False)")]
#[expect(clippy::too_many_arguments, reason = "Python calls it by keywords")]
pub fn simulate(
    py: Python<'_>,
    shape: &Shape,
    motion: Moved,
    touchpad: Option<PyRef<Pad>>,
    rate_hz: Option<f64>,
    seed: Whole,
    start_psi_rad: Option<f64>,
    friction: Friction,
    speed: Option<f64>,
    gyration_radius_m: Option<f64>,
    damping_per_s: f64,
    mass_kg: f64,
    with_forces: bool,
    with_stated_noise: bool,
) -> PyResult<Simulated> {
    let defaults = SimulateOptions::default();
    let touchpad = touchpad.map_or(defaults.touchpad, |pad| pad.0);
    let rate_hz = rate_hz.unwrap_or(touchpad.rate_hz);
    let faster = speed.unwrap_or(1.0);
    if !(faster > 0.0 && faster.is_finite()) {
        return Err(SimulateError::OutOfRange { what: "speed, must be positive and finite" }).or_raise();
    }
    let sampled = |motion: &Py<Motion>| motion.get().motion.sample(rate_hz / faster).or_raise();
    let (mut palms, planned_psi_rad) = match &motion {
        Moved::Planned(planned) => (sampled(&planned.get().motion)?, planned.get().start_psi_rad),
        Moved::Motion(motion) => (sampled(motion)?, 0.0),
        Moved::Sampled(table) => (from_table(table)?, 0.0),
    };
    palms.iter().try_for_each(|(_, palms)| require_few_turns(palms))?;
    palms.iter_mut().for_each(|(time_s, _)| *time_s /= faster);
    let options = SimulateOptions {
        touchpad,
        seed: seed.0,
        start_psi_rad: start_psi_rad.unwrap_or(planned_psi_rad),
        friction: friction.of_palms(),
        inertia: speed.map(|_| ObjectInertia { gyration_radius_m, damping_per_s }),
        mass_kg,
        with_forces,
        with_stated_noise,
    };
    let shape = shape.0.clone();
    let (simulation, coverage) = work::run(py, None, None, move |_| {
        palpate::simulate::simulate(&shape, &palms, &options).map(|simulation| {
            let coverage = palpate::simulate::coverage(&simulation, &palms);
            (simulation, coverage)
        })
    })?
    .or_raise()?;
    let file = LogFile { log: simulation.log, ..LogFile::default() };
    Ok(Simulated {
        log: Py::new(py, LogData::of(py, file, None))?,
        truth: Py::new(py, TrueData::of(py, simulation.truth))?,
        jumps: simulation.jumps.into_iter().map(JumpData).collect(),
        coverage,
    })
}

/// The samples of a motion from a table of 3 or 7 columns.
fn from_table(table: &Table) -> PyResult<Vec<(f64, PalmPair)>> {
    match table.as_array().ncols() {
        3 => {
            let rows: Vec<[f64; 3]> = arrays::rows("motion", table)?;
            Ok(rows.into_iter().map(|[time_s, phi1, phi2]| (time_s, PalmPair::hinged(phi1, phi2))).collect())
        }
        7 => Ok(arrays::rows("motion", table)?.iter().map(motion::sample).collect()),
        columns => Err(errors::input(format!("motion must have 3 or 7 columns, not {columns}"))),
    }
}
