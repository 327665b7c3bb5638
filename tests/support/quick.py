"""Which cases of a test the default run takes; the others are marked slow, or left out of CI."""

from collections.abc import Collection, Iterable
from typing import Any

import pytest


def slow_but(
    kept: int | Collection[Any], values: Iterable[Any], mark: pytest.MarkDecorator = pytest.mark.slow
) -> list[Any]:
    """Return the values of one parameter, or tuples of several; all but some, or the first, are marked."""
    every = list(values)
    some = every[:kept] if isinstance(kept, int) else kept
    parts = [(value, value if isinstance(value, tuple) else (value,)) for value in every]
    return [value if value in some else pytest.param(*several, marks=mark) for value, several in parts]


def fuzz_but(kept: Collection[Any], values: Iterable[Any]) -> list[Any]:
    """Return the values, all but the kept ones left out of CI."""
    return slow_but(kept, values, pytest.mark.fuzz)
