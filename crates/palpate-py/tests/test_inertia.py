"""Fast palms: what is simulated, and what a result says of it."""

import pickle

import pytest

import palpate

RADIUS_M = 0.02


def fast(speed: float | None = 8.0) -> palpate.Simulation:
    stone = palpate.SupportFunction.named("stone").translated(2e-3, 1e-3)
    return palpate.simulate(
        stone,
        palpate.PalmMotion.random(3, 40.0, 0.6),
        touchpad=palpate.Touchpad(noise_sd_m=5e-5),
        rate_hz=100,
        speed=speed,
        gyration_radius_m=RADIUS_M if speed else None,
        damping_per_s=0.3 if speed else 0.0,
    )


def test_a_speed_divides_the_time_and_lets_the_object_swing() -> None:
    log, truth = fast()
    assert log.time_s[-1] == pytest.approx(5.0)
    slow = fast(None).truth
    same_palms = slow.psi_rad[:: len(slow.psi_rad) // len(truth.psi_rad)]
    assert abs(same_palms[: len(truth.psi_rad)] - truth.psi_rad[: len(same_palms)]).max() > 1e-3


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
