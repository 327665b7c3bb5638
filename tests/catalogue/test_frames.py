"""Data frames hold the numbers of their result, column by column, with their signs."""

import numpy as np
import pandas as pd
import pytest

from orbitdb import Catalogue, levels
from orbitdb.quantum.length_spectrum import SPECTRUM_COLUMNS as OF_SPECTRUM

SIGNED = ("code", "area", "margin", "born", "walls")


def of_rows(names, rows):
    return dict(zip(names, zip(*rows, strict=True), strict=True))


def of_attributes(found, *names):
    return {name: [getattr(one, name) for one in found] for name in names}


RESULTS = {
    "rows": (
        lambda c: c.rows(p="2-4", columns=SIGNED, status="all"),
        lambda found: of_rows(SIGNED, found),
    ),
    "table": (lambda c: c.table(p="2-5"), lambda found: found.columns),
    "count": (lambda c: c.count(by=["p", "status"], status="all"), lambda found: found.columns),
    "lyapunov": (lambda c: c.lyapunov(p="2-5"), lambda found: found.columns),
    "fills": (
        lambda c: c.fills(),
        lambda found: of_attributes(found, "p", "words", "classes") | {"N_c": [one.n_c for one in found]},
    ),
    "sql": (
        lambda c: c.sql("SELECT code, -area AS area, NULL AS empty FROM catalogue WHERE p = 3"),
        lambda found: of_rows(("code", "area", "empty"), found),
    ),
    "length": (
        lambda c: c.identify(length=20.8, tolerance=0.5),
        lambda found: of_attributes(found, "code", "repetitions", "length", "difference"),
    ),
    "shadowed": (
        lambda c: c.identify(start=(0, 0.001, 0)),
        lambda found: of_attributes(found.shadowed, "first", "last", "turns", "distance")
        | {"code": [one.orbit.code for one in found.shadowed]},
    ),
    "field": (
        lambda c: c.field([-0.05, 0.05], code=["0123", "13"]),
        lambda found: {name: getattr(found, name) for name in ("code", "kappa", "area", "action", "trace")},
    ),
    "spectrum": (
        lambda c: c.spectrum((9.0, 12.0)),
        lambda found: dict(zip(OF_SPECTRUM, (found.length, *[np.full(found.length.size, np.nan)] * 2,
                                             found.orbits.real, found.orbits.imag), strict=True)),
    ),
    "levels": (
        lambda c: levels(1.6, 4),
        lambda found: {"k": found.k, "error": found.error, "parity": found.parity},
    ),
    "subset": (
        lambda c: c.select(p="2-5", status="all"),
        lambda found: of_attributes(found, "code", "area", "margin", "lambda_c", "quarter_maslov", "length"),
    ),
    "classes": (
        lambda c: c.classes(p="2-5"),
        lambda found: {name: getattr(found, name) for name in ("p", "words", "length", "lyapunov", "walls")},
    ),
}  # fmt: skip
"""For each result, how to get it, and its columns by another way than its data frame."""


@pytest.mark.parametrize("name", RESULTS)
def test_a_data_frame_has_the_values_of_its_result(varied, name):
    get, columns = RESULTS[name]
    found = get(Catalogue(varied, 1.6))
    frame, known = found.to_pandas(), columns(found)
    assert known.keys() <= {*frame.columns}
    for column, values in known.items():
        assert len(frame) == len(values) > 0
        own = [None if pd.isna(value) else value for value in frame[column]]
        assert own == [None if value is None or value != value else value for value in values], column


def test_an_arrow_table_has_the_values_of_its_subset(varied):
    subset = Catalogue(varied, 1.6).select(p="2-5", status="orbit,dynamical", coordinates=True)
    table = subset.to_arrow()
    assert min(value for value in table["area"].to_pylist() if value is not None) < 0
    for name in ("code", "area", "margin", "class_size"):
        assert table[name].to_pylist() == [getattr(orbit, name) for orbit in subset], name
    places = [None if orbit.coordinates is None else orbit.coordinates.tolist() for orbit in subset]
    assert table["coordinates"].to_pylist() == places
