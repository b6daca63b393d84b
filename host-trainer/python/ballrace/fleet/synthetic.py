"""Synthetic machines: short recordings of a housing's resonance under noise and shaft, some with a defect of the outer race."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from . import settings

#: Shaft's speed, ball passes of the outer race a turn, natural frequency in Hz and damping ratio of the housing.
SHAFT_HZ, BALL_PASSES, NATURAL_HZ, DAMPING = 25.0, 5.4, 3_000.0, 0.03


def is_defective(number: int, seed: int = 0) -> bool:
    """Whether machine `number` has a defect."""
    return bool(np.random.default_rng([seed, number]).random() < settings.SYNTHETIC_DEFECTS)


def samples(number: int, recordings: int, seed: int = 0) -> np.ndarray:
    """Acceleration in m/s² of machine `number`, shape (recordings, SYNTHETIC_SAMPLES); the same for the same seed."""
    rng = np.random.default_rng([seed, number])
    defective = rng.random() < settings.SYNTHETIC_DEFECTS
    n, rate = settings.SYNTHETIC_SAMPLES, settings.SYNTHETIC_RATE_HZ
    time = np.arange(n) / rate
    speed = SHAFT_HZ * (1.0 + 0.02 * rng.standard_normal(recordings))[:, None]
    angle = 2.0 * np.pi * rng.random((recordings, 1)) + 2.0 * np.pi * speed * time
    force = rng.standard_normal((recordings, n))
    if defective:
        passes = np.floor(BALL_PASSES * angle / (2.0 * np.pi))
        force += 40.0 * np.diff(passes, axis=1, prepend=passes[:, :1])
    decay = np.exp(-2.0 * np.pi * DAMPING * NATURAL_HZ * time) * np.sin(2.0 * np.pi * NATURAL_HZ * time)
    transfer = np.fft.rfft(decay, 2 * n)
    response = np.fft.irfft(np.fft.rfft(force, 2 * n) * transfer)[:, :n]
    return 0.3 * response + 0.5 * np.sin(angle) + 0.05 * rng.standard_normal((recordings, n))


def write(folder: Path, number: int, recordings: int, seed: int = 0) -> None:
    """Write machine `number` as `.npy` files and a `recordings.toml` into the new folder `folder`."""
    folder.mkdir(parents=True)
    entries = [f"[defaults]\nsample_rate_hz = {settings.SYNTHETIC_RATE_HZ}\nshaft_hz = {SHAFT_HZ}\n"]
    for index, recording in enumerate(samples(number, recordings, seed)):
        np.save(folder / f"r{index:03}.npy", recording.astype(np.float32))
        entries.append(f'[[recording]]\nfile = "r{index:03}.npy"\n')
    (folder / "recordings.toml").write_text("".join(entries))
