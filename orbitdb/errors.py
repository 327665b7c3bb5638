"""Errors that users see; each message is one line that says what to do."""

import errno
import math
from numbers import Real
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

DISK_TROUBLE = {getattr(errno, name, errno.EIO) for name in ("ENOSPC", "EDQUOT", "EFBIG", "EIO")}
"""Error numbers that mean a full or failing disk."""


class InputError(ValueError):
    """A value is invalid; the message says why, and what form it should have."""


class NotStoredError(InputError):
    """The catalogue lacks what a question needs; the message names the command that makes it."""


class SelectionError(InputError):
    """A part of the selection cannot be read; the message says how to write it."""


def check_int(name: str, value: Any, least: float = 1) -> int:
    """Return a whole number, such as 3, 1e7 or one of NumPy, as an int.

    Raises `InputError`, which names the value, for anything else, or if the number is below `least`.
    """
    number = isinstance(value, Real) and not isinstance(value, bool)
    if not number or value % 1 != 0 or value < least:
        bound = "" if least == -math.inf else f", {least} or more"
        raise InputError(f"{name} = {value!r:.40}: give a whole number{bound}")
    return int(value)


def check_number(name: str, value: Any) -> None:
    """Raise `InputError`, which names the value, unless it is a real number."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise InputError(f"{name} = {value!r:.40}: give a number")


def check_text(name: str, value: Any, example: str) -> None:
    """Raise `InputError`, which names the value and gives an example, unless it is a text."""
    if not isinstance(value, str):
        raise InputError(f"{name} = {value!r:.40}: give a text such as {example!r}")


def as_texts(name: str, values: Any) -> list[Any]:
    """Return the given texts as a list; a single one is a list of its own.

    Raises `InputError`, which names the values, if they are neither a text nor several; it does not look at
    each of several.
    """
    try:
        return [values] if isinstance(values, str | bytes) else [*values]
    except TypeError:
        raise InputError(f"{name} = {values!r:.40}: give a text, or a list of texts") from None


def as_floats(values: Any, help: str) -> "NDArray[np.float64]":
    """Return the given values as an array, without those that are masked (in rows, without such rows).

    Raises `InputError` with the help text if they are not real numbers.
    """
    import numpy as np  # late, because messages need no arrays

    if isinstance(values, np.ma.MaskedArray):
        masked = np.ma.getmaskarray(values).any(axis=tuple(range(1, values.ndim)))
        values = values.data[~masked]
    return as_reals(values, help)


def as_reals(values: Any, help: str) -> "NDArray[np.float64]":
    """Return the given values as an array of the same shape, with NaN where they are masked.

    Raises `InputError` with the help text if they are not real numbers.
    """
    import numpy as np

    try:
        given = np.ma.asarray(values)
        if not np.iscomplexobj(given):
            return np.asarray(np.ma.filled(given.astype(np.float64), np.nan))
    except (TypeError, ValueError, OverflowError):
        raise InputError(help) from None
    raise InputError(f"{help}; these are complex: give their real parts")


class StoreError(Exception):
    """The database, or the disk, cannot be used; the message says why and what to do."""


class DamagedError(StoreError):
    """SQLite cannot read the file, because parts of it are missing or wrong."""


class AlteredError(StoreError):
    """The database contains something that no command of this program writes.

    Attributes
    ----------
    what : str
        What is wrong: the expected value and the stored one.
    """

    def __init__(self, what: str) -> None:
        super().__init__(what)
        self.what = what

    def __str__(self) -> str:
        return f"the catalogue was altered: {self.what}; `catalogue.verify()` shows what is wrong"


class DeletedError(StoreError):
    """Rows that were chosen before have been deleted by another process since then."""

    def __str__(self) -> str:
        return f"{super().__str__()} were deleted meanwhile: ask again"


class WorkError(Exception):
    """Worker processes could not do their work; the message says why and what to do."""


class ExportError(InputError):
    """The file cannot be written; the message says why and what to do."""
