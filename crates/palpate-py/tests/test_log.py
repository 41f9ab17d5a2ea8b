"""Palm logs, in and out."""

from __future__ import annotations

import gzip
import io
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from conftest import LOGS
from numpy.testing import assert_allclose, assert_array_equal

import palpate
from palpate import Log

EGG = LOGS / "egg_full_turn_oracle_n0.1mm.csv"


@pytest.fixture(scope="module")
def log() -> Log:
    return Log.from_csv(EGG)


def test_a_csv_file_is_read_as_numpy_reads_it(log: Log) -> None:
    table = pd.read_csv(EGG, comment="#")
    assert len(log) == len(table) == 2044
    assert log.name == EGG.name
    for name in ("time_s", "phi1_rad", "phi2_rad"):
        assert_array_equal(getattr(log, name), table[name])
    for name in ("s1", "s2"):
        assert_allclose(getattr(log, f"{name}_m"), 1e-3 * table[f"{name}_mm"], rtol=1e-15)
    assert log.base1_m.shape == (2044, 2)
    assert log.force1_n is None


def test_every_way_in_gives_the_same_log(log: Log, tmp_path: Path) -> None:
    log.to_csv(tmp_path / "log.csv")
    assert Log.from_csv(tmp_path / "log.csv") == log
    assert Log.from_csv(str(tmp_path / "log.csv")) == log
    assert Log.from_pandas(log.to_pandas()) == log
    assert Log.from_numpy(log.to_numpy()) == log
    assert Log.from_numpy(**log.to_numpy()) == log
    assert Log.from_numpy(log.to_pandas().to_records(index=False)) == log
    assert Log(log.time_s, log.phi1_rad, log.phi2_rad, log.s1_m, log.s2_m) == log
    assert Log(*(list(column) for column in log.to_numpy().values())) == log


def test_units_in_names_are_converted(log: Log) -> None:
    frame = log.to_pandas()
    other = pd.DataFrame(
        {
            "s2_mm": frame.s2_m * 1e3,
            "phi1_deg": np.degrees(frame.phi1_rad),
            "phi2_deg": np.degrees(frame.phi2_rad),
            "time_ms": frame.time_s * 1e3,
            "comment": "made by hand",
            "s1_cm": frame.s1_m * 1e2,
        }
    )
    with pytest.warns(palpate.ReadWarning, match="columns ignored: comment"):
        read = Log.from_pandas(other)
    assert read.notes == ["columns ignored: comment"]
    for name in ("time_s", "phi1_rad", "s1_m", "s2_m"):
        assert_allclose(getattr(read, name), getattr(log, name), rtol=1e-14)


def test_missing_contacts_are_nan_everywhere(log: Log, tmp_path: Path) -> None:
    frame = log.to_pandas()
    frame.loc[3:5, "s1_m"] = np.nan
    for variant in (frame, frame.convert_dtypes(), frame.astype({"s1_m": object}).where(frame.notna(), None)):
        read = Log.from_pandas(variant)
        assert_array_equal(np.isnan(read.s1_m), frame.s1_m.isna())
        assert read == Log.from_numpy({str(name): values for name, values in frame.items()})
    read.to_csv(tmp_path / "gaps.csv")
    assert Log.from_csv(tmp_path / "gaps.csv") == read


def test_optional_columns_come_along(log: Log, tmp_path: Path) -> None:
    n = len(log)
    sd = np.full(n, 1e-4)
    sd[0] = np.nan
    full = Log(
        log.time_s,
        log.phi1_rad,
        log.phi2_rad,
        log.s1_m,
        log.s2_m,
        s1_sd_m=sd,
        force2_n=np.ones(n),
        base1_m=np.tile([0.01, 0.0], (n, 1)),
        metadata={"sensor": "pads 3 and 4"},
    )
    assert full.s1_sd_m is not None
    assert_array_equal(full.s1_sd_m, sd)
    assert full.s2_sd_m is None
    assert_array_equal(full.base1_m[:, 0], 0.01)
    full.to_csv(tmp_path / "full.csv")
    read = Log.from_csv(tmp_path / "full.csv")
    assert read == full
    assert read.metadata == full.metadata == {"sensor": "pads 3 and 4"}
    assert list(full.to_pandas()) == [
        *("time_s", "phi1_rad", "phi2_rad", "s1_m", "s2_m"),
        *("base1_x_m", "base1_y_m", "base2_x_m", "base2_y_m", "s1_sd_m", "force2_n"),
    ]


