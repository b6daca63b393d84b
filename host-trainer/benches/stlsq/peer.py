"""STLSQ of pysindy on the Lorenz system's cubic library: `peer.py ROWS RUNS` prints one JSON line."""

import json
import os
import sys
import time
import warnings

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np
import pysindy

warnings.filterwarnings("ignore")
rows, runs = int(sys.argv[1]), int(sys.argv[2])


def rate(s):
    x, y, z = s
    return np.array([10 * (y - x), x * (28 - z) - y, x * y - 8 / 3 * z])


h, state = 0.002, np.array([-8.0, 8.0, 27.0])
states = np.empty((rows, 3))
for n in range(rows):
    states[n] = state
    k1 = rate(state)
    k2 = rate(state + h / 2 * k1)
    k3 = rate(state + h / 2 * k2)
    k4 = rate(state + h * k3)
    state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
rates = rate(states.T).T
library = pysindy.PolynomialLibrary(degree=3).fit(states)
theta = np.asarray(library.transform(states))
times = []
for _ in range(runs):
    start = time.perf_counter()
    fitted = pysindy.STLSQ(threshold=0.1, alpha=0.05).fit(theta, rates)
    times.append(1e3 * (time.perf_counter() - start))
terms = (np.abs(fitted.coef_) > 0).sum(axis=1).tolist()
print(json.dumps({"version": pysindy.__version__, "median_ms": sorted(times)[runs // 2], "terms": terms}))
