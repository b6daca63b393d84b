"""`phases` of a machine by a process of `ballrace`, as the fleet's workers do, and by a call of the module, one thread each.

`BALLRACE=PATH python benchmarks/fleet_process.py [--machines N]`. The same synthetic machines of 20 recordings of 2,560
samples for both, one after the other; both orders in turn. The call draws the machine's page too, which cannot be left out.
"""

import argparse
import os
import statistics
import tempfile
import time
from pathlib import Path

# Before the module makes its threads.
os.environ["RAYON_NUM_THREADS"] = "1"

import ballrace
from ballrace.fleet import synthetic
from ballrace.fleet.sources import Synthetic
from ballrace.fleet.work import Job, find_program, phases

RECORDINGS = 20


def seconds(work) -> float:
    """Seconds that a call takes."""
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def main() -> None:
    """Print the sum and the median of both."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--machines", type=int, default=1000)
    machines = parser.parse_args().machines
    job = Job("phases", Synthetic(machines, RECORDINGS), "", find_program())
    took: dict[str, list[float]] = {"process": [], "call": []}
    for number in range(machines):
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch, "recordings")
            synthetic.write(folder, number, RECORDINGS)
            works = {
                "process": lambda folder=folder: phases(job, "m", folder, Path(scratch)),
                "call": lambda folder=folder: ballrace.phases(folder),
            }
            for name in sorted(works, reverse=number % 2 == 0):
                took[name].append(seconds(works[name]))
    for name, each in took.items():
        print(f"{name}: {sum(each):.1f} s, median {1e3 * statistics.median(each):.1f} ms a machine")
    ratio = statistics.median(a / b for a, b in zip(took["process"], took["call"]))
    print(f"process over call, median of {machines} machines: {ratio:.2f}")


if __name__ == "__main__":
    main()
