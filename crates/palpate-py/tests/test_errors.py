"""One hierarchy of exceptions, and no panic, whatever comes in."""

from __future__ import annotations

import inspect
import itertools
import math

import numpy as np
import pytest

import palpate

CLASSES = [getattr(palpate, name) for name in palpate.__all__ if inspect.isclass(getattr(palpate, name))]
FORMS = [form for form in CLASSES if issubclass(form, BaseException) and not issubclass(form, Warning)]


def test_all_exceptions_have_one_root() -> None:
    assert len(FORMS) == 11
    for form in FORMS:
        assert issubclass(form, palpate.PalpateError)
        assert form.__module__ == "palpate"
        assert form.__doc__
    assert issubclass(palpate.ReadWarning, UserWarning)
    assert issubclass(palpate.InputError, ValueError)
    for form in (palpate.ReadError, palpate.ShapeError, palpate.MotionError, palpate.SimulateError):
        assert issubclass(form, palpate.InputError)


NUMBERS = [0.0, -1.0, 1.0, 1e-300, 1e300, math.inf, -math.inf, math.nan]
COUNTS = [0, 1, -1, 2**63, 2**64, 10**30]
TABLES = [[], [[]], [(1, 2)], [(math.nan, 1.0)] * 20, [(math.inf, 1.0)] * 20, np.zeros((50, 2)), np.ones((50, 3))]
ODD = [None, "egg", b"egg", object(), {}, [None], ["a", 1], 1 + 2j]


def things() -> dict[str, list[object]]:
    """Values that a careless caller may give, by what an argument's name suggests."""
    egg = palpate.SupportFunction.named("egg")
    wild = palpate.SupportFunction(1e300, [(1e300, -1e300)] * 3)
    tiny = palpate.SupportFunction(1e-300, [(0, 1e-300)] * 2)
    palms = [palpate.PalmPair(0.7, 1.6), palpate.PalmPair(-12.0, 12.0), palpate.PalmPair(0, 0, (1e300, 0), (0, -1e300))]
    log = palpate.simulate(egg, palpate.PalmMotion.random(1, 3), rate_hz=4).log
    return {
        "shape": [egg, wild, tiny],
        "palms": [*palms],
        "start": [*palms],
        "end": [*palms],
        "log": [log, log[:3], log[:0], log[::-1]],
        "logs": [[], [log], [log[:3], log[:0]], [log[::-1], None], log],
        "moves": [[], [palpate.PalmMove.rotate(x, y) for x in NUMBERS for y in NUMBERS[:2]]],
    }


def calls() -> list[tuple[object, list[list[object]]]]:
    known = things()
    targets: list[object] = [
        palpate.simulate,
        palpate.plan_turn,
        palpate.plan_jump_free,
        palpate.follow,
        palpate.calibrate,
    ]
    targets += [palpate.reconstruct, palpate.reconstruct_from, palpate.cramer_rao_bound_m, palpate.sweep_jobs]
    palms = (palpate.PalmPair, palpate.PalmMotion, palpate.PalmMove)
    for form in (palpate.SupportFunction, *palms, palpate.Log, palpate.Rig):
        targets.append(form)
        targets += [getattr(form, name) for name in vars(form) if isinstance(vars(form)[name], staticmethod)]
    landscape = palpate.EnergyLandscape(palpate.SupportFunction.named("egg"), palpate.PalmPair(0.7, 1.6))
    for instance in (palpate.SupportFunction.named("egg"), palpate.PalmPair(0.7, 1.6), landscape, palpate.Touchpad()):
        targets += [getattr(instance, name) for name in dir(instance) if not name.startswith("_")]
    plain: list[list[object]] = [[*NUMBERS[:4], *ODD[:3]], [*NUMBERS[3:], *COUNTS[:3]], [*COUNTS], [*TABLES], ODD]
    every: list[tuple[object, list[list[object]]]] = []
    for target in targets:
        if not callable(target) or getattr(target, "__name__", "") in ("plot", "from_pandas", "from_csv", "_made"):
            continue
        try:
            parameters = list(inspect.signature(target).parameters.values())
        except (TypeError, ValueError):
            continue
        needed = [each.name for each in parameters if each.default is each.empty and each.kind < each.VAR_POSITIONAL]
        for choice in plain:
            every.append((target, [known.get(name, choice) for name in needed]))
            if all(name in known for name in needed):
                break
    return every


def test_no_argument_makes_it_panic() -> None:
    """Whatever comes in, a value or an ordinary exception comes out; a panic is no Exception and would fail this."""
    tried = 0
    for target, choices in calls():
        assert callable(target)
        for arguments in itertools.islice(itertools.product(*choices), 60):
            tried += 1
            try:
                target(*arguments)
            except palpate.InternalError as error:
                pytest.fail(f"{target}{arguments}: {error}")
            except (palpate.PalpateError, TypeError, ValueError):
                pass
    assert tried > 3000


def test_wrong_types_are_type_errors(egg: palpate.SupportFunction) -> None:
    with pytest.raises(TypeError, match="'str' object is not an instance of 'Log'"):
        palpate.reconstruct_from("trial.csv", egg, [0.0])  # type: ignore[arg-type]
    with pytest.raises(TypeError):
        palpate.simulate(egg, "random")


def test_what_is_no_log_says_what_is() -> None:
    with pytest.raises(palpate.InputError, match=r"the path of a CSV file, .*, not int$"):
        palpate.reconstruct(42)  # type: ignore[arg-type]
    with pytest.raises(palpate.InputError, match=r"not list; one log for each call$"):
        palpate.reconstruct(["a.csv", "b.csv"])  # type: ignore[arg-type]
