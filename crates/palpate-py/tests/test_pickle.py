"""Everything can be sent to another process and copied."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from conftest import LOGS

import palpate
from palpate import PalmMotion, PalmMove, PalmPair, SupportFunction


def everything() -> list[object]:
    egg = SupportFunction.named("egg")
    plan = palpate.plan_turn(egg, 30.0, limits=palpate.PalmLimits(smallest_phi2_rad=0.5))
    moves = [PalmMove.rotate(0.1, 1), PalmMove.open_one(2, 0.1, 1), PalmMove.open_and_rotate(0.1, 0.2, 1)]
    nested = PalmMove.back_and_forth(3, [*moves, PalmMove.open(0.1, 1), PalmMove.wait(1)])
    start = PalmPair(0.6, 1.1, (0.01, 0.02), (-0.01, 0.0))
    jumpy = palpate.simulate(SupportFunction.named("stone"), PalmMotion.random(2, 60), rate_hz=10, with_forces=True)
    assert jumpy.jumps
    gaps = palpate.Touchpad(dropout=0.2, noise_sd_m=1e-4)
    log, truth = palpate.simulate(egg, plan, touchpad=gaps, rate_hz=10, with_stated_noise=True)
    result = palpate.reconstruct(log)
    return [
        egg,
        SupportFunction.from_outline([(0, 0), (0.06, 0), (0.03, 0.01), (0, 0.04)]),
        start,
        *moves,
        nested,
        plan,
        plan.motion,
        plan.motion.with_bases((0.01, 0), (0, 0)),
        palpate.plan_jump_free(egg, 3, 30.0),
        PalmMotion.schedule(start, [nested]),
        PalmMotion.squeeze_and_rotate(20),
        PalmMotion.random(2**64 - 1, 20),
        PalmMotion.through([(0, 0.5, 1), (2, 0.6, 1.2)]),
        palpate.PalmLimits(),
        gaps,
        palpate.Touchpad.interlink(),
        *palpate.EnergyLandscape(egg, start).stable_poses(),
        *palpate.follow(SupportFunction.named("square"), PalmPair(0.2, 0.9), PalmPair(1.9, 0.9), 0.0)[1],
        jumpy,
        *jumpy.jumps,
        palpate.Rig.parse("palm1.zero_mm = 0.3\nangles.sign1 = -1"),
        log,
        truth,
        result,
        result.symmetry,
        palpate.reconstruct(palpate.Log.from_csv(LOGS / "stone_zigzag_oracle.csv")),
        *palpate.reconstruct(log, method="ode").doubts,
        palpate.compare(result, truth),
        palpate.posterior(log, result),
        palpate.calibrate([log]),
        palpate.Information.of(log, truth.shape, truth.psi_rad, 1e-4),
        *palpate.sweep_jobs('kind = "simulate"\nobjects.mixed = {}\ntouchpads = [{}]\n'),
    ]


def test_what_comes_back_is_the_same() -> None:
    for thing in everything():
        for protocol in (2, pickle.HIGHEST_PROTOCOL):
            back = pickle.loads(pickle.dumps(thing, protocol))
            assert type(back) is type(thing)
            assert back == thing, thing
            assert repr(back) == repr(thing)
        assert copy.deepcopy(thing) == thing


def test_a_result_keeps_its_log_and_its_residuals(result: palpate.Result) -> None:
    back = pickle.loads(pickle.dumps(result))
    assert back.log == result.log
    assert back.summary == result.summary
    np.testing.assert_array_equal(back.residual1, result.residual1)


def test_a_landscape_is_laid_out_anew(egg: SupportFunction) -> None:
    landscape = palpate.EnergyLandscape(egg, PalmPair(0.7, 1.6))
    back = pickle.loads(pickle.dumps(landscape))
    assert back.stable_poses() == landscape.stable_poses()


def test_errors_survive_the_way_back_from_a_worker() -> None:
    with pytest.raises(palpate.ReadError) as caught:
        palpate.Log.from_numpy(time_s=[0, 1])
    back = pickle.loads(pickle.dumps(caught.value))
    assert str(back) == str(caught.value)
    assert (back.file, back.line, back.column, back.problem) == (
        *(caught.value.file, caught.value.line, caught.value.column),
        caught.value.problem,
    )
