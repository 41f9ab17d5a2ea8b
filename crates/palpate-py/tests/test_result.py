"""Reconstruction: what goes in, what comes out, what is refused."""

from __future__ import annotations

import json
import sys
import urllib.parse
import urllib.request
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from conftest import LOGS
from numpy.testing import assert_allclose, assert_array_equal

import palpate


def test_the_egg_is_found(result: palpate.Result, simulation: palpate.Simulation, egg: palpate.SupportFunction) -> None:
    assert result.certified
    assert result.com_certified
    assert result.reason == ""
    assert result.doubts == []
    errors = palpate.compare(result, simulation.truth)
    assert errors.rms_r_m < 2e-5
    assert errors.rms_form_m <= errors.rms_r_m
    assert errors.rms_psi_rad < 2e-3
    assert_allclose(result.shape.perimeter_m, egg.perimeter_m, atol=5e-5)
    assert "certified: shape, motion and centre of mass" in repr(result)


def test_columns_fit_each_other(result: palpate.Result) -> None:
    n = len(result.psi)
    assert result.theta.shape == result.r.shape == result.r_sd.shape == result.touches.shape == (720,)
    assert result.boundary.shape == (720, 2)
    assert result.time.shape == result.psi_sd.shape == result.com_sd.shape == result.residual1.shape == (n,)
    assert result.com.shape == (n, 2)
    assert result.psi[0] == 0
    assert_allclose(result.r, result.shape.r(result.theta), rtol=1e-12)
    assert_allclose(result.boundary, result.shape.boundary(result.theta), rtol=1e-9, atol=1e-12)
    assert_allclose(result.curvature_radius, result.shape.v(result.theta), rtol=1e-9, atol=1e-12)
    assert np.all(result.r_sd[result.touches > 0] > 0)
    assert_allclose(np.std(result.residual1), result.sensor_sd_m, rtol=0.2)


def test_a_symmetry_completes_the_boundary(triangle: palpate.Result) -> None:
    symmetry = triangle.symmetry
    assert triangle.certified
    assert (symmetry.order, symmetry.mirror) == (3, True)
    assert (symmetry.probability or 0) > 0.9
    assert (symmetry.deviation_sd_m or 0) > 0
    assert "the same after 1/3 of a turn and in a mirror" in str(symmetry)
    assert triangle.summary["symmetry"]["order"] == 3
    # What a contact passed over itself, and its copies.
    assert np.all(triangle.touches[triangle.felt_itself] > 0)
    assert 0.5 < np.mean(triangle.felt_itself) < 0.95 < triangle.coverage
    assert_allclose(triangle.r, np.roll(triangle.r, 240), atol=1e-12)
    assert "1/3 of a turn" in triangle._repr_html_()


def test_an_egg_is_its_own_mirror_image_and_a_pebble_is_not(result: palpate.Result) -> None:
    assert (result.symmetry.order, result.symmetry.mirror) == (1, True)
    assert result.symmetry == result.symmetry
    pebble = palpate.SupportFunction.named("pebble")
    pad = palpate.Touchpad(noise_sd_m=1e-4)
    felt = palpate.simulate(pebble, palpate.plan_turn(pebble, 40.0), touchpad=pad, rate_hz=10)
    other = palpate.reconstruct(felt.log)
    assert (other.symmetry.order, other.symmetry.mirror, other.symmetry.deviation_sd_m) == (1, False, None)
    assert other.symmetry != result.symmetry


def test_error_bars_hold_the_truth(result: palpate.Result, simulation: palpate.Simulation) -> None:
    truth = simulation.truth
    turn = float(np.angle(np.mean(np.exp(1j * (truth.psi_rad - result.psi)))))
    misfit = np.abs(result.r - truth.shape.rotated(turn).r(result.theta))
    assert np.mean(misfit < 4 * result.r_sd + 1e-6) > 0.95


def test_the_summary_is_that_of_the_command_line(result: palpate.Result, tmp_path: Path) -> None:
    result.save(tmp_path / "out")
    assert json.loads((tmp_path / "out" / "summary.json").read_text()) == result.summary
    assert result.summary["certified"] is result.certified
    assert result.summary["samples"] == len(result.psi)
    assert result.summary["version"] == palpate.__version__