def test_slices_are_logs(log: Log) -> None:
    thin = log[100:1900:3]
    assert len(thin) == 600
    assert_array_equal(thin.time_s, log.time_s[100:1900:3])
    assert len(log[5000:]) == 0
    assert_array_equal(log[::-1].s1_m, log.s1_m[::-1])
    assert repr(thin) == f"<Log: 600 samples in {thin.time_s[-1] - thin.time_s[0]:.2f} s, 600 with both contacts>"


def test_masks_and_indices_cut_a_log(log: Log) -> None:
    early = log[log.time_s < 10]
    assert_array_equal(early.time_s, log.time_s[log.time_s < 10])
    assert log[[True] * len(log)] == log
    assert log[np.array([0, 5, 7])].time_s.tolist() == log.time_s[[0, 5, 7]].tolist()
    with pytest.raises(IndexError):
        log[[True, False]]
    with pytest.raises(palpate.InputError, match="a slice, a mask or an array of indices"):
        log[3]


def test_file_objects_are_read(log: Log) -> None:
    with EGG.open() as text, EGG.open("rb") as binary:
        assert Log.from_csv(text) == log
        read = Log.from_csv(binary)
    assert read == log
    assert read.name == EGG.name
    assert Log.from_csv(io.BytesIO(gzip.compress(EGG.read_bytes()))) == log
    assert Log.from_csv(io.StringIO(EGG.read_text())).name is None
    with pytest.raises(palpate.ReadError, match=r"the file object, line 1, column s2: the name has no unit"):
        Log.from_csv(io.StringIO("time_s,phi1_rad,phi2_rad,s1_m,s2\n0,1,1,0.1,0.1\n"))
    with pytest.raises(palpate.InputError, match="path of a file, or from a file object"):
        Log.from_csv(3)  # type: ignore[arg-type]


def test_whatever_is_a_log_is_reconstructed(log: Log, tmp_path: Path) -> None:
    some = log[::4]
    some.to_csv(tmp_path / "some.csv")
    expected = palpate.reconstruct(some)
    frame = some.to_pandas()
    given: list[Any] = [
        tmp_path / "some.csv",
        str(tmp_path / "some.csv"),
        frame,
        frame.set_index("time_s"),
        some.to_numpy(),
    ]
    for thing in given:
        assert palpate.reconstruct(thing) == expected
    with (tmp_path / "some.csv").open() as file:
        found = palpate.reconstruct(file)
    assert found == expected
    assert found.log == some
    with pytest.raises(palpate.ReadError, match="no such file"):
        palpate.reconstruct(tmp_path / "none.csv")
    with pytest.raises(palpate.InputError, match="mapping of names to columns"):
        palpate.reconstruct(3)  # type: ignore[arg-type]
    # A rig that counts otherwise is asked before the log is judged.
    rig = palpate.Rig.parse(palpate.Rig.template())
    assert palpate.reconstruct(tmp_path / "some.csv", rig=rig) == palpate.reconstruct(some, rig=rig)


def test_a_notebook_shows_no_markup_of_the_file(log: Log) -> None:
    frame = log.to_pandas().assign(**{"<b>": 1})
    with pytest.warns(palpate.ReadWarning) as caught:
        read = Log.from_pandas(frame)
    assert "&lt;b&gt;" in read._repr_html_()
    # The line to look at is the one that read the log.
    assert [warning.filename for warning in caught] == [__file__]


START = pd.Timestamp("2026-11-24T20:31:30.123456789")


