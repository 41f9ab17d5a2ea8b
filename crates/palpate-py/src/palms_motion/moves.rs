//! `PalmMove`: the pieces that a schedule of palm motions is made of.

use palpate::palms::{MotionError, Palm, PalmMove};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::interop::errors::{self, OrRaise};
use crate::interop::pickled::{self, Pickled};
use crate::interop::whole::Whole;

/// How deep moves there and back may be nested.
const DEEPEST: usize = 32;

/// One piece of a palm motion, for `PalmMotion.schedule`. Made by its static methods.
#[pyclass(frozen, eq, module = "palpate", name = "PalmMove")]
#[derive(Clone, PartialEq)]
pub struct Move(pub PalmMove);

#[pymethods]
impl Move {
    /// Both palms turn; the opening stays.
    ///
    /// Parameters
    /// ----------
    /// angle_rad : float
    ///     By how much, counter-clockwise, radians.
    /// duration_s : float
    ///     How long it takes, seconds.
    ///
    /// Returns
    /// -------
    /// PalmMove
    ///     The move.
    #[staticmethod]
    fn rotate(angle_rad: f64, duration_s: f64) -> Self {
        Self(PalmMove::Rotate { angle_rad, duration_s })
    }

    /// The opening grows (shrinks when negative: a squeeze); the bisector stays.
    ///
    /// Parameters
    /// ----------
    /// angle_rad : float
    ///     By how much the opening grows, radians.
    /// duration_s : float
    ///     How long it takes, seconds.
    ///
    /// Returns
    /// -------
    /// PalmMove
    ///     The move.
    #[staticmethod]
    fn open(angle_rad: f64, duration_s: f64) -> Self {
        Self(PalmMove::Open { angle_rad, duration_s })
    }

    /// One palm opens (closes when negative); the other stays put.
    ///
    /// Parameters
    /// ----------
    /// palm : {1, 2}
    ///     The palm that moves.
    /// angle_rad : float
    ///     By how much, radians.
    /// duration_s : float
    ///     How long it takes, seconds.
    ///
    /// Returns
    /// -------
    /// PalmMove
    ///     The move.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If palm is neither 1 nor 2.
    #[staticmethod]
    fn open_one(palm: Whole, angle_rad: f64, duration_s: f64) -> PyResult<Self> {
        let palm = match palm.0 {
            1 => Palm::One,
            2 => Palm::Two,
            other => return Err(errors::input(format!("palm must be 1 or 2, not {other}"))),
        };
        Ok(Self(PalmMove::OpenOne { palm, angle_rad, duration_s }))
    }

    /// Both palms turn and open at the same time.
    ///
    /// Parameters
    /// ----------
    /// open_rad : float
    ///     By how much the opening grows, radians.
    /// rotate_rad : float
    ///     By how much the bisector turns, radians.
    /// duration_s : float
    ///     How long it takes, seconds.
    ///
    /// Returns
    /// -------
    /// PalmMove
    ///     The move.
    #[staticmethod]
    fn open_and_rotate(open_rad: f64, rotate_rad: f64, duration_s: f64) -> Self {
        Self(PalmMove::OpenAndRotate { open_rad, rotate_rad, duration_s })
    }

    /// Both palms stay put.
    ///
    /// Parameters
    /// ----------
    /// duration_s : float
    ///     How long, seconds.
    ///
    /// Returns
    /// -------
    /// PalmMove
    ///     The move.
    #[staticmethod]
    fn wait(duration_s: f64) -> Self {
        Self(PalmMove::Wait { duration_s })
    }

    /// Moves in order, then each undone in reverse order.
    ///
    /// Parameters
    /// ----------
    /// times : int
    ///     How many times there and back.
    /// moves : list of PalmMove
    ///     The moves of the way there.
    ///
    /// Returns
    /// -------
    /// PalmMove
    ///     The moves as one.
    ///
    /// Raises
    /// ------
    /// MotionError
    ///     If moves are nested more than 32 deep.
    #[staticmethod]
    fn back_and_forth(times: Whole, moves: Vec<PyRef<Self>>) -> PyResult<Self> {
        let moves: Vec<PalmMove> = moves.iter().map(|each| each.0.clone()).collect();
        if depth(&moves) >= DEEPEST {
            let what = "the number of moves";
            return Err(MotionError::OutOfRange { what, range: "at most a million, 32 deep" }).or_raise();
        }
        Ok(Self(PalmMove::BackAndForth { times: times.small(), moves }))
    }

    fn __repr__(&self) -> String {
        let (name, arguments) = self.call();
        let arguments: Vec<String> = arguments.iter().map(f64::to_string).collect();
        match &self.0 {
            PalmMove::BackAndForth { times, moves } => format!("PalmMove.{name}({times}, <{} moves>)", moves.len()),
            _ => format!("PalmMove.{name}({})", arguments.join(", ")),
        }
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        let (name, numbers) = self.call();
        let arguments = match &self.0 {
            PalmMove::BackAndForth { times, moves } => {
                let moves: Vec<Self> = moves.iter().cloned().map(Self).collect();
                (*times, moves).into_pyobject(py)?
            }
            PalmMove::OpenOne { palm, angle_rad, duration_s } => {
                (if *palm == Palm::One { 1 } else { 2 }, *angle_rad, *duration_s).into_pyobject(py)?
            }
            _ => PyTuple::new(py, numbers)?,
        };
        pickled::by_method::<Self>(py, name, arguments)
    }
}

impl Move {
    /// The static method that makes this move, and the numbers it takes.
    fn call(&self) -> (&'static str, Vec<f64>) {
        match self.0 {
            PalmMove::Rotate { angle_rad, duration_s } => ("rotate", vec![angle_rad, duration_s]),
            PalmMove::Open { angle_rad, duration_s } => ("open", vec![angle_rad, duration_s]),
            PalmMove::OpenOne { palm, angle_rad, duration_s } => {
                ("open_one", vec![if palm == Palm::One { 1.0 } else { 2.0 }, angle_rad, duration_s])
            }
            PalmMove::OpenAndRotate { open_rad, rotate_rad, duration_s } => {
                ("open_and_rotate", vec![open_rad, rotate_rad, duration_s])
            }
            PalmMove::Wait { duration_s } => ("wait", vec![duration_s]),
            PalmMove::BackAndForth { .. } => ("back_and_forth", Vec::new()),
        }
    }
}

/// How deep these moves are nested; never deeper than the limit, by construction.
fn depth(moves: &[PalmMove]) -> usize {
    let below = moves.iter().map(|each| if let PalmMove::BackAndForth { moves, .. } = each { depth(moves) } else { 0 });
    1 + below.max().unwrap_or(0)
}
