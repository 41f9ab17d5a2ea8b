"""Rigs from their logs: of unknown objects, of a disc, and what each log contributed."""

from __future__ import annotations

import pickle
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

import palpate

NOISE_M = 5e-5
RADIUS_M = 0.02


@dataclass(frozen=True)
class Errors:
    """What the readings of a rig differ by."""

    zero_m: NDArray[np.float64]
    scale: NDArray[np.float64]
    phi_zero_rad: NDArray[np.float64]
    surface_m: NDArray[np.float64]

    @staticmethod
    def drawn(seed: int) -> Errors:
        """Errors that a rig of the default tolerances may have."""
        rig, rng = palpate.Rig(), np.random.default_rng(seed)
        sds = (rig.zero_sd_m, rig.scale_sd, rig.phi_zero_sd_rad, rig.surface_offset_sd_m)
        zero, scale, phi_zero, surface = (np.array(sd) * rng.standard_normal(2) for sd in sds)
        return Errors(zero, 1 + scale, phi_zero, surface)

    def constants(self) -> dict[str, float]:
        return {
            "s1_zero_m": self.zero_m[0],
            "s2_zero_m": self.zero_m[1],
            "scale_ratio": self.scale[0] - self.scale[1],
            "phi1_zero_rad": self.phi_zero_rad[0],
            "phi2_zero_rad": self.phi_zero_rad[1],
            "surface_difference_m": self.surface_m[0] - self.surface_m[1],
        }

    def put_into(self, log: palpate.Log) -> palpate.Log:
        """The log as this rig would have written it."""
        # The surfaces meet where the lines through the base points do not.
        along = np.array([log.phi1_rad, log.phi1_rad + log.phi2_rad])
        u1, u2 = np.stack([np.cos(along), np.sin(along)], axis=1)
        inwards = np.stack([[-u1[1], u1[0]], [u2[1], -u2[0]]]).transpose(2, 0, 1)
        meet = np.linalg.solve(inwards, np.broadcast_to(self.surface_m[:, None], (len(log), 2, 1)))[:, :, 0]
        s1, s2 = (s + np.sum(meet.T * u, axis=0) for s, u in ((log.s1_m, u1), (log.s2_m, u2)))
        return palpate.Log(
            log.time_s,
            log.phi1_rad + self.phi_zero_rad[0],
            log.phi2_rad + self.phi_zero_rad[1],
            self.scale[0] * s1 + self.zero_m[0],
            self.scale[1] * s2 + self.zero_m[1],
        )


def felt(name: str, seed: int) -> palpate.Log:
    shape = palpate.SupportFunction.named(name, 0.03)
    pad = palpate.Touchpad(noise_sd_m=NOISE_M)
    return palpate.simulate(shape, palpate.plan_turn(shape, 40.0), touchpad=pad, rate_hz=10, seed=seed).log


def disc(seed: int) -> palpate.Log:
    """A disc between palms that open, close and turn: it touches both as far from where they meet."""
    time, rng = np.arange(0.0, 20.0, 0.05), np.random.default_rng(seed)
    phi1, phi2 = 0.5 + 0.2 * np.sin(time), 1.4 + 0.7 * np.sin(0.9 * time)
    s = RADIUS_M / np.tan(phi2 / 2) + NOISE_M * rng.standard_normal((2, len(time)))
    return palpate.Log(time, phi1, phi2, *s)


@pytest.fixture(scope="module")
def errors() -> Errors:
    return Errors.drawn(4)


@pytest.fixture(scope="module")
def logs(errors: Errors) -> list[palpate.Log]:
    return [errors.put_into(felt(name, seed)) for seed, name in enumerate(("egg", "pebble", "stone"))]


@pytest.fixture(scope="module")
def found(logs: list[palpate.Log]) -> palpate.RigCalibration:
    return palpate.calibrate(logs)


def require_within_error_bars(found: palpate.RigCalibration, truth: dict[str, float]) -> None:
    for name, value in truth.items():
        constant = found.constants[name]
        assert constant.name == name
        assert abs(constant.value - value) < 4 * constant.sd < 4 * constant.prior_sd, (constant, value)


def test_constants_of_several_logs_lie_within_their_error_bars(
    found: palpate.RigCalibration, errors: Errors, logs: list[palpate.Log]
) -> None:
    assert (found.used, len(found.logs), found.drifted) == (3, 3, None)
    require_within_error_bars(found, errors.constants())
    zero = found.constants["s1_zero_m"]
    assert (zero.stated, zero.prior_sd) == (0.0, 0.5e-3)
    assert list(found.constants) == list(found.logs[0].constants)
    for log in found.logs:
        assert log.used
        assert (log.reason, log.name) == ("", None)
        assert log.residual_after_m is not None
        assert log.residual_before_m is not None
        assert log.residual_after_m < 1.2 * NOISE_M
        assert log.residual_before_m > 1.5 * log.residual_after_m
        assert log.constants["s1_zero_m"].sd > zero.sd
        assert log.drift is not None
        assert log.drift.constant in found.constants
        assert abs(log.drift.sds) < 4
    # What no log tells stays as it was.
    assert_allclose([found.size_sd, found.offset_sd_m], np.array([0.01, 0.5e-3]) / np.sqrt(2))


