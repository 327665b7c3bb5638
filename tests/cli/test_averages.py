"""`lyapunov` with sum rules and `simulate --legwise`, as a user calls them."""

import contextlib
import io
import json
import math
import re

import pytest
from contents import alter
from there import there

from orbitdb.cli.render import Format, write
from orbitdb.numerals import concise, with_error

LAMBDA_D, LAMBDA_C = 0.8867858, 0.3752123


@pytest.mark.parametrize("value", ["NULL", "1e308"])
def test_a_lambda_that_no_orbit_has_is_told(filled, cli, value):
    alter(filled, f"UPDATE orbit SET lyapunov = {value} WHERE length = (SELECT max(length) FROM orbit)")
    found = cli("lyapunov", "--db", str(filled))
    assert (found.code, found.out) == (3, "")
    assert "impossible numbers" in found.err


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (1.115e-3, "0.886786 +- 1.2e-03"),
        (4.41e-6, "0.8867858 +- 4.5e-06"),
        (5.31e-7, "0.88678577 +- 5.4e-07"),
        (0.0, "0.886786 +- 0.0e+00"),
        (math.inf, "0.886786 +- inf"),
    ],
)
def test_errors_are_rounded_up_beside_the_digits_that_they_are_of(error, text):
    assert with_error(0.886785768, error) == text
    told = io.StringIO()
    with contextlib.redirect_stdout(told):
        write(("lambda_d", "lambda_d_error"), [(0.886785768, error)], Format.TABLE)
    assert told.getvalue().splitlines()[1].split() == text.split(" +- ")


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [(0.886767, 2.11e-4, "0.88677(22)"), (0.88382, 0.04818, "0.884(49)"), (0.5, 12.3, "0(13)"),
     (-0.1, 0.995, "-0.1(10)"), (0.25, 0.0, "0.250000"), (None, None, None)],
)  # fmt: skip
def test_errors_stand_behind_the_digits_that_they_are_of(value, error, text):
    assert concise(value, error) == text


@pytest.mark.parametrize("cut", ["0", "-1", "nan", "1000.1"])
def test_limits_of_a_cut(filled, cli, cut):
    assert cli("lyapunov", "--cut", cut, "--db", str(filled)).says(2, f"cut {float(cut):g}", "1000")


def test_the_largest_cuts(filled, cli, monkeypatch):
    """Up to 1000 as they are; with determinants, up to so many factors, and what is advised is taken."""
    monkeypatch.setattr("orbitdb.catalogue.averaged.MOST_FACTORS", 600)
    chosen = ("lyapunov", "--p", "2-4", "--json", "--db", str(filled), "--cut")
    found, none = cli(*chosen, "1000"), cli(*chosen, "1e-7")
    assert json.loads(found.out)[0]["cut"] == 1000
    assert "no average" not in found.err
    assert json.loads(none.out)[0]["lambda_d_zeta"] is None
    assert "the zeta function gives no average (no orbit has a lambda up to 1e-07)" in none.err
    refused = cli(*chosen, "1000", "--weight", "det")
    assert (refused.code, refused.out) == (2, "")
    said = r"orbitdb: cut 1000 has too many terms with --weight det: give (\d+) or less\n"
    most = float(there(re.fullmatch(said, refused.err))[1])
    assert cli(*chosen, str(most), "--weight", "det").code == 0
    assert "too many terms" in cli(*chosen, str(1.2 * most), "--weight", "det").err


def test_weights_have_names(filled, cli):
    assert cli("lyapunov", "--weight", "x", "--db", str(filled)).says(2, "'x'", "exp", "det")
