"""Sweeps: the same table whoever does the jobs, stopped and taken up again; on a Ray cluster that loses a node."""

from __future__ import annotations

import importlib.metadata
import json
import os
import pickle
import subprocess
import sys
from collections import Counter, deque
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from conftest import LOGS

import palpate
from palpate import _progress

PLAN = """
kind = "simulate"
trials = 4
samples = 60
objects.ellipse = { axis_ratio = [0.6, 0.8] }
touchpads = [{ noise_sd_m = 0.1e-3 }]
reconstruct.method = "quadrature"
"""


def jobs_in_journal(folder: Path) -> list[int]:
    lines = (folder / "journal.jsonl").read_text().splitlines()[1:]
    return [json.loads(line[17:])["row"]["job"] for line in lines]


@pytest.fixture(scope="module")
def local(tmp_path_factory: pytest.TempPathFactory) -> palpate.SweepResult:
    return palpate.sweep(PLAN, tmp_path_factory.mktemp("sweep") / "local")


def test_pandas_reads_the_table_itself(local: palpate.SweepResult) -> None:
    # What it needs for that is the extra of that name.
    frame, columns = pd.read_parquet(local.table), local.to_pandas()
    assert list(frame) == list(columns)
    np.testing.assert_allclose(frame["rms_r_m"], columns["rms_r_m"])
    assert frame["object"].tolist() == columns["object"].tolist()
    extra = importlib.metadata.metadata("palpate").get_all("Requires-Dist") or []
    assert {line.split(">")[0] for line in extra if "table" in line} == {"pandas", "pyarrow"}


def test_the_table_comes_back_as_columns(local: palpate.SweepResult) -> None:
    assert len(local) == local.reconstructed == 8
    assert local.certified == local.without_log == local.without_result == local.finished_before == 0
    assert str(local) == "8 jobs: 8 reconstructed, 0 of them certified"
    assert sorted(file.name for file in local.folder.iterdir()) == ["journal.jsonl", "results.parquet", "seconds.csv"]
    columns = local.columns
    assert columns["job"].tolist() == list(range(8))
    assert columns["seed"].tolist() == [1, 2, 3, 4] * 2
    assert columns["object"].tolist() == ["ellipse 0.6"] * 4 + ["ellipse 0.8"] * 4
    assert columns["motion"].tolist() == ["random"] * 8
    assert columns["solved"].tolist() == [None] * 8
    assert np.isnan(columns["counts_per_inch"]).all()
    assert (columns["rms_r_m"] > 0).all()
    kinds = {name: columns[name].dtype.kind for name in ("job", "certified", "coverage", "samples", "reason", "wrong")}
    assert kinds == {"job": "i", "certified": "b", "coverage": "f", "samples": "f", "reason": "O", "wrong": "O"}
    frame = local.to_pandas()
    assert frame.shape == (8, len(columns))
    assert frame.groupby("object")["rms_r_m"].median().notna().all()
    back = pickle.loads(pickle.dumps(local))
    assert back.table == local.table
    np.testing.assert_array_equal(back.columns["rms_r_m"], columns["rms_r_m"])


def test_a_plan_is_a_file_a_text_or_a_list_of_jobs(local: palpate.SweepResult, tmp_path: Path) -> None:
    (tmp_path / "plan.toml").write_text(PLAN)
    jobs = palpate.sweep_jobs(tmp_path / "plan.toml")
    assert jobs[0].to_dict()["source"]["simulate"]["object"]["ellipse"]["axis_ratio"] == 0.6
    assert "0.6" in repr(jobs[0])
    assert palpate.sweep(pickle.loads(pickle.dumps(jobs)), tmp_path / "list", threads=1).table.read_bytes() == (
        local.table.read_bytes()
    )
    some = palpate.sweep((job for job in jobs[6:]), tmp_path / "some")
    assert some.columns["seed"].tolist() == [3, 4]
    again = palpate.sweep(str(tmp_path / "plan.toml"), tmp_path / "list")
    assert again.finished_before == 8
    assert str(again).startswith("8 jobs, 8 of them finished before: ")


