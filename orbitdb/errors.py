"""Errors that users see; each message is one line that says what to do."""

import errno
from numbers import Integral

DISK_TROUBLE = {getattr(errno, name, errno.EIO) for name in ("ENOSPC", "EDQUOT", "EFBIG", "EIO")}
"""Error numbers that mean a full or failing disk."""


class InputError(ValueError):
    """A value is invalid; the message says why, and what form it should have."""


def need_whole(name: str, value: object, least: int = 1) -> None:
    """Raise `InputError` unless the value with this name is a whole number and not too small."""
    if isinstance(value, bool) or not isinstance(value, Integral) or value < least:
        raise InputError(f"{name} = {value!r:.40}: give a whole number, {least} or more")


class StoreError(Exception):
    """The database, or the disk, cannot be used; the message says why and what to do."""


class AlteredError(StoreError):
    """The database contains something that no command of this program writes.

    Attributes
    ----------
    what : str
        What the value should be, and the value.
    """

    def __init__(self, what: str) -> None:
        super().__init__(what)
        self.what = what

    def __str__(self) -> str:
        return f"the catalogue was altered: {self.what}; 'orbitdb verify' shows what is wrong"


class WorkError(Exception):
    """Worker processes could not do their work; the message says why and what to do."""


class ExportError(InputError):
    """The file cannot be written; the message says why and what to do."""
