"""Times SciPy's solve_ivp on the 5-DoF rig: `rig_peer.py REFERENCE BALLS NUMBER…`.

REFERENCE holds the accelerations ax and ay of the second half of the time, doubles. Prints a line for each method:
name, seconds (median of 3), RMS error against the reference, at the loosest tolerance that keeps to the target.
"""

import sys
import time

import numpy as np
from scipy.integrate import solve_ivp

reference = np.fromfile(sys.argv[1]).reshape(2, -1)
balls = int(sys.argv[2])
numbers = [float(v) for v in sys.argv[3:]]
ms, ks, cs, mp, kp, cp, mr, kr, cr = numbers[:9]
kb, clearance, unbalance, load, omega, cage, shaft0, cage0 = numbers[9:17]
gravity, rate, target, absolute_per_relative = numbers[17:]
samples = reference.shape[1]
pitch = 2 * np.pi * np.arange(balls) / balls
centrifugal = unbalance * omega**2


def derivative(t, z):
    xs, xp, ys, yp, yb, vxs, vxp, vys, vyp, vyb = z
    angle = cage0 + cage * t + pitch
    c, s = np.cos(angle), np.sin(angle)
    deflection = np.maximum((xs - xp) * c + (ys - yp) * s - clearance, 0.0)
    force = kb * deflection * np.sqrt(deflection)
    fx, fy = force @ c, force @ s
    psi = shaft0 + omega * t
    spring = kr * (yb - yp) + cr * (vyb - vyp)
    return np.array([
        vxs, vxp, vys, vyp, vyb,
        (centrifugal * np.cos(psi) - fx - cs * vxs - ks * xs) / ms,
        (fx - cp * vxp - kp * xp) / mp,
        (load - ms * gravity + centrifugal * np.sin(psi) - fy - cs * vys - ks * ys) / ms,
        (fy - cp * vyp - kp * yp + spring) / mp,
        -spring / mr - gravity,
    ])


def run(method, tolerance):
    times = np.arange(2 * samples) / rate
    start = time.perf_counter()
    solution = solve_ivp(
        derivative, (0.0, times[-1]), np.zeros(10), method, t_eval=times,
        rtol=max(tolerance, 3e-14), atol=tolerance * absolute_per_relative,
    )
    a = np.array([derivative(t, z) for t, z in zip(times[samples:], solution.y.T[samples:])]).T
    seconds = time.perf_counter() - start
    return seconds, np.sqrt(np.mean((a[[6, 9]] - reference) ** 2))


for method in ["LSODA", "RK45"]:
    for exponent in range(3, 13):
        seconds, error = run(method, 10.0**-exponent)
        if error <= target:
            break
    seconds = sorted([seconds] + [run(method, 10.0**-exponent)[0] for _ in range(2)])[1]
    print(f"SciPy {method}, rtol 1e-{exponent:02}\t{seconds}\t{error}")
