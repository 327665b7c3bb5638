"""The path of a catalogue, the identity of the file that is there, and where its journal is.

This module does not import NumPy, so that commands without a catalogue start at once.
"""

import os
from pathlib import Path
from typing import NamedTuple

from orbitdb.errors import InputError, StoreError


def default_path() -> Path:
    """Return the path of the default catalogue: ORBITDB_DB, or ``orbits.db`` in the user's data folder."""
    named = os.environ.get("ORBITDB_DB")
    return home_expanded(named) if named else data_folder() / "orbits.db"


def home_expanded(path: Path | str) -> Path:
    """Return a path with the home folder in place of ``~``, which shells leave as it is within quotes."""
    if not os.fspath(path):
        raise InputError("the path is empty: name a file")
    if "\0" in str(path):
        raise InputError(f"{str(path)!r} cannot be a path: name a file without null characters")
    return Path(os.path.expanduser(path))


def absolute_path(path: Path | str | None) -> Path:
    """Return the absolute path of a catalogue, so that it does not follow `os.chdir`; None is the default."""
    return (default_path() if path is None else home_expanded(path)).absolute()


def data_folder() -> Path:
    """Return the user's data folder for orbitdb."""
    from platformdirs import user_data_path

    return user_data_path("orbitdb", appauthor=False)


class Place(NamedTuple):
    """The identity of a file, whatever its name."""

    device: int
    inode: int


def place(path: Path) -> Place | None:
    """Identify the file that is now at a path; return None if nothing is there."""
    try:
        status = path.stat()
    except OSError:
        return None
    return Place(status.st_dev, status.st_ino)


def need_place(path: Path, opened: Place | None, message: str) -> None:
    """Raise `StoreError` if the opened file was replaced or deleted; `message` ends the error message."""
    now = place(path)
    if now != opened:
        what = "moved or deleted" if now is None else "replaced by another file"
        raise StoreError(f"{path} was {what} while this command {message}")


def beside(path: Path) -> tuple[Path, Path]:
    """Return the paths of a file's journal and of the journal's index."""
    real = Path(os.path.realpath(path))
    return real.with_name(real.name + "-wal"), real.with_name(real.name + "-shm")


def places_beside(path: Path) -> dict[Path, Place | None]:
    """Return the identities of a file's journal and of the journal's index."""
    return {part: place(part) for part in beside(path)}


def remove_journal_of(path: Path, opened: Place | None, journal: dict[Path, Place | None]) -> None:
    """Remove the journal of an opened file that is no longer at its path; SQLite would leave it there.

    It would be taken for that of the next file with this name.
    """
    if place(path) != opened:
        for part, was in journal.items():
            if was is not None and place(part) == was:
                part.unlink(missing_ok=True)
