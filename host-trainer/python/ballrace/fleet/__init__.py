"""`monitor`, `phases`, `sweep` and `diagnose` over many machines, on Dask; results in Parquet. See docs/fleet.md."""

from .engine import Summary, run
from .sources import Folders, InputError, Partitions, Synthetic

__all__ = ["Folders", "InputError", "Partitions", "Summary", "Synthetic", "run"]
