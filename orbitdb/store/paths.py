"""The path of a catalogue, the identity of the file that is there, and whether its disk is a network disk.

This module does not import NumPy or SQLAlchemy, so that commands without a catalogue start at once.
"""

import os
import re
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from orbitdb.errors import InputError, StoreError
from orbitdb.text import quoted


def default_path() -> Path:
    """Return the path of the default catalogue: ORBITDB_DB, or ``orbits.db`` in the user's data folder."""
    named = os.environ.get("ORBITDB_DB")
    return home_expanded(named) if named else data_folder() / "orbits.db"


def as_path(path: Path | str) -> Path:
    """Return a path as it is; raise `InputError` for anything else, such as a half length."""
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"path = {path!r:.40}: give the path of a file; a half length is a={path!r:.40}")
    return Path(path)


def home_expanded(path: Path | str) -> Path:
    """Return a path with the home folder in place of ``~``, which shells leave as it is within quotes."""
    as_path(path)
    if not os.fspath(path):
        raise InputError("the path is empty: name a file")
    if "\0" in str(path):
        raise InputError(f"{str(path)!r} cannot be a path: name a file without null characters")
    expanded = Path(os.path.expanduser(path))
    if expanded.name == ":memory:" or expanded.name.endswith(_OF_JOURNALS):
        raise InputError(f"{expanded.name} has a meaning for SQLite: name another file")
    if (size := len(os.fsencode(expanded.name))) > _LONGEST_NAME:
        raise InputError(f"the file name has {size} bytes: give one of at most {_LONGEST_NAME}")
    return expanded


_OF_JOURNALS = ("-wal", "-shm", "-journal")
"""What SQLite adds to the name of a file for its journals."""

_LONGEST_NAME = 255 - max(map(len, _OF_JOURNALS))
"""Maximum length of a file name in bytes, so that systems allow those of the journals, too."""


def absolute_path(path: Path | str | None) -> Path:
    """Return the absolute path of a catalogue, so that it does not follow `os.chdir`; None is the default."""
    return (default_path() if path is None else home_expanded(path)).absolute()


def data_folder() -> Path:
    """Return the user's data folder for orbitdb.

    Raises
    ------
    StoreError
        If you have no home folder.
    """
    from platformdirs import user_data_path

    try:
        folder = user_data_path("orbitdb", appauthor=False)
    except (KeyError, RuntimeError):  # no HOME, and no entry for this user
        folder = None
    if folder is None or not folder.is_absolute():
        raise StoreError("you have no home folder: name a catalogue with --db or ORBITDB_DB")
    return folder


class FileId(NamedTuple):
    """The identity of a file, and what changes when it is written."""

    device: int
    inode: int
    size: int
    modified: int

    def is_same(self, other: "FileId | None") -> bool:
        """Tell whether this is the same file, even if it was written in the meantime."""
        return other is not None and self[:2] == other[:2]


def file_id(path: Path) -> FileId | None:
    """Identify the file that is now at a path; return None if nothing is there."""
    try:
        status = path.stat()
    except OSError:
        return None
    return FileId(status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns)


def journal_files(path: Path) -> tuple[Path, Path]:
    """Return the paths of a file's journal and of the journal's index, which lie beside the file itself."""
    real = Path(os.path.realpath(path)) if path.is_symlink() else path
    return real.with_name(real.name + "-wal"), real.with_name(real.name + "-shm")


def journal_ids(path: Path) -> dict[Path, FileId | None]:
    """Return the identities of a file's journal and of the journal's index."""
    return {part: file_id(part) for part in journal_files(path)}


def journal_size(path: Path) -> int:
    """Return the size in bytes of a file's journal; 0 if it has none."""
    journal = file_id(journal_files(path)[0])
    return journal.size if journal else 0


def refuse_links(path: Path) -> None:
    """Raise `StoreError` if a file to write has another name: each name has a journal of its own."""
    with suppress(OSError):
        if path.stat().st_nlink > 1:
            raise StoreError(
                f"{path} has another name (a hard link, as 'cp -al' makes), and writing through two names "
                f"destroys it: make it a file of its own with 'cp {quoted(path)} {quoted(f'{path}.new')} && "
                f"mv {quoted(f'{path}.new')} {quoted(path)}'"
            )


def check_same_file(path: Path, opened: FileId | None, message: str) -> None:
    """Raise `StoreError` if the opened file was replaced or deleted; `message` ends the error message."""
    now = file_id(path)
    if now is None or not now.is_same(opened):
        what = "moved or deleted" if now is None else "replaced by another file"
        raise StoreError(f"{path} was {what} while this command {message}")


NETWORK_DISKS = {
    *("9p", "afs", "beegfs", "ceph", "cifs", "coda", "fhgfs", "gfs2", "glusterfs", "gpfs", "lustre", "ncpfs"),
    *("nfs", "nfs4", "ocfs2", "orangefs", "panfs", "pvfs2", "smb3", "smbfs", "virtiofs", "wekafs"),
    *("fuse.beegfs", "fuse.ceph", "fuse.glusterfs", "fuse.juicefs", "fuse.rclone", "fuse.s3fs", "fuse.sshfs"),
}
"""Types of file systems that several machines can use; SQLite's journal works on only one of them."""


def disk_type(path: Path, mounts: str) -> str | None:
    """Return the type of the file system of an absolute path, given the text of ``/proc/mounts``.

    It is that of the longest mount point that contains the path; of several there, that of the last one.
    """
    kinds: dict[Path, str] = {}
    for line in mounts.splitlines():
        _, place, kind, *_ = line.split(" ")
        kinds[Path(_OCTAL.sub(lambda match: chr(int(match[1], 8)), place))] = kind
    return next((kinds[point] for point in (path, *path.parents) if point in kinds), None)


_OCTAL = re.compile(r"\\([0-7]{3})")
"""How the system writes blanks in the names of folders."""


def network_disk(path: Path) -> str | None:
    """Return the type of the file system of a path if it is a network disk, or None."""
    try:
        mounts = Path("/proc/mounts").read_text(encoding="utf-8", errors="surrogateescape")
    except OSError:  # not on Linux
        return None
    kind = disk_type(Path(os.path.realpath(path)), mounts)
    return kind if kind in NETWORK_DISKS else None
