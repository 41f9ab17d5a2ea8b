//! `PalmMotion`: how the palms turn over time.

use std::sync::Arc;

use numpy::PyArray2;
use palpate::palms::{PalmMotion, PalmMove, PalmPair};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::interop::arrays::{self, Table};
use crate::interop::errors::{self, OrRaise};
use crate::interop::pickled::{self, Pickled};
use crate::interop::whole::Whole;
use crate::object::shape::finite;
use crate::palms_motion::moves::Move;
use crate::palms_motion::palms::Palms;

/// How the palms turn over time, smoothly. Made by its static methods, or by `plan_turn` and `plan_jump_free`.
#[pyclass(frozen, eq, module = "palpate", name = "PalmMotion")]
#[derive(Clone)]
pub struct Motion {
    pub motion: PalmMotion,
    /// How it was made, so that it can be made again elsewhere.
    recipe: Recipe,
}

impl PartialEq for Motion {
    fn eq(&self, other: &Self) -> bool {
        self.motion == other.motion
    }
}

/// How a motion was made.
#[derive(Clone)]
enum Recipe {
    Schedule(PalmPair, Vec<PalmMove>),
    SqueezeAndRotate(f64, u32),
    Random(u64, f64, f64),
    Through(Vec<[f64; 3]>),
    Planned(Arc<dyn Made>),
}

/// What a motion was made from, where that is no business of this file.
pub trait Made: Send + Sync {
    /// The call that makes the motion again.
    fn call<'py>(&self, py: Python<'py>) -> Pickled<'py>;
}

impl Motion {
    /// The motion of a plan.
    pub fn planned(motion: PalmMotion, plan: Arc<dyn Made>) -> Self {
        Self { motion, recipe: Recipe::Planned(plan) }
    }
}

#[pymethods]
impl Motion {
    /// A schedule of moves.
    ///
    /// Parameters
    /// ----------
    /// start : PalmPair
    ///     Where the palms start; their base points stay.
    /// moves : list of PalmMove
    ///     The moves in order.
    ///
    /// Returns
    /// -------
    /// PalmMotion
    ///     The motion; each move starts and ends smoothly.
    ///
    /// Raises
    /// ------
    /// MotionError
    ///     If the palms become parallel or cross on the way, or a number is out of range.
    #[staticmethod]
    fn schedule(start: &Palms, moves: Vec<PyRef<Move>>) -> PyResult<Self> {
        let moves: Vec<PalmMove> = moves.iter().map(|each| each.0.clone()).collect();
        let motion = PalmMotion::schedule(start.0, &moves).or_raise()?;
        Ok(Self { motion, recipe: Recipe::Schedule(start.0, moves) })
    }

    /// Squeezes with rotations and openings of one palm, as in figure 6 of Moll and Erdmann (2001).
    ///
    /// It knows nothing of the object; most objects jump now and then.
    ///
    /// Parameters
    /// ----------
    /// duration_s : float
    ///     How long it takes, seconds.
    /// times : int, default 2
    ///     How many times there and back.
    ///
    /// Returns
    /// -------
    /// PalmMotion
    ///     The motion.
    ///
    /// Raises
    /// ------
    /// MotionError
    ///     If the duration is not positive and finite.
    #[staticmethod]
    #[pyo3(signature = (duration_s, times=Whole(2)), text_signature = "(duration_s, times=2)")]
    fn squeeze_and_rotate(duration_s: f64, times: Whole) -> PyResult<Self> {
        let times = times.small();
        let motion = PalmMotion::squeeze_and_rotate(duration_s, times).or_raise()?;
        Ok(Self { motion, recipe: Recipe::SqueezeAndRotate(duration_s, times) })
    }

    /// A random smooth motion of hinged palms, which knows nothing of the object.
    ///
    /// Parameters
    /// ----------
    /// seed : int
    ///     From 0 on; the same seed gives the same motion.
    /// duration_s : float
    ///     How long it takes, seconds.
    /// amplitude : float, default 1
    ///     How far the palms go, 0 to 1.
    ///
    /// Returns
    /// -------
    /// PalmMotion
    ///     The motion.
    ///
    /// Raises
    /// ------
    /// MotionError
    ///     If a number is out of range.
    #[staticmethod]
    #[pyo3(signature = (seed, duration_s, amplitude=1.0))]
    fn random(seed: Whole, duration_s: f64, amplitude: f64) -> PyResult<Self> {
        let motion = PalmMotion::random(seed.0, duration_s, amplitude).or_raise()?;
        Ok(Self { motion, recipe: Recipe::Random(seed.0, duration_s, amplitude) })
    }

    /// A smooth curve through given palm angles.
    ///
    /// Parameters
    /// ----------
    /// points : array_like of float, shape (n, 3)
    ///     Time in seconds (increasing), phi1 and phi2 in radians.
    ///
    /// Returns
    /// -------
    /// PalmMotion
    ///     The motion; it starts at time 0.
    ///
    /// Raises
    /// ------
    /// MotionError
    ///     With fewer than two points, times that do not increase, or palms that become parallel.
    #[staticmethod]
    fn through(points: Table) -> PyResult<Self> {
        let points: Vec<[f64; 3]> = arrays::rows("points", &points)?;
        let triples: Vec<(f64, f64, f64)> = points.iter().map(|&point| point.into()).collect();
        let motion = PalmMotion::through(&triples).or_raise()?;
        Ok(Self { motion, recipe: Recipe::Through(points) })
    }

