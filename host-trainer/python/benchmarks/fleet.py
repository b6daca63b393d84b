"""Throughput of `ballrace.fleet` by workers and by machines, next to pandas, scipy and multiprocessing.

`BALLRACE=PATH python benchmarks/fleet.py --model MODEL [--machines N …]`. Both make the same synthetic machines in their
workers (three recordings of 2,560 samples). `fleet monitor` reads each by a `ballrace` process (device's model, vibration
indicators, events) and writes Parquet, restartable. The plain script reads the same files with numpy and computes RMS,
kurtosis and Welch's spectrum; it has no model, no events, and loses all if it is killed.
"""

import argparse
import multiprocessing
import tempfile
import time
from pathlib import Path

import numpy as np
import pandas as pd
import psutil
from scipy import signal, stats

from ballrace import fleet
from ballrace.fleet import settings, synthetic


def plain_machine(number: int) -> list[dict]:
    """RMS, kurtosis and the strongest frequency of a machine's recordings."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        synthetic.write(Path(folder, "m"), number, 3)
        for path in sorted(Path(folder, "m").glob("*.npy")):
            x = np.load(path)
            frequency, power = signal.welch(x, settings.SYNTHETIC_RATE_HZ, nperseg=1024)
            peak = frequency[power.argmax()]
            rows.append({"machine": number, "rms": float(np.std(x)), "kurtosis": float(stats.kurtosis(x, fisher=False)), "peak_hz": peak})
    return rows


def plain(machines: int, workers: int, out: str) -> float:
    """Seconds of the plain script, its pool's start included."""
    began = time.perf_counter()
    with multiprocessing.get_context("spawn").Pool(workers) as pool:
        rows = [row for some in pool.imap(plain_machine, range(machines), chunksize=50) for row in some]
    pd.DataFrame(rows).to_parquet(f"{out}/plain.parquet")
    return time.perf_counter() - began


def ours(machines: int, workers: int, out: str, model: str) -> tuple[float, list[tuple[int, float]]]:
    """Seconds of the fleet, its workers' start included, and resident MiB of all its processes by machines done."""
    memory: list[tuple[int, float]] = []

    def watch(done, total, errors, seconds):
        family = [psutil.Process(), *psutil.Process().children(recursive=True)]
        total_rss = 0
        for process in family:
            try:
                total_rss += process.memory_info().rss
            except psutil.NoSuchProcess:
                pass
        memory.append((done, total_rss / 2**20))

    summary = fleet.run("monitor", f"synthetic:{machines}", f"{out}/fleet", model=model, workers=workers, progress=watch)
    assert (summary.machines, summary.errors) == (machines, 0)
    return summary.seconds, memory


def main() -> None:
    """Print one line a size and number of workers."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--model", required=True)
    parser.add_argument("--machines", type=int, nargs="*", default=[100, 1000, 10_000])
    parser.add_argument("--workers", type=int, nargs="*", default=[1, 2, 4])
    given = parser.parse_args()
    largest = sorted(given.machines)[len(given.machines) // 2]
    runs = [(machines, 2) for machines in given.machines] + [(largest, workers) for workers in given.workers if workers != 2]
    for machines, workers in runs:
        with tempfile.TemporaryDirectory() as out:
            seconds, memory = ours(machines, workers, out, given.model)
            peer = plain(machines, workers, out)
        tenths = [memory[round(part * (len(memory) - 1) / 4)] for part in range(5)]
        print(
            f"{machines} machines, {workers} workers: fleet {seconds:.1f} s, {machines / seconds:.0f}/s; plain {peer:.1f} s, "
            f"{machines / peer:.0f}/s; ratio {seconds / peer:.2f}; MiB by machines done: "
            + ", ".join(f"{done}: {mib:.0f}" for done, mib in tenths),
            flush=True,
        )


if __name__ == "__main__":
    main()
