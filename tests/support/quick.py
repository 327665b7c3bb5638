"""Which cases of a test the default run takes; the others are marked slow."""

from collections.abc import Collection, Iterable
from typing import Any

import pytest


def slow_but(kept: Collection[Any], values: Iterable[Any]) -> list[Any]:
    """Return the values of one parameter, all but the kept ones marked slow."""
    return [value if value in kept else pytest.param(value, marks=pytest.mark.slow) for value in values]


def fuzz_but(kept: Collection[Any], values: Iterable[Any]) -> list[Any]:
    """Return the values of one parameter, or tuples of several, all but the kept ones left out of CI."""
    return [
        value if value in kept else pytest.param(*_several(value), marks=pytest.mark.fuzz) for value in values
    ]


def _several(value: Any) -> tuple[Any, ...]:
    return value if isinstance(value, tuple) else (value,)
