"""Times polars and pandas on a FEMTO folder: `readers_peer.py FOLDER`.

Prints the names of the readers, a line each, and an empty line. Then, for each line on stdin, runs
the reader of that number and prints the seconds it took. All read the two acceleration columns
into memory.
"""

import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pandas as pd
import polars as pl

folder = Path(sys.argv[1])
files = sorted(folder.glob("acc_*.csv"))


def polars_read(file):
    return pl.read_csv(file, has_header=False, columns=[4, 5])


def pandas_read(file):
    return pd.read_csv(file, header=None, usecols=[4, 5])


def polars_files():
    return [polars_read(file) for file in files]


def polars_threads():
    with ThreadPoolExecutor() as pool:
        return list(pool.map(polars_read, files))


def polars_scan():
    scan = pl.scan_csv(folder / "acc_*.csv", has_header=False)
    return scan.select(pl.nth(4, 5)).collect()


def pandas_files():
    return [pandas_read(file) for file in files]


def pandas_threads():
    with ThreadPoolExecutor() as pool:
        return list(pool.map(pandas_read, files))


readers = [
    (f"polars {pl.__version__}, read_csv a file", polars_files),
    (f"polars {pl.__version__}, read_csv in threads", polars_threads),
    (f"polars {pl.__version__}, scan_csv of all", polars_scan),
    (f"pandas {pd.__version__}, read_csv a file", pandas_files),
    (f"pandas {pd.__version__}, read_csv in threads", pandas_threads),
]
for name, _ in readers:
    print(name)
print(flush=True)
for line in sys.stdin:
    start = time.perf_counter()
    readers[int(line)][1]()
    print(time.perf_counter() - start, flush=True)
