"""Fast palms: what is simulated, and what a result says of it."""

import pickle

import numpy as np
import pytest

import palpate

RADIUS_M = 0.02


SPEED = 6.0


def fast(speed: float | None = SPEED) -> palpate.Simulation:
    return palpate.simulate(
        palpate.SupportFunction.named("stone"),
        palpate.PalmMotion.random(3, 40.0, 0.5),
        touchpad=palpate.Touchpad(noise_sd_m=5e-5),
        rate_hz=100 if speed else 100 / SPEED,
        speed=speed,
        gyration_radius_m=RADIUS_M,
        damping_per_s=0.3,
    )


def test_a_speed_divides_the_time_and_lets_the_object_swing() -> None:
    (log, truth), (slow_log, slow_truth) = fast(), fast(None)
    assert np.allclose(log.time_s * SPEED, slow_log.time_s)
    assert np.allclose(log.phi1_rad, slow_log.phi1_rad)
    assert np.abs(truth.psi_rad - slow_truth.psi_rad).max() > 1e-2


def test_a_result_tells_the_inertia() -> None:
    log, _ = fast()
    result = palpate.reconstruct(log)
    assert result.com_certified
    assert result.inertia is not None
    assert result.inertia["gyration_radius_m"] == pytest.approx(RADIUS_M, rel=0.01)
    assert result.inertia["damping_per_s"] == pytest.approx(0.3, abs=0.1)
    assert pickle.loads(pickle.dumps(result)).inertia == result.inertia


def test_what_is_not_simulated_is_refused() -> None:
    egg, motion = palpate.SupportFunction.named("egg"), palpate.PalmMotion.random(3, 40.0, 0.6)
    with pytest.raises(palpate.SimulateError, match="friction and inertia"):
        palpate.simulate(egg, motion, speed=2.0, friction=0.1)
    with pytest.raises(palpate.SimulateError, match="speed"):
        palpate.simulate(egg, motion, speed=0.0)
    with pytest.raises(palpate.SimulateError, match="damping"):
        palpate.simulate(egg, motion, speed=2.0, damping_per_s=-1.0)
