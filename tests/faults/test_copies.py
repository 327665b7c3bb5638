"""A copy of a catalogue is whole and consistent, even while others write, and replaces no catalogue."""

import sys

import pytest
from contents import agrees, ask, content, is_sound
from processes import (
    go_on,
    kill_group,
    pausing,
    run,
    small_blocks,
    start,
    wait_until_paused,
    wait_until_ready,
)

from orbitdb import Catalogue
from orbitdb.errors import ExportError
from orbitdb.filling.fill import fill_periods


def test_a_copy_has_the_same_content_and_no_journal(varied, tmp_path, cli):
    copy = tmp_path / "copy.db"
    outcome = cli("export", str(copy), "--db", str(varied))
    assert (outcome.code, outcome.out) == (0, "")
    assert f"copied from {varied}, in {copy}" in outcome.err
    assert [each.name for each in tmp_path.iterdir()] == ["copy.db"]
    assert content(copy) == content(varied)
    assert Catalogue(copy).verify().sound
    list(fill_periods(copy, 2.0, [3]))  # it can be filled further
    assert Catalogue(copy).a_values() == [1.0, 1.6, 2.0]
    assert Catalogue(varied).a_values() == [1.0, 1.6]


def test_a_copy_replaces_no_catalogue(varied, own, tmp_path, cli):
    before = own.read_bytes()
    for options in ([], ["--force"]):
        assert cli("export", str(own), *options, "--db", str(varied)).says(2, "is never replaced")
    with pytest.raises(ExportError, match="never replaced"):
        Catalogue(own).copy(own, force=True)
    assert own.read_bytes() == before
    text = tmp_path / "text.db"
    text.write_text("not a catalogue")
    with pytest.raises(ExportError, match="already exists"):
        Catalogue(varied).copy(text)
    assert text.read_text() == "not a catalogue"
    assert cli("export", str(text), "--db", str(varied)).says(2, "already exists: --force")
    assert cli("export", str(text), "--db", str(varied), "--contains", "3").says(
        2, "--contains does nothing with text.db"
    )
    assert cli("export", str(text), "--force", "--db", str(varied)).code == 0
    assert content(text) == content(varied)


def test_a_copy_in_a_snapshot_is_that_of_the_snapshot(own, tmp_path):
    catalogue = Catalogue(own)
    with catalogue.snapshot() as then:
        assert then.count(p=7) == 0
        list(fill_periods(own, 1.6, [7]))
        then.copy(tmp_path / "copy.db")
    assert (Catalogue(tmp_path / "copy.db").count(p=7), catalogue.count(p=7)) == (0, 376)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="the processes are stopped with POSIX signals")
def test_a_copy_made_in_the_midst_of_a_fill_continues_like_it(filled, tmp_path):
    """The latest blocks are only in the journal then."""
    Catalogue(filled).delete(1.6, p=8)
    process = start("fill", "--p", "8", "--jobs", "1", "--db", filled, command=pausing(before=6))
    try:
        wait_until_paused(process)
        copy = tmp_path / "copy.db"
        Catalogue(filled).copy(copy)
        partial = ask(copy, "SELECT words FROM fill WHERE p = 8")
        assert partial == ask(filled, "SELECT words FROM fill WHERE p = 8")
        assert go_on(process)[0] == 0
    finally:
        if process.poll() is None:
            kill_group(process)
    assert 0 < partial[0][0] < 2096
    assert agrees(copy) > 0
    assert Catalogue(copy).verify().sound
    list(fill_periods(copy, 1.6, [8]))
    assert content(copy) == content(filled)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="the processes are stopped with POSIX signals")
def test_copies_made_during_a_fill_are_sound(tmp_path):
    path = tmp_path / "orbits.db"
    assert run("fill", "--p", "3", "--db", path).returncode == 0
    filling = start("fill", "--p", "9", "--jobs", "1", "--db", path, command=small_blocks(32))
    wait_until_ready(filling)
    words: list[int] = []
    while filling.poll() is None:
        copy = tmp_path / f"copy{len(words)}.db"
        done = run("export", copy, "--db", path)
        assert done.returncode == 0, done.stderr
        assert is_sound(copy)
        words.append(agrees(copy))
    filling.communicate()
    assert words == sorted(words)
    assert run("verify", "--db", copy).returncode == 0
    assert not [each.name for each in tmp_path.iterdir() if each.suffix != ".db"]
