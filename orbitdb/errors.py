"""What can be wrong with what a user gives: errors whose message is one line with the remedy."""

import errno

DISK_TROUBLE = {getattr(errno, name, errno.EIO) for name in ("ENOSPC", "EDQUOT", "EFBIG", "EIO")}
"""What the system reports when a disk is full or fails."""


class InputError(ValueError):
    """A value cannot be used; the message says why and how to write it."""


class StoreError(Exception):
    """The database, or the disk, cannot be used; the message says why and what to do."""


class WorkError(Exception):
    """Worker processes could not do their work; the message says why and what to do."""


class ExportError(InputError):
    """The file cannot be written; the message says why and what to do."""
