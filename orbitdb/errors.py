"""Errors that users see; each message is one line that says what to do."""

import errno
import os
from collections.abc import Callable, Iterable, Sequence
from functools import cache, wraps
from inspect import signature
from numbers import Integral, Real
from pathlib import Path
from types import FunctionType, NoneType, UnionType
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar, get_args, get_origin

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

DISK_TROUBLE = {getattr(errno, name, errno.EIO) for name in ("ENOSPC", "EDQUOT", "EFBIG", "EIO")}
"""Error numbers that mean a full or failing disk."""


class InputError(ValueError):
    """A value is invalid; the message says why, and what form it should have."""


def need_whole(name: str, value: object, least: int = 1) -> None:
    """Raise `InputError` unless the value with this name is a whole number and not too small."""
    if isinstance(value, bool) or not isinstance(value, Integral) or value < least:
        raise InputError(f"{name} = {value!r:.40}: give a whole number, {least} or more")


def as_floats(values: Any, help: str) -> "NDArray[np.float64]":
    """Return the given values as an array; raise `InputError` with the help text if they are not numbers."""
    import numpy as np  # late, because messages need no arrays

    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputError(help) from None


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


_Function = TypeVar("_Function", bound=Callable[..., Any])
_Class = TypeVar("_Class", bound=type)

_Kinds: TypeAlias = dict[str, tuple[Any, tuple[type, ...], str]]
"""For each parameter of a function, its default, the types that are right, and their name in messages."""

_KINDS: dict[Any, tuple[type, str]] = {
    float: (Real, "a number"),
    int: (Integral, "a whole number"),
    str: (str, "a string"),
    Path: (os.PathLike, "a path"),
    Callable: (Callable, "a function"),  # type: ignore[dict-item]
    Sequence: (Iterable, "a list"),  # an array is a list, too
    Iterable: (Iterable, "a list"),
    NoneType: (NoneType, ""),
}
"""For each annotation that is checked, what a value must be, and its name in messages."""


def checked(function: _Function) -> _Function:
    """Decorate a function so that arguments of the wrong type raise `InputError`.

    Defaults are accepted, and parameters with other annotations than those in `_KINDS` are not checked.
    Numbers of NumPy become Python's, which SQLite and JSON can take, and 1e7 is a whole number.
    """

    @wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        kinds = _kinds_of(call)
        given = [_right(name, value, kinds) for name, value in zip(kinds, args, strict=False)]
        named = {name: _right(name, value, kinds) for name, value in kwargs.items()}
        return function(*given, *args[len(kinds) :], **named)

    return call  # type: ignore[return-value]


def _right(name: str, value: Any, kinds: _Kinds) -> Any:
    """Return an argument as a plain number if it is a number; raise `InputError` if its type is wrong."""
    default, types, meant = kinds.get(name, (None, (), ""))
    plain = value.item() if getattr(value, "shape", None) == () else value
    if Integral in types and isinstance(plain, float) and plain.is_integer():
        plain = int(plain)  # such as 1e7
    right = isinstance(plain, types) and not isinstance(plain, bool)
    if types and not right and value is not default:
        raise InputError(f"{name} = {plain!r:.40}: give {meant}")
    return plain


def checked_methods(owner: _Class) -> _Class:
    """Decorate a class so that its public methods check their arguments (`checked`)."""
    for name, method in list(vars(owner).items()):
        public = not name.startswith("_") or name in ("__init__", "__getitem__")
        if public and isinstance(method, FunctionType):
            setattr(owner, name, checked(method))
    return owner


@cache
def _kinds_of(function: Callable[..., Any]) -> _Kinds:
    """Return the default, the types and their names for each parameter; types are empty if unchecked."""
    kinds = {}
    for name, parameter in signature(function).parameters.items():
        union = isinstance(parameter.annotation, UnionType)
        parts = get_args(parameter.annotation) if union else (parameter.annotation,)
        members = [get_origin(part) or part for part in parts]
        known = [_KINDS[member] for member in members if member in _KINDS]
        types = tuple(kind for kind, _ in known) if len(known) == len(members) else ()
        if name == "a":
            types = ()  # `Stadium` says more about it
        kinds[name] = parameter.default, types, " or ".join(text for _, text in known if text)
    return kinds
