"""Parquet of `ballrace collect`, read with DuckDB and polars. Needs mosquitto, and `$BALLRACE`."""

import os
import shutil
import socket
import sqlite3
import subprocess
import time
from pathlib import Path

import pytest

for module in ("duckdb", "polars"):
    pytest.importorskip(module)
import duckdb
import polars as pl

from ballrace.fleet import synthetic

PROGRAM = shutil.which(os.environ.get("BALLRACE", "ballrace"))
MOSQUITTO = shutil.which("mosquitto") or shutil.which("mosquitto", path="/usr/sbin:/usr/local/sbin")
MODEL = Path(__file__).parents[3] / "core" / "examples" / "least.json"
MACHINES = ["007", "mill <1> & co", "pümp=%"]
pytestmark = [
    pytest.mark.skipif(PROGRAM is None, reason="no ballrace program: set $BALLRACE or $PATH"),
    pytest.mark.skipif(MOSQUITTO is None, reason="no mosquitto: .ci/run tools installs it"),
]


@pytest.fixture
def broker():
    """Address of a mosquitto of the test's own."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    process = subprocess.Popen([MOSQUITTO, "-p", str(port)], stderr=subprocess.DEVNULL)
    while socket.socket().connect_ex(("127.0.0.1", port)) != 0:
        assert process.poll() is None, "mosquitto ended"
        time.sleep(0.02)
    yield f"mqtt://127.0.0.1:{port}/plant"
    process.terminate()
    process.wait()


def test_partitions_are_what_the_sqlite_file_has(tmp_path, broker):
    def run(*arguments):
        subprocess.run([PROGRAM, *map(str, arguments)], cwd=tmp_path, check=True, capture_output=True)

    collect = ("collect", broker, "--out", "fleet.sqlite", "--parquet", "parts", "--until-idle", "0.5")
    synthetic.write(tmp_path / "machine", 0, 2)
    # The first run makes the session; what comes after it, the broker keeps.
    run(*collect)
    for machine in MACHINES:
        run("monitor", "--model", MODEL, "machine", "--publish", broker, "--machine", machine, "--blocks")
    run(*collect)
    columns = "session, sequence, kind, status, received_ms, time_s, level, ewma, alarms"
    expected = sqlite3.connect(tmp_path / "fleet.sqlite").execute(f"select machine, {columns} from messages order by 1, 2, 3").fetchall()
    assert {row[0] for row in expected} == set(MACHINES) and len(expected) > 10
    source = f"read_parquet('{tmp_path}/parts/*/*/*.parquet', hive_types_autocast = false)"
    assert duckdb.sql(f"select machine, {columns} from {source} order by 1, 2, 3").fetchall() == expected
    types = {"machine": pl.String, "day": pl.Date}
    frame = pl.scan_parquet(tmp_path / "parts", hive_partitioning=True, hive_schema=types).collect()
    assert frame.sort("machine", "session", "sequence").select("machine", *columns.split(", ")).rows() == expected
