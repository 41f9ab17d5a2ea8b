"""Who is told how far a reconstruction, a calibration or a sweep has come: a callable, a bar, or nobody."""

from __future__ import annotations

import sys
import threading
import time
import warnings
from collections.abc import Callable
from typing import Any, Protocol

PATIENCE_S = 1.0
"""Work shorter than this needs no sign of life."""


class Listener(Protocol):
    """Told how far the work has come, and closed in the end."""

    def __call__(self, stage: str, fraction: float, /) -> None: ...

    def close(self) -> None: ...


class _Called:
    """Passes everything on to a callable."""

    def __init__(self, callback: Callable[[str, float], object]) -> None:
        self._callback = callback

    def __call__(self, stage: str, fraction: float, /) -> None:
        self._callback(stage, fraction)

    def close(self) -> None:
        pass


class _Bar:
    """A bar that appears when the work takes long, and goes away with it."""

    def __init__(self, tqdm: Any) -> None:
        form = "{desc} |{bar}| {percentage:3.0f} % of the budget, {elapsed}"
        self._bar = tqdm(total=1.0, leave=False, delay=PATIENCE_S, bar_format=form)

    def __call__(self, stage: str, fraction: float, /) -> None:
        # At the end the bar goes away in a moment.
        if fraction < 1:
            self._bar.set_description_str(stage, refresh=False)
            self._bar.update(fraction - self._bar.n)

    def close(self) -> None:
        self._bar.close()


class _JobsBar:
    """A bar of the jobs of a sweep, which counts those finished earlier as well, but not into its rate."""

    def __init__(self, tqdm: Any, jobs: int) -> None:
        self._tqdm = tqdm
        self._jobs = jobs
        self._bar: Any = None

    def __call__(self, stage: str, fraction: float, /) -> None:
        finished = round(fraction * self._jobs)
        if self._bar is None:
            self._bar = self._tqdm(total=self._jobs, initial=finished, unit="job", leave=False, delay=PATIENCE_S)
        self._bar.update(finished - self._bar.n)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()


class _Text:
    """A bar of plain text for who has no tqdm: it appears when the work takes long, and goes away with it."""

    WIDTH = 24
    TICK_S = 0.2

    def __init__(self) -> None:
        self._stream = sys.stderr
        self._started = time.monotonic()
        self._next = self._started + PATIENCE_S
        self._shown = 0

    def __call__(self, stage: str, fraction: float, /) -> None:
        now = time.monotonic()
        if now < self._next or fraction >= 1 or self._stream is None:
            return
        self._next = now + self.TICK_S
        done = round(fraction * self.WIDTH)
        bar = "#" * done + "." * (self.WIDTH - done)
        self._write(f"{stage} |{bar}| {100 * fraction:3.0f} %, {now - self._started:.0f} s")

    def close(self) -> None:
        if self._shown:
            self._write("")
            self._stream.write("\r")
            self._stream.flush()

    def _write(self, text: str) -> None:
        # What was there before is written over.
        self._stream.write("\r" + text.ljust(self._shown))
        self._stream.flush()
        self._shown = len(text)


def listener(progress: bool | Callable[[str, float], object] | None, *, jobs: int | None = None) -> Listener | None:
    """What `progress` asks for; by default a bar, if someone is watching. A sweep says its `jobs`."""
    if callable(progress):
        return _Called(progress)
    if progress is False or (progress is None and not _is_watched()):
        return None
    try:
        with warnings.catch_warnings():
            # Without its widgets a notebook gets a bar of text, which is good enough.
            warnings.simplefilter("ignore")
            from tqdm.auto import tqdm

            return _Bar(tqdm) if jobs is None else _JobsBar(tqdm, jobs)
    except ImportError:
        return _Text()


def _is_watched() -> bool:
    """Whether someone is likely to look: a terminal or a notebook, and no threads that would each draw a bar."""
    if threading.current_thread() is not threading.main_thread():
        return False
    if "ipykernel" in sys.modules:
        return True
    return sys.stderr is not None and sys.stderr.isatty()
