"""From a vibration recording to a sparse dynamics model on a microcontroller, and what a simulation left out.

>>> import ballrace
>>> recordings = ballrace.load("data/Bearing3_3")
>>> model = ballrace.fit(recordings[:100])
>>> ballrace.monitor(model, recordings)["summary"]["first_alarm"]
>>> open("model.bin", "wb").write(model.export("bin"))

Many machines at once: `ballrace.fleet`. Estimators of scikit-learn: `ballrace.sklearn`. Tables: `ballrace.tables`.
"""

from ._ballrace import (
    Diagnosis,
    Error,
    InputError,
    Model,
    Page,
    Recording,
    Rig,
    __version__,
    calibrate,
    diagnose,
    fit,
    load,
    monitor,
    phases,
    spectra,
    stlsq,
    sweep,
)
from ._report import Report

__all__ = [
    "Diagnosis",
    "Error",
    "InputError",
    "Model",
    "Page",
    "Recording",
    "Report",
    "Rig",
    "__version__",
    "calibrate",
    "diagnose",
    "fit",
    "load",
    "monitor",
    "phases",
    "spectra",
    "stlsq",
    "sweep",
]
