"""Equations 19 to 21 of Moll & Erdmann (2001) with SciPy.

Started with the piece of a log that ``cargo xtask bench-peers`` writes; each line that comes in asks for one run,

    METHOD TOLERANCE

and is answered by the seconds that ``scipy.integrate.solve_ivp`` took, and r1, r2 and ψ at each sample, one after
another. The spline through the readings is made beforehand.
"""

import json
import sys
import time
from math import cos, sin
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import PPoly, make_interp_spline


def signals(times_s, channels):
    """Values and rates of the channels, as one piecewise polynomial: a single call gives all."""
    values = [PPoly.from_spline(make_interp_spline(times_s, channel, k=5)) for channel in channels]
    rates = [np.vstack([np.zeros(one.c.shape[1]), one.derivative().c]) for one in values]
    return PPoly(np.stack([*(one.c for one in values), *rates], axis=2), values[0].x)


def equations(felt):
    """The rates of (r1, r2, ψ)."""

    def slope(time_s, state):
        phi1, phi2, s1, s2, phi1_rate, phi2_rate, s1_rate, s2_rate = felt(time_s).tolist()
        r1, r2, _ = state.tolist()
        sin1, cos1, sin2, cos2, sin12 = sin(phi1), cos(phi1), sin(phi2), cos(phi2), sin(phi1 + phi2)
        general_d2 = s1 * cos2 - s2
        general_r2_rate = -s1_rate * sin2 - s1 * cos2 * phi2_rate
        general_d2_rate = s1_rate * cos2 - s1 * sin2 * phi2_rate - s2_rate
        numerator = general_r2_rate * cos1 - general_d2_rate * sin1 + general_d2 * phi2_rate * sin12 / sin2
        psi_rate = numerator / (r1 * sin12 + (r2 - s1 * sin2) * sin1 + general_d2 * cos1)
        d1, d2 = (r1 * cos2 + r2) / sin2 - s1, -(r2 * cos2 + r1) / sin2 + s2
        return [-d1 * (phi1_rate - psi_rate), -d2 * (phi1_rate + phi2_rate - psi_rate), psi_rate]

    return slope


def main():
    """Answers until nothing more is asked."""
    piece = json.loads(Path(sys.argv[1]).read_text())
    times_s = np.array(piece["time_s"])
    slope = equations(signals(times_s, [piece[name] for name in ("phi1_rad", "phi2_rad", "s1_m", "s2_m")]))
    start = np.array([piece["start_r1_m"], piece["start_r2_m"], 0.0])
    for line in sys.stdin:
        method, tolerance = line.split()
        rtol = float(tolerance)
        atol = rtol * np.array([start[0], start[0], 1.0])
        began = time.perf_counter()
        solved = solve_ivp(slope, times_s[[0, -1]], start, method, t_eval=times_s, rtol=rtol, atol=atol)
        seconds = time.perf_counter() - began
        if solved.success:
            print(seconds, *solved.y.ravel().tolist(), flush=True)
        else:
            print("error", solved.message, flush=True)


if __name__ == "__main__":
    main()
