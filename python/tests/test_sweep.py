"""A campaign on a local Dask cluster: the numbers of one process, also where a worker is killed."""

import os
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
distributed = pytest.importorskip("distributed", reason="the extra `dask` is not installed")


def command() -> str:
    """The newest build of the command."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    built = [target / profile / "hoverlock" for profile in ("release", "debug")]
    # The newest: the module was built from the same sources.
    newest = max((path for path in built if path.exists()), key=lambda path: path.stat().st_mtime, default=None)
    found = str(newest) if newest else shutil.which("hoverlock")
    if found is None:
        pytest.skip("the command hoverlock is not built")
    return found


def sweep(out: Path, *further: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "HOVERLOCK_PYTHON": sys.executable}
    points = ["--scene", "helipad-in-mist", "--seeds", "4", "--seconds", "1"]
    line = [command(), "sweep", *points, "--json", "--out", str(out), *further]
    return subprocess.run(line, env=environment, capture_output=True, text=True, check=False)


def test_a_cluster_gives_the_numbers_of_one_process_also_when_a_worker_is_killed(tmp_path: Path) -> None:
    alone = sweep(tmp_path / "alone")
    assert alone.stdout, alone.stderr
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as cluster:
        victim = next(iter(cluster.workers.values())).pid

        def kill() -> None:
            time.sleep(1.5)
            os.kill(victim, 9)

        killer = threading.Thread(target=kill)
        killer.start()
        together = sweep(tmp_path / "together", "--dask", cluster.scheduler_address)
        killer.join()
    assert together.stdout, together.stderr
    assert together.stdout == alone.stdout
    # The order too, although the points are finished in another.
    assert (tmp_path / "alone/results.csv").read_text() == (tmp_path / "together/results.csv").read_text()


def test_the_table_opens_in_pandas(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    sweep(tmp_path, "--config", "dog_bits=10")
    table = pandas.read_csv(tmp_path / "results.csv")
    assert len(table) == 8
    assert set(table["design"]) == {"kt27", "dog_bits=10"}
    assert table["rms_m"].dtype == float and table["pass"].dtype == bool
    assert table.groupby("design")["m10k"].first()["dog_bits=10"] < table.groupby("design")["m10k"].first()["kt27"]


def test_a_scheduler_without_workers_is_reported(tmp_path: Path) -> None:
    with distributed.LocalCluster(n_workers=0, processes=True, dashboard_address=None, silence_logs=50) as cluster:
        environment = {**os.environ, "HOVERLOCK_PYTHON": sys.executable}
        line = [command(), "sweep", "--scene", "helipad-in-mist", "--seeds", "1", "--seconds", "1", "--out", str(tmp_path / "out")]
        with subprocess.Popen([*line, "--dask", cluster.scheduler_address], env=environment, stderr=subprocess.PIPE, text=True) as waiting:
            assert waiting.stderr is not None
            said = next(line for line in waiting.stderr if "workers" in line)
            assert f"no workers at {cluster.scheduler_address} yet" in said
            cluster.scale(1)
            assert waiting.wait(timeout=120) == 0


def test_without_a_scheduler_there_is_one_line(tmp_path: Path) -> None:
    refused = sweep(tmp_path / "none", "--dask", "tcp://127.0.0.1:1")
    assert refused.returncode == 2
    assert "no scheduler at tcp://127.0.0.1:1" in refused.stderr
