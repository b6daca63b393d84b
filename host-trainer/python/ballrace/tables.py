"""Recordings from and to tables of pandas, polars and Arrow, by narwhals."""

from __future__ import annotations

from typing import Any

import narwhals as nw
import numpy as np

from ._ballrace import InputError, Recording

TIME = "time_s"


def recording(table: Any, *, sample_rate_hz: float | None = None, name: str = "recording", **condition: float) -> Recording:
    """Recording of a table: a column a channel, accelerations in m/s².

    Without `sample_rate_hz` the rate is that of the column `time_s`, whose steps must be even. `condition`: `shaft_hz`, `load_n`.
    Raises `InputError` for a column that holds no numbers, or without a rate.
    """
    frame = nw.from_native(table, eager_only=True)
    columns: dict[str, np.ndarray] = {}
    for column in frame.columns:
        if not frame[column].dtype.is_numeric():
            raise InputError(f"column {column}: found {frame[column].dtype}, expected numbers")
        columns[column] = np.ascontiguousarray(frame[column].to_numpy(), dtype=np.float64)
    time = columns.pop(TIME, None)
    if sample_rate_hz is None:
        sample_rate_hz = _rate(time)
    return Recording(columns, sample_rate_hz, name=name, **condition)


def _rate(time: np.ndarray | None) -> float:
    if time is None or len(time) < 2:
        raise InputError(f"found neither sample_rate_hz nor a column {TIME} of two rows, expected one of them")
    steps = np.diff(time)
    step = float(np.median(steps))
    if not (step > 0 and np.all(np.abs(steps - step) < 0.01 * step)):
        raise InputError(f"column {TIME}: found steps from {steps.min():g} to {steps.max():g} s, expected even ones")
    return (len(time) - 1) / float(time[-1] - time[0])


def columns(recording: Recording) -> dict[str, np.ndarray]:
    """Columns of a recording: `time_s`, then its channels, which are not copied."""
    return {TIME: np.arange(len(recording)) / recording.sample_rate_hz} | recording.channels


def pandas(recording: Recording) -> Any:
    """Data frame of pandas, a column a channel."""
    import pandas as pd

    return pd.DataFrame(columns(recording), copy=False)


def polars(recording: Recording) -> Any:
    """Data frame of polars, a column a channel."""
    import polars as pl

    return pl.DataFrame(columns(recording))


def arrow(recording: Recording) -> Any:
    """Table of Arrow, a column a channel."""
    import pyarrow as pa

    return pa.table(columns(recording))
