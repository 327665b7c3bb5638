"""The cases of a test that the default run includes; others are marked slow, or left out of CI."""

from collections.abc import Collection, Iterable
from typing import Any

import pytest


def slow_but(
    kept: int | Collection[Any], values: Iterable[Any], mark: pytest.MarkDecorator = pytest.mark.slow
) -> list[Any]:
    """Return values, or tuples of several; all are marked except the kept ones, or the first `kept`."""
    every = list(values)
    some = every[:kept] if isinstance(kept, int) else kept
    parts = [(value, value if isinstance(value, tuple) else (value,)) for value in every]
    return [value if value in some else pytest.param(*several, marks=mark) for value, several in parts]


def fuzz_but(kept: Collection[Any], values: Iterable[Any]) -> list[Any]:
    """Return values; only the kept ones run in CI."""
    return slow_but(kept, values, pytest.mark.fuzz)
