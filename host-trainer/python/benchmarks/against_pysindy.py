"""Equations of Lorenz and of a forced Duffing oscillator, found by pysindy and by ballrace in one run.

`python benchmarks/against_pysindy.py [--rows N] [--runs N]`, with pysindy and scikit-learn. Two comparisons of each problem:

- regression: the same library matrix and the same exact derivatives for both; only the regression is timed;
- whole fit: from states and times alone. pysindy differentiates and expands by `FiniteDifference` and
  `PolynomialLibrary`; here the same is done by `numpy.gradient`, `PolynomialFeatures` and `ballrace.sklearn.STLSQ`.

Every library has one thread. The runs of both alternate; times are medians.
"""

import os

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ[variable] = "1"

import argparse
import statistics
import time
import warnings
from dataclasses import dataclass

import numpy as np
import pysindy
from sklearn.preprocessing import PolynomialFeatures

import ballrace
from ballrace.sklearn import STLSQ

PYSINDY_THRESHOLD = 0.1  # bound on a coefficient
PYSINDY_ALPHA = 0.0  # no ridge, as ours by default
SHARE = 1e-4  # ours: share of the target's variance
DEGREE = 3


@dataclass
class Problem:
    """A system, its trajectory, and a library of functions of its states."""

    name: str
    step_s: float
    states: np.ndarray  # (rows, states)
    rates: np.ndarray  # (rows, states), exact
    given: np.ndarray  # (rows, columns), functions of time that enter the library as they are
    truth: list[dict[str, float]]  # of each state's rate, by the name of the term
    names: list[str]  # of the states
    given_names: list[str]

    def library(self) -> np.ndarray:
        """Powers of the states up to the third, then the given columns: (rows, functions)."""
        return np.hstack([PolynomialFeatures(DEGREE).fit_transform(self.states), self.given])

    def terms(self) -> list[str]:
        powers = PolynomialFeatures(DEGREE).fit(self.states[:1])
        return [*powers.get_feature_names_out(self.names), *self.given_names]


def runge_kutta(rate, state: np.ndarray, step: float, rows: int) -> np.ndarray:
    """States (rows, states) at every step, of rate(t, state)."""
    states = np.empty((rows, len(state)))
    for n in range(rows):
        states[n] = state
        t = n * step
        k1 = rate(t, state)
        k2 = rate(t + step / 2, state + step / 2 * k1)
        k3 = rate(t + step / 2, state + step / 2 * k2)
        k4 = rate(t + step, state + step * k3)
        state = state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return states


def lorenz(rows: int) -> Problem:
    def rate(t, s):
        x, y, z = s
        return np.array([10 * (y - x), x * (28 - z) - y, x * y - 8 / 3 * z])

    states = runge_kutta(rate, np.array([-8.0, 8.0, 27.0]), 0.002, rows)
    truth = [{"x": -10, "y": 10}, {"x": 28, "y": -1, "x z": -1}, {"z": -8 / 3, "x y": 1}]
    return Problem("Lorenz", 0.002, states, rate(0, states.T).T, np.empty((rows, 0)), truth, ["x", "y", "z"], [])


def duffing(rows: int) -> Problem:
    """x″ + 0.3 x′ − x + x³ = 0.5 cos 1.2 t; the forcing enters the library as two columns that are given."""
    c, a, b, force, w = 0.3, -1.0, 1.0, 0.5, 1.2

    def rate(t, s):
        x, v = s
        return np.array([v, -c * v - a * x - b * x**3 + force * np.cos(w * t)])

    motion = runge_kutta(rate, np.array([0.5, 0.0]), 0.005, rows)
    t = 0.005 * np.arange(rows)
    given = np.column_stack([np.cos(w * t), np.sin(w * t)])
    truth = [{"v": 1}, {"x": 1, "v": -0.3, "x^3": -1, "cos": 0.5}]
    return Problem("forced Duffing", 0.005, motion, rate(t, motion.T).T, given, truth, ["x", "v"], ["cos", "sin"])


