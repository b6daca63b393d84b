"""The same batches of the same 1,000 machines on Ray: `BALLRACE=PATH python benchmarks/fleet_ray.py --model MODEL`."""

import argparse
import os
import tempfile
import time

import psutil
import ray

from ballrace.fleet import Synthetic, results, settings
from ballrace.fleet.engine import run_batch
from ballrace.fleet.work import Job, find_program

parser = argparse.ArgumentParser()
parser.add_argument("--model", required=True)
parser.add_argument("--machines", type=int, default=1000)
given = parser.parse_args()
with tempfile.TemporaryDirectory() as out:
    source = Synthetic(given.machines)
    began = time.perf_counter()
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    start = time.perf_counter() - began
    results.extend_plan(out, source.names(), settings.BATCH)
    job = Job("monitor", source, out, find_program(), model=os.path.abspath(given.model))
    remote = ray.remote(num_cpus=1, max_retries=settings.DEATHS)(run_batch)
    ended = ray.get([remote.remote(job, number) for number, _ in results.planned(out)])
    seconds = time.perf_counter() - began
    family = [psutil.Process(), *psutil.Process().children(recursive=True)]
    mib = sum(process.memory_info().rss for process in family) / 2**20
    print(f"{sum(count for count, _ in ended)} machines on Ray, 2 workers: {seconds:.1f} s, start {start:.1f} s, {mib:.0f} MiB")
    ray.shutdown()
