"""Equations of known systems, found from their states and derivatives."""

import numpy as np
import pytest

import ballrace

NAMES = ["1", "x", "v", "xx", "xv", "vv", "xxx", "xxv", "xvv", "vvv", "cos", "sin"]
TRUTH = [{"v": 1.0}, {"x": 1.0, "v": -0.3, "xxx": -1.0, "cos": 0.5}]


def duffing(rows=20_000, step=5e-3):
    """Times, states (rows, 2) and rates (rows, 2) of x″ + 0.3 x′ − x + x³ = 0.5 cos 1.2 t, by steps of Runge and Kutta."""

    def rate(t, s):
        return np.array([s[1], -0.3 * s[1] + s[0] - s[0] ** 3 + 0.5 * np.cos(1.2 * t)])

    state, states = np.array([0.5, 0.0]), []
    times = step * np.arange(rows)
    for t in times:
        states.append(state)
        k1 = rate(t, state)
        k2 = rate(t + step / 2, state + step / 2 * k1)
        k3 = rate(t + step / 2, state + step / 2 * k2)
        state = state + step / 6 * (k1 + 2 * k2 + 2 * k3 + rate(t + step, state + step * k3))
    states = np.array(states)
    return times, states, rate(times, states.T).T


def library(times, states):
    """Powers up to the third, and the forcing's frequency: (rows, 12)."""
    x, v = states.T
    powers = [x**i * v ** (n - i) for n in range(4) for i in range(n, -1, -1)]
    return np.stack([*powers, np.cos(1.2 * times), np.sin(1.2 * times)], axis=1)


def equations(coefficients):
    return [{name: value for name, value in zip(NAMES, column) if value != 0} for column in coefficients.T]


def test_the_forced_duffing_oscillator_is_found():
    times, states, rates = duffing()
    theta = library(times, states)
    for found, truth in zip(equations(ballrace.stlsq(theta, rates)), TRUTH):
        assert found == pytest.approx(truth, rel=1e-9)
    # Derivatives of the states by central differences, good to h²/6 of the third derivative.
    slopes = np.gradient(states, times, axis=0, edge_order=2)
    for found, truth in zip(equations(ballrace.stlsq(theta, slopes, threshold=1e-4)), TRUTH):
        assert found == pytest.approx(truth, rel=1e-4)
    # With noise of a tenth of their spread on the rates the terms are the same.
    noisy = rates + 0.1 * rates.std(axis=0) * np.random.default_rng(0).standard_normal(rates.shape)
    for found, truth in zip(equations(ballrace.stlsq(theta, noisy, threshold=1e-3)), TRUTH):
        assert found == pytest.approx(truth, rel=0.02)


@pytest.mark.parametrize("seed", range(20))
def test_no_equation_is_found_where_there_is_none(seed):
    times, states, rates = duffing()
    theta = library(times, states)
    random = np.random.default_rng(seed)
    # White noise, and the true rates in another order: the same values without the dynamics.
    targets = np.column_stack([random.standard_normal(len(rates)), random.permutation(rates[:, 1])])
    # By chance a term has a share of about one in 20,000 rows, ten times that where columns are alike.
    assert not ballrace.stlsq(theta, targets, threshold=1e-2).any()
    # The order is all that was taken: with it the same call finds the equation.
    assert equations(ballrace.stlsq(theta, rates[:, 1:], threshold=1e-2))[0] == pytest.approx(TRUTH[1], rel=1e-9)
