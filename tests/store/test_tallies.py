"""Histograms: round edges, or even ones in the logarithm; `test_questions` compares what they hold."""

import sqlite3
from contextlib import closing

import numpy as np
import pytest
from there import there

from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.catalogue.counts import histogram
from orbitdb.store.asking.selection import Selection


def test_bins_have_round_edges(filled_once):
    catalogue = Catalogue(filled_once)
    lengths = there(histogram(catalogue, Selection(periods=((2, 5),)), "length", 10))
    assert lengths.edges == pytest.approx(np.arange(10, 23, 2))
    fine = there(histogram(catalogue, Selection(periods=((2, 5),)), "lambda_d", 10)).edges
    assert fine.tolist() == [float(f"{edge:.2f}") for edge in fine]
    alone = there(histogram(catalogue, Selection(periods=((2, 2),)), "length", 10))
    assert (alone.counts.tolist(), alone.edges.tolist()) == ([1], [10.0, 11.0])
    assert histogram(catalogue, Selection(), "born", 10) is None


@pytest.mark.parametrize(("times", "logarithmic"), [(1000.0, False), (1001.0, True)])
def test_bins_are_even_in_the_logarithm_where_values_span_decades(filled, times, logarithmic):
    with closing(sqlite3.connect(filled)) as plain, plain:
        plain.execute("UPDATE orbit SET margin = 1.0 WHERE margin > 0")
        plain.execute(
            "UPDATE orbit SET margin = ? WHERE cycle IN (SELECT id FROM cycle WHERE p = 2)", (times,)
        )
    margins = there(histogram(Catalogue(filled), Selection(where="margin > 0"), "margin", 10))
    assert margins.logarithmic is logarithmic
    spaces = np.diff(np.log(margins.edges) if logarithmic else margins.edges)
    assert np.ptp(spaces) < 1e-9 * spaces[0]
    assert (margins.counts[-1], margins.counts[0]) == (1, margins.counts.sum() - 1)
