"""Palm logs from and to pandas. Imported when it is asked for, so that palpate needs no pandas."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import pandas as pd

    from palpate import Log


def columns_of(frame: pd.DataFrame) -> dict[str, Any]:
    """Columns of a data frame by name, with NaN for what is missing."""
    columns: dict[str, Any] = {}
    for place, name in enumerate(frame.columns):
        column = frame.iloc[:, place]
        try:
            values: Any = column.to_numpy(dtype="float64", na_value=np.nan)
        except (TypeError, ValueError):
            # Text where a number belongs is for the reader to refuse, if it needs the column.
            values = [None if missing else str(value) for value, missing in zip(column, column.isna(), strict=True)]
        if str(name) in columns:
            # A mapping would lose one of them without a word.
            from palpate import ReadError

            problem = f"the data frame has two columns named {name}; remove one of them"
            raise ReadError(problem, "the data frame", None, str(name), problem)
        columns[str(name)] = values
    return columns


def frame_of(log: Log) -> pd.DataFrame:
    """Columns of a palm log as a data frame."""
    import pandas as pd

    return pd.DataFrame(log.to_numpy())
