"""The ids of words that are too long to pack into one."""

from contents import ask

from orbitdb.catalogue import Catalogue
from orbitdb.filling.fill import fill_word
from orbitdb.store.file import migrate
from orbitdb.store.tables import LONG
from orbitdb.symbols.words import MAX_KEYED, keys_of_period, parse


def test_long_words_get_ids_in_order_of_arrival(tmp_path):
    """Ids of classes count up, and those of pruned words count down."""
    path = tmp_path / "orbits.db"
    migrate(path)
    words = [parse(text) for text in ("1^30 5^29", "1^31 5^29", "1^30 5^31")]
    broken = ["001" * 7 + "1", "0" * 29 + "1"]
    for word in (*words, words[0], *broken, broken[1]):
        fill_word(path, word, 1.6)
    catalogue = Catalogue(path)
    assert len({catalogue[word].length for word in words}) == len(words)
    assert ask(path, "SELECT id FROM cycle ORDER BY id") == [(LONG,), (LONG + 1,), (LONG + 2,)]
    assert ask(path, "SELECT id, p FROM pruned ORDER BY id DESC") == [(-LONG, 22), (-LONG - 1, 30)]


def test_ids_of_long_words_are_above_those_of_all_periods():
    """So counting a period by its range of ids never includes a long word."""
    assert keys_of_period(MAX_KEYED)[1] < LONG


def test_words_of_any_length_sort_as_texts(tmp_path):
    """Words that begin alike are compared beyond the symbols that fit into one number."""
    catalogue = Catalogue.create(tmp_path / "orbits.db", 1.6)
    catalogue.fill(
        "2-3", words=map(parse, ("1^10 3^10", "1^11 3^10", "1^30 5^29", "1^31 5^29", "0^25 1", "001"))
    )
    codes = list(catalogue.select(status="all").code)
    assert list(catalogue.select(status="all", order="code").code) == sorted(codes) != codes
    assert list(catalogue.select(status="all", order="code desc").code) == sorted(codes)[::-1]
