"""What can be wrong with what a user gives: errors whose message is one line with the remedy."""

import errno

DISK_TROUBLE = {getattr(errno, name, errno.EIO) for name in ("ENOSPC", "EDQUOT", "EFBIG", "EIO")}
"""What the system reports when a disk is full or fails."""


class InputError(ValueError):
    """A value cannot be used; the message says why and how to write it."""


class StoreError(Exception):
    """The database, or the disk, cannot be used; the message says why and what to do."""


class AlteredError(StoreError):
    """The database holds what no command of this program writes.

    Attributes
    ----------
    what : str
        The value, and what it stands for.
    """

    def __init__(self, what: str) -> None:
        super().__init__(what)
        self.what = what

    def __str__(self) -> str:
        return f"the catalogue was altered: {self.what}; 'orbitdb verify' tells what is wrong"


class WorkError(Exception):
    """Worker processes could not do their work; the message says why and what to do."""


class ExportError(InputError):
    """The file cannot be written; the message says why and what to do."""
