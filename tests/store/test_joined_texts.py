"""Numbers that SQLite joins to one text are those that it would give one by one."""

import pytest
import sqlalchemy as sa
from hypothesis import given
from hypothesis import strategies as st

from orbitdb.store.reading.joined_texts import joined_numbers

TABLE = sa.Table("numbers", sa.MetaData(), sa.Column("place", sa.Integer), sa.Column("number"))
QUERY = sa.select(TABLE.c.number).order_by(TABLE.c.place)


@pytest.fixture(scope="module")
def memory():
    with sa.create_engine("sqlite://").connect() as connection:
        connection.exec_driver_sql("CREATE TABLE numbers (place INTEGER PRIMARY KEY, number)")
        yield connection


USUAL = st.floats(1e-15, 8e6) | st.floats(-8e6, -1e-15) | st.sampled_from([0.0, float("inf")])


@given(numbers=st.lists(USUAL, max_size=40) | st.lists(st.floats(allow_nan=False), max_size=9))
def test_every_number_comes_back_bit_by_bit(memory, numbers):
    assert written(memory, numbers, whole=False) == numbers


@given(numbers=st.lists(st.integers(-(2**53), 2**53) | st.just(float("inf")), max_size=9))
def test_so_do_integers(memory, numbers):
    assert written(memory, numbers, whole=True) == numbers


def written(memory: sa.Connection, numbers: list[float], whole: bool) -> list[float]:
    """Write numbers, and return what is read."""
    memory.execute(sa.delete(TABLE))
    for number in numbers:
        memory.execute(sa.insert(TABLE).values(number=number))
    return joined_numbers(memory, QUERY, {}, whole).tolist()
