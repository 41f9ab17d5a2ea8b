"""The other rig: a pivoting grasp."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import palpate

CENTER_M = (0.004, 0.003)
WAYS = [[0.5, 0.62], [0.5, 0.35], [0.5, 0.66], [0.5, 0.3]]


@pytest.fixture(scope="module")
def felt() -> tuple[palpate.Strokes, palpate.Truth]:
    egg = palpate.SupportFunction.named("egg", 0.03).translated(*CENTER_M)
    return palpate.simulate_strokes(egg, WAYS, center_of_mass_m=CENTER_M, noise_sd_m=1e-4, arm_noise_sd_m=2e-5, seed=3)


def test_strokes_are_reconstructed_and_saved(felt: tuple[palpate.Strokes, palpate.Truth], tmp_path: Path) -> None:
    log, truth = felt
    found = palpate.reconstruct_strokes(log)
    assert found.certified
    assert found.doubts == []
    assert found.shape.mean_radius_m == pytest.approx(0.03, abs=5e-5)
    assert len(found.psi) == len(log) == len(log.time_s)
    # The orientation is known up to a constant, and nowhere without a contact.
    assert np.isnan(found.psi[np.isnan(log.s_m)]).all()
    off = found.psi - truth.psi_rad
    off = off[~np.isnan(off)]
    turned = np.angle(np.exp(1j * (off - off[0])))
    assert np.sqrt(np.mean((turned - turned.mean()) ** 2)) < 0.01
    assert found.center_of_mass_direction_rad is not None
    found.save(tmp_path / "found", truth=truth)
    assert json.loads((tmp_path / "found" / "summary.json").read_text())["truth"]["rms_r_m"] < 1e-4
    assert found.summary["rig"] == "pivot"
    assert "Against the truth" in (tmp_path / "found" / "report.html").read_text(encoding="utf-8")
    assert repr(found).startswith("<StrokesResult: certified")


def test_a_log_reads_back_and_is_taken_as_a_file(felt: tuple[palpate.Strokes, palpate.Truth], tmp_path: Path) -> None:
    log, _ = felt
    log.to_csv(tmp_path / "strokes.csv")
    again = palpate.Strokes.from_csv(tmp_path / "strokes.csv")
    np.testing.assert_array_equal(again.pivot_m, log.pivot_m)
    np.testing.assert_array_equal(again.s_m, log.s_m)
    assert (again.name, again.swing_period_s) == ("strokes.csv", None)
    found = palpate.reconstruct_strokes(tmp_path / "strokes.csv", calibrated=True, harmonics=4)
    assert found.log.name == "strokes.csv"
    assert "strokes.csv" in found.report_html()
    columns = palpate.Strokes(log.time_s, log.pivot_m[:, 0], log.pivot_m[:, 1], log.s_m, swing_period_s=0.5)
    assert columns.swing_period_s == 0.5


def test_planned_strokes_feel_what_was_promised(felt: tuple[palpate.Strokes, palpate.Truth]) -> None:
    egg = palpate.SupportFunction.named("egg", 0.03).translated(*CENTER_M)
    strokes, coverage = palpate.plan_strokes(egg, center_of_mass_m=CENTER_M, most_strokes=1)
    assert len(strokes) == len(coverage) == 1
    log, _ = palpate.simulate_strokes(egg, strokes, center_of_mass_m=CENTER_M)
    assert palpate.reconstruct_strokes(log, calibrated=True).coverage == pytest.approx(coverage[0], abs=0.03)
    # By a result: it says in which direction its centre of mass is, and not how far without a period of swinging.
    found = palpate.reconstruct_strokes(felt[0])
    with pytest.raises(palpate.InputError, match="center_of_mass_m"):
        palpate.plan_strokes(found)
    angle = found.center_of_mass_direction_rad
    assert angle is not None
    center = (0.005 * np.cos(angle), 0.005 * np.sin(angle))
    _, expected = palpate.plan_strokes(found, center_of_mass_m=center)
    assert expected[-1] > 0.5
    with pytest.raises(palpate.InputError, match="in order"):
        palpate.plan_strokes(egg, along_m=(0.6, 0.4))


def test_strokes_are_known_while_they_are_felt(felt: tuple[palpate.Strokes, palpate.Truth]) -> None:
    log, _ = felt
    live = palpate.LiveStrokes()
    estimates = [live.push(time_s, x, y, s) for time_s, (x, y), s in zip(log.time_s, log.pivot_m, log.s_m, strict=True)]
    assert estimates[0].reason == "too few samples for a first search"
    assert estimates[0].shape is None
    assert np.isnan(estimates[0].psi_rad)
    assert estimates[0].samples == 1
    certified = [estimate for estimate in estimates if estimate.certified]
    assert certified
    last = certified[-1]
    assert last.shape is not None
    assert last.shape.mean_radius_m == pytest.approx(0.03, abs=1e-4)
    assert 0 < last.r_sd_m < 1e-4
    assert 0.5 < last.coverage <= 1
    assert any(0 < estimate.psi_sd_rad < 0.1 for estimate in certified)
    assert not all(estimate.on_unfelt for estimate in certified)
    assert live.push(-1.0, 0.5, 0.03, None).refused == 1
    assert last.time_s <= log.time_s[-1]
    np.testing.assert_array_equal(live.finish().r, palpate.reconstruct_strokes(log).r)
    assert repr(last).startswith("<StrokesEstimate after ")
    with pytest.raises(palpate.ReconstructError, match="at least 30"):
        palpate.LiveStrokes().finish()


def test_what_is_no_log_of_strokes_is_named(tmp_path: Path) -> None:
    with pytest.raises(palpate.InputError, match="differ in length"):
        palpate.Strokes([0.0, 1.0], [0.0], [0.0], [0.0])
    with pytest.raises(palpate.ReconstructError, match="30"):
        palpate.reconstruct_strokes(palpate.Strokes([0.0, 1.0], [0.0, 0.1], [0.03, 0.03], [0.0, 0.1]))
    (tmp_path / "rig.toml").write_text("[pad]\ntilt_deg = 3\n")
    with pytest.raises(palpate.ReadError, match="tilt_deg"):
        palpate.reconstruct_strokes(palpate.Strokes([0.0], [0.0], [0.0], [0.0]), rig=tmp_path / "rig.toml")
    with pytest.raises(palpate.InputError):
        palpate.simulate_strokes(palpate.SupportFunction.named("egg", 0.03), WAYS, friction=-1.0)
