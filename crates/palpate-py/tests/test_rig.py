"""Rigs: files, constants that are estimated with the shape, conventions that are applied to logs."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import palpate

ZERO_M = 0.3e-3
TEXT = """
[palm1]
zero_mm = 0.3
zero_sd_um = 20
direction = "to_base"
length_mm = 55.5
[angles]
phi2_zero_deg = 1
sign2 = -1
[clock]
offset_ms = 3
"""


def changed(log: palpate.Log, **columns: object) -> palpate.Log:
    return palpate.Log.from_numpy({**log.to_numpy(), **columns})


@pytest.fixture(scope="module")
def distorted(simulation: palpate.Simulation) -> palpate.Log:
    return changed(simulation.log, s1_m=simulation.log.s1_m + ZERO_M)


@pytest.fixture(scope="module")
def found(distorted: palpate.Log) -> palpate.Result:
    return palpate.reconstruct(distorted, rig=palpate.Rig())


def test_a_rig_says_what_its_file_says() -> None:
    rig = palpate.Rig.parse(TEXT)
    assert rig.zero_m == (0.3e-3, 0.0)
    assert rig.zero_sd_m == (20e-6, 0.5e-3)
    assert (rig.scale, rig.scale_sd) == ((1.0, 1.0), (0.01, 0.01))
    assert (rig.surface_offset_m, rig.surface_offset_sd_m) == ((0.0, 0.0), (0.5e-3, 0.5e-3))
    assert_allclose(rig.phi_zero_rad, (0.0, np.radians(1)))
    assert_allclose(rig.phi_zero_sd_rad, np.radians([0.5, 0.5]))
    assert (rig.clock_offset_s, rig.clock_offset_sd_s) == (3e-3, 0.0)
    assert repr(rig) == (
        "<Rig: zero 0.3 ± 0.02 and 0 ± 0.5 mm, scale 1 ± 0.01 and 1 ± 0.01, surface offset 0 ± 0.5 and 0 ± 0.5 mm, "
        "phi zero 0 ± 0.008727 and 0.017453 ± 0.008727 rad, clock offset 3 ± 0 ms, conventions of its own>"
    )


def test_a_rig_file_reads_back(tmp_path: Path) -> None:
    rig, path = palpate.Rig.parse(TEXT), tmp_path / "rig.toml"
    path.write_text(rig.to_toml())
    assert palpate.Rig.read(path) == rig == palpate.Rig.read(str(path))
    assert rig != palpate.Rig()
    assert palpate.Rig.parse("") == palpate.Rig.parse(palpate.Rig.template()) == palpate.Rig()
    exact = palpate.Rig.exact()
    assert exact.zero_sd_m == exact.scale_sd == exact.surface_offset_sd_m == exact.phi_zero_sd_rad == (0.0, 0.0)
    assert exact != palpate.Rig()


@pytest.mark.parametrize("rig", [palpate.Rig(), palpate.Rig.exact(), palpate.Rig.parse(TEXT)])
def test_a_rig_survives_pickling(rig: palpate.Rig) -> None:
    back = pickle.loads(pickle.dumps(rig))
    assert back == rig
    assert repr(back) == repr(rig)


def test_a_wrong_rig_file_is_refused_with_place_and_remedy(tmp_path: Path, simulation: palpate.Simulation) -> None:
    path = tmp_path / "rig.toml"
    path.write_text("[palm1]\nzero_m = 0.3\n")
    uses = (lambda: palpate.Rig.read(path), lambda: palpate.reconstruct(simulation.log, rig=path))
    for use in uses:
        with pytest.raises(palpate.ReadError) as caught:
            use()
        problem = "0.3 m is beyond 0.1 m; did you mean zero_mm?"
        assert str(caught.value) == f"{path}, line 2, key palm1.zero_m: {problem}"
        assert (caught.value.file, caught.value.line) == (str(path), 2)
        assert (caught.value.column, caught.value.problem) == ("palm1.zero_m", problem)
    with pytest.raises(palpate.ReadError, match=r"none\.toml: no such file; check the path"):
        palpate.Rig.read(tmp_path / "none.toml")
    with pytest.raises(palpate.ReadError, match=r"the rig, line 1, key palm1\.zero: the key has no unit"):
        palpate.Rig.parse("palm1.zero = 0.3")
    with pytest.raises(TypeError):
        palpate.reconstruct(simulation.log, rig=0.3)  # type: ignore[arg-type]


def test_the_zero_of_a_pad_is_found_with_the_shape(
    found: palpate.Result, simulation: palpate.Simulation, tmp_path: Path
) -> None:
    assert found.certified
    assert found.calibration is not None
    zero = found.calibration["s1_zero_m"]
    assert abs(zero.value - ZERO_M) < 5 * zero.sd < 0.5e-3
    assert (zero.name, zero.stated, zero.prior_sd) == ("s1_zero_m", 0.0, 0.5e-3)
    assert found.calibration["clock_offset_s"].sd == 0.0
    assert_allclose([found.size_sd, found.offset_sd_m], np.array([0.01, 0.5e-3]) / np.sqrt(2))
    assert palpate.compare(found, simulation.truth).rms_r_m < 1e-4
    # From a file, the same.
    path = tmp_path / "rig.toml"
    path.write_text(palpate.Rig.template())
    assert palpate.reconstruct(found.log or simulation.log, rig=str(path)) == found


def test_the_constants_are_told(found: palpate.Result, tmp_path: Path) -> None:
    assert found.calibration is not None
    zero = found.calibration["s1_zero_m"]
    told = found.summary["calibration"]["s1_zero_m"]
    assert told == {"value": zero.value, "sd": zero.sd, "stated": zero.stated, "prior_sd": zero.prior_sd}
    assert (found.summary["size_sd"], found.summary["offset_sd_m"]) == (found.size_sd, found.offset_sd_m)
    assert repr(found).endswith(", rig estimated>")
    assert "s1 zero" in found._repr_html_()
    assert "clock" not in found._repr_html_()
    assert repr(zero).startswith("<CalibrationConstant: s1_zero_m 3.")
    found.save(tmp_path / "out")
    read = palpate.Result.load(tmp_path / "out")
    assert read.calibration == found.calibration
    assert (read.size_sd, read.offset_sd_m) == (found.size_sd, found.offset_sd_m)


def test_a_result_keeps_its_calibration_when_pickled(found: palpate.Result) -> None:
    back = pickle.loads(pickle.dumps(found))
    assert back == found
    assert back.calibration == found.calibration
    assert (back.size_sd, back.offset_sd_m, back.summary) == (found.size_sd, found.offset_sd_m, found.summary)
    assert repr(back) == repr(found)
    assert found.calibration is not None
    assert list(back.calibration) == list(found.calibration)


def test_without_a_rig_readings_are_taken_as_they_are(result: palpate.Result, simulation: palpate.Simulation) -> None:
    assert (result.calibration, result.size_sd, result.offset_sd_m) == (None, 0.0, 0.0)
    assert result.summary["calibration"] == {}
    assert "rig" not in repr(result)
    for rig in (None, palpate.Rig.exact()):
        assert palpate.reconstruct(simulation.log, rig=rig) == result


def test_a_known_start_and_the_older_methods_take_a_rig(
    distorted: palpate.Log, found: palpate.Result, simulation: palpate.Simulation
) -> None:
    truth = simulation.truth
    near = palpate.reconstruct_from(distorted, truth.shape, truth.psi_rad, rig=palpate.Rig())
    assert near.calibration is not None
    assert found.calibration is not None
    zero = found.calibration["s1_zero_m"]
    assert abs(near.calibration["s1_zero_m"].value - zero.value) < 2 * zero.sd
    stated = palpate.Rig.parse("palm1.zero_mm = 0.3")
    old = palpate.reconstruct(distorted, method="ode", rig=stated)
    assert old.calibration is None
    assert palpate.compare(old, truth).rms_r_m == pytest.approx(
        palpate.compare(palpate.reconstruct(simulation.log, method="ode"), truth).rms_r_m, rel=1e-3
    )


EXACT = """
[palm1]
zero_sd_m = 0
scale_sd = 0
surface_offset_sd_m = 0
direction = "to_base"
length_m = 0.125
base_x_m = 0.001
[palm2]
zero_sd_m = 0
scale_sd = 0
surface_offset_sd_m = 0
[angles]
phi1_zero_sd_rad = 0
phi2_zero_sd_rad = 0
sign1 = -1
"""


def test_conventions_are_applied_once(simulation: palpate.Simulation, tmp_path: Path) -> None:
    log, rig = simulation.log, palpate.Rig.parse(EXACT)
    base_m = np.column_stack([np.full(len(log), 0.001), np.zeros(len(log))])
    nowhere = np.zeros(len(log))
    wanted = changed(log, base1_x_m=base_m[:, 0], base1_y_m=nowhere, base2_x_m=nowhere, base2_y_m=nowhere)
    written = changed(log, phi1_rad=-log.phi1_rad, s1_m=0.125 - log.s1_m)
    expected, found = palpate.reconstruct(wanted), palpate.reconstruct(written, rig=rig)
    assert found.log is not None
    assert_array_equal(found.log.phi1_rad, wanted.phi1_rad)
    assert_allclose(found.log.s1_m, wanted.s1_m, atol=1e-16)
    assert_array_equal(found.log.base1_m, base_m)
    assert_allclose(found.r, expected.r, atol=1e-9)
    # The log of the result, its copies, and a log that was read by the rig are not turned again.
    for again in (found.log, pickle.loads(pickle.dumps(found.log)), found.log[:]):
        assert palpate.reconstruct(again, rig=rig) == found
    written.to_csv(tmp_path / "log.csv")
    read = palpate.Log.from_csv(tmp_path / "log.csv", rig=rig)
    assert read == found.log
    assert palpate.reconstruct(read, rig=rig) == found
    with pytest.raises(palpate.InputError, match="was read by the conventions of another rig"):
        palpate.reconstruct(read, rig=palpate.Rig.parse("angles.sign2 = -1"))


def test_a_palm_that_counts_negative_angles_is_read_by_its_rig(simulation: palpate.Simulation, tmp_path: Path) -> None:
    log, path = simulation.log, tmp_path / "log.csv"
    columns = [log.time_s, log.phi1_rad, -log.phi2_rad, log.s1_m, log.s2_m]
    header = "time_s,phi1_rad,phi2_rad,s1_m,s2_m"
    np.savetxt(path, np.column_stack(columns), fmt="%.17g", delimiter=",", header=header, comments="")
    with pytest.raises(palpate.ReadError, match="is negative"):
        palpate.Log.from_csv(path)
    (tmp_path / "rig.toml").write_text("angles.sign2 = -1\n")
    assert palpate.Log.from_csv(path, rig=tmp_path / "rig.toml") == log
    with pytest.raises(palpate.InputError, match=r"sample 1 \(counted from 1\): with sign2 = -1 of the rig"):
        palpate.reconstruct(log, rig=tmp_path / "rig.toml")
