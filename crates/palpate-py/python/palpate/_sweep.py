"""Sweeps: many jobs, here or on a cluster, into one table."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from palpate import _progress
from palpate._errors import InputError
from palpate._palpate import SweepFolder, SweepJob, sweep_jobs

if TYPE_CHECKING:
    from collections.abc import Callable

    import pandas as pd
    from numpy.typing import NDArray

__all__ = ["SweepResult", "sweep"]

LOCAL = "local"
"""The engine that does the jobs on the threads of this machine."""


@dataclass(frozen=True, eq=False)
class SweepResult:
    """What came of a sweep. Its length is the number of jobs.

    Parameters
    ----------
    folder : pathlib.Path
        The folder with `results.parquet`, `seconds.csv` and `journal.jsonl`. An attribute too, as the following.
    columns : dict of str to numpy.ndarray
        The columns of `results.parquet` by name, shape (jobs,), read-only. What is null there is NaN in numbers and
        None elsewhere.
    finished_before : int
        So many jobs were finished by earlier calls.
    """

    folder: Path
    columns: dict[str, NDArray[Any]] = field(repr=False)
    finished_before: int

    @property
    def table(self) -> Path:
        """pathlib.Path: the table, `results.parquet`."""
        return self.folder / "results.parquet"

    @property
    def reconstructed(self) -> int:
        """int: Number of jobs with a result, certified or not."""
        return self._count("status", "reconstructed")

    @property
    def certified(self) -> int:
        """int: Number of jobs whose result is certified."""
        return self._count("certified", True)

    @property
    def without_log(self) -> int:
        """int: Number of jobs whose log could not be simulated or read; the column `reason` says why."""
        return self._count("status", "no-log")

    @property
    def without_result(self) -> int:
        """int: Number of jobs with a log, but without a result; the column `reason` says why."""
        return self._count("status", "no-result")

    def to_pandas(self) -> pd.DataFrame:
        """The table as a data frame.

        Returns
        -------
        pandas.DataFrame
            A row for each job, with the columns of `results.parquet`.
        """
        import pandas as pd

        return pd.DataFrame(self.columns)

    def _count(self, column: str, value: object) -> int:
        return int((self.columns[column] == value).sum())

    def __len__(self) -> int:
        return len(self.columns["job"])

    def __str__(self) -> str:
        before = f", {self.finished_before} of them finished before" if self.finished_before else ""
        return f"{len(self)} jobs{before}: {self.reconstructed} reconstructed, {self.certified} of them certified"


def sweep(
    plan: str | os.PathLike[str] | Iterable[SweepJob],
    folder: str | os.PathLike[str],
    *,
    engine: str = LOCAL,
    threads: int | None = None,
    progress: bool | Callable[[str, float], object] | None = None,
) -> SweepResult:
    """Do many jobs, simulated or recorded logs to reconstruct, and make one table of them.

    The folder is that of `palpate sweep`, and the bytes of its table are the same wherever the jobs were done. A sweep
    that was stopped, by Ctrl-C or a kill, goes on where it was when it is called again, on the same engine or another.
    Other Python threads run meanwhile.

    Parameters
    ----------
    plan : str, os.PathLike or iterable of SweepJob
        Path of a plan, a TOML file; or its text, if there is a line break in it; or jobs from `sweep_jobs`.
    folder : str or os.PathLike
        Folder for the tables, made if missing; to resume a sweep that was stopped, its folder.
    engine : str
        'local': the threads of this machine. Else Ray, with this version of palpate on every node: 'auto' for the
        cluster that this machine belongs to, or an address such as '10.0.0.1:6379' or 'ray://10.0.0.1:10001'. Where
        this process is connected to Ray already, that connection is used. Every node must see recorded logs under the
        same path.
    threads : int, optional
        Threads to work with. Default: as many as there are processors. Not for Ray, where each processor of the
        cluster does one job at a time.
    progress : bool or callable, optional
        True: a bar, by tqdm if it is installed; False: none; a callable: called with 'jobs' (str) and the share of
        them that is finished (float). Default: a bar if someone is watching.

    Returns
    -------
    SweepResult
        The table, and how it went. What became of a single job is told in its row: it is no error.

    Raises
    ------
    ReadError
        If the plan cannot be read, or makes no sense.
    SweepError
        If the folder belongs to another sweep, another program is at work in it, it cannot be written, or the cluster
        is of no use. What was finished is kept.
    ImportError
        If Ray is asked for and not installed.

    Examples
    --------
    >>> import palpate, tempfile
    >>> plan = '''
    ... kind = "simulate"
    ... trials = 3
    ... samples = 100
    ... objects.named = { name = "egg" }
    ... touchpads = [{ noise_sd_m = 0.1e-3 }]
    ... reconstruct.method = "quadrature"
    ... '''
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     result = palpate.sweep(plan, folder)
    >>> print(result)
    3 jobs: 3 reconstructed, 0 of them certified
    >>> result.columns["seed"]
    array([1., 2., 3.])
    """
    if engine != LOCAL:
        if threads is not None:
            raise InputError(
                "threads goes with engine='local'; on Ray each processor of the cluster does a job at a time"
            )
        try:
            from palpate import _ray
        except ImportError as error:
            raise ImportError("a sweep on a cluster needs Ray; pip install 'palpate[ray]'") from error
    jobs = sweep_jobs(plan) if isinstance(plan, (str, os.PathLike)) else list(plan)
    at_work = SweepFolder(jobs, folder)
    listener = None
    try:
        before, count = at_work.done()
        listener = _progress.listener(progress, jobs=count)
        if listener is not None:
            listener("jobs", before / count)
        if engine == LOCAL:
            at_work.run(threads, listener)
        elif before < count:
            _ray.run(at_work, engine, listener)
        columns = at_work.finish()
    finally:
        at_work.close()
        if listener is not None:
            listener.close()
    return SweepResult(Path(folder), columns, before)


for _thing in (sweep, SweepResult):
    # They are to be known by the name that people import.
    _thing.__module__ = "palpate"
