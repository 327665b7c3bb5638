"""Questions that nobody waits for any more end, whenever that is."""

import itertools
from contextlib import closing

import pytest

from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.store.asking import confinement
from orbitdb.store.asking.confinement import CancelledError
from orbitdb.store.asking.criteria import choose


@pytest.mark.parametrize(
    ("criteria", "order"),
    [
        ({"where": "length > 9"}, "p"),
        ({"where": "code like '%13%'"}, "p"),
        ({"contains": "13"}, "code"),
        ({"where": "code like '%13%' or p = 4"}, "p"),
        ({"where": "element = 3"}, "-element,length"),
    ],
)
def test_a_question_ends_wherever_it_is_cancelled(filled_once, criteria, order, monkeypatch):
    monkeypatch.setattr(confinement, "STEPS_BETWEEN_LOOKS", 5_000)
    with closing(Catalogue(filled_once)) as catalogue:
        selection, looks = choose(**criteria), itertools.count()
        size = catalogue.count(selection)  # so that SQLite has read the schema
        whole = catalogue.choose(selection, order, cancelled=lambda: next(looks) < 0)
        asked = next(looks)
        assert asked > 0
        assert len(whole) == size
        ended = 0
        for n in range(asked):
            looks_until = itertools.chain(itertools.repeat(False, n), itertools.repeat(True))
            try:
                found = catalogue.choose(selection, order, cancelled=looks_until.__next__)
            except CancelledError:
                ended += 1
            else:
                assert found == whole  # nothing was left to be done
        assert ended >= max(1, asked - 2)