def test_logs_lie_in_the_folder_of_the_plan(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = 'kind = "reconstruct"\nlogs = "egg_*.csv"\nreconstruct.method = "quadrature"\n'
    (tmp_path / "plan.toml").write_text(plan.replace("egg_", f"{LOGS.as_posix()}/egg_"))
    monkeypatch.chdir(LOGS)
    jobs = palpate.sweep_jobs(plan)
    elsewhere = palpate.sweep_jobs(tmp_path / "plan.toml")
    monkeypatch.chdir(tmp_path)
    result = palpate.sweep(jobs, "found")
    assert result.columns["object"].tolist() == ["egg_full_turn_oracle_n0.1mm.csv"]
    assert result.columns["rms_r_m"][0] < 1e-3
    with pytest.raises(palpate.InputError, match="the jobs come from plans in two folders"):
        palpate.sweep(jobs + elsewhere, "both")


def test_it_goes_on_where_it_was(local: palpate.SweepResult, tmp_path: Path) -> None:
    def interrupt(stage: str, share: float) -> None:
        assert stage == "jobs"
        if share >= 3 / 8:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        palpate.sweep(PLAN, tmp_path, threads=2, progress=interrupt)
    assert not (tmp_path / "results.parquet").exists()
    told: list[float] = []
    result = palpate.sweep(PLAN, tmp_path, progress=lambda _, share: told.append(share))
    # How far the threads had come when the listener was heard is a matter of the machine.
    assert 3 <= result.finished_before <= 8
    assert told[0] == result.finished_before / 8
    assert told[-1] == 1
    assert sorted(jobs_in_journal(tmp_path)) == list(range(8)), "each job once"
    assert result.table.read_bytes() == local.table.read_bytes()


def test_a_bar_counts_jobs(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_progress, "PATIENCE_S", 0.0)
    palpate.sweep(PLAN, tmp_path, progress=True)
    assert "/8 [" in capsys.readouterr().err


def test_bad_plans_and_folders_are_told_as_by_the_program(local: palpate.SweepResult, tmp_path: Path) -> None:
    with pytest.raises(palpate.ReadError, match=r"^the plan, line 3, trials: at least one is needed") as caught:
        palpate.sweep_jobs('\nkind = "simulate"\ntrials = 0\n')
    assert (caught.value.file, caught.value.line, caught.value.column) == ("the plan", 3, "trials")
    with pytest.raises(palpate.ReadError, match=r"missing\.toml: the plan cannot be read"):
        palpate.sweep("missing.toml", tmp_path / "out")
    with pytest.raises(palpate.ReadError, match="there is no touchpad; add one"):
        palpate.sweep('kind = "simulate"\nobjects.mixed = {}\n', tmp_path / "out")
    with pytest.raises(palpate.InputError, match="there is no job"):
        palpate.sweep([], tmp_path / "out")
    with pytest.raises(TypeError):
        palpate.sweep(["egg"], tmp_path / "out")  # type: ignore[list-item]
    with pytest.raises(palpate.InputError, match="threads must be from 1 to 1024"):
        palpate.sweep(PLAN, tmp_path / "threads", threads=0)
    with pytest.raises(palpate.InputError, match="threads goes with engine='local'"):
        palpate.sweep(PLAN, tmp_path / "out", engine="auto", threads=2)
    assert not (tmp_path / "out").exists()
    with pytest.raises(palpate.SweepError, match="the folder holds another sweep of 8 jobs"):
        palpate.sweep(PLAN.replace("60", "70"), local.folder)
    (tmp_path / "file").write_text("")
    with pytest.raises(palpate.SweepError, match="file"):
        palpate.sweep(PLAN, tmp_path / "file")


@pytest.fixture
def without_ray(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setitem(sys.modules, "ray", None)
    monkeypatch.delitem(sys.modules, "palpate._ray", raising=False)
    monkeypatch.delattr(palpate, "_ray", raising=False)
    yield
    sys.modules.pop("palpate._ray", None)


@pytest.mark.usefixtures("without_ray")
def test_without_ray_it_says_what_to_install(tmp_path: Path) -> None:
    with pytest.raises(ImportError, match=r"needs Ray; pip install 'palpate\[ray\]'"):
        palpate.sweep(PLAN, tmp_path / "out", engine="auto")
    assert not (tmp_path / "out").exists()


def test_a_cluster_that_is_not_there_is_told_at_once(tmp_path: Path) -> None:
    pytest.importorskip("ray", reason="Ray is not installed")
    with pytest.raises(palpate.SweepError, match=r"^127\.0\.0\.1:1: no Ray cluster answers at this address: "):
        palpate.sweep(PLAN, tmp_path, engine="127.0.0.1:1")
    assert palpate.sweep(PLAN, tmp_path).reconstructed == 8, "the folder is free again"


CLUSTER = Path(__file__).with_name("cluster.py")


def on_cluster(*arguments: str | Path) -> str:
    """What the script says; in a process of its own, for Ray leaves threads and handlers behind."""
    pytest.importorskip("ray", reason="Ray is not installed")
    environment = os.environ | {"RAY_USAGE_STATS_ENABLED": "0", "RAY_DEDUP_LOGS": "0"}
    command = [sys.executable, str(CLUSTER), *map(str, arguments)]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=3000, env=environment)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    return ran.stdout


@pytest.mark.skipif(sys.platform == "win32", reason="Ray has no clusters of Windows machines")
def test_a_cluster_that_loses_a_worker_and_a_node_gives_the_same_table(tmp_path: Path) -> None:
    plan = PLAN.replace("trials = 4", "trials = 40")
    (tmp_path / "plan.toml").write_text(plan)
    local = palpate.sweep(plan, tmp_path / "local")
    said = on_cluster(tmp_path / "plan.toml", tmp_path / "ray")
    assert "stopped\n" in said
    assert "of them finished before: 80 reconstructed" in said
    assert "worker killed\n" in said
    assert "node killed\n" in said
    assert Counter(jobs_in_journal(tmp_path / "ray")) == Counter(range(80)), "each job once"
    assert (tmp_path / "ray" / "results.parquet").read_bytes() == local.table.read_bytes()


def test_chunks_shrink_and_lost_jobs_go_alone() -> None:
    pytest.importorskip("ray", reason="Ray is not installed")
    from palpate import _ray

    waiting, sizes = deque(range(2000)), []
    while waiting:
        sizes.append(len(_ray._next_chunk(waiting, Counter(), 2)))
    assert sum(sizes) == 2000
    assert sizes == sorted(sizes, reverse=True)
    assert (sizes[0], sizes[-1]) == (64, 1)

    waiting, losses = deque(range(100)), Counter({0: 1, 3: 1})
    chunks = [_ray._next_chunk(waiting, losses, 1) for _ in range(4)]
    assert chunks == [[0], [1, 2], [3], list(range(4, 16))]

    losses.update({3: _ray.MOST_LOSSES - 2})
    _ray._refuse_killers([3], losses, OSError("gone"))
    losses.update([3])
    with pytest.raises(palpate.SweepError, match="job 3 was lost with its worker 5 times, the last time so: gone"):
        _ray._refuse_killers([3], losses, OSError("gone"))
