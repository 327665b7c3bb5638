"""A folder for files between processes that does not outlive them, even if they are killed.

It belongs to whoever holds a lock on it, which the system takes away with the process. Who wants a
folder clears away those first that belong to nobody any more.
"""

import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

_PREFIX = "orbitdb-parcels-"
_OURS = re.compile(r"[0-9a-f]{32}")
"""Names of the files, as `uuid.uuid4` gives them: nothing else is ever removed."""


@contextmanager
def scratch_folder() -> Iterator[Path]:
    """Make a folder that is removed behind the context, with all files in it.

    Notes
    -----
    Where folders cannot be locked (Windows, some network file systems) left-overs stay.
    """
    _clear_left_overs()
    while True:
        path = Path(tempfile.mkdtemp(prefix=_PREFIX))
        lock = _lock(path, wait=True)
        if path.exists():  # else another process has just taken it for a left-over
            break
        if lock is not None:
            os.close(lock)
    try:
        yield path
    finally:
        _remove(path)
        if lock is not None:
            os.close(lock)


def _clear_left_overs() -> None:
    """Remove this user's folders that nobody holds."""
    for path in Path(tempfile.gettempdir()).glob(f"{_PREFIX}*"):
        lock = _lock(path, wait=False)
        if lock is not None:
            _remove(path)
            os.close(lock)


def _lock(path: Path, wait: bool) -> int | None:
    """Take a folder of this user's; None if it cannot be locked, or somebody holds it and we do not wait."""
    try:
        import fcntl

        opened = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    except (ImportError, OSError):
        return None
    try:
        if os.fstat(opened).st_uid == os.getuid():
            fcntl.flock(opened, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
            return opened
    except OSError:
        pass
    os.close(opened)
    return None


def _remove(path: Path) -> None:
    with suppress(OSError):
        for file in path.iterdir():
            if _OURS.fullmatch(file.name):
                file.unlink(missing_ok=True)
        path.rmdir()
