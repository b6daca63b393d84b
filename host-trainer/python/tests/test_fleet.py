"""A fleet on two real worker processes: each machine once, whatever dies. Needs the extra `fleet`, and `$BALLRACE`."""

import contextlib
import json
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
import numpy as np
import polars
import psutil
import pyarrow as pa
import pyarrow.parquet as pq
from distributed import Client

import ballrace
from ballrace import fleet
from ballrace.fleet import results, synthetic
from ballrace.fleet.work import COMMANDS, Job, run_machine

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
    version = subprocess.run([PROGRAM, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    for number in range(6):
        synthetic.write(root / f"pump{number}", number, 2)
    (root / "pump3" / "r001.npy").write_bytes(b"not numpy")
    first = monitor(root, out, batch=2)
    assert (first.machines, first.errors, first.before) == (6, 1, 0)
    found = statuses(out)
    assert found["pump3"][0] == "error" and "r001.npy" in found["pump3"][1]
    assert polars.scan_parquet(f"{out}/indicators/*.parquet").collect().height == 10
    assert set(polars.read_parquet(f"{out}/status/*.parquet")["version"]) == {version}
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
        while not list(out.glob("status/batch-*.parquet")):
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


def test_scheduler_and_workers_that_were_started_apart(tmp_path):
    """As on many machines: a scheduler, and two workers with folders of their own."""
    out, file = tmp_path / "out", tmp_path / "scheduler.json"
    dask, where = [sys.executable, "-m", "dask"], ["--scheduler-file", str(file), "--no-dashboard"]
    with contextlib.ExitStack() as started:

        def start(*arguments, folder):
            folder.mkdir()
            process = subprocess.Popen([*dask, *arguments, *where], cwd=folder, stderr=subprocess.DEVNULL)
            started.callback(process.wait)
            started.callback(process.terminate)
            return process

        scheduler = start("scheduler", "--host", "127.0.0.1", "--port", "0", folder=tmp_path / "scheduler")
        for name in ("w1", "w2"):
            start("worker", "--nthreads", "1", "--no-nanny", "--local-directory", ".", "--name", name, folder=tmp_path / name)
        while not file.exists():
            assert scheduler.poll() is None, "the scheduler ended"
            time.sleep(0.05)
        with Client(scheduler_file=str(file)) as client:
            client.wait_for_workers(2)
            address = client.scheduler.address
        line = [sys.executable, "-m", "ballrace.fleet", "monitor", "--machines", "synthetic:40", "--out", str(out), "--batch", "5"]
        line += ["--scheduler", address, "--model", str(MODEL), "--program", PROGRAM]
        run = subprocess.run(line, capture_output=True, text=True, check=True)
    assert run.stdout.startswith("40 machines, 0 with an error") and "WARNING" not in run.stderr
    assert len(statuses(out)) == 40
    # Nothing of the machines is left in the workers' folders.
    assert not [path for name in ("w1", "w2") for path in (tmp_path / name).rglob("ballrace-*")]


def test_killed_run_goes_on(tmp_path):
    out = tmp_path / "out"
    line = [sys.executable, "-m", "ballrace.fleet", "monitor", "--machines", "synthetic:400", "--out", str(out)]
    line += ["--model", str(MODEL), "--program", PROGRAM, "--workers", "2", "--batch", "20"]
    run = subprocess.Popen(line, stderr=subprocess.DEVNULL)
    while not list(out.glob("status/batch-*.parquet")):
        assert run.poll() is None, "the run ended before it was killed"
        time.sleep(0.02)
    run.send_signal(signal.SIGINT)
    assert run.wait(30) == 130
    summary = monitor("synthetic:400", out, batch=20)
    assert summary.machines == 400 and summary.before > 0
    assert len(statuses(out)) == 400


def test_diagnose_of_two_machines(tmp_path):
    rig = 'kind = "sdof"\nmass_kg = 2.0\ndamping_n_s_per_m = 4.0\nstiffness_n_per_m = 800.0\ninput_gain_n_per_unit = 3.0\n'
    rough = rig + '[[effect]]\nname = "coulomb-friction"\nforce_n = 0.5\n'
    t = np.arange(3000) / 500
    drives = [0.5 * sum(np.sin((2 + 3 * k + n) * t + k * k) for k in range(8)) for n in range(4)]
    root, out = tmp_path / "fleet", tmp_path / "out"
    for name, toml in (("good", rig), ("rough", rough)):
        folder = root / name / "recordings"
        folder.mkdir(parents=True)
        given = [ballrace.Recording({"u": u}, 500.0) for u in drives]
        for n, made in enumerate(ballrace.Rig(toml).predict(given)):
            np.savetxt(folder / f"r{n}.csv", np.stack([made["u"], made["q"]], axis=1), delimiter=",", header="u,q", comments="")
        files = "".join(f'[[recording]]\nfile = "r{n}.csv"\n' for n in range(4))
        (folder / "recordings.toml").write_text(f"[defaults]\nsample_rate_hz = 500.0\n{files}")
    (root / "rough" / "rig.toml").write_text(rig)
    (tmp_path / "rig.toml").write_text(rig)
    summary = fleet.run("diagnose", root, out, rig=str(tmp_path / "rig.toml"), program=PROGRAM, workers=2, batch=1)
    assert (summary.machines, summary.errors) == (2, 0), statuses(out)
    verdicts = duckdb.sql(f"select machine, verdict, causes from read_parquet('{out}/diagnosis/*.parquet') order by machine")
    assert verdicts.fetchall() == [("good", "no-mismatch", 0), ("rough", "mismatch", 1)]
    (cause,) = polars.read_parquet(f"{out}/causes/*.parquet").to_dicts()
    assert (cause["machine"], cause["place"], cause["name"]) == ("rough", 0, "coulomb-friction")
    assert json.loads(cause["parameters"])["force_n"] == pytest.approx(0.5, rel=0.05)
    # As `ballrace fleet --diagnoses` takes them.
    assert json.loads((out / "diagnoses" / "rough" / "diagnosis.json").read_text())["verdict"] == "mismatch"


@pytest.mark.parametrize("command", COMMANDS)
def test_tables_without_rows_can_be_read(command, tmp_path):
    results.write_schemas(tmp_path, command)
    status = {"machine": "m", "status": "error", "error": "broken"}
    for rows in ([{"machine": "m"}], []):
        results.write_batch(tmp_path, command, 0, [status], {name: rows for name in results.OF_COMMAND[command]})
        for name in results.OF_COMMAND[command]:
            # What a batch had before is gone when it is repeated without rows.
            assert duckdb.sql(f"select machine from read_parquet('{tmp_path}/{name}/*.parquet')").fetchall() == [("m",)] * len(rows)
            assert polars.read_parquet(f"{tmp_path}/{name}/*.parquet").columns[0] == "machine"


def test_phases_and_sweep_of_a_machine(tmp_path):
    config = tmp_path / "sweep.toml"
    config.write_text('solver = "stlsq"\nnd = 1\nnf = 1\n')
    for command, recordings, columns in (("phases", 20, {"channel", "denoised"}), ("sweep", 1, {"solver", "r2"})):
        job = Job(command, fleet.Synthetic(1, recordings), str(tmp_path), PROGRAM, config=str(config))
        status, rows = run_machine(job, "m0000000")
        assert (status["status"], status["error"]) == ("ok", None)
        results.write_batch(str(tmp_path), command, 0, [status], {command: [row | {"machine": "m0000000"} for row in rows[command]]})
        # The columns of the command's own table, all of them.
        assert command == "phases" or list(rows["sweep"][0]) == [name for name, _ in results.TABLES["sweep"]]
        assert columns <= set(polars.read_parquet(f"{tmp_path}/{command}/*.parquet").columns)