@pytest.mark.parametrize("zone", [None, "Europe/Berlin"])
@pytest.mark.parametrize("name", ["time", "time_ms", "timestamp", "Time [s]"])
def test_dates_are_seconds_since_the_first(log: Log, name: str, zone: str | None) -> None:
    seconds = log.time_s - log.time_s[0]
    dates = pd.DatetimeIndex(START + pd.to_timedelta(seconds, unit="s"), tz=zone)
    others = log.to_pandas().drop(columns="time_s")
    as_column = others.assign(**{name: dates})
    for frame in (as_column, as_column.set_index(name), others.set_axis(dates)):
        assert_allclose(Log.from_pandas(frame).time_s, seconds, atol=1e-9)
    lengths = pd.to_timedelta(log.time_s + 5.0, unit="s")
    as_column = others.assign(**{name: lengths})
    for frame in (as_column, as_column.set_index(name), others.set_axis(lengths)):
        assert_allclose(Log.from_pandas(frame).time_s, log.time_s + 5.0, atol=1e-9)


def test_dates_of_numpy_are_read_in_every_way(log: Log) -> None:
    arrays = log.to_numpy()
    time_s = arrays.pop("time_s")
    seconds = time_s - time_s[0]
    for unit, tolerance in (("ns", 1e-9), ("us", 1e-6), ("ms", 1e-3)):
        steps = np.round(seconds * {"ns": 1e9, "us": 1e6, "ms": 1e3}[unit]).astype("int64")
        dates = START.to_datetime64().astype(f"datetime64[{unit}]") + steps
        for values in (dates, steps.astype(f"timedelta64[{unit}]")):
            assert_allclose(Log.from_numpy(arrays, time=values).time_s, seconds, atol=tolerance)
            assert_allclose(Log(values, *arrays.values()).time_s, seconds, atol=tolerance)


def test_a_frame_may_have_time_as_its_index(log: Log) -> None:
    frame = log.to_pandas()
    assert Log.from_pandas(frame.set_index("time_s")) == log
    assert_allclose(Log.from_pandas(frame.set_index(frame.time_s.mul(1e3).rename("Time (ms)"))).time_s, log.time_s)
    # An index that is no time, or one beside a column of time, is left alone.
    assert Log.from_pandas(frame.set_axis(frame.index.rename("sample"))) == log
    dates = pd.DatetimeIndex(START + pd.to_timedelta(log.time_s, unit="s"))
    assert Log.from_pandas(frame.set_axis(dates)) == log
    with pytest.raises(palpate.ReadError, match="there is no column for time"):
        Log.from_pandas(frame.drop(columns="time_s"))


def test_dates_that_are_missing_or_of_another_quantity_are_refused(log: Log) -> None:
    frame = log.to_pandas()
    dates = pd.Series(START + pd.to_timedelta(log.time_s, unit="s"))
    with pytest.raises(palpate.ReadError, match="NaN stands where a number must be") as caught:
        Log.from_pandas(frame.assign(time_s=dates.where(dates.index != 7)))
    assert (caught.value.line, caught.value.column) == (7, "time_s")
    with pytest.raises(palpate.ReadError, match="is not a number"):
        Log.from_pandas(frame.assign(phi1_rad=dates))
    with pytest.warns(palpate.ReadWarning, match="columns ignored: recorded"):
        assert Log.from_pandas(frame.assign(recorded=dates)) == log


def test_sizes_that_no_palms_have_are_refused(log: Log) -> None:
    frame = log.to_pandas()
    with pytest.raises(palpate.ReadError, match="m is more than 2 m; correct it, or name the column s1_cm, s1_mm"):
        Log.from_pandas(frame.assign(s1_m=1e3 * frame.s1_m))
    with pytest.raises(palpate.ReadError, match=r"the log lasts .* s, more than 1000000 s"):
        Log.from_pandas(frame.assign(time_s=1e9 * frame.time_s))