def test_a_result_folder_reads_back(result: palpate.Result, simulation: palpate.Simulation, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    result.save(folder, truth=simulation.truth, title="An <egg>")
    assert {path.name for path in folder.iterdir()} == {"report.html", "shape.csv", "motion.csv", "summary.json"}
    page = (folder / "report.html").read_text()
    assert "An &lt;egg&gt;" in page
    assert page == result.report_html(truth=simulation.truth, title="An <egg>")
    assert "truth" in json.loads((folder / "summary.json").read_text())
    read = palpate.Result.load(folder)
    for name in ("theta", "r", "r_sd", "boundary", "psi", "psi_sd", "com", "com_sd", "theta1", "piece", "touches"):
        assert_array_equal(getattr(read, name), getattr(result, name), err_msg=name)
    assert_allclose(read.shape.harmonics_m, result.shape.harmonics_m, atol=1e-12)
    assert (read.certified, read.reason, read.seconds) == (result.certified, result.reason, result.seconds)
    assert read.log is None
    assert np.isnan(read.residual1).all()
    with pytest.raises(palpate.InputError, match="has no log"):
        read.report_html()


def test_nothing_of_others_is_overwritten(result: palpate.Result, tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(palpate.WriteError, match=r"thesis\.tex"):
        result.save(tmp_path)
    with pytest.raises(palpate.ReadError, match="no such file"):
        palpate.Result.load(tmp_path)
    with pytest.raises(palpate.ReadError, match="no such folder"):
        palpate.Truth.load(tmp_path / "none")


def test_a_truth_folder_reads_back(simulation: palpate.Simulation, tmp_path: Path) -> None:
    simulation.truth.save(tmp_path / "egg.truth")
    assert palpate.Truth.load(tmp_path / "egg.truth") == simulation.truth


def test_jumps_are_told() -> None:
    log = palpate.Log.from_csv(LOGS / "stone_zigzag_oracle.csv")
    result = palpate.reconstruct(log)
    truth = palpate.Truth.load(LOGS / "stone_zigzag_oracle.truth")
    assert result.certified
    assert len(result.jumps) == 8
    assert result.piece[-1] == 8
    assert all(jump.physical and jump.height_drop_m > 0 for jump in result.jumps)
    assert [jump.time_s for jump in result.jumps] == result.summary["jumps"]
    assert palpate.compare(result, truth).rms_r_m < 1e-6


def test_what_cannot_be_certified_is_no_error() -> None:
    # Nobody can feel a circle turn.
    motion, pad = palpate.PalmMotion.random(1, 20), palpate.Touchpad(noise_sd_m=1e-4)
    log = palpate.simulate(palpate.SupportFunction(0.03), motion, touchpad=pad, rate_hz=3).log
    result = palpate.reconstruct(log)
    assert not result.certified
    assert result.reason == "; ".join(str(doubt) for doubt in result.doubts)
    uncertain = next(doubt for doubt in result.doubts if doubt.kind == "uncertain-orientation")
    assert uncertain.text.startswith("the orientation is known only to")
    assert uncertain.values.keys() == {"sd_rad", "largest_sd_rad"}
    assert uncertain.values["largest_sd_rad"] > uncertain.values["sd_rad"] > 0.02
    assert not uncertain.concerns_center_of_mass_only
    assert [doubt["kind"] for doubt in result.summary["doubts"]] == [doubt.kind for doubt in result.doubts]
    assert "NOT certified" in repr(result)
    assert "NOT certified" in result._repr_html_()


def test_doubts_come_back_from_a_folder(tmp_path: Path) -> None:
    log = palpate.simulate(palpate.SupportFunction.named("egg"), palpate.PalmMotion.random(1, 20), rate_hz=5).log
    result = palpate.reconstruct(log, method="ode")
    assert [(doubt.kind, doubt.values) for doubt in result.doubts] == [("uncertified-method", {"method": "ode"})]
    result.save(tmp_path / "out")
    assert palpate.Result.load(tmp_path / "out").doubts == result.doubts
    # An older version wrote the words alone.
    path = tmp_path / "out" / "summary.json"
    summary = json.loads(path.read_text())
    del summary["doubts"]
    path.write_text(json.dumps(summary))
    read = palpate.Result.load(tmp_path / "out")
    assert (read.certified, read.reason) == (False, result.reason)
    assert [(doubt.kind, doubt.text, doubt.values) for doubt in read.doubts] == [("reported", result.reason, {})]
    summary["certified"] = True
    path.write_text(json.dumps(summary))
    read = palpate.Result.load(tmp_path / "out")
    assert (read.certified, read.com_certified, read.reason) == (True, False, result.reason)
    assert read.doubts[0].concerns_center_of_mass_only


def test_options_do_what_they_say(simulation: palpate.Simulation, result: palpate.Result) -> None:
    log, truth = simulation
    eight = palpate.reconstruct(log, harmonics=8, sensor_sd_m=1e-4)
    assert eight.shape.harmonics_m.shape == (8, 2)
    assert eight.sensor_sd_m == 1e-4
    twice = palpate.reconstruct(log, min_touches=2)
    assert_allclose(twice.touches, np.where(result.touches < 2, 0, result.touches))
    for method in ["ode", "quadrature"]:
        old = palpate.reconstruct(log, method=method)
        assert not old.certified
        assert "neither error bars nor a certificate" in old.reason
        assert palpate.compare(old, truth).rms_r_m < 1e-3
    start = palpate.reconstruct_from(log, truth.shape, truth.psi_rad)
    assert_allclose(start.r, result.r, atol=2e-6)
    bound = palpate.cramer_rao_bound_m(log, truth.shape, truth.psi_rad, 1e-4)
    assert bound is not None
    assert 1e-7 < bound < 1e-5
    assert palpate.cramer_rao_bound_m(log, truth.shape, [0.0], 1e-4) is None


def test_the_number_of_threads_does_not_matter(simulation: palpate.Simulation, result: palpate.Result) -> None:
    assert palpate.reconstruct(simulation.log, threads=1) == result
    assert palpate.reconstruct(simulation.log, threads=3) == result


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"harmonics": 1}, "the number of harmonics must be from 2 to 64, not 1"),
        ({"harmonics": 65}, "the number of harmonics must be from 2 to 64, not 65"),
        ({"sensor_sd_m": 0.0}, "must be a positive number of metres, not 0"),
        ({"sensor_sd_m": float("nan")}, "must be a positive number of metres, not NaN"),
        ({"harmonics": -3}, "-3 is out of range"),
        ({"harmonics": 2**70}, "out of range"),
        ({"method": "magic"}, "method must be 'likelihood', 'ode' or 'quadrature', not 'magic'"),
        ({"threads": 0}, "threads must be from 1 to 1024"),
    ],
)
def test_options_out_of_range_are_refused(
    simulation: palpate.Simulation, options: dict[str, object], words: str
) -> None:
    with pytest.raises(palpate.PalpateError, match=words):
        palpate.reconstruct(simulation.log, **options)  # type: ignore[arg-type]


