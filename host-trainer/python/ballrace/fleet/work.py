"""One machine and one command: a `ballrace` process over the machine's recordings, its answer as rows of tables.

A process of its own costs some milliseconds, takes every option of the command as it is, and cannot take a worker with
it: whatever happens to it becomes the text of the machine's row in `status`.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import tempfile
import time
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pyarrow.parquet as pq

from . import settings
from .sources import InputError, Source

COMMANDS = ("monitor", "phases", "sweep", "diagnose")
Rows = dict[str, list[dict]]


class CommandError(Exception):
    """Text of a command that did not exit with 0."""


@dataclass(frozen=True)
class Job:
    """What is done with every machine; plain data that travels to the workers."""

    command: str
    source: Source
    out: str
    program: str
    model: str | None = None
    rig: str | None = None
    baseline: str | None = None
    config: str | None = None
    options: tuple[str, ...] = ()
    timeout_s: float = settings.TIMEOUT_S


def find_program(stated: str | None = None) -> str:
    """Path of the `ballrace` program: as stated, `$BALLRACE`, or on `$PATH`. Raises `InputError` where there is none."""
    name = stated or os.environ.get("BALLRACE") or "ballrace"
    path = shutil.which(name)
    if path is None:
        raise InputError(f"{name}: found no such program, expected ballrace (--program PATH, $BALLRACE or $PATH)")
    return os.path.abspath(path)


def version(program: str) -> str:
    """What `ballrace --version` prints on this host. Raises `CommandError` or `OSError` where the program cannot be run."""
    return _version(program, os.stat(program).st_mtime_ns)


@cache
def _version(program: str, changed_ns: int) -> str:
    """As `version`; a worker may live longer than a program."""
    try:
        done = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError) as error:
        raise CommandError(f"{program} --version: {error}") from None
    return done.stdout.strip()


def run_machine(job: Job, machine: str, scratch_root: str | None = None) -> tuple[dict, Rows]:
    """Status row of a machine, and its rows of each table. Never raises for what is wrong with the machine."""
    began = time.perf_counter()
    rows: Rows = {}
    error = made_by = None
    try:
        made_by = version(job.program)
        with tempfile.TemporaryDirectory(prefix="ballrace-", dir=scratch_root) as scratch:
            recordings = job.source.recordings(machine, Path(scratch))
            rows = RUN[job.command](job, machine, recordings, Path(scratch))
    except (CommandError, InputError, OSError, ValueError, KeyError) as caught:
        text = str(caught) if isinstance(caught, CommandError | InputError) else f"{type(caught).__name__}: {caught}"
        error, rows = text[: settings.TEXT], {}
    status = {"machine": machine, "status": "error" if error else "ok", "error": error}
    return status | {"seconds": time.perf_counter() - began, "version": made_by}, rows


def call(job: Job, arguments: list[str | Path]) -> str:
    """Standard output of `ballrace COMMAND ARGUMENTS OPTIONS --json`, on one thread: the workers are the parallelism."""
    line = [job.program, job.command, *map(str, arguments), *job.options, "--json"]
    environment = {"RAYON_NUM_THREADS": "1"} | os.environ
    try:
        done = subprocess.run(line, capture_output=True, text=True, errors="replace", timeout=job.timeout_s, env=environment)
    except subprocess.TimeoutExpired:
        raise CommandError(f"found no answer of {job.command} after {job.timeout_s:g} s, expected one within that") from None
    if done.returncode < 0:
        raise CommandError(f"{job.command} was ended by {signal.Signals(-done.returncode).name}: {done.stderr.strip()}".rstrip(": "))
    if done.returncode > 0:
        raise CommandError(done.stderr.strip().removeprefix("error: ") or f"{job.command} ended with exit code {done.returncode}")
    return done.stdout


def monitor(job: Job, machine: str, recordings: Path, scratch: Path) -> Rows:
    """Vibration indicators of each recording, events (status changes and faults), and the summary."""
    events = json.loads(call(job, ["--model", job.model, recordings]))
    rows: Rows = {"indicators": [], "events": [], "summary": []}
    for event in events:
        kind = event["event"]
        if kind == "summary":
            first = event["first_alarm"] or {}
            flat = {f"faults_{key}": value for key, value in event["faults"].items()}
            flat |= {f"first_alarm_{key}": first.get(key) for key in ("recording", "recording_index", "sample", "time_s")}
            rows["summary"].append(event | flat)
        else:
            rows["indicators" if kind == "recording" else "events"].append(event)
    return rows


def phases(job: Job, machine: str, recordings: Path, scratch: Path) -> Rows:
    """A row a channel, raw and denoised: when aging and failure began."""
    rows = []
    for answer in json.loads(call(job, [recordings]))["machines"]:
        for channel in answer["channels"]:
            row = {"recordings": answer["recordings"], "gaps": answer["gaps"]} | channel
            row |= {f"healthy_{key}": value for key, value in channel["healthy"].items()}
            for phase in ("aging", "failure"):
                row |= {f"{phase}_{key}": value for key, value in (channel[phase] or {}).items()}
            rows.append(row)
    return {"phases": rows}


def sweep(job: Job, machine: str, recordings: Path, scratch: Path) -> Rows:
    """The rows of the command's own `sweep.parquet`: one a fit."""
    config = scratch / "sweep.toml"
    config.write_text(f"recordings = [{json.dumps(str(recordings))}]\n{Path(job.config).read_text()}")
    call(job, ["--config", config, "--out", scratch / "sweep"])
    return {"sweep": pq.read_table(scratch / "sweep" / "sweep.parquet").to_pylist()}


def diagnose(job: Job, machine: str, recordings: Path, scratch: Path) -> Rows:
    """The verdict, and a row a cause. The command's folder (report, corrected rig) is kept under `diagnoses/MACHINE`."""
    rig = job.source.own(machine, "rig.toml") or job.rig
    if rig is None:
        raise InputError(f"{machine}: found no rig.toml, expected one in the machine's folder or --rig")
    baseline = job.source.own(machine, "baseline") or job.baseline
    kept = Path(job.out, "diagnoses", machine)
    kept.parent.mkdir(exist_ok=True)
    fresh = Path(tempfile.mkdtemp(prefix=f".{machine}.", dir=kept.parent))
    try:
        arguments = ["--rig", rig, "--recordings", recordings, "--out", fresh]
        answer = json.loads(call(job, arguments + (["--baseline", baseline] if baseline else [])))
        shutil.rmtree(kept, ignore_errors=True)
        fresh.rename(kept)
    finally:
        shutil.rmtree(fresh, ignore_errors=True)
    fit = answer.get("fit") or {}
    verdict = {"verdict": answer["verdict"], "causes": len(answer["causes"])} | {f"fit_{key}": value for key, value in fit.items()}
    causes = [
        {"place": place, **cause, "parameters": json.dumps(cause["parameters"]), "interval95": json.dumps(cause["interval95"])}
        for place, cause in enumerate(answer["causes"])
    ]
    return {"diagnosis": [verdict], "causes": causes}


RUN = {"monitor": monitor, "phases": phases, "sweep": sweep, "diagnose": diagnose}
