"""Choose the cases of a test that the default run includes; mark the others slow, or leave them out of CI."""

from collections.abc import Collection, Iterable
from typing import Any

import pytest


def slow_but(
    kept: int | Collection[Any], values: Iterable[Any], mark: pytest.MarkDecorator = pytest.mark.slow
) -> list[Any]:
    """Return the values, or tuples of values; all are marked except those in `kept`, or the first `kept`.

    Raises `ValueError` if `kept` names a value that does not exist.
    """
    every = list(values)
    some = every[:kept] if isinstance(kept, int) else kept
    if unknown := [value for value in some if value not in every]:
        raise ValueError(f"{unknown} cannot be kept: the values are {every}")
    parts = [(value, value if type(value) is tuple else (value,)) for value in every]  # not a NamedTuple
    return [value if value in some else pytest.param(*several, marks=mark) for value, several in parts]


def fuzz_but(kept: Collection[Any], values: Iterable[Any]) -> list[Any]:
    """Return the values; only those in `kept` run in CI."""
    return slow_but(kept, values, pytest.mark.fuzz)