def test_logs_and_truths_that_do_not_fit_are_refused(simulation: palpate.Simulation, result: palpate.Result) -> None:
    log, truth = simulation
    with pytest.raises(palpate.ReconstructError, match="5 samples with both contacts seen; at least 12"):
        palpate.reconstruct(log[:5])
    with pytest.raises(palpate.ReconstructError, match="the start has 3 orientations and the log 401 samples"):
        palpate.reconstruct_from(log, truth.shape, [0, 1, 2])
    short = palpate.Truth(truth.theta_rad, truth.r_m, truth.time_s[:9], truth.psi_rad[:9], truth.com_m[:9])
    for use in (lambda: palpate.compare(result, short), lambda: result.report_html(truth=short)):
        with pytest.raises(palpate.CompareError, match="do not belong to the same log"):
            use()
    with pytest.raises(palpate.InputError, match="psi_rad differ in length"):
        palpate.Truth(truth.theta_rad, truth.r_m, truth.time_s, truth.psi_rad[:9], truth.com_m)


def test_a_notebook_shows_verdict_and_outline(result: palpate.Result) -> None:
    html = result._repr_html_()
    assert "certified: shape, motion and centre of mass" in html
    assert "<svg" in html


def test_the_information_of_a_log_is_what_the_error_bars_are_made_of() -> None:
    egg = palpate.SupportFunction.named("egg")
    pad = palpate.Touchpad(noise_sd_m=1e-4)
    log, truth = palpate.simulate(egg, palpate.plan_turn(egg, 40.0), touchpad=pad, rate_hz=10)
    best = palpate.Information.of(log, truth.shape, truth.psi_rad, 1e-4)
    assert best.rms_r_sd_m == pytest.approx(palpate.cramer_rao_bound_m(log, truth.shape, truth.psi_rad, 1e-4))
    assert best.covariance_m2.shape == (2 * best.order + 1, 2 * best.order + 1)
    angles_rad = np.arange(1, best.order + 1) * 0.7
    row = np.concatenate([[1.0], np.cos(angles_rad), np.sin(angles_rad)])
    assert best.r_sd_m(0.7) == pytest.approx(np.sqrt(row @ best.covariance_m2 @ row))
    np.testing.assert_allclose(best.r_sd_m([0.7, 0.7]), best.r_sd_m(0.7))
    sd_m, change = best.weakest_direction()
    assert sd_m**2 == pytest.approx(np.linalg.eigvalsh(best.covariance_m2)[-1])
    assert change.harmonics_m.shape == (best.order, 2)
    result = palpate.reconstruct(log)
    found = palpate.posterior(log, result)
    np.testing.assert_allclose(found.r_sd_m(result.theta), result.r_sd, rtol=0.1)
    with pytest.raises(palpate.InputError, match="orientations"):
        palpate.Information.of(log, truth.shape, [0.0], 1e-4)


