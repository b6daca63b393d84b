"""A fleet on two real worker processes: each machine once, whatever dies. Needs the extra `fleet`, and `$BALLRACE`."""

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

for module in ("distributed", "duckdb", "polars", "pyarrow"):
    pytest.importorskip(module)
import duckdb
import polars
import psutil
import pyarrow as pa
import pyarrow.parquet as pq

from ballrace import fleet
from ballrace.fleet import results, synthetic
from ballrace.fleet.work import Job, run_machine

PROGRAM = shutil.which(os.environ.get("BALLRACE", "ballrace"))
MODEL = Path(__file__).parents[3] / "core" / "examples" / "least.json"
pytestmark = pytest.mark.skipif(PROGRAM is None, reason="no ballrace program: set $BALLRACE or $PATH")


def monitor(machines, out, **more):
    return fleet.run("monitor", machines, out, model=str(MODEL), program=PROGRAM, workers=2, **more)


def statuses(out):
    rows = duckdb.sql(f"select machine, status, error from read_parquet('{out}/status/*.parquet') order by machine").fetchall()
    assert len({row[0] for row in rows}) == len(rows), "a machine is there twice"
    return {row[0]: row[1:] for row in rows}


def test_broken_machine_says_why_and_resume_recomputes_nothing(tmp_path):
    root, out = tmp_path / "fleet", tmp_path / "out"
    for number in range(6):
        synthetic.write(root / f"pump{number}", number, 2)
    (root / "pump3" / "r001.npy").write_bytes(b"not numpy")
    first = monitor(root, out, batch=2)
    assert (first.machines, first.errors, first.before) == (6, 1, 0)
    found = statuses(out)
    assert found["pump3"][0] == "error" and "r001.npy" in found["pump3"][1]
    assert polars.scan_parquet(f"{out}/indicators/*.parquet").collect().height == 10
    written = {path: path.stat().st_mtime_ns for path in out.rglob("*.parquet")}
    again = monitor(root, out, batch=2)
    assert (again.machines, again.before) == (6, 6)
    assert written == {path: path.stat().st_mtime_ns for path in out.rglob("*.parquet")}
    # A machine more is a batch more; what was broken is repeated on demand.
    synthetic.write(root / "pump9", 9, 2)
    shutil.copy(root / "pump3" / "r000.npy", root / "pump3" / "r001.npy")
    last = monitor(root, out, batch=2, retry_errors=True)
    assert (last.machines, last.errors, last.before) == (7, 0, 4)
    assert duckdb.sql(f"select count(*) from read_parquet('{out}/summary/*.parquet')").fetchall() == [(7,)]
    with pytest.raises(fleet.InputError, match="expected"):
        fleet.run("phases", root, out, program=PROGRAM)


def test_partitions_by_machine_and_day(tmp_path):
    root = tmp_path / "lake"
    for number in range(3):
        for day, samples in enumerate(synthetic.samples(number, 2)):
            folder = root / f"machine=m{number}" / f"day=2026-01-0{day + 1}"
            folder.mkdir(parents=True)
            pq.write_table(pa.table({"ay": samples}), folder / "r0.parquet")
    options = ("--sample-rate", "25600")
    assert monitor(root, tmp_path / "all", options=options).errors == 0
    rows = duckdb.sql(f"select recording from read_parquet('{tmp_path}/all/indicators/*.parquet') where machine = 'm1' order by recording_index")
    assert rows.fetchall() == [("2026-01-01_r0",), ("2026-01-02_r0",)]
    monitor(root, tmp_path / "day", options=options, days=("2026-01-02",))
    assert polars.read_parquet(f"{tmp_path}/day/indicators/*.parquet")["recording"].to_list() == ["2026-01-02_r0"] * 3


def worker_at_work():
    """A worker that has a `ballrace` process at this moment."""
    while True:
        for process in psutil.Process().children(recursive=True):
            with contextlib.suppress(psutil.Error):
                if process.name() == "ballrace":
                    return process.ppid()


def test_killed_worker_loses_and_doubles_nothing(tmp_path):
    out, killed = tmp_path / "out", []

    def kill():
        while not list(out.glob("status/*.parquet")):
            time.sleep(0.02)
        victim = worker_at_work()
        os.kill(victim, signal.SIGKILL)
        killed.append(victim)

    killer = threading.Thread(target=kill, daemon=True)
    killer.start()
    summary = monitor("synthetic:600", out, batch=20)
    killer.join(5)
    assert killed, "the run ended before a worker could be killed"
    assert (summary.machines, summary.errors) == (600, 0)
    assert len(statuses(out)) == 600
    assert duckdb.sql(f"select count(*) from read_parquet('{out}/indicators/*.parquet')").fetchall() == [(1800,)]


def test_killed_run_goes_on(tmp_path):
    out = tmp_path / "out"
    line = [sys.executable, "-m", "ballrace.fleet", "monitor", "--machines", "synthetic:400", "--out", str(out)]
    line += ["--model", str(MODEL), "--program", PROGRAM, "--workers", "2", "--batch", "20"]
    run = subprocess.Popen(line, stderr=subprocess.DEVNULL)
    while not list(out.glob("status/*.parquet")):
        assert run.poll() is None, "the run ended before it was killed"
        time.sleep(0.02)
    run.send_signal(signal.SIGINT)
    assert run.wait(30) == 130
    summary = monitor("synthetic:400", out, batch=20)
    assert summary.machines == 400 and summary.before > 0
    assert len(statuses(out)) == 400


def test_phases_and_sweep_of_a_machine(tmp_path):
    config = tmp_path / "sweep.toml"
    config.write_text('solver = "stlsq"\nnd = 1\nnf = 1\n')
    for command, recordings, columns in (("phases", 20, {"channel", "denoised"}), ("sweep", 1, {"solver", "r2"})):
        job = Job(command, fleet.Synthetic(1, recordings), str(tmp_path), PROGRAM, config=str(config))
        status, rows = run_machine(job, "m0000000")
        assert (status["status"], status["error"]) == ("ok", None)
        results.write_batch(str(tmp_path), 0, [status], {command: [row | {"machine": "m0000000"} for row in rows[command]]})
        assert columns <= set(polars.read_parquet(f"{tmp_path}/{command}/*.parquet").columns)
