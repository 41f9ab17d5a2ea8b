"""Sweeps on a Ray cluster. Imported when one is asked for, so that palpate needs no Ray.

This process hands out jobs in chunks, and it alone writes into the folder. A worker does the jobs of its chunk one
after another and after a short while sends back what it has; what it has not begun is handed out again, and so is a
whole chunk that was lost with its worker. A job that was done twice for that reason gave the same row, and is kept
once.
"""

from __future__ import annotations

import contextlib
import logging
import socket
from collections import Counter, deque
from typing import TYPE_CHECKING, Any

import ray
from ray import exceptions

from palpate._errors import PalpateError, SweepError
from palpate._palpate import SweepFolder, __version__, run_sweep_jobs

if TYPE_CHECKING:
    from palpate._progress import Listener

CHUNKS_PER_PROCESSOR = 8
"""The jobs that are left are cut into so many chunks for each processor, so that all end at about the same time."""
MOST_JOBS = 64
"""No chunk has more jobs."""
CHUNK_S = 2.0
"""A worker begins no job of its chunk after so long, so that little is lost with a worker."""
AHEAD = 2
"""Chunks for each processor that are on their way or being done, so that none waits for the next one."""
MOST_LOSSES = 5
"""A job that was lost so often is taken to be what kills its workers."""
TICK_S = 0.5
"""Time between two looks at the number of processors, and at Ctrl-C."""
REACH_S = 10.0
"""A cluster whose address does not answer for so long is not there; Ray itself would try for minutes."""

LOST = (
    exceptions.LocalRayletDiedError,
    exceptions.NodeDiedError,
    exceptions.ObjectLostError,
    exceptions.OutOfMemoryError,
    exceptions.WorkerCrashedError,
)
"""What Ray says when a chunk went down with its worker, or its outcomes did."""


def run(folder: SweepFolder, address: str, listener: Listener | None) -> None:
    """Does what is not finished on the cluster at this address, or on the one that this process is connected to."""
    connected = ray.is_initialized()
    try:
        if not connected:
            _connect(address)
        _hand_out(folder, listener)
    except exceptions.RayTaskError as error:
        if isinstance(error.cause, PalpateError):
            raise error.cause from None
        raise SweepError(
            f"{address}: a worker could not do its jobs; is palpate {__version__} there? {error}"
        ) from error
    except exceptions.RayError as error:
        raise SweepError(f"{address}: Ray failed: {error}") from error
    finally:
        if not connected:
            ray.shutdown()


def _connect(address: str) -> None:
    host, _, port = address.removeprefix("ray://").rpartition(":")
    if port.isdecimal():
        try:
            socket.create_connection((host.strip("[]"), int(port)), timeout=REACH_S).close()
        except (OSError, OverflowError) as error:
            raise SweepError(f"{address}: no Ray cluster answers at this address: {error}") from error
    try:
        ray.init(address=address, log_to_driver=False, logging_level=logging.ERROR)
    except (ConnectionError, RuntimeError, ValueError) as error:
        raise SweepError(f"{address}: Ray cannot be reached: {error}") from error


def _hand_out(folder: SweepFolder, listener: Listener | None) -> None:
    # Ray's own retries would do a whole chunk again, and for ever when a job needs more memory than there is.
    remote = ray.remote(num_cpus=1, max_retries=0)(_do)
    waiting = deque(folder.todo())
    losses: Counter[int] = Counter()
    at_work: dict[Any, list[int]] = {}
    try:
        while waiting or at_work:
            processors = max(1, int(ray.cluster_resources().get("CPU", 0)))
            while waiting and len(at_work) < AHEAD * processors:
                chunk = _next_chunk(waiting, losses, processors)
                at_work[remote.remote(__version__, folder.letters(chunk), folder.base, CHUNK_S)] = chunk
            for reference in ray.wait(list(at_work), timeout=TICK_S)[0]:
                chunk = at_work.pop(reference)
                try:
                    outcomes: list[str] = ray.get(reference)
                except LOST as error:
                    outcomes = []
                    losses.update(chunk)
                    _refuse_killers(chunk, losses, error)
                folder.keep(outcomes)
                waiting.extendleft(reversed(chunk[len(outcomes) :]))
            if listener is not None:
                finished, jobs = folder.done()
                listener("jobs", finished / jobs)
    finally:
        for reference in at_work:
            # Nobody waits for these any more; the connection may be what failed.
            with contextlib.suppress(Exception):
                ray.cancel(reference)


def _next_chunk(waiting: deque[int], losses: Counter[int], processors: int) -> list[int]:
    """Takes the next jobs. One that was lost goes alone, so that what kills its worker is known, and does so alone."""
    size = min(MOST_JOBS, max(1, len(waiting) // (CHUNKS_PER_PROCESSOR * processors)))
    chunk = [waiting.popleft()]
    while len(chunk) < size and not losses[chunk[0]] and waiting and not losses[waiting[0]]:
        chunk.append(waiting.popleft())
    return chunk


def _refuse_killers(chunk: list[int], losses: Counter[int], error: Exception) -> None:
    for job in chunk:
        if losses[job] >= MOST_LOSSES:
            raise SweepError(
                f"job {job} was lost with its worker {losses[job]} times, the last time so: {error}"
            ) from error


def _do(version: str, jobs: list[tuple[int, str]], base: str, seconds: float) -> list[str]:
    """Does jobs on a worker, for so many seconds."""
    if version != __version__:
        raise SweepError(
            f"a worker has palpate {__version__}, the sweep is by {version}; install one version everywhere"
        )
    return run_sweep_jobs(jobs, base, seconds)
