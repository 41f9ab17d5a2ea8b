"""The online estimator, and sources that are watched."""

import math
from pathlib import Path

import numpy as np
import pytest

import palpate

PLAN = "shape = 'egg'\nduration_s = 40\nrate_hz = 10\nspeed = 0\n"


def felt() -> palpate.Log:
    egg = palpate.SupportFunction.named("egg", 0.03)
    return palpate.simulate(egg, palpate.plan_turn(egg, 40.0), rate_hz=10).log


def pushed(log: palpate.Log) -> tuple[palpate.Live, list[palpate.LiveEstimate]]:
    live = palpate.Live()
    rows = zip(log.time_s, log.phi1_rad, log.phi2_rad, log.s1_m, log.s2_m, strict=True)
    return live, [live.push(*row) for row in rows]


def test_samples_are_taken_one_by_one_and_the_end_is_that_of_reconstruct() -> None:
    log = felt()
    live, estimates = pushed(log)
    first, last = estimates[0], estimates[-1]
    assert first.shape is None
    assert math.isnan(first.psi_rad)
    assert not first.certified
    assert first.reason
    assert last.certified
    assert last.com_certified
    assert last.reason == ""
    assert last.doubts == []
    assert (last.samples, last.refused, last.time_s) == (len(log), 0, log.time_s[-1])
    assert last.shape is not None
    assert abs(last.shape.perimeter_m - palpate.SupportFunction.named("egg", 0.03).perimeter_m) < 1e-4
    assert last.hypotheses == last.alternatives == 1
    assert not last.contradicted
    assert not last.ambiguous
    assert last.coverage > 0.9
    assert repr(last) == f"<LiveEstimate after {len(log)} samples: {100 * last.coverage:.0f} % felt, certified>"
    result, batch = live.finish(), palpate.reconstruct(log)
    assert np.array_equal(result.r, batch.r)
    assert np.array_equal(result.psi, batch.psi)
    assert abs(last.psi_rad - batch.psi[-1]) < 0.02
    assert np.hypot(*(np.array(last.com_m) - batch.com[-1])) < 1e-4


def test_a_contact_may_be_missing_and_what_is_no_sample_is_counted() -> None:
    live = palpate.Live()
    assert live.push(0.0, 1.0, 1.2, None, math.nan).samples == 1
    estimate = live.push(0.1, 1.0, 0.0, 0.03, 0.03)
    assert (estimate.samples, estimate.refused) == (1, 1)
    with pytest.raises(palpate.ReconstructError, match="samples with both contacts"):
        live.finish()


def test_a_source_is_watched_to_its_end(tmp_path: Path) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text(PLAN)
    watch = palpate.watch(f"sim:{plan}")
    estimates = list(watch)
    assert len(estimates) == 401
    assert estimates[-1].certified
    assert watch.losses == "nothing"
    assert watch.finish().certified
    rig = palpate.Rig.parse("[palm1]\nzero_sd_mm = 0.1\n")
    assert next(iter(palpate.watch(f"sim:{plan}", rig=rig))).samples == 1


@pytest.mark.parametrize("source", ["sim:", "missing.csv", "serial:/dev/null?baud=x"])
def test_what_is_no_source_is_refused(source: str) -> None:
    with pytest.raises(palpate.InputError, match=source.split("?")[0]):
        palpate.watch(source)
