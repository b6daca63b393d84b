"""From a vibration recording to a sparse dynamics model on a microcontroller, and what a simulation left out.

>>> import ballrace
>>> recordings = ballrace.load("data/Bearing3_3")
>>> model = ballrace.fit(recordings[:100])
>>> ballrace.monitor(model, recordings)["summary"]["first_alarm"]
>>> open("model.bin", "wb").write(model.export("bin"))

Many machines at once: `ballrace.fleet`. Estimators of scikit-learn: `ballrace.sklearn`. Tables: `ballrace.tables`.
"""

from . import _ballrace
from ._ballrace import *  # noqa: F403
from ._report import Report

__all__ = ["Report"]
__all__ += _ballrace.__all__