def columns(**changes: object) -> dict[str, object]:
    n = np.arange(20.0)
    good = {"time_s": n, "phi1_rad": 1 + 0 * n, "phi2_rad": 1.2 + 0 * n, "s1_m": 0.03 + 0 * n, "s2_m": 0.03 + 0 * n}
    return {name: value for name, value in (good | changes).items() if value is not None}


def with_value(place: int, value: object) -> list[object]:
    cells: list[object] = list(0.5 + np.arange(20.0) / 100)
    cells[place] = value
    return cells


@pytest.mark.parametrize(
    ("change", "line", "column", "words"),
    [
        ({"s1_m": None}, None, None, "there is no column for s1; it must be named s1_m, s1_cm, s1_mm or s1_um"),
        ({"s2_m": None, "s2": np.zeros(20)}, None, "s2", "the name has no unit; name the column s2_m, s2_cm, s2_mm or"),
        ({"s1_m": with_value(7, -0.1)}, 7, "s1_m", "-0.1"),
        ({"s1_m": with_value(7, "wet")}, 7, "s1_m", '"wet" is not a number'),
        ({"s1_m": with_value(7, np.inf)}, 7, "s1_m", "inf"),
        ({"time_s": with_value(7, 0.0)}, 7, "time_s", "time decreases"),
        ({"time_s": with_value(7, None)}, 7, "time_s", "number"),
        ({"phi2_rad": np.full(20, np.pi)}, 0, "phi2_rad", "parallel"),
        ({"phi2_rad": np.full(20, 74.0)}, 0, "phi2_rad", "phi2_deg"),
        ({"s1_m": np.zeros(19)}, None, "s1_m", "the column has 19 values, the first one has 20"),
        ({"s1_m": np.full(20, np.nan)}, None, None, "0 of its 20"),
    ],
)
def test_unusable_columns_are_refused_with_their_place(
    change: dict[str, object], line: int | None, column: str | None, words: str
) -> None:
    with pytest.raises(palpate.ReadError) as caught:
        Log.from_numpy(columns(**change))
    error = caught.value
    assert (error.line, error.column) == (line, column), error
    assert words in str(error)
    assert error.problem in str(error)
    assert isinstance(error, ValueError)


def test_tables_that_are_none_are_refused() -> None:
    for nonsense in (3, "time_s", np.zeros((20, 5)), [1, 2]):
        with pytest.raises(palpate.InputError, match="mapping of names to arrays"):
            Log.from_numpy(nonsense)  # type: ignore[arg-type]
    with pytest.raises(palpate.InputError, match="one-dimensional"):
        Log.from_numpy(columns(s1_m=np.zeros((20, 2))))
    with pytest.raises(palpate.InputError, match=r"base1_m must have the shape \(n, 2\), not \(20, 3\)"):
        Log(*columns().values(), base1_m=np.zeros((20, 3)))  # type: ignore[arg-type]
    frame = pd.DataFrame(columns())
    with pytest.raises(palpate.ReadError, match="two columns named s1_m"):
        Log.from_pandas(pd.concat([frame, frame[["s1_m"]]], axis=1))


def test_files_are_refused_in_the_words_of_the_command_line(tmp_path: Path) -> None:
    """The sentences are those that crates/palpate-cli/tests/bad_input.rs and the tutorial have."""
    path = tmp_path / "trial.csv"
    path.write_text("time_s,phi1_rad,phi2_rad,s1_m,s2\n0,1,1,0.1,0.1\n")
    with pytest.raises(palpate.ReadError) as caught:
        Log.from_csv(path)
    names = "s2_m, s2_cm, s2_mm or s2_um"
    assert str(caught.value) == f"{path}, line 1, column s2: the name has no unit; name the column {names}"
    with pytest.raises(palpate.ReadError, match="no such file; check the path"):
        Log.from_csv(tmp_path / "none.csv")
    path.write_bytes(bytes(range(256)))
    with pytest.raises(palpate.ReadError, match="this is a binary file, not text; export it as CSV"):
        Log.from_csv(path)
    with pytest.raises(palpate.WriteError, match="a folder of that name exists"):
        Log.from_csv(EGG).to_csv(tmp_path)
