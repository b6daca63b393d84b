"""Results in Parquet: `OUT/TABLE/batch-NNNNNNN.parquet`, each written to a temporary name and renamed.

A table without rows, `schema.parquet`, is there from the start.

`OUT/plan` says which machines a batch has, before its work begins, and never changes. A batch is done once its file in
`status` exists, which is written last. A batch that is repeated replaces its own files, so nothing is there twice.
"""

from __future__ import annotations

import fcntl
import json
import os
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from .sources import InputError

SCHEMA = "ballrace-fleet/2"
TEXT, FLAG, REAL, WHOLE = pa.string(), pa.bool_(), pa.float64(), pa.int64()


def _columns(kind: pa.DataType, names: str) -> list[tuple[str, pa.DataType]]:
    return [(name, kind) for name in names.split()]


#: Tables of each command beside `status`.
OF_COMMAND = {
    "monitor": ("indicators", "events", "summary"),
    "phases": ("phases",),
    "sweep": ("sweep",),
    "diagnose": ("diagnosis", "causes"),
}

#: Columns of each table after `machine`.
TABLES: dict[str, list[tuple[str, pa.DataType]]] = {
    "status": _columns(TEXT, "status error") + _columns(REAL, "seconds") + _columns(TEXT, "version"),
    "indicators": _columns(TEXT, "recording")
    + _columns(WHOLE, "recording_index")
    + _columns(REAL, "start_s rms_m_per_s2 peak_m_per_s2 crest_factor kurtosis velocity_mm_per_s")
    + _columns(TEXT, "no_velocity zone")
    + _columns(REAL, "ewma"),
    "events": _columns(TEXT, "event was status recording")
    + _columns(WHOLE, "recording_index sample")
    + _columns(REAL, "time_s")
    + _columns(WHOLE, "block")
    + _columns(REAL, "level deviation ewma")
    + _columns(TEXT, "kind")
    + _columns(REAL, "value"),
    "summary": _columns(TEXT, "status")
    + _columns(WHOLE, "recordings samples evaluated blocks alarms")
    + _columns(WHOLE, "faults_non_finite faults_saturated faults_stuck faults_missing")
    + _columns(TEXT, "first_alarm_recording")
    + _columns(WHOLE, "first_alarm_recording_index first_alarm_sample")
    + _columns(REAL, "first_alarm_time_s"),
    "phases": _columns(WHOLE, "recordings gaps")
    + _columns(TEXT, "channel")
    + _columns(FLAG, "denoised")
    + _columns(WHOLE, "healthy_recordings")
    + _columns(REAL, "healthy_kurtosis healthy_kurtosis_std")
    + _columns(WHOLE, "in_a_row aging_index")
    + _columns(TEXT, "aging_name")
    + _columns(REAL, "aging_time_s")
    + _columns(WHOLE, "failure_index")
    + _columns(TEXT, "failure_name")
    + _columns(REAL, "failure_time_s")
    + _columns(WHOLE, "aging_recordings"),
    "sweep": _columns(TEXT, "name recording")
    + _columns(WHOLE, "nd nmd nf powers")
    + _columns(TEXT, "solver alignment estimator filter")
    + _columns(REAL, "lambda1 lambda2 lambda3")
    + _columns(TEXT, "sparsity")
    + _columns(WHOLE, "seed epochs functions terms")
    + _columns(REAL, "r2 r2_validation r2_held_out r2_causal")
    + _columns(TEXT, "null_kind")
    + _columns(REAL, "r2_causal_null r2_null seconds")
    + _columns(TEXT, "error"),
    "diagnosis": _columns(TEXT, "verdict")
    + _columns(WHOLE, "causes")
    + _columns(TEXT, "fit_metric fit_held_out")
    + _columns(REAL, "fit_before fit_after fit_noise_floor fit_p_value"),
    "causes": _columns(WHOLE, "place")
    + _columns(TEXT, "name")
    + _columns(REAL, "probability")
    + _columns(TEXT, "parameters interval95 evidence equation"),
}