def test_the_rig_is_one_to_use_and_to_keep(
    found: palpate.RigCalibration, logs: list[palpate.Log], tmp_path: Path
) -> None:
    rig, zeros = found.rig, [found.constants[name] for name in ("s1_zero_m", "s2_zero_m")]
    assert_allclose(rig.zero_m, [zero.value for zero in zeros], rtol=1e-12)
    assert_allclose(rig.zero_sd_m, [zero.sd for zero in zeros], rtol=1e-12)
    (tmp_path / "rig.toml").write_text(rig.to_toml())
    assert palpate.Rig.read(tmp_path / "rig.toml") == rig
    result = palpate.reconstruct(logs[0], rig=rig)
    assert result.certified
    assert result.calibration is not None
    assert result.calibration["s1_zero_m"].sd <= zeros[0].sd


def test_it_says_what_was_found(found: palpate.RigCalibration) -> None:
    assert repr(found) == "<RigCalibration: calibrated by 3 of 3 logs; size to 0.71 % and 0.354 mm all around>"
    lines = str(found).splitlines()
    assert lines[0] == "calibrated by 3 of 3 logs"
    assert len(lines) == 1 + 6 + 3  # the clock is exact
    zero = found.constants["s1_zero_m"]
    assert lines[1] == f"s1 zero: {1e3 * zero.value:.4f} ± {1e3 * zero.sd:.4f} mm, stated 0.000 ± 0.500 mm"
    assert lines[7].startswith("log 0: 0.0")
    assert "mm left in the contacts" in repr(found.logs[0])
    assert repr(found.logs[0].drift).endswith("of its standard deviations>")


def test_a_log_at_odds_is_named_and_hopeless_ones_count_for_nothing(
    logs: list[palpate.Log], errors: Errors, tmp_path: Path
) -> None:
    moved = replace(errors, zero_m=errors.zero_m + np.array([0, 4e-4]))
    moved.put_into(felt("egg", 7)).to_csv(tmp_path / "moved.csv")
    hopeless = felt("stone", 8)[:10]
    found = palpate.calibrate([*logs[:2], palpate.Log.from_csv(tmp_path / "moved.csv"), hopeless])
    assert (found.used, found.drifted) == (3, 2)
    drift = found.logs[2].drift
    assert drift is not None
    assert drift.constant == "s2_zero_m"
    assert drift.difference == pytest.approx(4e-4, abs=1e-4)
    assert drift.sds > 4
    assert found.logs[2].name == "moved.csv"
    left_out = found.logs[3]
    assert not left_out.used
    assert left_out.reason
    assert left_out.constants == {}
    assert (left_out.residual_before_m, left_out.residual_after_m, left_out.drift) == (None, None, None)
    assert repr(left_out) == f"<LogContribution does not count: {left_out.reason}>"
    assert repr(found).endswith(", log 2 is at odds with the others>")
    assert "\nlog 2 (moved.csv): " in str(found)
    assert "\nlog 3 does not count: " in str(found)
    assert "\nlog 2 is at odds with the others: s2 zero differs by 0." in str(found)
    back = pickle.loads(pickle.dumps(found))
    assert (back, repr(back), str(back)) == (found, repr(found), str(found))
    assert back.logs == found.logs


def test_where_no_log_counts_the_rig_stays(logs: list[palpate.Log]) -> None:
    rig = palpate.Rig.parse("palm1.zero_mm = 0.3\nclock.offset_ms = 2")
    found = palpate.calibrate([logs[0][:10]], rig=rig)
    assert (found.used, found.rig) == (0, rig)
    assert repr(found).startswith("<RigCalibration: NOT calibrated, none of 1 logs counts;")


def test_everything_comes_back_from_a_pickle(found: palpate.RigCalibration) -> None:
    for thing in (found, *found.logs, found.logs[0].drift, found.rig, *found.constants.values()):
        back = pickle.loads(pickle.dumps(thing))
        assert type(back) is type(thing)
        assert back == thing
        assert repr(back) == repr(thing)
    assert found.logs[0] != found.logs[1]
    assert list(pickle.loads(pickle.dumps(found)).constants) == list(found.constants)


