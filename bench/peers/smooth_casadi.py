"""Smoothing by IPOPT with CasADi's exact derivatives: one symbolic sample, mapped over all of them."""

import time

import casadi
import numpy as np
import problem


def solve(given):
    began = time.perf_counter()
    order, samples, unknowns = given.harmonics, given.samples, given.unknowns
    a, psi, data = casadi.SX.sym("a", unknowns), casadi.SX.sym("psi"), casadi.SX.sym("data", 7)
    phi1, sin1, sin12, sin2, cos2, s1, s2 = casadi.vertsplit(data)
    theta1 = phi1 - psi - np.pi / 2
    # Contact 2 is at theta1 + phi2 - pi.
    cos, sin = [casadi.cos(theta1)], [casadi.sin(theta1)]
    cos.append(sin[0] * sin2 - cos[0] * cos2)
    sin.append(-(sin[0] * cos2 + cos[0] * sin2))
    r, d = [a[0], a[0]], [0, 0]
    for i in (0, 1):
        c, s = 1, 0
        for k in range(1, order + 1):
            c, s = c * cos[i] - s * sin[i], s * cos[i] + c * sin[i]
            r[i] += a[k] * c + a[order + k] * s
            d[i] += k * (a[k] * s - a[order + k] * c)
    squares = (
        (((r[0] * cos2 + r[1]) / sin2 - d[0] - s1) / given.sensor_m) ** 2
        + (((r[1] * cos2 + r[0]) / sin2 + d[1] - s2) / given.sensor_m) ** 2
        + ((d[0] * sin12 + d[1] * sin1) / given.balance_m) ** 2
    )
    sample = casadi.Function("sample", [a, psi, data], [squares])
    all_a, all_psi = casadi.MX.sym("a", unknowns), casadi.MX.sym("psi", samples)
    table = np.vstack(
        [given.phi1, np.sin(given.phi1), np.sin(given.phi1 + given.phi2), np.sin(given.phi2), np.cos(given.phi2), given.s1, given.s2]
    )
    # In units of the noise the coefficients are of the size that the solver likes; the tolerance is that of the gradient.
    a_m = all_a * given.sensor_m
    cost = casadi.sum2(sample.map(samples)(a_m, all_psi.T, table)) + casadi.sumsqr(a_m / given.prior_m)
    options = {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-3, "nlp_scaling_method": "none"}}
    solver = casadi.nlpsol("solver", "ipopt", {"x": casadi.vertcat(all_a, all_psi), "f": cost}, options)
    unit = np.concatenate([np.full(unknowns, given.sensor_m), np.ones(samples)])
    start = given.start() / unit
    low, high = np.full(start.size, -np.inf), np.full(start.size, np.inf)
    # The common rotation is free: one orientation stays.
    low[unknowns] = high[unknowns] = start[unknowns]
    found = solver(x0=start, lbx=low, ubx=high)
    if not solver.stats()["success"]:
        raise RuntimeError(solver.stats()["return_status"])
    return time.perf_counter() - began, np.asarray(found["x"]).ravel() * unit, solver.stats()["iter_count"]


problem.serve(solve)
