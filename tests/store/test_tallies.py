"""Tallies and histograms: the same counts as row by row, by class and by a pass over all words."""

import numpy as np
import pytest

from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading import tallies
from orbitdb.store.reading.catalogue import Catalogue
from orbitdb.store.reading.tallies import histogram


def test_bins_have_round_edges_or_even_ones_in_the_logarithm(filled_once, monkeypatch):
    catalogue = Catalogue(filled_once)
    lengths = histogram(catalogue, Selection(periods=((2, 5),)), "length", 10)
    assert lengths.edges == pytest.approx(np.arange(10, 23, 2))
    fine = histogram(catalogue, Selection(periods=((2, 5),)), "lambda_d", 10).edges
    assert fine.tolist() == [float(f"{edge:.2f}") for edge in fine]
    monkeypatch.setattr(tallies, "_DECADES", 100.0)
    margins = histogram(catalogue, Selection(where="margin > 0"), "margin", 10)
    assert margins.logarithmic
    assert np.ptp(np.diff(np.log(margins.edges))) < 1e-12
    alone = histogram(catalogue, Selection(periods=((2, 2),)), "length", 10)
    assert (alone.counts.tolist(), alone.edges.tolist()) == ([1], [10.0, 11.0])
    assert histogram(catalogue, Selection(), "born", 10) is None


def test_bins_are_the_finest_of_round_widths():
    """Of 1, 2, 2.5 and 5 times a power of ten it is the least with no more bins than asked for."""
    rng = np.random.default_rng(3)
    widths = [factor * 10.0**power for power in range(-6, 6) for factor in (1.0, 2.0, 2.5, 5.0)]
    for low, high in np.sort(10.0 ** rng.uniform(-1, 3, (150, 2)), axis=1).tolist():
        bins = int(rng.integers(2, 30))
        edges = tallies._round_edges(low, high, bins)
        spans = ((np.floor(low / width), np.floor(high / width) + 1, width) for width in widths)
        first, last, width = next(span for span in spans if span[1] - span[0] <= bins)
        assert edges == pytest.approx(width * np.arange(first, last + 1))
    assert tallies._round_edges(3.0, 3.0, 5).tolist() == [3.0, 4.0]
    assert tallies._even_edges(0.5, 8.0, 4) == pytest.approx([0.5, 1, 2, 4, 8])
