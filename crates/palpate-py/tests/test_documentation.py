"""What the documentation says is tried: docstrings, README, guide."""

from __future__ import annotations

import doctest
import inspect
import re
import runpy
from pathlib import Path

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


def test_the_packages_own_readme_is_true(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "trial.csv").write_bytes((LOGS / "egg_full_turn_oracle_n0.1mm.csv").read_bytes())
    (tmp_path / "example.py").write_text(code_in(ROOT / "crates" / "palpate-py" / "README.md", "# palpate"))
    runpy.run_path(str(tmp_path / "example.py"))