    /// The same motion with the base points of the palms elsewhere.
    ///
    /// Parameters
    /// ----------
    /// base1_m, base2_m : tuple of float
    ///     Base points in the global frame (Y up), metres.
    ///
    /// Returns
    /// -------
    /// PalmMotion
    ///     The motion.
    fn with_bases(&self, base1_m: (f64, f64), base2_m: (f64, f64)) -> PyResult<Self> {
        finite("base points", &[base1_m.0, base1_m.1, base2_m.0, base2_m.1])?;
        let motion = self.motion.clone().with_bases(base1_m.into(), base2_m.into());
        Ok(Self { motion, recipe: self.recipe.clone() })
    }

    /// float: how long the motion takes, seconds.
    #[getter]
    fn duration_s(&self) -> f64 {
        self.motion.duration_s()
    }

    /// The palms at one instant.
    ///
    /// Parameters
    /// ----------
    /// time_s : float
    ///     When, seconds; before the start and after the end the palms stay put.
    ///
    /// Returns
    /// -------
    /// PalmPair
    ///     The palms.
    fn at(&self, time_s: f64) -> PyResult<Palms> {
        if time_s.is_nan() {
            return Err(errors::input("time_s must be a number".to_owned()));
        }
        Ok(Palms(self.motion.at(time_s)))
    }

    /// The palms at even steps from start to end.
    ///
    /// Parameters
    /// ----------
    /// rate_hz : float
    ///     Samples per second.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray
    ///     Columns time (seconds), phi1, phi2 (radians), and x, y of base 1 and of base 2 (metres), shape (n, 7).
    ///
    /// Raises
    /// ------
    /// MotionError
    ///     If the rate is not positive, or there would be more than 5 million samples.
    fn sample(&self, py: Python<'_>, rate_hz: f64) -> PyResult<Py<PyArray2<f64>>> {
        let rows: Vec<[f64; 7]> = self.motion.sample(rate_hz).or_raise()?.iter().map(row).collect();
        Ok(arrays::table(py, &rows))
    }

    fn __repr__(&self) -> String {
        let kind = match &self.recipe {
            Recipe::Schedule(_, moves) => format!("schedule of {} moves", moves.len()),
            Recipe::SqueezeAndRotate(_, times) => format!("squeeze and rotate, {times} times"),
            Recipe::Random(seed, ..) => format!("random, seed {seed}"),
            Recipe::Through(points) => format!("through {} points", points.len()),
            Recipe::Planned(_) => "planned".to_owned(),
        };
        format!("<PalmMotion: {kind}, {:.4} s>", self.motion.duration_s())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        let (make, arguments) = match &self.recipe {
            Recipe::Schedule(start, moves) => {
                let moves: Vec<Move> = moves.iter().cloned().map(Move).collect();
                pickled::by_method::<Self>(py, "schedule", (Palms(*start), moves))?
            }
            Recipe::SqueezeAndRotate(duration_s, times) => {
                pickled::by_method::<Self>(py, "squeeze_and_rotate", (*duration_s, *times))?
            }
            Recipe::Random(seed, duration_s, amplitude) => {
                pickled::by_method::<Self>(py, "random", (*seed, *duration_s, *amplitude))?
            }
            Recipe::Through(points) => pickled::by_method::<Self>(py, "through", (arrays::table(py, points),))?,
            Recipe::Planned(plan) => plan.call(py)?,
        };
        let bases = self.motion.at(0.0);
        pickled::by_method::<Self>(py, "_made", (make, arguments, bases.base1_m, bases.base2_m))
    }

    #[staticmethod]
    fn _made(
        make: Bound<'_, PyAny>,
        arguments: Bound<'_, PyTuple>,
        base1: [f64; 2],
        base2: [f64; 2],
    ) -> PyResult<Self> {
        let made = make.call1(arguments)?;
        let made = made.cast::<Self>()?.get();
        Ok(Self { motion: made.motion.clone().with_bases(base1, base2), recipe: made.recipe.clone() })
    }
}

/// A sample of a motion as a row of numbers.
pub fn row((time_s, palms): &(f64, PalmPair)) -> [f64; 7] {
    let ([x1, y1], [x2, y2]) = (palms.base1_m, palms.base2_m);
    [*time_s, palms.phi1_rad, palms.phi2_rad, x1, y1, x2, y2]
}

/// A sample of a motion from a row of numbers.
pub fn sample(&[time_s, phi1_rad, phi2_rad, x1, y1, x2, y2]: &[f64; 7]) -> (f64, PalmPair) {
    (time_s, PalmPair { phi1_rad, phi2_rad, base1_m: [x1, y1], base2_m: [x2, y2] })
}
