"""The smoothing problem that palpate and its peers solve (`cargo xtask bench-peers`), in numpy.

A file holds little-endian floats: N, K, the standard deviations of contacts and balance; the prior standard deviations of the
coefficients (a0, a1 ... aK, b1 ... bK) and their start; then phi1, phi2, s1, s2 and the start of psi at the N samples.
"""

import sys

import numpy as np


class Problem:
    """Unknown are the coefficients and psi, in this order; all lengths in metres, all angles in radians."""

    def __init__(self, path):
        numbers = np.fromfile(path, dtype="<f8")
        self.samples, self.harmonics = int(numbers[0]), int(numbers[1])
        self.sensor_m, self.balance_m = numbers[2:4]
        self.unknowns = 2 * self.harmonics + 1
        self.prior_m, self.coefficients = numbers[4 : 4 + 2 * self.unknowns].reshape(2, -1)
        columns = numbers[4 + 2 * self.unknowns :].reshape(5, self.samples)
        self.phi1, self.phi2, self.s1, self.s2, self.psi = columns

    def start(self):
        return np.concatenate([self.coefficients, self.psi])

    def residuals(self, x):
        """Contact 1, contact 2 and balance of all samples, then the prior."""
        return self.evaluate(x)[0]

    def evaluate(self, x):
        """Residuals, their derivatives by the coefficients (3, N, 2K + 1) and by psi (3, N)."""
        a = x[: self.unknowns]
        theta1 = self.phi1 - x[self.unknowns :] - np.pi / 2
        k = np.arange(1, self.harmonics + 1)
        one = np.ones((self.samples, 1))
        zero = np.zeros((self.samples, 1))
        r, d, bent = [], [], []
        for theta in (theta1, theta1 + self.phi2 - np.pi):
            # One sine and cosine for each sample, powers of them for the harmonics.
            turn = np.cumprod(np.repeat(np.exp(1j * theta)[:, None], self.harmonics, axis=1), axis=1)
            cos, sin = turn.real, turn.imag
            r.append(np.hstack([one, cos, sin]))
            d.append(np.hstack([zero, k * sin, -k * cos]))
            # r - v = -r''
            bent.append(np.hstack([zero, k * k * cos, k * k * sin]))
        sin2, cos2 = np.sin(self.phi2)[:, None], np.cos(self.phi2)[:, None]
        sin1, sin12 = np.sin(self.phi1)[:, None], np.sin(self.phi1 + self.phi2)[:, None]

        def mixed(r, d):
            """Contacts and balance are linear in r and d at both contacts."""
            return (
                ((r[0] * cos2 + r[1]) / sin2 - d[0]) / self.sensor_m,
                ((r[1] * cos2 + r[0]) / sin2 + d[1]) / self.sensor_m,
                (d[0] * sin12 + d[1] * sin1) / self.balance_m,
            )

        by_shape = mixed(r, d)
        # theta falls as psi grows: dr/dpsi = d, dd/dpsi = v - r.
        turned = ([d[i] @ a[:, None] for i in (0, 1)], [-(bent[i] @ a[:, None]) for i in (0, 1)])
        by_psi = [column[:, 0] for column in mixed(*turned)]
        measured = (self.s1 / self.sensor_m, self.s2 / self.sensor_m, 0.0)
        values = [rows @ a - part for rows, part in zip(by_shape, measured)]
        return np.concatenate([*values, a / self.prior_m]), by_shape, by_psi

    def answer(self, seconds, x, steps):
        """The line that is waited for: seconds, cost, steps, coefficients."""
        residuals = self.residuals(x)
        numbers = [seconds, residuals @ residuals, float(steps), *x[: self.unknowns]]
        print(*(repr(float(number)) for number in numbers), flush=True)


def serve(solve):
    """Solves the problem of the first argument once for each line that comes in."""
    problem = Problem(sys.argv[1])
    for _ in sys.stdin:
        try:
            problem.answer(*solve(problem, *sys.argv[2:]))
        except Exception as error:  # noqa: BLE001 - whatever it is, it is the answer
            print("error", type(error).__name__, str(error).replace("\n", " "), flush=True)
