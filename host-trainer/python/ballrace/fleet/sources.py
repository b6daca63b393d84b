"""Machines and their recordings: folders, Parquet partitioned by machine and day, or synthetic ones made on the fly."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote

from . import synthetic

PARTITION = "machine="
DAY = "day="


class InputError(ValueError):
    """Bad input: where, what was found, what was expected."""


@dataclass(frozen=True)
class Folders:
    """Machines as subfolders of `root`: `root/NAME/` holds the recordings of NAME, `root/NAME/recordings/` where that
    exists. A `rig.toml` and a folder `baseline/` beside them are the machine's own."""

    root: str

    def names(self) -> Iterator[str]:
        """Names of the machines, ordered."""
        yield from sorted(entry.name for entry in os.scandir(self.root) if entry.is_dir() and not entry.name.startswith("."))

    def recordings(self, name: str, scratch: Path) -> Path:
        """Folder of the machine's recordings."""
        folder = Path(self.root, name)
        inner = folder / "recordings"
        return inner if inner.is_dir() else folder

    def own(self, name: str, file: str) -> Path | None:
        """A file or folder that the machine has of its own, such as `rig.toml`."""
        path = Path(self.root, name, file)
        return path if path.exists() else None


@dataclass(frozen=True)
class Partitions:
    """Machines as Hive partitions: `root/machine=NAME/day=DATE/*.parquet`, each file a recording, a column a channel.
    Days follow each other in the order of their names; with `days` only those are read."""

    root: str
    days: tuple[str, ...] = ()

    def names(self) -> Iterator[str]:
        """Names of the machines, ordered."""
        entries = (entry for entry in os.scandir(self.root) if entry.is_dir())
        yield from sorted(unquote(entry.name[len(PARTITION) :]) for entry in entries if entry.name.startswith(PARTITION))

    def folder(self, name: str) -> Path:
        """The machine's partition; its name is percent-encoded where Hive's writers do so."""
        plain = Path(self.root, PARTITION + name)
        if plain.is_dir():
            return plain
        entries = (entry for entry in os.scandir(self.root) if entry.name.startswith(PARTITION))
        found = [Path(entry.path) for entry in entries if unquote(entry.name[len(PARTITION) :]) == name]
        if not found:
            raise InputError(f"{plain}: found nothing there, expected the partition of a machine")
        return found[0]

    def recordings(self, name: str, scratch: Path) -> Path:
        """Folder of links to the machine's files, in the order of days and names; nothing is copied."""
        folder, links = self.folder(name), scratch / "recordings"
        links.mkdir()
        files = sorted(path for path in folder.glob(f"{DAY}*/*.parquet") if not path.name.startswith((".", "_")))
        if self.days:
            files = [path for path in files if unquote(path.parent.name[len(DAY) :]) in self.days]
        if not files:
            days = f"day={', '.join(self.days)}" if self.days else "day=DATE"
            raise InputError(f"{folder}: found no recordings, expected {days}/*.parquet")
        for path in files:
            (links / f"{path.parent.name[len(DAY) :]}_{path.name}").symlink_to(path.resolve())
        return links

    def own(self, name: str, file: str) -> Path | None:
        """A file or folder that the machine has of its own, such as `rig.toml`."""
        path = self.folder(name) / file
        return path if path.exists() else None


@dataclass(frozen=True)
class Synthetic:
    """Machines number 0 to `count` − 1 with `recordings` short recordings each, made when they are worked on."""

    count: int
    per_machine: int = 3
    seed: int = 0

    def names(self) -> Iterator[str]:
        """Names of the machines, ordered."""
        return (f"m{number:07}" for number in range(self.count))

    def recordings(self, name: str, scratch: Path) -> Path:
        """Folder into which the machine's recordings were written just now."""
        folder = scratch / "recordings"
        synthetic.write(folder, int(name[1:]), self.per_machine, self.seed)
        return folder

    def own(self, name: str, file: str) -> Path | None:
        """Nothing: a synthetic machine has its recordings only."""
        return None


Source = Folders | Partitions | Synthetic


def open_source(machines: str | os.PathLike | Source, days: tuple[str, ...] = ()) -> Source:
    """Source that `machines` names: a folder, or `synthetic:COUNT[:RECORDINGS[:SEED]]`.

    Raises `InputError` where there are no machines."""
    if isinstance(machines, Folders | Partitions | Synthetic):
        return machines
    text = os.fspath(machines)
    if text.startswith("synthetic:"):
        try:
            return Synthetic(*(int(part) for part in text.split(":")[1:]))
        except (TypeError, ValueError):
            raise InputError(f"{text}: expected synthetic:COUNT[:RECORDINGS[:SEED]], whole numbers") from None
    root = os.path.abspath(text)
    if not os.path.isdir(root):
        raise InputError(f"{text}: found no folder, expected one with a subfolder or a partition machine=NAME a machine")
    partitions = Partitions(root, days)
    if next(partitions.names(), None) is not None:
        return partitions
    if days:
        raise InputError(f"{text}: found no partition machine=NAME, expected them with --day")
    folders = Folders(root)
    if next(folders.names(), None) is None:
        raise InputError(f"{text}: found no machine, expected a subfolder or a partition machine=NAME for each")
    return folders
