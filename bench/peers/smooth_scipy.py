"""Smoothing by `scipy.optimize.least_squares`: numpy residuals of all samples at once and their exact sparse derivatives."""

import time

import numpy as np
import problem
from scipy.optimize import least_squares
from scipy.sparse import csr_array


def solve(given, tolerance):
    began = time.perf_counter()
    samples, unknowns = given.samples, given.unknowns
    # A row of contact or balance has the coefficients and its own psi, a row of the prior one coefficient.
    own = np.hstack([np.tile(np.arange(unknowns), (samples, 1)), unknowns + np.arange(samples)[:, None]])
    columns = np.concatenate([np.tile(own.ravel(), 3), np.arange(unknowns)])
    rows = np.concatenate([np.arange(3 * samples) * (unknowns + 1), 3 * samples * (unknowns + 1) + np.arange(unknowns + 1)])
    shape = (3 * samples + unknowns, unknowns + samples)
    last = [None, None]

    def evaluate(x):
        if last[0] is None or not np.array_equal(last[0], x):
            last[:] = [x.copy(), given.evaluate(x)]
        return last[1]

    def jacobian(x):
        _, by_shape, by_psi = evaluate(x)
        blocks = [np.hstack([a, p[:, None]]).ravel() for a, p in zip(by_shape, by_psi)]
        return csr_array((np.concatenate([*blocks, 1 / given.prior_m]), columns, rows), shape=shape)

    found = least_squares(
        lambda x: evaluate(x)[0],
        given.start(),
        jacobian,
        x_scale="jac",
        ftol=float(tolerance),
        xtol=None,
        gtol=None,
        tr_solver="lsmr",
        tr_options={"regularize": False},
    )
    return time.perf_counter() - began, found.x, found.nfev


problem.serve(solve)
