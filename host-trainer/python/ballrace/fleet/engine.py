"""A run over a fleet: batches of machines on Dask's workers, which write the results themselves."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

import dask
from distributed import Client, Future, KilledWorker, LocalCluster, as_completed, get_worker

from . import results, settings
from .sources import InputError, open_source
from .work import COMMANDS, Job, find_program, run_machine

NEEDS = {"monitor": "model", "sweep": "config"}


@dataclass(frozen=True)
class Summary:
    """Counts of a run: machines of the fleet, of those with an error, of those that were done before; seconds."""

    machines: int
    errors: int
    before: int
    seconds: float


def run(
    command: str,
    machines,
    out: str | os.PathLike,
    *,
    model: str | None = None,
    rig: str | None = None,
    baseline: str | None = None,
    config: str | None = None,
    options: tuple[str, ...] = (),
    days: tuple[str, ...] = (),
    workers: int | None = None,
    scheduler: str | None = None,
    program: str | None = None,
    batch: int = settings.BATCH,
    timeout_s: float = settings.TIMEOUT_S,
    retry_errors: bool = False,
    progress=None,
) -> Summary:
    """Run `command` over all machines and write the tables to `out`; a second call goes on where the first ended.

    `machines` is a folder, `synthetic:COUNT[:RECORDINGS[:SEED]]` or a source. `options` go to the command as they are.
    `workers` processes are started here, or those of the Dask `scheduler` are used, which see the same paths.
    `retry_errors` repeats batches in which a machine had an error. `progress(done, total, errors, seconds)` is called
    after each batch. Raises `InputError` for bad input; what is wrong with a machine is in its row of `status`."""
    began = time.perf_counter()
    given = {"model": model, "rig": rig, "baseline": baseline, "config": config}
    if command not in COMMANDS:
        raise InputError(f"{command}: expected one of {', '.join(COMMANDS)}")
    if command in NEEDS and given[NEEDS[command]] is None:
        raise InputError(f"{command}: found no --{NEEDS[command]}, expected one")
    for name, path in given.items():
        if path is not None and not os.path.exists(path):
            raise InputError(f"--{name} {path}: found nothing there")
    given = {name: os.path.abspath(path) if path is not None else None for name, path in given.items()}
    source, out = open_source(machines, tuple(days)), os.path.abspath(out)
    job = Job(command, source, out, find_program(program), **given, options=tuple(options), timeout_s=timeout_s)
    what = {"command": command, "source": asdict(source), "options": job.options} | given
    with results.claim(out, what):
        results.write_schemas(out, command)
        total = results.extend_plan(out, source.names(), batch)
        counts, errors, before = 0, 0, 0
        todo = []
        for number, names in results.planned(out):
            had = results.done(out, number)
            if had is None or (retry_errors and had[1]):
                todo.append(number)
            else:
                counts, errors, before = counts + had[0], errors + had[1], before + had[0]
        if todo:
            with _client(workers, scheduler) as client, closing(_batches(client, job, todo)) as ends:
                for ended, wrong in ends:
                    counts, errors = counts + ended, errors + wrong
                    if progress:
                        progress(counts, total, errors, time.perf_counter() - began)
    return Summary(counts, errors, before, time.perf_counter() - began)


@contextmanager
def _client(workers: int | None, scheduler: str | None) -> Iterator[Client]:
    """Client of the scheduler, or of workers of its own. It is closed before them: they would warn of results that it holds."""
    if scheduler:
        with Client(scheduler) as client:
            yield client
        return
    with dask.config.set({"distributed.scheduler.allowed-failures": settings.DEATHS}):
        count = workers or os.cpu_count()
        with LocalCluster(n_workers=count, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
            yield client


def _batches(client: Client, job: Job, todo: list[int]) -> Iterator[tuple[int, int]]:
    """Numbers of machines and of errors of each batch as it ends, with a bounded number of them submitted."""
    ahead = settings.AHEAD * max(1, len(client.scheduler_info()["workers"]))
    left = iter(todo)
    batches: dict[Future, int] = {}

    def submit():
        number = next(left, None)
        if number is None:
            return None
        future = client.submit(run_batch, job, number, pure=False)
        batches[future] = number
        return future

    try:
        running = as_completed([future for _ in range(ahead) if (future := submit())])
        for future in running:
            number = batches.pop(future)
            try:
                yield future.result()
            except KilledWorker as died:
                yield give_up(job, number, str(died))
            fresh = submit()
            if fresh is not None:
                running.add(fresh)
    finally:
        client.cancel(list(batches))


def _machines(job: Job, number: int) -> list[str]:
    path = Path(job.out, "plan", f"batch-{number:07}.parquet")
    return results.pq.read_table(path)["machine"].to_pylist()


def run_batch(job: Job, number: int) -> tuple[int, int]:
    """On a worker: all machines of a batch, written; returns the numbers of machines and of errors."""
    try:
        scratch = get_worker().local_directory
    except ValueError:
        scratch = None
    statuses, tables = [], {}
    for machine in _machines(job, number):
        status, rows = run_machine(job, machine, scratch)
        statuses.append(status)
        for name, entries in rows.items():
            tables.setdefault(name, []).extend(entry | {"machine": machine} for entry in entries)
    results.write_batch(job.out, job.command, number, statuses, tables)
    return len(statuses), sum(status["status"] == "error" for status in statuses)


def give_up(job: Job, number: int, why: str) -> tuple[int, int]:
    """Rows that say why, for a batch whose workers died again and again."""
    machines = _machines(job, number)
    error = f"the worker died with this machine's batch: {why}"
    statuses = [{"machine": name, "status": "error", "error": error} for name in machines]
    results.write_batch(job.out, job.command, number, statuses, {})
    return len(machines), len(machines)


def print_progress(interval_s: float = settings.PROGRESS_S):
    """Progress on stderr with the time left: one line that changes on a terminal, else one now and then."""
    last = [0.0]

    def show(done: int, total: int, errors: int, seconds: float) -> None:
        terminal = sys.stderr.isatty()
        if not terminal and done < total and seconds - last[0] < interval_s:
            return
        last[0] = seconds
        left = seconds * (total - done) / max(done, 1)
        text = f"{done} of {total} machines, {errors} errors, {seconds:.0f} s, about {left:.0f} s left"
        print(f"\r{text}  " if terminal else text, end="" if terminal and done < total else "\n", file=sys.stderr, flush=True)

    return show
