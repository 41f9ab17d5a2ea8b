"""Palms with friction: what is simulated, and what a result says of it."""

import numpy as np
import pytest

import palpate


def motion() -> np.ndarray:
    t = np.linspace(0.0, 10.0, 201)
    return np.column_stack([t, 0.9 + 0.3 * np.sin(0.7 * t), 1.3 + 0.4 * np.sin(0.9 * t)])


def test_an_object_rolls_on_the_palm_that_holds_it() -> None:
    egg = palpate.SupportFunction.named("egg")
    _, slides = palpate.simulate(egg, motion())
    log, rolls = palpate.simulate(egg, motion(), friction=(0.5, 0.0))
    assert np.abs(slides.psi_rad - rolls.psi_rad).max() > 0.05
    # Rolling on palm 1 needs no shape.
    s1, s2, phi1, phi2 = log.s1_m, log.s2_m, log.phi1_rad, log.phi2_rad
    rate = s2 / (s2 - s1 * np.cos(phi2))
    steps = np.diff(phi1) + 0.5 * (rate[1:] + rate[:-1]) * np.diff(phi2)
    assert np.allclose(np.diff(rolls.psi_rad), steps, atol=2e-5)


def test_one_number_is_for_both_palms() -> None:
    egg = palpate.SupportFunction.named("egg")
    both = palpate.simulate(egg, motion(), friction=0.2)
    each = palpate.simulate(egg, motion(), friction=(0.2, 0.2))
    assert np.array_equal(both.log.s1_m, each.log.s1_m)
    with pytest.raises(palpate.SimulateError, match="friction"):
        palpate.simulate(egg, motion(), friction=-0.1)


def test_without_friction_a_result_has_none() -> None:
    egg = palpate.SupportFunction.named("egg")
    log, _ = palpate.simulate(egg, palpate.plan_turn(egg, 40.0), rate_hz=5)
    result = palpate.reconstruct(log)
    assert result.friction is None
    assert result.com_strips is None


def test_measured_forces_give_the_weight() -> None:
    egg = palpate.SupportFunction.named("egg")
    plan = palpate.plan_turn(egg, 40.0)
    log, _ = palpate.simulate(egg, plan, rate_hz=5, mass_kg=0.05, with_forces=True)
    result = palpate.reconstruct(log)
    assert result.forces is not None
    assert result.forces["mass_kg"] == pytest.approx(0.05, rel=1e-3)
    assert result.forces["weight_sd_n"] < 1e-3
    # Without friction nothing tells the contact modes.
    assert np.isnan(result.mode1).all()
    assert result.mode2.shape == result.time.shape
    without, _ = palpate.simulate(egg, plan, rate_hz=5)
    assert palpate.reconstruct(without).forces is None


def test_an_object_is_carried_round_by_palms_with_friction() -> None:
    egg = palpate.SupportFunction.named("egg")
    friction = {"mu1": 0.1, "mu2": 0.3, "mu1_sd": 0.001, "mu2_sd": 0.001}
    plan = palpate.plan_turn(egg, 40.0, friction=friction)
    _, truth = palpate.simulate(egg, plan, rate_hz=10, friction=(0.1, 0.3))
    turned = abs(truth.psi_rad[-1] - truth.psi_rad[0])
    assert plan.full_turn == (turned >= 2.0 * np.pi - 1e-6)
    assert palpate.plan_turn(egg, 40.0, friction=0.05).full_turn
    with pytest.raises(KeyError, match="mu2"):
        palpate.plan_turn(egg, 40.0, friction={"mu1": 0.1})
    with pytest.raises(palpate.MotionError, match="friction"):
        palpate.plan_turn(egg, 40.0, friction=-0.1)