def write_schemas(out: str, command: str) -> None:
    """Write each table of the command without rows, `OUT/TABLE/schema.parquet`, so that all can be read at any time."""
    for name in ("status", *OF_COMMAND[command]):
        path = Path(out, name, "schema.parquet")
        if not path.exists():
            _write(path, _table(name, []))


def write_batch(out: str, command: str, batch: int, statuses: list[dict], rows: dict[str, list[dict]]) -> None:
    """Write a batch's tables, `status` last: only then is the batch done. `rows` have their `machine`."""
    for name in OF_COMMAND[command]:
        entries = rows.get(name)
        if entries:
            _write(_file(out, name, batch), _table(name, entries))
        else:
            # What a repeated batch had before.
            _file(out, name, batch).unlink(missing_ok=True)
    _write(_file(out, "status", batch), _table("status", statuses))


def _table(name: str, rows: list[dict]) -> pa.Table:
    columns = [("machine", TEXT), *TABLES[name]]
    return pa.table({column: pa.array([row.get(column) for row in rows], kind) for column, kind in columns})


def _file(out: str, name: str, batch: int) -> Path:
    return Path(out, name, f"batch-{batch:07}.parquet")


def _write(path: Path, table: pa.Table) -> None:
    path.parent.mkdir(exist_ok=True)
    descriptor, temporary = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".tmp", dir=path.parent)
    try:
        with open(descriptor, "wb") as file:
            pq.write_table(table, file, compression="zstd")
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


@contextmanager
def claim(out: str, what: dict) -> Iterator[None]:
    """`out` for this run alone, made where it is missing. Refuses a folder of another command, or with other files.

    Raises `InputError`; removes what a killed run left under temporary names."""
    folder, note = Path(out), Path(out, "fleet.json")
    folder.mkdir(parents=True, exist_ok=True)
    if not note.exists() and any(entry.name != ".lock" for entry in folder.iterdir()):
        raise InputError(f"{out}: found other files, expected an empty folder or results of ballrace.fleet")
    with open(folder / ".lock", "w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise InputError(f"{out}: found another run at work in it, expected none") from None
        what = json.loads(json.dumps({"schema": SCHEMA} | what))
        if note.exists():
            had = json.loads(note.read_text())
            for key in what | had:
                if had.get(key) != what.get(key):
                    raise InputError(f"{out}: found results with {key} {had.get(key)}, expected {what.get(key)}; take another --out")
        else:
            fresh = note.with_suffix(".tmp")
            fresh.write_text(json.dumps(what, indent=2) + "\n")
            fresh.replace(note)
        for left in folder.glob("*/.*.parquet.*.tmp"):
            left.unlink(missing_ok=True)
        yield


def extend_plan(out: str, machines: Iterable[str], size: int) -> int:
    """Put machines that no batch has yet into new batches of `size`, and return the number of machines of all batches.

    Names are read in a stream and written in pieces: memory holds the names that are planned already, and one batch."""
    known: set[str] = set()
    first = 0
    for batch, names in planned(out):
        known.update(names)
        first = batch + 1
    fresh = (name for name in machines if name not in known)
    count = len(known)
    while names := list(islice(fresh, size)):
        _write(_file(out, "plan", first), pa.table({"machine": pa.array(names, TEXT)}))
        first, count = first + 1, count + len(names)
    return count


def planned(out: str) -> Iterator[tuple[int, list[str]]]:
    """Batches of the plan in order: number, machines."""
    for path in sorted(Path(out, "plan").glob("batch-*.parquet")):
        yield int(path.stem.removeprefix("batch-")), pq.read_table(path)["machine"].to_pylist()


def done(out: str, batch: int) -> tuple[int, int] | None:
    """Numbers of machines and of errors of a batch that is done, else none."""
    path = _file(out, "status", batch)
    if not path.exists():
        return None
    statuses = pq.read_table(path, columns=["status"])["status"].to_pylist()
    return len(statuses), statuses.count("error")