def test_a_disc_of_known_radius_tells_the_size_too() -> None:
    errors, rig = Errors.drawn(5), palpate.Rig()
    logs = [errors.put_into(disc(seed)) for seed in (1, 2)]
    told: list[tuple[str, float]] = []
    found = palpate.calibrate(
        iter(logs), known_radius_m=RADIUS_M, progress=lambda stage, share: told.append((stage, share))
    )
    assert told[-1] == ("done", 1.0)
    truth = errors.constants()
    assert found.constants["phi1_zero_rad"].sd == found.constants["phi1_zero_rad"].prior_sd
    del truth["phi1_zero_rad"]
    require_within_error_bars(found, truth)
    assert found.used == 2
    assert found.size_sd < 0.01 / np.sqrt(2)
    assert found.offset_sd_m < 0.8 * 0.5e-3 / np.sqrt(2)
    assert found.rig.scale_sd < rig.scale_sd
    assert all(log.residual_after_m is not None and log.residual_after_m < 1.2 * NOISE_M for log in found.logs)
    assert pickle.loads(pickle.dumps(found)) == found
    with pytest.raises(palpate.InputError, match=r"suggest a disc of \d+\.\d mm; check known_radius_m, or the .* rig$"):
        palpate.calibrate(logs, known_radius_m=0.03)


CONVENTIONS = "angles.sign1 = -1\npalm1.direction = 'to_base'\npalm1.length_m = 0.125\npalm1.scale_sd = 0.02\n"


def test_the_rig_keeps_its_conventions(tmp_path: Path) -> None:
    rig, log = palpate.Rig.parse(CONVENTIONS), disc(1)
    written = palpate.Log(log.time_s, -log.phi1_rad, log.phi2_rad, 0.125 - log.s1_m, log.s2_m)
    written.to_csv(tmp_path / "log.csv")
    (tmp_path / "rig.toml").write_text(CONVENTIONS)
    found = palpate.calibrate([written], rig=tmp_path / "rig.toml", known_radius_m=RADIUS_M)
    assert_allclose(found.rig.zero_m, (0, 0), atol=1e-4)
    read = palpate.Log.from_csv(tmp_path / "log.csv", rig=found.rig)
    assert_allclose(read.phi1_rad, log.phi1_rad)
    assert_allclose(read.s1_m, log.s1_m)
    # A log that was read by its rig is not turned again.
    again = palpate.calibrate([read], rig=rig, known_radius_m=RADIUS_M)
    assert (again.rig, again.constants) == (found.rig, found.constants)
    # Without a rig, the conventions are those that the logs were read by.
    alone = palpate.calibrate([read], known_radius_m=RADIUS_M)
    assert palpate.Log.from_csv(tmp_path / "log.csv", rig=alone.rig) == read
    with pytest.raises(palpate.InputError, match="by the conventions of different rigs"):
        palpate.calibrate([read, log], known_radius_m=RADIUS_M)
    with pytest.raises(palpate.InputError, match=r"^logs\[1\]: the log was read by the conventions of another rig"):
        palpate.calibrate([log, read], rig=palpate.Rig.parse("palm2.base_x_mm = 1"), known_radius_m=RADIUS_M)


def test_bad_arguments_are_refused(logs: list[palpate.Log], tmp_path: Path) -> None:
    log = logs[0]
    with pytest.raises(palpate.InputError, match="there is no log"):
        palpate.calibrate([])
    with pytest.raises(TypeError, match=r"give \[log\] for a single one"):
        palpate.calibrate(log)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="'str' object is not an instance of 'Log'"):
        palpate.calibrate(["trial.csv"])  # type: ignore[list-item]
    with pytest.raises(TypeError, match="positional"):
        palpate.calibrate([log], palpate.Rig())  # type: ignore[call-arg]
    with pytest.raises(palpate.InputError, match="every constant of the rig is exact"):
        palpate.calibrate([log], rig=palpate.Rig.exact())
    for radius_m in (0.0, -0.02, np.nan, np.inf):
        with pytest.raises(palpate.InputError, match="radius of the disc must be a positive number of metres"):
            palpate.calibrate([log], known_radius_m=radius_m)
    with pytest.raises(palpate.InputError, match="disc"):
        palpate.calibrate([log], known_radius_m=20.0)
    with pytest.raises(palpate.InputError, match="readings of the disc"):
        palpate.calibrate([log[:5]], known_radius_m=RADIUS_M)
    with pytest.raises(palpate.ReconstructError, match="sample 2"):
        palpate.calibrate([log[::-1]])
    with pytest.raises(palpate.ReadError, match=r"none\.toml: no such file"):
        palpate.calibrate([log], rig=tmp_path / "none.toml")
    with pytest.raises(palpate.InputError, match="threads must be from 1"):
        palpate.calibrate([log], threads=0)


def test_progress_never_decreases_and_what_it_raises_ends_the_call(logs: list[palpate.Log]) -> None:
    told: list[float] = []

    class EnoughError(Exception):
        pass

    def listener(stage: str, share: float) -> None:
        told.append(share)
        if share > 0.5:
            raise EnoughError(stage)

    with pytest.raises(EnoughError):
        palpate.calibrate(logs[:2], progress=listener)
    assert told == sorted(told)
    assert told[0] >= 0
