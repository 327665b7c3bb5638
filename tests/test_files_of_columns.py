"""Files of columns are either complete or absent, and do not depend on writing by rows or by columns."""

import errno
import json
import os
import resource
import sys
from functools import partial

import pytest
from processes import run
from quick import slow_but

from orbitdb import output_files as files
from orbitdb.errors import StoreError


def test_an_unwritable_file_is_refused_before_rows_are_read(tmp_path):
    def rows():
        yield pytest.fail("the first row was asked for")

    for form in files.FORMATS:
        with pytest.raises(StoreError, match="there is no folder"):
            files.write_file(tmp_path / "missing" / f"x.{form}", form, ("code",), rows(), {})


@pytest.mark.slow
def test_files_can_have_more_rows_than_a_block(tmp_path):
    from pyarrow import parquet

    rows = [[str(n), n / 7, [n / 3]] for n in range(45_000)]
    for form in files.FORMATS:
        files.write_file(tmp_path / f"x.{form}", form, ("code", "length", "coordinates"), rows, {})
    table = parquet.read_table(tmp_path / "x.parquet")
    assert table["length"].to_pylist() == [n / 7 for n in range(45_000)]
    for form in ("json", "jsonl"):
        text = (tmp_path / f"x.{form}").read_text()
        written = json.loads(text) if form == "json" else list(map(json.loads, text.splitlines()))
        assert [row["coordinates"] for row in written] == [[n / 3] for n in range(45_000)]


@pytest.mark.parametrize("form", files.FORMATS)
@pytest.mark.parametrize("trouble", slow_but([KeyboardInterrupt], [KeyboardInterrupt, ZeroDivisionError]))
def test_an_interrupted_export_keeps_the_old_file(tmp_path, form, trouble):
    def rows():
        yield from (["13", float(n)] for n in range(10_000))
        raise trouble

    target = tmp_path / f"orbits.{form}"
    target.write_text("old")
    with pytest.raises(trouble):
        files.write_file(target, form, ("code", "length"), rows(), {})
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [(target.name, "old")]


WRITE = """
import random, sys
from importlib.metadata import version
from pathlib import Path
from orbitdb import errors, output_files
random.seed(1)
rows = [["13", random.random()] for _ in range(50_000)]
try:
    output_files.write_file(Path(sys.argv[1]), sys.argv[2], ("code", "length"), rows, {})
except errors.StoreError as error:
    print(error)
"""


@pytest.mark.parametrize("form", slow_but(["csv"], files.FORMATS))
def test_a_full_disk_is_reported_and_leaves_no_file(tmp_path, form):
    target = tmp_path / f"orbits.{form}"
    full = partial(resource.setrlimit, resource.RLIMIT_FSIZE, (100_000, 100_000))
    done = run(target, form, command=[sys.executable, "-P", "-c", WRITE], preexec_fn=full)
    assert done.stdout == f"{target} cannot be written ({os.strerror(errno.EFBIG)}); nothing was saved\n"
    assert done.stderr == ""
    assert list(tmp_path.iterdir()) == []
