"""Files of columns are either complete or absent, and do not depend on writing by rows or by columns."""

import errno
import os
import resource
import sys
from functools import partial

import numpy as np
import pytest
from processes import run
from quick import slow_but

from orbitdb import column_files
from orbitdb import export as files
from orbitdb.errors import InputError, StoreError


def test_an_unwritable_file_is_refused_before_rows_are_read(tmp_path):
    def rows():
        pytest.fail("the first row was asked for")
        yield []

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
    with np.load(tmp_path / "x.npz") as archive:
        np.testing.assert_array_equal(table["length"].to_numpy(), archive["length"])
        np.testing.assert_array_equal(archive["coordinates"], np.arange(45_000) / 3)


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
from orbitdb import errors, export
random.seed(1)
rows = [["13", random.random()] for _ in range(50_000)]
try:
    export.write_file(Path(sys.argv[1]), sys.argv[2], ("code", "length"), rows, {})
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


def test_npz_refuses_texts_that_need_too_much_memory(tmp_path):
    with pytest.raises(InputError, match="parquet"), open(tmp_path / "orbits.npz", "wb") as file:
        column_files.write_npz(file, ("code",), [["1" * 10**6]] * 1000, {})


def test_npz_without_rows_has_all_columns(tmp_path):
    with open(tmp_path / "orbits.npz", "wb") as file:
        column_files.write_npz(file, ("code", "p", "length", "coordinates"), [], {})
    sizes = {name: array.size for name, array in np.load(tmp_path / "orbits.npz").items()}
    assert sizes == {"code": 0, "p": 0, "length": 0, "coordinates": 0, "coordinates_start": 1, "metadata": 1}
