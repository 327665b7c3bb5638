"""Results of a catalogue have public names, one-line reprs and data frames."""

import shutil
from pathlib import Path

import pytest
from made_levels import keep_made_levels

import orbitdb
from orbitdb import Catalogue


def with_levels(catalogue):
    copy = Path(shutil.copy(catalogue.path, catalogue.path.with_name("levels.db")))
    keep_made_levels(copy)
    return Catalogue(copy)


HELD = {
    "Subset": lambda c: c.select(p="2-4", status="orbit"),
    "Result": lambda c: c.table(),
    "Spectrum": lambda c: c.spectrum((4, 9), points=20),
    "Levels": lambda c: with_levels(c).levels(parity="ee"),
    "OrbitClasses": lambda c: c.classes(p="2-4"),
    "Fill": lambda c: c.fill("3")[-1],
    "Sweep": lambda c: c.sweep("6")[-1],
    "Life": lambda c: c.births(4)[0],
    "EntropyBounds": lambda c: c.prove_bounds(edges=4),
    "Reference": lambda c: c.simulate(bounces=20_000),
    "Verification": lambda c: c.verify(p="2-3"),
    "Trajectory": lambda c: c.identify(start=(0, 0.5, 1.2)),
    "FieldOrbits": lambda c: c.field(0.05, p="2-4"),
}
"""Every type of result, by its public name."""

FIRST = {
    "Subset": ("code", "13"),
    "Result": ("N_c", 1),
    "Spectrum": ("length", 4.0),
    "Levels": ("parity", "ee"),
    "OrbitClasses": ("words", 1),
    "Fill": ("N_c", 8),
    "Sweep": ("N_t", 252),
    "Life": ("representative", "0103"),
    "EntropyBounds": ("window", 4),
    "Reference": ("seed", 0),
    "Verification": ("failures", 0),
    "Trajectory": ("sequence_first", -33),
    "FieldOrbits": ("kappa", 0.05),
}
"""A column of each result, with its first value."""


@pytest.fixture(scope="module")
def catalogue(tmp_path_factory):
    catalogue = Catalogue.create(tmp_path_factory.mktemp("results") / "c.db")
    catalogue.fill("2-5")
    catalogue.fill_births("4")
    return catalogue


@pytest.mark.parametrize("name", HELD)
def test_a_result_has_a_public_name_a_one_line_repr_and_a_data_frame(catalogue, name):
    found = HELD[name](catalogue)
    assert isinstance(found, getattr(orbitdb, name))
    assert "\n" not in repr(found)
    assert len(repr(found)) < 300
    frame = found.to_pandas()
    column, first = FIRST[name]
    assert frame[column].iloc[0] == first
    for values in (column for _, column in frame.items() if column.dtype == object):
        assert not all(value is None or isinstance(value, float) for value in values)


LISTS = {
    "p": lambda c: c.fill("2-3"),
    "upper": lambda c: c.entropy_curve(),
    "code": lambda c: c.with_length(10.4),
    "strength": lambda c: c.scars(1, 3, word="13", parities="ee"),
    "N_t": lambda c: c.sweeps(),
}
"""A column of each list of results."""


@pytest.mark.parametrize("column", LISTS)
def test_a_list_of_results_is_a_data_frame_of_its_entries(catalogue, column):
    listed = LISTS[column](catalogue)
    frame = listed.to_pandas()
    assert len(frame) == len(listed)
    assert not listed or column in frame


def test_missing_numbers_of_a_data_frame_are_nan(catalogue):
    frame = catalogue.lyapunov(p="4-5").to_pandas()
    assert set(frame.dtypes.drop("p").map(str)) == {"float64"}
    assert catalogue.entropy(p="4-5", status="orbit").to_pandas()["h_zeta"].dtype == float
    assert catalogue.select(p=4).to_pandas()["dies"].dtype == float


def test_print_shows_the_rows_of_a_result(catalogue):
    table = catalogue.table(p="2-4")
    assert repr(table) == (
        "<3 rows, p, N_t, N_c, N, ...: words of period 2 to 4 at a = 1.6; print() shows them>"
    )
    assert str(table).splitlines()[0].split() == list(table.columns)
