"""Long calls: Ctrl-C, progress, other threads, forks."""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
import textwrap
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest
from conftest import LOGS

import palpate
from palpate import _progress

ENDLESS = """
    import os, signal, threading
    import numpy as np
    import palpate

    # A shell ignores Ctrl-C for what it runs in the background, and Python then leaves it ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    begun = threading.Event()

    class Motion:
        # The call asks for the numbers of the motion: by then it has begun.
        def __array__(self, dtype=None, copy=None):
            begun.set()
            return palpate.PalmMotion.random(1, 1000.0).sample(100.0)

    def interrupt():
        begun.wait()
        print("begun", flush=True)
        os.kill(os.getpid(), signal.SIGINT)

    # So many harmonics, all of them zero, take hours.
    circle = palpate.SupportFunction(0.03, np.zeros((100_000, 2)))
    threading.Thread(target=interrupt).start()
    try:
        palpate.simulate(circle, Motion())
        print("finished")
    except KeyboardInterrupt:
        print("interrupted")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="a process cannot send itself Ctrl-C")
def test_ctrl_c_ends_a_call_that_tells_nothing() -> None:
    """The simulation would take hours on any machine; nothing may wait for its end."""
    run = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(ENDLESS)], capture_output=True, text=True, timeout=1200, check=True
    )
    assert run.stdout.split() == ["begun", "interrupted"]


def test_progress_is_told_and_never_decreases(simulation: palpate.Simulation) -> None:
    told: list[tuple[str, float]] = []
    palpate.reconstruct(simulation.log, progress=lambda stage, share: told.append((stage, share)))
    shares = [share for _, share in told]
    assert shares == sorted(shares)
    assert 0 <= shares[0] <= shares[-1] == 1
    assert told[0][0] == "searching for arrangements"


def test_what_a_listener_raises_ends_the_call(simulation: palpate.Simulation, result: palpate.Result) -> None:
    class EnoughError(Exception):
        pass

    def listener(stage: str, share: float) -> None:
        raise EnoughError(stage)

    with pytest.raises(EnoughError, match="searching"):
        palpate.reconstruct(simulation.log, progress=listener)
    # The work that was dropped leaves nothing behind.
    assert palpate.reconstruct(simulation.log) == result


def test_a_listener_is_called_in_the_thread_that_called(simulation: palpate.Simulation) -> None:
    threads = set()
    palpate.reconstruct(simulation.log, progress=lambda *_: threads.add(threading.get_ident()))
    assert threads == {threading.get_ident()}


def test_other_threads_run_meanwhile(simulation: palpate.Simulation, result: palpate.Result) -> None:
    """Two calls that each wait for the other's first sign of progress: neither may hold the interpreter."""
    meet = threading.Barrier(2, timeout=1200)

    def solve() -> palpate.Result:
        met = False

        def listener(stage: str, share: float) -> None:
            nonlocal met
            if not met:
                met = True
                meet.wait()

        return palpate.reconstruct(simulation.log, progress=listener)

    with ThreadPoolExecutor(2) as pool:
        futures = [pool.submit(solve) for _ in range(2)]
        assert [future.result() for future in futures] == [result, result]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
@pytest.mark.filterwarnings("ignore:.*multi-threaded.*fork.*:DeprecationWarning")
def test_a_forked_process_works(simulation: palpate.Simulation, result: palpate.Result) -> None:
    """A thread pool does not survive a fork; a child that used the parent's would wait for ever."""
    assert palpate.reconstruct(simulation.log) == result
    with multiprocessing.get_context("fork").Pool(2) as pool:
        results = pool.map_async(palpate.reconstruct, [simulation.log] * 2).get(timeout=1200)
    assert results == [result, result]


def test_a_bar_is_shown_when_it_is_wanted(
    simulation: palpate.Simulation, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_progress, "PATIENCE_S", 0.0)
    palpate.reconstruct(simulation.log, progress=True)
    assert "% of the budget" in capsys.readouterr().err
    palpate.reconstruct(simulation.log)  # nobody is watching
    palpate.reconstruct(simulation.log, progress=False)
    assert capsys.readouterr().err == ""


def test_without_tqdm_there_is_a_bar_of_text(
    simulation: palpate.Simulation, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    monkeypatch.setattr(_progress, "_is_watched", lambda: True)
    # Work that is short needs none.
    assert palpate.reconstruct(simulation.log[:100]).psi.shape == (100,)
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(_progress, "PATIENCE_S", 0.0)
    assert palpate.reconstruct(simulation.log, progress=True).certified
    shown = capsys.readouterr().err
    assert "|" in shown
    assert " %, 0 s" in shown
    # It has gone away with the work.
    assert shown.endswith("\r")
    assert shown.rsplit("\r", 2)[1].strip() == ""


def test_many_logs_at_once() -> None:
    names = ("egg_full_turn_oracle_n0.1mm", "ellipse_full_turn_pymunk", "pebble_full_turn_mujoco_sensor")
    logs = [palpate.Log.from_csv(LOGS / f"{name}.csv")[::5] for name in names]
    alone = [palpate.reconstruct(log, threads=1) for log in logs]
    with ThreadPoolExecutor(3) as pool:
        assert list(pool.map(palpate.reconstruct, logs)) == alone
