"""Numbers for people: digits, uncertainties and run notation in tables."""

import math
import re
from decimal import Decimal

import pytest

from orbitdb import Catalogue
from orbitdb.text import in_brackets


@pytest.mark.parametrize("form", ["table", "markdown", "latex"])
def test_tables_have_as_many_digits_as_asked_for(cli, own, form):
    asked = (
        "query",
        "--p",
        "2-4",
        "--order",
        "length",
        "--limit",
        "3",
        "--a",
        "1.6",
        "-c",
        "length,lambda_c",
    )
    numbers = re.findall(r"\d+\.\d+", cli(*asked, "--format", form, "--digits", "4").out)
    assert numbers[:2] == ["10.40", "0.4065"]
    assert {len(text.replace(".", "").lstrip("0")) for text in numbers} == {4}


def test_numbers_with_their_uncertainty_contain_the_exact_ones(cli, own):
    """The bounds are those of the stored columns, and include the rounding of what is shown."""
    asked = ("query", "--p", "2-5", "--status", "orbit", "--a", "1.6", "-c", "code,length,lyapunov,lambda_c")
    told = [line.split() for line in cli(*asked, "--limit", "200", "--uncertainty").out.splitlines()]
    assert told[0] == ["code", "length", "lyapunov", "lambda_c"]
    orbits = {orbit.code: orbit for orbit in Catalogue(own, 1.6).select(p="2-5", status="orbit")}
    assert len(told) == 1 + len(orbits)
    for code, *texts in told[1:]:
        for name, text in zip(told[0][1:], texts, strict=True):
            value, bound = (Decimal(getattr(orbits[code], each)) for each in (name, f"{name}_error"))
            shown, units = text.removesuffix(")").split("(")
            within = int(units) * Decimal((0, (1,), -len(shown.partition(".")[2])))
            assert abs(Decimal(shown) - value) + bound <= within < 12 * (bound + Decimal(math.ulp(value)))
    word = cli("query", "0123", "--a", "1.6", "--uncertainty").out
    (length,) = (row[1] for row in told if row[0] == "0123")
    assert f"\nlength         {length}\n" in word


@pytest.mark.parametrize(
    ("value", "bound", "text"),
    [
        (22.45436241091962, 2.8e-14, "22.45436241091962(3)"),
        (0.5, 0.094, "0.5(1)"),
        (1.06, 0.009, "1.06(1)"),
        (-3.14159, 1e-3, "-3.142(2)"),
        (1234.5, 70.0, "1234(71)"),
        (10.4, 0.0, "10.4"),
        (2.0, math.inf, "2(inf)"),
    ],
)
def test_a_bound_in_brackets_includes_the_rounding(value, bound, text):
    assert in_brackets(value, bound) == text


def test_long_codes_in_latex_have_powers_in_braces(cli):
    found = cli("query", "1^30(02)^9 3", "--a", "1.6", "-c", "code,p", "--format", "latex").out
    assert r"$\mathtt{1^{30}(02)^{9} 3}$ & 49 \\" in found


@pytest.mark.parametrize("option", [("--digits", "3"), ("--uncertainty",)])
def test_formats_for_programs_refuse_to_round(cli, own, option):
    assert cli("query", "--p", "3", "--json", *option).says(
        2, "are for tables; other formats have all digits"
    )
    assert cli("count", "--uncertainty", "--digits", "3").says(2, "--uncertainty chooses the digits")
