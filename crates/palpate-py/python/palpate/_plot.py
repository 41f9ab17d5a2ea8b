"""Pictures with matplotlib. Imported when one is asked for, so that palpate needs no matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from palpate._palpate import Log, Result, SupportFunction, Truth

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

MM = 1e3
MICRO = 1e6
BAND = 1.959964
"""Half the width of a 95 % band, in standard deviations."""
FOUND = "#2a78c4"
TRUE = "#d9822b"
CENTER = "#c0392b"
NEVER = "#999999"
CONTACTS = ("#b0478c", "#d55e00")
"""Of palm 1 and palm 2, as in the report."""


def _new_axes(rows: int = 1) -> Any:
    try:
        import matplotlib.pyplot as plt
    except ImportError as error:
        raise ImportError("plots need matplotlib; install palpate[plot]") from error
    size = (6.4, 6.0) if rows == 1 else (8.0, 5.0)
    return plt.subplots(rows, 1, figsize=size, layout="constrained", sharex=rows > 1)[1]


def _finish_outline(ax: Axes) -> None:
    ax.plot([0], [0], "+", color=CENTER, markersize=10, markeredgewidth=1.5, label="centre of mass")
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_xlabel("x (mm)")
    ax.set_ylabel("y (mm)")


def _closed(values: NDArray[Any]) -> NDArray[Any]:
    return np.concatenate([values, values[:1]])


def plot_shape(shape: SupportFunction, ax: Axes | None = None, **style: Any) -> Axes:
    """Outline of a shape; see `SupportFunction.plot`."""
    ax = _new_axes() if ax is None else ax
    points = _closed(shape.boundary()) * MM
    ax.plot(points[:, 0], points[:, 1], **({"color": FOUND} | style))
    _finish_outline(ax)
    return ax


def _turn(result: Result, truth: Truth) -> float:
    """Angle by which the true object frame is turned against the reconstructed one."""
    if len(truth) != len(result.psi):
        from palpate import CompareError

        counts = f"the truth has {len(truth)} poses, the reconstruction {len(result.psi)}"
        raise CompareError(f"{counts}: they do not belong to the same log")
    return float(np.angle(np.mean(np.exp(1j * (truth.psi_rad - result.psi)))))


def plot_result(result: Result, ax: Axes | None, truth: Truth | None, magnify: float) -> Axes:
    """Outline of a result with its band; see `Result.plot`."""
    is_own = ax is None
    ax = _new_axes() if ax is None else ax
    points = _closed(result.boundary) * MM
    felt = _closed(result.touches) > 0
    theta = _closed(result.theta)
    half = (magnify * BAND * MM * _closed(result.r_sd))[:, None] * np.stack([np.cos(theta), np.sin(theta)], axis=1)
    label = "95 % band" if magnify == 1 else f"95 % band, drawn {magnify:g} times wider"
    for start, end in _runs(felt):
        inner, outer = (points - half)[start:end], (points + half)[start:end]
        ring = np.concatenate([outer, inner[::-1]])
        ax.fill(ring[:, 0], ring[:, 1], color=FOUND, alpha=0.3, linewidth=0, label=label)
        label = "_"
    if not felt.all():
        ax.plot(points[:, 0], points[:, 1], "--", color=NEVER, linewidth=1, label="never felt", zorder=1.5)
    if truth is not None:
        true = _closed(truth.shape.rotated(_turn(result, truth)).boundary()) * MM
        ax.plot(true[:, 0], true[:, 1], color=TRUE, linewidth=3.5, alpha=0.7, label="true")
    line = np.where(felt[:, None], points, np.nan)
    ax.plot(line[:, 0], line[:, 1], color=FOUND, linewidth=1.2, label="found")
    _finish_outline(ax)
    ax.set_title("certified" if result.certified else "NOT certified")
    if is_own:
        # The layout makes room for it.
        ax.get_figure().legend(loc="outside lower center", ncols=2, frameon=False, fontsize="small")  # type: ignore[union-attr]
    else:
        # Who gave the axes lays them out; beside a convex outline there is room in the corners.
        ax.legend(loc="best", fontsize="small")
    return ax


def _runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Start and end (exclusive) of each stretch of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return [(int(start), int(end)) for start, end in edges.reshape(-1, 2)]


def _two(axes: Sequence[Axes] | None, name: str) -> NDArray[Any]:
    both: NDArray[Any] = np.asarray(_new_axes(2) if axes is None else axes)
    if both.shape != (2,):
        from palpate import InputError

        raise InputError(f"{name} draws in two axes")
    return both


def plot_log(log: Log, axes: Sequence[Axes] | None) -> NDArray[Any]:
    """Palm angles and contact positions over time; see `Log.plot`."""
    both = _two(axes, "Log.plot")
    upper, lower = both
    palms = zip("₁₂", (log.phi1_rad, log.phi2_rad), (log.s1_m, log.s2_m), CONTACTS, strict=True)
    for number, angle, position, color in palms:
        upper.plot(log.time_s, np.degrees(angle), color=color, linewidth=1.2, label=f"φ{number}")
        # Dots show a reading between two gaps too.
        lower.plot(log.time_s, MM * position, ".-", color=color, linewidth=0.8, markersize=2, label=f"s{number}")
    upper.set_ylabel("palm angle (deg)")
    lower.set_ylabel("contact position (mm)")
    lower.set_xlabel("time (s)")
    for ax in both:
        ax.legend(fontsize="small")
    return both


def plot_residuals(result: Result, axes: Sequence[Axes] | None) -> NDArray[Any]:
    """Measured minus predicted contact positions over time; see `Result.plot_residuals`."""
    residuals = (result.residual1, result.residual2)
    if all(np.isnan(residual).all() for residual in residuals):
        from palpate import InputError

        raise InputError("this result has no residuals: they are not in the folder that it was read from")
    both = _two(axes, "plot_residuals")
    limit = 2 * MICRO * result.sensor_sd_m
    for number, (ax, residual, color) in enumerate(zip(both, residuals, CONTACTS, strict=True), start=1):
        ax.plot(result.time, MICRO * residual, ".", color=color, markersize=2)
        for level in (-limit, limit):
            ax.axhline(level, color=NEVER, linestyle="--", linewidth=1)
        seen = residual[~np.isnan(residual)]
        beyond = np.mean(np.abs(MICRO * seen) > limit) if len(seen) else 0.0
        ax.set_title(f"palm {number}: {100 * beyond:.1f} % beyond two standard deviations", fontsize="small")
        ax.set_ylabel("residual (µm)")
    both[1].set_xlabel("time (s)")
    return both


def plot_motion(result: Result, axes: Sequence[Axes] | None, truth: Truth | None) -> NDArray[Any]:
    """Orientation and centre of mass over time; see `Result.plot_motion`."""
    both = _two(axes, "plot_motion")
    upper, lower = both
    # Nothing is drawn over a jump.
    gaps = np.flatnonzero(np.diff(result.piece.astype(np.int64))) + 1
    time = np.insert(result.time, gaps, np.nan)

    def over_time(ax: Axes, values: NDArray[Any], sd: NDArray[Any], scale: float, color: str, label: str) -> None:
        middle, half = np.insert(scale * values, gaps, np.nan), np.insert(scale * BAND * sd, gaps, np.nan)
        ax.fill_between(time, middle - half, middle + half, color=color, alpha=0.3, linewidth=0)
        ax.plot(time, middle, color=color, linewidth=1.2, label=label)

    over_time(upper, result.psi, result.psi_sd, float(np.degrees(1)), FOUND, "found")
    over_time(lower, result.com[:, 0], result.com_sd, MM, FOUND, "X found")
    over_time(lower, result.com[:, 1], result.com_sd, MM, CENTER, "Y found")
    if truth is not None:
        # The whole turns between the two are of no meaning, and jumps may be counted differently.
        offset = truth.psi_rad - _turn(result, truth) - result.psi
        psi = result.psi + (offset + np.pi) % (2 * np.pi) - np.pi
        com = np.insert(truth.com_m * MM, gaps, np.nan, axis=0)
        beneath: dict[str, Any] = {"color": TRUE, "linewidth": 3.5, "alpha": 0.7, "zorder": 1.8}
        upper.plot(time, np.insert(np.degrees(psi), gaps, np.nan), label="true", **beneath)
        lower.plot(time, com[:, 0], label="true", **beneath)
        lower.plot(time, com[:, 1], label="_", **beneath)
    upper.set_ylabel("orientation ψ (deg)")
    lower.set_ylabel("centre of mass (mm)")
    lower.set_xlabel("time (s)")
    for ax in both:
        ax.legend(fontsize="small")
    return both
