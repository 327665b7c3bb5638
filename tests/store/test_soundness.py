"""Words and coordinates that cannot be read are named in one line."""

import numpy as np
import pytest

from orbitdb.errors import StoreError
from orbitdb.store.rows import coordinates_of, need_words

BLOB = np.array([0.5, -0.25]).astype("<f8").tobytes()


def test_invalid_words_and_coordinates_are_named():
    need_words(["013", "02"], [3, 2])
    need_words([], [])
    assert coordinates_of([BLOB, BLOB], 2).tolist() == [[0.5, -0.25]] * 2
    far = np.array([0.5, -1e7]).tobytes()
    for refused, named in (
        (lambda: need_words(["013", "0x3", "9"], [3, 3, 1]), "altered: not a word: '0x3'"),
        (lambda: need_words(["013", "3" * 50], [3, 49]), f"not a word: '{'3' * 37}...'"),
        (
            lambda: coordinates_of([BLOB, BLOB + BLOB], 2),
            "coordinates of 2 bounces with a wrong size in bytes: '32'",
        ),
        (lambda: coordinates_of([BLOB, far], 2), "impossible coordinates of an orbit of period '2'"),
    ):
        with pytest.raises(StoreError) as error:
            refused()
        assert named in str(error.value)
