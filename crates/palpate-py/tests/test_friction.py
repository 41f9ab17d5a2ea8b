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
    assert palpate.reconstruct(log).friction is None
