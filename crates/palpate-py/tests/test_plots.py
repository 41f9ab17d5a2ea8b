"""Pictures with matplotlib: what is drawn, and where."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
from conftest import LOGS
from numpy.testing import assert_allclose

import palpate


@pytest.fixture(autouse=True)
def _no_figures_left() -> Iterator[None]:
    yield
    plt.close("all")


def lines(ax: Any) -> dict[str, Any]:
    return {line.get_label(): line for line in ax.lines}


def test_the_outline_is_drawn_in_millimetres(result: palpate.Result, simulation: palpate.Simulation) -> None:
    _, ax = plt.subplots()
    assert result.plot(ax=ax, truth=simulation.truth, magnify=20) is ax
    drawn = lines(ax)
    assert_allclose(drawn["found"].get_xydata()[:720], 1e3 * result.boundary)
    # Turned as the motions say, the true outline lies on the one that was found.
    assert_allclose(drawn["true"].get_xydata(), drawn["found"].get_xydata(), atol=0.05)
    assert "never felt" not in drawn
    assert ax.patches[0].get_label() == "95 % band, drawn 20 times wider"
    assert ax.get_title() == "certified"
    ax.figure.canvas.draw()


def test_what_was_never_felt_is_dashed() -> None:
    result = palpate.reconstruct(palpate.Log.from_csv(LOGS / "stone_zigzag_oracle.csv"))
    ax = result.plot()
    assert lines(ax)["never felt"].get_linestyle() == "--"
    found = lines(ax)["found"].get_xdata()[:720]
    assert np.array_equal(np.isnan(found), result.touches == 0)
    upper, lower = result.plot_motion()
    # A gap at each of the eight jumps.
    assert np.isnan(lines(upper)["found"].get_ydata()).sum() == 8
    assert lower.get_xlabel() == "time (s)"
    upper.figure.canvas.draw()


def test_the_motion_is_drawn_with_the_truth(result: palpate.Result, simulation: palpate.Simulation) -> None:
    upper, lower = result.plot_motion(truth=simulation.truth)
    assert_allclose(lines(upper)["true"].get_ydata(), np.degrees(result.psi), atol=0.5)
    assert_allclose(lines(lower)["X found"].get_ydata(), 1e3 * result.com[:, 0])
    with pytest.raises(palpate.InputError, match="two axes"):
        result.plot_motion(axes=[upper])


def test_a_shape_is_drawn(egg: palpate.SupportFunction) -> None:
    ax = egg.plot(color="black")
    assert egg.plot(ax) is ax
    assert ax.lines[0].get_color() == "black"


def test_a_truth_of_another_log_is_refused(result: palpate.Result, simulation: palpate.Simulation) -> None:
    t = simulation.truth
    short = palpate.Truth(t.theta_rad, t.r_m, t.time_s[:9], t.psi_rad[:9], t.com_m[:9])
    with pytest.raises(palpate.CompareError, match="do not belong to the same log"):
        result.plot(truth=short)


def test_without_matplotlib_the_message_says_what_to_install(
    result: palpate.Result, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    with pytest.raises(ImportError, match=r"install palpate\[plot\]"):
        result.plot()


def test_a_log_is_drawn(simulation: palpate.Simulation) -> None:
    log = simulation.log
    upper, lower = log.plot()
    assert_allclose(lines(upper)["φ₁"].get_xydata(), np.stack([log.time_s, np.degrees(log.phi1_rad)], axis=1))
    assert_allclose(lines(lower)["s₂"].get_ydata(), 1e3 * log.s2_m)
    assert lower.get_xlabel() == "time (s)"
    assert log.plot([upper, lower])[0] is upper
    with pytest.raises(palpate.InputError, match="two axes"):
        log.plot([upper])


def test_residuals_are_drawn(result: palpate.Result, tmp_path: Path) -> None:
    upper, lower = result.plot_residuals()
    assert_allclose(upper.lines[0].get_ydata(), 1e6 * result.residual1)
    assert_allclose([line.get_ydata()[0] for line in lower.lines[1:]], 2e6 * result.sensor_sd_m * np.array([-1, 1]))
    assert "palm 2" in lower.get_title()
    result.save(tmp_path / "saved")
    with pytest.raises(palpate.InputError, match="no residuals"):
        palpate.Result.load(tmp_path / "saved").plot_residuals()


@pytest.mark.parametrize("own", [True, False])
def test_the_legend_is_not_cut_off(own: bool, result: palpate.Result, simulation: palpate.Simulation) -> None:
    ax: Any = result.plot(None if own else plt.subplots(figsize=(6.4, 4.8))[1], truth=simulation.truth, magnify=100)
    figure = ax.figure
    figure.canvas.draw()
    (legend,) = figure.legends if own else [ax.get_legend()]
    box, sheet = legend.get_window_extent(), figure.bbox
    assert sheet.x0 <= box.x0 < box.x1 <= sheet.x1
    assert sheet.y0 <= box.y0 < box.y1 <= sheet.y1
    assert len(legend.get_texts()) == 4
    # Nor does it lie on what belongs to the axes.
    assert own == (box.y1 <= ax.get_tightbbox().y0 + 1)
