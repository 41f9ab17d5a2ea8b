"""Palm logs from and to pandas, and results to it. Imported when it is asked for, so that palpate needs no pandas."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import pandas as pd

    from palpate import Log, Result


TIME = re.compile(r"time(_?stamp)?([\W_].*)?", re.IGNORECASE)
"""Names of a column of time, with any unit."""


def columns_of(frame: pd.DataFrame) -> dict[str, Any]:
    """Columns of a data frame by name, with NaN for what is missing; its index as one more where it is time."""
    columns: dict[str, Any] = {}
    for place, name in enumerate(frame.columns):
        if str(name) in columns:
            # A mapping would lose one of them without a word.
            from palpate import ReadError

            problem = f"the data frame has two columns named {name}; remove one of them"
            raise ReadError(problem, "the data frame", None, str(name), problem)
        columns[str(name)] = values_of(frame.iloc[:, place])
    has_time = any(TIME.fullmatch(name) for name in columns)
    index = frame.index
    is_time = TIME.fullmatch(str(index.name)) or kind_of(index) in "mM"
    if is_time and not has_time:
        name = "time" if index.name is None else str(index.name)
        columns[name if TIME.fullmatch(name) else f"time {name}"] = values_of(index.to_series())
    return columns


def kind_of(values: pd.Series[Any] | pd.Index[Any]) -> str:
    """The kind of numpy's type: M for dates, m for durations."""
    return str(getattr(values.dtype, "kind", "O"))


def values_of(column: pd.Series[Any]) -> Any:
    """The values of a column for the reader: numbers, dates or durations of numpy, or text."""
    kind = kind_of(column)
    if kind in "mM":
        # Dates with a time zone become those of UTC.
        return column.to_numpy(dtype="datetime64[ns]" if kind == "M" else "timedelta64[ns]")
    try:
        return column.to_numpy(dtype="float64", na_value=np.nan)
    except (TypeError, ValueError):
        # Text where a number belongs is for the reader to refuse, if it needs the column.
        return [None if missing else str(value) for value, missing in zip(column, column.isna(), strict=True)]


def frame_of(log: Log) -> pd.DataFrame:
    """Columns of a palm log as a data frame."""
    import pandas as pd

    return pd.DataFrame(log.to_numpy())


def frame_of_result(result: Result, table: str) -> pd.DataFrame:
    """The motion or the shape of a result; see `Result.to_pandas`."""
    import pandas as pd

    if table == "motion":
        columns = {
            "psi_rad": result.psi,
            "psi_sd_rad": result.psi_sd,
            "com_x_m": result.com[:, 0],
            "com_y_m": result.com[:, 1],
            "com_sd_m": result.com_sd,
            "theta1_rad": result.theta1,
            "theta2_rad": result.theta2,
            "piece": result.piece,
            "mode1": result.mode1,
            "mode2": result.mode2,
            "residual1_m": result.residual1,
            "residual2_m": result.residual2,
        }
        return pd.DataFrame(columns, index=pd.Index(result.time, name="time_s"))
    if table == "shape":
        columns = {
            "r_m": result.r,
            "r_sd_m": result.r_sd,
            "x_m": result.boundary[:, 0],
            "y_m": result.boundary[:, 1],
            "curvature_radius_m": result.curvature_radius,
            "touches": result.touches,
        }
        return pd.DataFrame(columns, index=pd.Index(result.theta, name="theta_rad"))
    from palpate import InputError

    raise InputError(f"there is no table {table!r}; take 'motion' or 'shape'")
