"""Rows of a catalogue say how many there are, what is missing, and up to which length they are complete."""

import json

import pytest

from orbitdb import Catalogue, InputError, Listing, Selection
from orbitdb.cli.advice import completed

CHOSEN = [
    ("--p 2-9", {"p": "2-9"}),
    ("--p 9", {"p": 9}),
    ("--p 4 --status geometric", {"p": 4, "status": "geometric"}),
    ("--p 3 --exists 2", {"p": 3, "exists": 2}),
    ("--where length>99", {"where": "length>99"}),
    ("--where code='310'", {"where": "code='310'"}),
    ("--a all --p 2-7", {"a": (1.0, 1.6), "p": "2-7"}),
    ("--status orbit --order length --limit 3", {"status": "orbit", "order": "length", "limit": 3}),
    ("--a all --range length=:9", {"a": (1.0, 1.6), "length": (None, 9)}),
    ("--classes --p 2-6 --limit 4 --offset 2", {"classes": True, "p": "2-6", "limit": 4, "offset": 2}),
    ("--p 3 -c code,born", {"p": 3, "columns": ("code", "born")}),
]


@pytest.mark.parametrize(("options", "asked"), CHOSEN, ids=[options for options, _ in CHOSEN])
def test_a_listing_says_what_the_command_prints(cli, own, options, asked):
    listing = Catalogue(own).rows(**{"a": 1.6, "columns": ("code", "p"), **asked})
    assert isinstance(listing, Listing)
    options += "" if "--a" in options else " --a 1.6"
    columns = () if "-c" in options else ("-c", "code,p")
    done = cli("query", *options.split(), *columns, "--format", "jsonl")
    assert done.err.splitlines() == [*map(completed, (*listing.notes, *listing.complete))]
    rows = [json.loads(line) for line in done.out.splitlines()]
    assert [tuple(row[name] for name in listing.columns) for row in rows] == [*listing]
    assert done.code == (1 if listing.empty else 0)
    if listing.limit is None:
        assert listing.total == len(rows)
    table = cli("query", *options.split(), *columns).err.splitlines()
    if rows:
        assert table.pop().startswith(listing.describe(listing.total))
    assert len(table) == len(listing.notes) + len(listing.complete)


def test_rows_at_several_a_are_those_of_each(varied):
    catalogue = Catalogue(varied)
    each = [Selection(a, periods=((3, 3),)) for a in (1.0, 1.6)]
    listing = catalogue.rows(each, columns=("a", "code"), order="a,code")
    alone = (catalogue.rows(one, columns=("a", "code"), order="code") for one in each)
    assert [*listing] == [row for rows in alone for row in rows]
    assert [*catalogue.rows(a=(1.0, 1.6), p=3, columns=("a", "code"), order="a,code")] == [*listing]
    assert listing.total == sum(catalogue.count(one) for one in each) == 16
    with pytest.raises(InputError, match="one a or more"):
        catalogue.rows([])


def test_an_empty_listing_is_complete_only_by_proof(varied):
    catalogue = Catalogue(varied, 1.6)
    assert catalogue.rows(p=9, order="length").complete == ()
    (told,) = catalogue.rows(order="length", where="length < 1").complete
    assert told.startswith("complete, by proof, up to length")


def test_a_minus_reverses_an_order(varied):
    catalogue = Catalogue(varied, 1.6)
    for orders in (("-length", "length desc"), ("-length desc", "length"), ("-length asc", "length desc")):
        one, other = ([*catalogue.rows(p="2-4", order=each, columns=("code",))] for each in orders)
        assert one == other


def test_the_head_of_a_listing_begins_after_the_rows_that_are_skipped(varied):
    catalogue = Catalogue(varied, 1.6)
    for most in (None, 4):
        listing = catalogue.rows(p="2-4", order="length", columns=("code",), offset=5, limit=most)
        assert [*listing.head(6)] == [*listing][:6] != []


def test_a_listing_can_be_read_again_and_shown(varied):
    listing = Catalogue(varied).rows(a=1.6, p="2-3", columns=("code", "length"), limit=2)
    assert [*listing] == [*listing] != []
    title, heading, *rows = repr(listing).splitlines()
    assert (title, heading.split()) == ("<orbits of period 2 to 3 at a = 1.6>", ["code", "length"])
    assert [row.split()[0] for row in rows] == [code for code, _ in listing]
    longer = Catalogue(varied).rows(a=1.6, p="2-4", columns=("code", "length"))
    assert repr(longer) == "<orbits of period 2 to 4 at a = 1.6: code, length>"
    assert listing.to_pandas()["length"].iloc[0] == 10.4
    page = listing._repr_html_()
    assert "9 orbits of period 2 to 3 at a = 1.6" in page
    assert page.count("<tr>") == 3


def test_metadata_name_only_the_a_that_have_rows(cli, varied, tmp_path):
    done = cli("export", str(tmp_path / "x.csv"), "--a", "1", "--a", "1.7", "--p", "2", "--db", str(varied))
    assert done.code == 0
    assert json.loads((tmp_path / "x.csv-metadata.json").read_text())["a"] == [1.0]


@pytest.mark.parametrize("wrong", [{"columns": ("lenght",)}, {"order": "lenght"}, {"p": "x"}, {"limit": -1}])
def test_a_wrong_question_is_refused_at_once(varied, wrong):
    with pytest.raises(InputError, match=r"lenght|periods 'x'|limit = -1"):
        Catalogue(varied).rows(**wrong)


@pytest.mark.parametrize("ending", ["csv", "jsonl", "parquet"])
def test_a_listing_writes_the_file_of_the_command(cli, varied, tmp_path, ending):
    one, other = tmp_path / f"one.{ending}", tmp_path / f"other.{ending}"
    listing = Catalogue(varied, a=1.6).rows(p="2-4", status="orbit", columns=("code", "length"))
    assert listing.write(one) == listing.total == 41
    options = ("--a", "1.6", "--p", "2-4", "--status", "orbit", "-c", "code,length")
    assert cli("export", str(other), *options, "--db", str(varied)).code == 0
    if ending != "parquet":  # which contains the time
        assert one.read_bytes() == other.read_bytes()
    with pytest.raises(InputError, match="exists"):
        listing.write(one)
    assert listing.write(one, force=True) == 41


def test_a_description_names_only_the_a_that_have_rows(own):
    listing = Catalogue(own).rows(a=(0.3, 1.6), p=3)
    assert listing.describe(listing.total) == "8 orbits of period 3 at a = 1.6"
    assert "0.3" in Catalogue(own).rows(a=(0.3, 0.4), p=3).describe(0)