def alternating(first, second, runs: int) -> tuple[float, float]:
    """Median milliseconds of two calls, which take turns."""
    times = ([], [])
    for run in range(runs):
        for which, call in sorted(enumerate((first, second)), reverse=run % 2 == 1):
            began = time.perf_counter()
            call()
            times[which].append(1e3 * (time.perf_counter() - began))
    return statistics.median(times[0]), statistics.median(times[1])


def table(problem: Problem, theirs: np.ndarray, ours: np.ndarray) -> None:
    """Prints coefficients (terms, targets) side by side, of every term that one of the three has."""
    terms = problem.terms()
    print(f"  {'':7}{'term':9}{'truth':>12}{'pysindy':>14}{'ballrace':>14}")
    for target, truth in enumerate(problem.truth):
        for n, term in enumerate(terms):
            values = truth.get(term, 0.0), theirs[n, target], ours[n, target]
            if any(values):
                print(f"  {problem.names[target] + '′':7}{term:9}{values[0]:12.6f}{values[1]:14.8f}{values[2]:14.8f}")
    exact = np.array([[truth.get(term, 0.0) for truth in problem.truth] for term in terms])
    print(f"  largest difference: pysindy to ballrace {abs(theirs - ours).max():.1e}, "
          f"to the truth pysindy {abs(theirs - exact).max():.1e}, ballrace {abs(ours - exact).max():.1e}")


def compare(problem: Problem, runs: int) -> None:
    theta, states, given = problem.library(), problem.states, problem.given
    print(f"\n{problem.name}: {theta.shape[0]} rows, {theta.shape[1]} functions, {states.shape[1]} equations, "
          f"step {problem.step_s} s")

    def pysindy_regression():
        return pysindy.STLSQ(threshold=PYSINDY_THRESHOLD, alpha=PYSINDY_ALPHA).fit(theta, problem.rates).coef_.T

    def ballrace_regression():
        return ballrace.stlsq(theta, problem.rates, threshold=SHARE)

    print(" regression on the same matrix and exact derivatives")
    table(problem, pysindy_regression(), ballrace_regression())
    theirs, ours = alternating(pysindy_regression, ballrace_regression, runs)
    print(f"  median of {runs}: pysindy {theirs:.1f} ms, ballrace {ours:.1f} ms, ratio {theirs / ours:.1f}")

    def pysindy_whole():
        library = pysindy.PolynomialLibrary(degree=DEGREE)
        if given.size:
            of_states, of_given = range(states.shape[1]), range(states.shape[1], states.shape[1] + given.shape[1])
            library = pysindy.GeneralizedLibrary([library, pysindy.IdentityLibrary()], inputs_per_library=[of_states, of_given])
        model = pysindy.SINDy(
            optimizer=pysindy.STLSQ(threshold=PYSINDY_THRESHOLD, alpha=PYSINDY_ALPHA),
            feature_library=library,
            differentiation_method=pysindy.FiniteDifference(order=2),
        )
        model.fit(states, t=problem.step_s, u=given if given.size else None)
        return model.coefficients().T

    def ballrace_whole():
        rates = np.gradient(states, problem.step_s, axis=0, edge_order=2)
        return STLSQ(threshold=SHARE).fit(problem.library(), rates).coef_.T

    print(" whole fit: derivatives, library, regression")
    table(problem, pysindy_whole(), ballrace_whole())
    theirs, ours = alternating(pysindy_whole, ballrace_whole, max(3, runs // 3))
    print(f"  median of {max(3, runs // 3)}: pysindy {theirs:.0f} ms, ballrace {ours:.0f} ms, ratio {theirs / ours:.1f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=int, default=50_000)
    parser.add_argument("--runs", type=int, default=15)
    arguments = parser.parse_args()
    warnings.filterwarnings("ignore")
    print(f"pysindy {pysindy.__version__}, ballrace {ballrace.__version__}, one thread each")
    for problem in (lorenz(arguments.rows), duffing(arguments.rows)):
        compare(problem, arguments.runs)


if __name__ == "__main__":
    main()
