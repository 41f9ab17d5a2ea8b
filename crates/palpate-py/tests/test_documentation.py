"""What the documentation says is tried: docstrings, README, guide."""

from __future__ import annotations

import doctest
import inspect
import re
import runpy
from pathlib import Path

import numpy as np
import pytest
from conftest import LOGS, ROOT

import palpate


def documented() -> list[tuple[str, object]]:
    public = [(name, getattr(palpate, name)) for name in palpate.__all__ if name != "__version__"]
    members = [
        (f"{name}.{member}", getattr(thing, member))
        for name, thing in public
        if inspect.isclass(thing) and thing.__module__ == "palpate" and not issubclass(thing, BaseException)
        for member in vars(thing)
        if not member.startswith("_")
    ]
    return public + members


@pytest.mark.parametrize(("name", "thing"), documented(), ids=[name for name, _ in documented()])
def test_examples_in_docstrings_are_true(name: str, thing: object) -> None:
    text = inspect.getdoc(thing) or ""
    example = doctest.DocTestParser().get_doctest(text, {}, name, None, None)
    failures: list[str] = []
    doctest.DocTestRunner().run(example, out=failures.append)
    assert not failures, "".join(failures)


@pytest.mark.parametrize(("name", "thing"), documented(), ids=[name for name, _ in documented()])
def test_everything_says_what_it_is(name: str, thing: object) -> None:
    first = (inspect.getdoc(thing) or "").split("\n\n")[0]
    assert first, f"{name} has no docstring"
    assert "\n" not in first or name == "Simulation", f"the summary of {name} has several lines"


def code_in(path: Path, heading: str) -> str:
    """The first Python example below a heading."""
    section = path.read_text(encoding="utf-8").split(heading, 1)[1]
    found = re.search(r"```python\n(.*?)```", section, re.DOTALL)
    assert found
    return found[1]


def test_the_readmes_example_gives_a_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    code = code_in(ROOT / "README.md", "## From Python")
    assert len(code.strip().splitlines()) <= 10
    (tmp_path / "example.py").write_text(code)
    runpy.run_path(str(tmp_path / "example.py"))
    assert (tmp_path / "pebble.png").read_bytes().startswith(b"\x89PNG")


def test_the_how_to_reads_counts_and_gaps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    egg = palpate.SupportFunction.named("egg")
    pad = palpate.Touchpad.interlink(length_m=0.2, dropout=0.1)
    log = palpate.simulate(egg, palpate.plan_turn(egg, 40.0), touchpad=pad, rate_hz=10).log
    counts = (1e3 * np.stack([log.s1_m, log.s2_m]) - 12.5) / (25.4 / 200)
    table = np.stack([log.time_s, np.degrees(log.phi1_rad), np.degrees(log.phi1_rad + log.phi2_rad), *counts], axis=1)
    lines = (",".join("" if np.isnan(value) else f"{value:.10f}" for value in row) for row in table)
    (tmp_path / "counts.csv").write_text("\n".join(lines))
    (tmp_path / "example.py").write_text(code_in(ROOT / "docs" / "how-to-own-sensor.md", "### From Python"))
    left = runpy.run_path(str(tmp_path / "example.py"))
    assert left["result"].certified
    np.testing.assert_allclose(left["log"].s1_m, log.s1_m, atol=1e-9)
    assert palpate.Result.load(tmp_path / "trial").certified


def test_the_guide_to_sweeps_is_true(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    code = code_in(ROOT / "docs" / "sweeps.md", "## From Python")
    assert "trials = 5" in code
    (tmp_path / "example.py").write_text(code.replace("trials = 5", "trials = 1"))
    left = runpy.run_path(str(tmp_path / "example.py"))
    assert len(left["result"]) == 4


def test_the_packages_own_readme_is_true(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "trial.csv").write_bytes((LOGS / "egg_full_turn_oracle_n0.1mm.csv").read_bytes())
    (tmp_path / "example.py").write_text(code_in(ROOT / "crates" / "palpate-py" / "README.md", "# palpate"))
    runpy.run_path(str(tmp_path / "example.py"))
