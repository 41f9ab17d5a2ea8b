"""What the tests share: one object, what was felt of it, and what came out."""

from __future__ import annotations

from pathlib import Path

import matplotlib
import pytest

import palpate

matplotlib.use("Agg")

ROOT = Path(__file__).parents[3]
LOGS = ROOT / "examples" / "logs"


@pytest.fixture(scope="session")
def egg() -> palpate.SupportFunction:
    return palpate.SupportFunction.named("egg", 0.03)


@pytest.fixture(scope="session")
def plan(egg: palpate.SupportFunction) -> palpate.PlannedMotion:
    return palpate.plan_turn(egg, 40.0)


@pytest.fixture(scope="session")
def simulation(egg: palpate.SupportFunction, plan: palpate.PlannedMotion) -> palpate.Simulation:
    pad = palpate.Touchpad(noise_sd_m=1e-4)
    return palpate.simulate(egg, plan, touchpad=pad, rate_hz=10, seed=1)


@pytest.fixture(scope="session")
def result(simulation: palpate.Simulation) -> palpate.Result:
    return palpate.reconstruct(simulation.log)


@pytest.fixture(scope="session")
def triangle() -> palpate.Result:
    motion = palpate.PalmMotion.random(5, 60)
    pad = palpate.Touchpad(noise_sd_m=5e-5)
    simulation = palpate.simulate(palpate.SupportFunction.named("triangle"), motion, touchpad=pad, rate_hz=20, seed=5)
    return palpate.reconstruct(simulation.log)
