"""Words: how they are read, written, rotated and packed into integers."""

from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbitdb.symbols.words import (
    MAX_ORDER,
    MAX_PACKED,
    SYMBOLS,
    WordError,
    are_primitive,
    from_strings,
    is_primitive,
    least_rotation,
    least_rotations,
    pack,
    parse,
    primitive_root,
    run_notation,
    to_strings,
    unpack,
)

words = st.text(SYMBOLS, min_size=1, max_size=30)
powered = st.lists(st.tuples(st.text(SYMBOLS, min_size=1, max_size=3), st.integers(1, 9)), min_size=1).map(
    lambda terms: "".join(unit * count for unit, count in terms)
)


def rotations(word: str) -> list[str]:
    return [word[i:] + word[:i] for i in range(len(word))]


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("1232131", "1232131"),
        (" 12 32\t131\n", "1232131"),
        ("1^20 (02)^5 3", "1" * 20 + "02" * 5 + "3"),
        ("1 ^ 2", "11"),
        ("((1^2 0)^2 3)^2", "1101103" * 2),
        ("12^3", "1222"),
        ("1^2^3", "1" * 6),
        (f"(13)^{MAX_ORDER // 2}", "13" * (MAX_ORDER // 2)),
        (f"1^{MAX_ORDER}", "1" * MAX_ORDER),
    ],
)
def test_parse_reads_run_notation(text, word):
    assert parse(text) == word


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1717", "symbol '7' at position 2 of '1717' is not one of 0 1 2 3 4 5"),
        ("12  x3", "symbol 'x' at position 5 of '12  x3' is not one of 0 1 2 3 4 5"),
        ("13\u00b2", "symbol '\u00b2' at position 3 of "),
        ("13^\u0663", "'^' at position 3 of "),
        ("13^", "'^' at position 3 of '13^' needs a number after it"),
        ("^3", "'^' at position 1 of '^3' has nothing before it to repeat"),
        ("1(^3)", "'^' at position 3 of '1(^3)' has nothing before it to repeat"),
        ("13  ^0", "'^0' at position 5 of '13  ^0': repeat at least once"),
        ("1^2 3^0", "'^0' at position 6 of '1^2 3^0': repeat at least once"),
        ("1^2(^3)", "'^' at position 5 of '1^2(^3)' has nothing before it to repeat"),
        ("1^2 3^9999999", "the power ^9999999 at position 6 of "),
        ("13)", "unmatched ')' at position 3 of '13)'"),
        ("1(3", "unmatched '(' in '1(3'"),
        ("1()3", "empty brackets at position 3 of '1()3'"),
        ("", "the code is empty"),
    ],
)
def test_errors_of_parse_name_symbol_and_position(text, message):
    with pytest.raises(WordError) as error:
        parse(text)
    assert str(error.value).startswith(message)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "bomb",
    [
        "((1^1000)^1000)^1000",
        "1^" + "9" * 5000,
        f"1^{MAX_ORDER + 1}",
        "(((((((1^99)^99)^99)^99)^99)^99)^99",
        f"(1^{MAX_ORDER})^2",
        f"1^{MAX_ORDER - 1} 3^2",
    ],
)
def test_codes_that_expand_to_huge_words_are_refused(bomb):
    with pytest.raises(WordError, match=f"more than {MAX_ORDER}"):
        parse(bomb)


@pytest.mark.slow
def test_the_length_of_a_plain_word_is_limited():
    assert len(parse("13" * (MAX_ORDER // 2))) == MAX_ORDER
    with pytest.raises(WordError, match=f"has {MAX_ORDER + 1} symbols"):
        parse("1" * (MAX_ORDER + 1))


def test_error_messages_stay_short():
    with pytest.raises(WordError) as error:
        parse("1" * 100_000 + "7")
    assert "position 100001" in str(error.value)
    assert len(str(error.value)) < 200


@given(st.one_of(words, powered))
def test_run_notation_can_be_read_back(word):
    assert parse(run_notation(word)) == word


units = st.recursive(
    st.text(SYMBOLS, min_size=1, max_size=5).map(lambda word: (word, word)),
    lambda inner: st.tuples(inner, inner, st.integers(1, 8)).map(
        lambda drawn: (f"({drawn[0][0]}) ^{drawn[2]} {drawn[1][0]}", drawn[0][1] * drawn[2] + drawn[1][1])
    ),
    max_leaves=5,
)


@given(units, st.integers(0, 99), st.text(f"{SYMBOLS}()^ 6½٣\udcff", max_size=2))
def test_codes_give_words_or_an_error(unit, place, wrong):
    text, word = unit
    assert parse(text) == word
    place %= len(text)
    with suppress(WordError):
        assert set(parse(text[:place] + wrong + text[place + 1 :])) <= set(SYMBOLS)


def test_run_notation_is_short():
    assert run_notation("1" * 20 + "02" * 5 + "3") == "1^20(02)^5 3"
    assert run_notation("1232131") == "1232131"
    assert run_notation("113") == "113"
    assert run_notation("1" * 100_000) == "1^100000"


@given(st.one_of(words, powered))
def test_the_least_rotation_is_the_minimum_of_all_rotations(word):
    assert least_rotation(word) == min(rotations(word))


@given(words, st.integers(1, 5))
def test_roots_and_primitivity_agree_with_rotations(word, count):
    root = primitive_root(word)
    assert root * (len(word) // len(root)) == word
    assert is_primitive(word) == (len(set(rotations(word))) == len(word))
    assert primitive_root(word * count) == root
    assert is_primitive(word * count) == (is_primitive(word) and count == 1)
    assert are_primitive(from_strings([word * count])).tolist() == [is_primitive(word * count)]


@given(
    st.integers(1, MAX_PACKED).flatmap(
        lambda p: st.lists(st.text(SYMBOLS, min_size=p, max_size=p), min_size=1)
    )
)
def test_arrays_and_packed_words_agree_with_strings(strings):
    symbols = from_strings(strings)
    p = symbols.shape[1]
    assert to_strings(symbols) == strings
    codes = pack(symbols)
    assert (unpack(codes, p) == symbols).all()
    assert np.argsort(codes, kind="stable").tolist() == sorted(range(len(strings)), key=strings.__getitem__)
    least = to_strings(unpack(least_rotations(codes, p), p))
    assert least == [least_rotation(word) for word in strings]


def test_empty_batches_are_allowed():
    assert to_strings(np.zeros((0, 5), dtype=np.uint8)) == []
    assert len(least_rotations(np.zeros(0, dtype=np.int64), 5)) == 0
