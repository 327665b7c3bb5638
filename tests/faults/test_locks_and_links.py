"""Locks that our own process must not drop, and names of a file that must not be written through."""

import os
import re
import shutil
import subprocess
import sys

import pytest

from orbitdb import Catalogue
from orbitdb.errors import ExportError

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the locks and links of POSIX")

LOCKS = """
import fcntl, sys
with open(sys.argv[1], "r+b") as file:
    try:
        fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB, 510, 0x40000002)  # SQLite's bytes for readers
    except OSError:
        print("held")
"""


def is_held(path):
    """Tell whether another process keeps SQLite's lock of readers on a file."""
    return (
        subprocess.run([sys.executable, "-c", LOCKS, path], capture_output=True, text=True).stdout == "held\n"
    )


@pytest.mark.parametrize("linked", [False, True])
def test_a_refused_target_keeps_the_locks_of_the_catalogue(filled, tmp_path, linked):
    target = tmp_path / "link.db" if linked else filled
    if linked:
        target.symlink_to(filled)
    with Catalogue(filled, a=1.6).snapshot() as then:
        assert then.count(p=3) == 8
        assert is_held(filled)
        for write in (then.copy, then.rows(p=3, columns=("code",)).write):
            with pytest.raises(
                ExportError, match="is an SQLite file, such as a catalogue, and is never replaced"
            ):
                write(
                    target.with_suffix(".db"), **({"force": True} if write == then.copy else {"form": "csv"})
                )
            assert is_held(filled)
    assert not is_held(filled)


def test_targets_are_told_apart_by_their_content(filled, tmp_path):
    target = tmp_path / "target.csv"
    journal = bytes.fromhex("377f0682") + bytes(28)
    for content in (journal, bytes.fromhex("d9d505f920a163d7"), filled.read_bytes()[:5000]):
        target.write_bytes(content)
        with pytest.raises(ExportError, match="is an SQLite file"):
            Catalogue(filled, a=1.6).rows(p=3).write(target, force=True)
        assert target.read_bytes() == content
    for content in (b"", b"x", b"a,b\n1,2\n" * 1000):
        target.write_bytes(content)
        assert Catalogue(filled, a=1.6).rows(p=3).write(target, force=True) == 8


WRITERS = [
    ("fill", "--p", "3", "--a", "1"),
    ("delete", "--a", "1.6", "--yes"),
    ("sweep", "--p", "9"),
    ("verify", "--prove"),
]


@pytest.mark.parametrize("command", WRITERS, ids=lambda command: command[0])
def test_a_file_with_two_names_is_not_written_to(filled, cli, command):
    other = filled.with_name("backup.db")
    os.link(filled, other)
    before = filled.read_bytes()
    for path in (filled, other):
        ended = cli(*command, "--db", str(path))
        assert ended.says(3, f"{path} has another name (a hard link, as 'cp -al' makes)")
        assert f"cp {path} {path}.new && mv {path}.new {path}" in ended.err
        assert cli("query", "--p", "3", "--db", str(path)).code == 0
    assert filled.read_bytes() == before
    shutil.copyfile(filled, f"{filled}.new")
    os.replace(f"{filled}.new", filled)
    assert cli("fill", "--p", "3", "--a", "1", "--db", str(filled)).code == 0
    assert other.read_bytes() == before


WITHOUT_FILES = """
import os, resource, sys
from orbitdb import Catalogue, StoreError
catalogue = Catalogue(sys.argv[1], a=1.6)
assert catalogue.count(p=3) == 8
resource.setrlimit(resource.RLIMIT_NOFILE, (64, 64))
opened = []
try:
    while True:
        opened.append(os.open(os.devnull, os.O_RDONLY))
except OSError:
    pass
try:
    catalogue.count(p=3)
except StoreError as error:
    print(error)
os.close(opened.pop()), os.close(opened.pop()), os.close(opened.pop()), os.close(opened.pop())
assert catalogue.count(p=3) == 8
"""


def test_a_process_without_a_free_descriptor_says_so(filled):
    done = subprocess.run([sys.executable, "-c", WITHOUT_FILES, filled], capture_output=True, text=True)
    said = "this process has 64 open files, all that 'ulimit -n' allows: close some, or raise the limit"
    assert done.stdout == f"{filled} cannot be opened: {said}\n", done.stderr


@pytest.mark.parametrize("most", [5, 6, 7])
@pytest.mark.slow
def test_a_command_with_few_descriptors_says_so(filled, most):
    table = f"'{sys.executable}' -P -m orbitdb fill --p 4 --db '{filled}'"
    ended = subprocess.run(["bash", "-c", f"ulimit -n {most}; exec {table}"], capture_output=True, text=True)
    assert ended.returncode == 3, ended.stderr
    assert re.search(r"open files.* 'ulimit -n'", ended.stderr.splitlines()[-1])  # of a catalogue or a module
    assert "Traceback" not in ended.stderr


@pytest.mark.slow
def test_a_limit_of_the_size_of_files_is_named(filled):
    before = Catalogue(filled, a=1.6).count()
    fill = f"'{sys.executable}' -P -m orbitdb fill --p 10 --a 1 --jobs 1 --db '{filled}'"
    ended = subprocess.run(["bash", "-c", f"ulimit -f 1200; exec {fill}"], capture_output=True, text=True)
    assert ended.returncode == 3, ended.stderr
    assert "cannot grow, because 'ulimit -f' allows files of 1.2 MB" in ended.stderr.splitlines()[-1]
    assert Catalogue(filled, a=1.6).count() == before
