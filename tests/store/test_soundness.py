"""Rows have the values that their status requires; each missing or impossible value is detected by itself."""

import numpy as np
import pytest

from orbitdb.errors import StoreError
from orbitdb.orbits.status import NUMBERS
from orbitdb.store.reading.soundness import are_whole, coordinates_of, is_whole, need_words, sound_words

BLOB = np.array([0.5, -0.25]).astype("<f8").tobytes()
NUMBERS_OF_IT = dict.fromkeys(NUMBERS, 0.5) | {"residual": 0.0, "error": 0.0}
ORBIT = {"status": "orbit", "solver": "newton", "coordinates": BLOB, **NUMBERS_OF_IT}
NOTHING = dict.fromkeys(NUMBERS) | {"coordinates": None, "solver": "newton"}
BARE = {"solver": "relaxation", "error": None, "length_error": None, "lyapunov_error": None}


@pytest.mark.parametrize(
    "row",
    [
        ORBIT,
        ORBIT | {"status": "boundary", "margin": -0.0},
        ORBIT | BARE,
        NOTHING | {"status": "dynamical", "margin": -0.1},
        NOTHING | {"status": "unresolved"},
    ],
)
def test_whole_rows_are_sound(row):
    assert is_whole(row, 2)
    assert not is_whole(row | {"solver": "magic"}, 2)
    assert not is_whole(row | {"status": "odd"}, 2)


@pytest.mark.parametrize(
    "change",
    [
        *({name: None} for name in (*NUMBERS, "coordinates")),
        *({name: value} for name in NUMBERS for value in (float("nan"), float("inf"))),
        *({name: -1e-9} for name in ("error", "length_error", "lyapunov_error", "residual")),
        {"length": 0.0},
        {"lyapunov": 0.0},
        {"coordinates": BLOB[:8]},
        {"coordinates": BLOB + BLOB},
        {"coordinates": np.array([0.5, np.nan]).tobytes()},
        {"coordinates": np.array([0.5, -1e8]).tobytes()},
        {"solver": "newton", **{name: None for name in BARE if name != "solver"}},
        BARE | {"error": 0.5},
        BARE | {"length": None},
        {"length": "12"},
        {"margin": b"\0"},
        {"coordinates": "0" * len(BLOB)},
    ],
    ids=str,
)
def test_rows_with_missing_or_impossible_values_are_not_sound(change):
    assert not is_whole(ORBIT | change, 2)


@pytest.mark.parametrize("name", [*NUMBERS, "coordinates"])
@pytest.mark.parametrize("status", ["dynamical", "unresolved"])
def test_words_that_are_not_orbits_have_no_numbers(name, status):
    row = NOTHING | {"status": status, "margin": -0.1, name: BLOB if name == "coordinates" else -0.1}
    assert is_whole(row, 2) == (name == "margin")
    assert is_whole(NOTHING | {"status": status}, 2) == (status == "unresolved")


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


def test_sound_words_are_admissible_primitive_and_of_their_period():
    words = ["013", "13", "0x3", "001", "131", "131313", "013"]
    assert sound_words(words, 3).tolist() == [0, 4, 6]
    assert sound_words(["131313", "132132", "012301"], 6).tolist() == []
    assert sound_words(["x"], 1).tolist() == []


def test_rows_are_judged_one_by_one():
    far = {"coordinates": np.array([0.5, 1e8]).tobytes()}
    rows = [ORBIT, ORBIT | far, NOTHING | {"status": "unresolved"}, ORBIT | {"coordinates": BLOB[:8]}, ORBIT]
    assert are_whole({name: [row[name] for row in rows] for name in ORBIT}, 2).tolist() == [1, 0, 1, 0, 1]
