"""Narrow the type of an optional value that a test knows to be present."""

from typing import TypeVar

T = TypeVar("T")


def there(value: T | None) -> T:
    assert value is not None
    return value
