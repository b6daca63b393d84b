"""Native half of the package; the docstrings are those of the module itself."""

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from ._report import Report

__all__ = [
    "Diagnosis",
    "Error",
    "InputError",
    "Model",
    "Page",
    "Recording",
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
__version__: str

_Path: TypeAlias = str | PathLike[str]
_Recordings: TypeAlias = Recording | Sequence[Recording] | _Path | Sequence[_Path]
_Progress: TypeAlias = bool | Callable[[float | None, str], object]

class Error(Exception): ...
class InputError(ValueError): ...

@final
class Recording:
    def __new__(
        cls,
        channels: Mapping[str, NDArray[np.float64]],
        sample_rate_hz: float,
        *,
        name: str = "recording",
        shaft_hz: float | None = None,
        load_n: float | None = None,
    ) -> Recording: ...
    @property
    def name(self) -> str: ...
    @property
    def sample_rate_hz(self) -> float: ...
    @property
    def shaft_hz(self) -> float | None: ...
    @property
    def load_n(self) -> float | None: ...
    @property
    def channels(self) -> dict[str, NDArray[np.float64]]: ...
    def __getitem__(self, channel: str, /) -> NDArray[np.float64]: ...
    def __len__(self) -> int: ...

@final
class Page:
    @property
    def html(self) -> str: ...
    def save(self, path: _Path) -> None: ...

@final
class Model:
    @staticmethod
    def load(path: _Path) -> Model: ...
    def save(self, path: _Path) -> None: ...
    def export(self, format: Literal["json", "bin", "rust", "c"] = "bin") -> bytes: ...
    @property
    def report(self) -> dict[str, Any] | None: ...
    @property
    def sample_rate_hz(self) -> float: ...
    def predict(self, samples: NDArray[np.float64]) -> dict[str, NDArray[Any]]: ...
    def text(self, terms: int = 6) -> str: ...
    def print(self, terms: int = 6) -> None: ...

@final
class Rig:
    def __new__(cls, toml: str) -> Rig: ...
    @staticmethod
    def load(path: _Path) -> Rig: ...
    def to_toml(self) -> str: ...
    def simulate(
        self, shaft_hz: float, load_n: float, *, sample_rate_hz: float = 25600.0, seconds: float = 1.0, seed: int = 0
    ) -> Recording: ...
    def predict(self, recordings: _Recordings, *, seed: int = 0) -> list[Recording]: ...

@final
class Diagnosis:
    @property
    def verdict(self) -> Literal["mismatch", "no-mismatch", "unexplained"]: ...
    @property
    def sentence(self) -> str: ...
    @property
    def causes(self) -> list[dict[str, Any]]: ...
    @property
    def corrected_rig(self) -> Rig: ...
    @property
    def page(self) -> Page: ...
    def to_dict(self) -> dict[str, Any]: ...

def load(
    *paths: _Path,
    sample_rate_hz: float | None = None,
    unit: Literal["m/s^2", "g"] | None = None,
    variable: str | None = None,
    channels: Sequence[str] | None = None,
    resample_hz: float | None = None,
) -> list[Recording]: ...
def fit(
    recordings: _Recordings,
    *,
    channel: str | None = None,
    solver: Literal["sindy-nn", "stlsq"] = "sindy-nn",
    dimension: int | None = None,
    degree: int | None = None,
    harmonics: int | None = None,
    hidden: Sequence[int] | None = None,
    alignment: Literal["half", "forward", "causal"] | None = None,
    max_steps: int | None = None,
    trainings: int | None = None,
    null: int | None = None,
    false_alarms_per_day: float | None = None,
    seed: int = 0,
    progress: _Progress | None = None,
) -> Model: ...
def monitor(model: Model, recordings: _Recordings, *, channel: str | None = None) -> Report: ...
def calibrate(
    rig: Rig, recordings: _Recordings, *, seed: int = 0, progress: _Progress | None = None
) -> tuple[Rig, Report]: ...
def diagnose(
    rig: Rig,
    recordings: _Recordings,
    *,
    baseline: _Recordings | None = None,
    seed: int = 0,
    progress: _Progress | None = None,
) -> Diagnosis: ...
def spectra(
    recordings: _Recordings,
    *,
    shaft_hz: float | None = None,
    rig: _Path | None = None,
    band_hz: tuple[float, float] | None = None,
    channel: str | None = None,
    seed: int = 0,
) -> Report: ...
def phases(
    recordings: _Recordings,
    *,
    healthy: int | None = None,
    sigmas: float = 3.0,
    failure: Literal["successive", "rising", "largest"] = "largest",
    ratio: float = 3.0,
    wavelet: str = "db4",
    threshold: Literal["universal", "minimax", "sure"] = "universal",
    shrinkage: Literal["soft", "hard"] = "soft",
    noise: Literal["finest", "each-level"] = "each-level",
    below_hz: float = 50.0,
    name: _Path | None = None,
) -> Report: ...
def sweep(
    recordings: _Recordings,
    *,
    preset: Literal["table3", "table4", "table5", "fig10", "fig11", "all"] | None = None,
    count: int | None = None,
    lambda_: Sequence[float] | Sequence[Sequence[float]] | None = None,
    out: _Path | None = None,
    progress: _Progress | None = None,
    **grid: Any,
) -> list[dict[str, Any]]: ...
def stlsq(
    theta: NDArray[np.float64],
    targets: NDArray[np.float64],
    *,
    threshold: float = 1e-6,
    ridge: float = 0.0,
    rounds: int = 20,
) -> NDArray[np.float64]: ...