def test_results_are_tables(result: palpate.Result, tmp_path: Path) -> None:
    result.save(tmp_path / "saved")
    motion, shape = result.to_pandas(), result.to_pandas("shape")
    for frame, name in ((motion, "motion"), (shape, "shape")):
        file = pd.read_csv(tmp_path / "saved" / f"{name}.csv")
        written = frame.reset_index()
        assert list(written)[: len(list(file))] == list(file)
        for column in file:
            assert_allclose(written[column], file[column], atol=1e-12)
    assert_array_equal(motion.index, result.time)
    assert_array_equal(motion["residual1_m"], result.residual1)
    assert shape.index.name == "theta_rad"
    with pytest.raises(palpate.InputError, match="'motion' or 'shape'"):
        result.to_pandas("jumps")  # type: ignore[arg-type]


def test_the_motion_is_an_animation(result: palpate.Result, tmp_path: Path) -> None:
    gif = result.animation()
    assert gif.startswith(b"GIF89a")
    # At the end of a cell it would be shown, as bytes.
    assert result.animation(tmp_path / "films" / "egg.gif") is None
    assert (tmp_path / "films" / "egg.gif").read_bytes() == gif
    result.save(tmp_path / "saved")
    with pytest.raises(palpate.InputError, match="has no log"):
        palpate.Result.load(tmp_path / "saved").animation()


def test_the_report_is_shown_in_a_notebook_or_a_browser(
    result: palpate.Result, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[str] = []

    def open_page(address: str) -> bool:
        opened.append(address)
        return True

    monkeypatch.setattr("webbrowser.open", open_page)
    monkeypatch.delitem(sys.modules, "ipykernel", raising=False)
    result.show(title="shown")
    page = Path(urllib.request.url2pathname(urllib.parse.urlparse(opened[0]).path))
    assert "<h1>shown</h1>" in page.read_text(encoding="utf-8")
    page.unlink()
    displayed: list[dict[str, Any]] = []
    monkeypatch.setitem(sys.modules, "ipykernel", sys)
    monkeypatch.setattr("IPython.display.display", lambda data, raw: displayed.append(data))
    result.show(height=500)
    frame = displayed[0]["text/html"]
    assert frame.startswith('<iframe srcdoc="&lt;!doctype html&gt;')
    assert 'height="500"' in frame
    assert len(opened) == 1
