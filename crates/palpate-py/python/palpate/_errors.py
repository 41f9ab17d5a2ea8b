"""The exceptions of palpate: one hierarchy, with the words of the command line."""

from __future__ import annotations

__all__ = [
    "CompareError",
    "InputError",
    "InternalError",
    "MotionError",
    "PalpateError",
    "ReadError",
    "ReadWarning",
    "ReconstructError",
    "ShapeError",
    "SimulateError",
    "SweepError",
    "WriteError",
]


class PalpateError(Exception):
    """Root of all exceptions that palpate raises on purpose."""


class InputError(PalpateError, ValueError):
    """An argument is out of range, or does not fit the others."""


class ReadError(InputError):
    """A file or table cannot be used as what it should be.

    Parameters
    ----------
    message : str
        Where, what is wrong, and what to do: what `str` shows.
    file : str
        Name of the file, or what stands for it. An attribute too, as the following.
    line : int or None
        Line in the file, from 1. For columns in memory the row, from 0.
    column : str or None
        Name of the column, or key of a plan or rig file.
    problem : str
        What is wrong, and what to do, without the place.
    """

    file: str
    line: int | None
    column: str | None
    problem: str

    def __init__(
        self,
        message: str,
        file: str = "",
        line: int | None = None,
        column: str | None = None,
        problem: str = "",
    ) -> None:
        super().__init__(message, file, line, column, problem)
        self.file = file
        self.line = line
        self.column = column
        self.problem = problem

    def __str__(self) -> str:
        return str(self.args[0])


class ReadWarning(UserWarning):
    """Something about a file or table that was read, such as columns left aside."""


class WriteError(PalpateError):
    """A file or folder cannot be written."""


class ShapeError(InputError):
    """A shape cannot be made from what was given."""


class MotionError(InputError):
    """A palm motion is impossible, or none could be planned."""


class SimulateError(InputError):
    """The object cannot be simulated, or leaves the palms."""


class ReconstructError(PalpateError):
    """The log cannot be reconstructed at all, or an option is out of range."""


class CompareError(InputError):
    """Result and truth do not belong together, or one of them is empty."""


class SweepError(PalpateError):
    """A sweep cannot be run in this folder or on this cluster, or not to its end. What was finished is kept."""


class InternalError(PalpateError, RuntimeError):
    """A fault of palpate itself. Please report it with the input."""


for _name in __all__:
    # They are to be known by the name that people import.
    globals()[_name].__module__ = "palpate"
