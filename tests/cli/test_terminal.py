"""Commands in a real terminal."""

import re
import sys
from itertools import chain
from pathlib import Path

import pexpect
import pytest
from processes import COMMAND, commands, small_blocks
from quick import slow_but
from terminal import Run, Session, ended, run_in_terminal, run_several_in_terminal, spawn
from there import there

from orbitdb.catalogue import Catalogue

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo-terminal")

KEPT = "nothing that was stored is lost, and the same command continues from there"
INTERRUPTED = f"orbitdb: interrupted; {KEPT}"
BAR = r"[━─]{12,}"
NEW = ("--db", "{folder}/new.db")
FILLING = [
    ("fill", "--p", "6", *NEW),
    ("fill", "--p", "7", *NEW),  # continues from p = 6
    ("fill", "--p", "5", "--a", "1", *NEW),  # the classes are known already
    ("fill", "--p", "3", "--method", "relaxation", "--a", "2", *NEW),
    ("fill", "--p", "4", "--geometric", *NEW),
    ("simulate", "--bounces", "300000", *NEW),
    ("verify", "--prove", "--p", "2-4", *NEW),
    ("migrate", "--db", "{folder}/empty.db"),
    ("births", "--p", "5", *NEW),
    ("sweep", "--p", "7", *NEW),
    ("bounds", "--edges", "6", "--prove", *NEW),
]
READING = [
    ("verify", "--p", "2-5", "--format", "csv"),
    ("export", "{folder}/rows.csv"),
    ("export", "{folder}/rows.parquet", "-c", "+coordinates", "--a", "1"),
    ("plot", "lengths", "-o", "{folder}/lengths.svg"),
    ("plot", "life", "--code", "013", "-o", "{folder}/life.svg"),
    ("entropy",),
    ("lyapunov",),
    ("lyapunov", "--cut", "4", "--p", "2-4", "--json"),
]
MEASURING = [("bench", "--p", "3", "--format", "csv"), ("bench", "--kind", "methods", "--p", "3")]
QUIET = [
    ("fill", "--p", "14", "--dry-run"),
    ("query", "--code", "1232131"),
    ("query", "--status", "orbit"),
    ("query", "--p", "2", "--json"),
    ("query", "--p", "2,3", "--format", "tsv"),
    ("table",),
    ("info",),
    ("columns",),
    ("sql", "SELECT p, count(*) AS words FROM catalogue GROUP BY p"),
    ("identify", "--length", "10.4"),
    ("identify", "--start", "0.3,0.2,1"),
    ("query", "--code", "9"),
    ("table", "--a", "9"),
    ("fill",),
    ("browse", "--p", "x"),
    ("nothing",),
]
A_FEW = [("fill", "--p", "5", *NEW)]
A_FEW_QUIET = [("query", "--p", "2,3"), ("query", "--code", "9")]
HELP = [("--help",), ("--version",), *((name, "--help") for name in commands())]


def same(text: str) -> str:
    """Mask the numbers of a text, which vary between runs, and drop blanks, which wrapping changes."""
    return re.sub(r"[\d.e+-]*\d[\d.e+-]*", "#", re.sub(r"\s", "", text))


def runs_of(commands, folder: Path, columns: int = 80, to: str = "") -> list[Run]:
    """Return the runs of commands in a folder. `to` sends stdout (o), stderr (e) or both to files."""
    folder.mkdir()
    runs = []
    for number, arguments in enumerate(commands):
        out, err = (folder / f"{number}.txt" if stream in to else None for stream in "oe")
        placed = [argument.replace("{folder}", str(folder)) for argument in arguments]
        runs.append(Run(placed, columns, out, err))
    return runs


def well_behaved(session: Session) -> None:
    assert "Traceback" not in session.text, session.text
    assert session.restored
    assert session.plain


def on_screens_as_in_files(commands, quiet, tmp_path: Path, widths=(80,), **variables: str) -> None:
    """Check that screens end up with exactly what files get. `quiet` commands show no bar; others may."""
    both = [*commands, *quiet]
    screens = {f"s{columns:03}": runs_of(both, tmp_path / f"s{columns:03}", columns) for columns in widths}
    runs = {"both": runs_of(both, tmp_path / "both", 80, "oe"), **screens}
    sessions = iter(run_several_in_terminal([*chain.from_iterable(runs.values())], **variables))
    codes, with_bar = [], set[int]()
    for run in runs["both"]:
        found = next(sessions)
        assert not found.raw
        assert "\x1b" not in there(run.out).read_text()
        codes.append(found.code)
    for name in screens:
        for number, (code, run) in enumerate(zip(codes, runs[name], strict=True)):
            session = next(sessions)
            well_behaved(session)
            assert session.code == code, session.text
            expected = there(runs["both"][number].out).read_text().replace("/both/", f"/{name}/")
            assert same("".join(session.lines)) == same(expected), run
            assert session.erased, run
            with_bar |= {number} if session.had_bar else set()
    assert with_bar  # not of every command: a quick one may end before its bar is drawn
    assert with_bar <= set(range(len(commands)))


def test_a_fill_and_two_queries_show_on_screen_what_files_get(varied, tmp_path):
    on_screens_as_in_files(A_FEW, A_FEW_QUIET, tmp_path, ORBITDB_DB=str(varied))


@pytest.mark.slow
def test_info_fits_into_the_terminal(cli, tmp_path):
    for command in ("fill", "--p", "4"), ("bounds", "--edges", "2", "--prove"):
        assert cli(*command, "--a", "0.30000000000000004").code == 0
    database, widths = str(tmp_path / "orbits.db"), (60, 80)
    for columns, session in zip(
        widths, run_several_in_terminal([Run(["info"], columns) for columns in widths], ORBITDB_DB=database),
        strict=True,
    ):  # fmt: skip
        assert max(map(len, session.text.splitlines()[1:])) <= columns
        assert "balls" in session.text


@pytest.mark.slow
def test_commands_that_fill_show_on_screen_what_files_get(tmp_path):
    on_screens_as_in_files(FILLING, [], tmp_path, (200,))


@pytest.mark.slow
def test_commands_that_read_show_on_screen_what_files_get(varied, tmp_path):
    on_screens_as_in_files(READING, QUIET, tmp_path, (80,), ORBITDB_DB=str(varied))


@pytest.mark.slow
def test_benchmarks_and_help_show_on_screen_what_files_get(tmp_path):
    on_screens_as_in_files(MEASURING, HELP, tmp_path, (80,))


def ends_in_order(session: Session, code: int, lines: list[str]) -> None:
    assert session.code == code, session.text
    well_behaved(session)
    assert [line.lstrip("^C") for line in session.lines] == lines


def filling(path: Path, *options: str) -> pexpect.spawn:
    """Start a fill in a window of 80 columns, and wait for its bar."""
    child = spawn("fill", "--p", "12", *options, "--db", path, command=small_blocks(64))
    child.expect("ready\r\n")
    child.expect(r"words, p = [^\r]*\r")
    return child


@pytest.mark.slow
@pytest.mark.parametrize("jobs", ["1", "2"])
def test_ctrl_c_ends_a_fill_whose_window_was_resized(tmp_path, jobs):
    child = filling(tmp_path / "orbits.db", "--jobs", jobs)
    child.setwinsize(24, 200)
    child.expect(rf"\r\x1b\[Jwords, p = [ \d]+ of 12 {BAR} [^\r]*/s  [\d,]+ of 276,797 *\r")
    wide = child.before + child.after
    child.setwinsize(24, 40)
    child.expect(rf"\r\x1b\[Jwords, p = [ \d]+ of 12 {BAR}  +\d+%[^\r]{{,5}}\r")
    wide += child.before  # drawn for the old width
    narrow = child.after
    child.sendintr()
    child.expect(pexpect.EOF)
    session = ended(child, (wide, 200), (narrow + child.before, 40))
    ends_in_order(session, 130, [INTERRUPTED[:40], INTERRUPTED[40:80].rstrip(), INTERRUPTED[80:]])


@pytest.mark.slow
def test_ctrl_c_at_a_question_ends_its_line_and_deletes_nothing(filled):
    child = spawn("delete", "--a", "1.6", "--db", filled, columns=300)
    child.expect(r"\[y/N\]: ")
    asked = child.before + child.after
    child.sendintr()
    child.expect(pexpect.EOF)
    session = ended(child, (asked + child.before, 300))
    assert session.code == 130
    question, told = session.lines
    assert (question.startswith("Delete "), told) == (True, "orbitdb: interrupted")
    assert [fill.p for fill in Catalogue(filled).fills(a=1.6)] == [*range(2, 9)]


@pytest.mark.slow
def test_a_command_can_be_suspended_and_resumed(tmp_path):
    shell = spawn("--norc", "--noprofile", "-i", command=["bash"], PS1="$ ")
    command = [*COMMAND[:-1], f"'{COMMAND[-1]}'", "simulate", "--db", str(tmp_path / "orbits.db")]
    shell.sendline(" ".join([*command, "--bounces", "1000000000"]))  # still running when it returns
    shell.expect(rf"{BAR}[^\r]*\r")
    shell.send("\x1a")
    shell.expect(r"\[1\]\+ +Stopped")
    shell.sendline("bg")
    shell.expect(r"\$ ")
    with pytest.raises(pexpect.TIMEOUT):  # nothing is drawn over the prompt
        shell.expect(BAR, timeout=1)
    shell.sendline("fg")
    shell.expect(rf"{BAR}[^\r]*\r")
    shell.sendintr()
    shell.expect("orbitdb: interrupted")
    shell.expect(r"\$ ")
    shell.sendline("exit 7")
    shell.expect(pexpect.EOF)
    assert ended(shell).code == 7


_INTERRUPTED_IMPORT = """
import signal, sys
class Finder:
    def find_spec(self, name, path, target=None):
        if name == {name!r}:
            signal.raise_signal(signal.SIGINT)
            print("goes on")
sys.meta_path.insert(0, Finder())
from orbitdb.cli.main import run
run()
"""


@pytest.mark.parametrize(
    "name",
    slow_but(["numpy"], ["typer", "numpy", "orbitdb.cli.commands.fill", "numpy._core.multiarray", "sqlite3"]),
)
def test_ctrl_c_during_imports_ends_the_command(tmp_path, name):
    command = [sys.executable, "-P", "-c", _INTERRUPTED_IMPORT.format(name=name)]
    session = run_in_terminal(
        "fill", "--p", "3", "--db", tmp_path / "orbits.db", command=command, columns=200
    )
    ends_in_order(session, 130, [INTERRUPTED])


ODD = [
    ("export", "--format", "csv", "--p", "2,3"),
    ("verify", "--p", "2-3", "--json"),
    ("entropy", "--format", "tsv"),
    *QUIET,
]


@pytest.mark.parametrize(
    ("commands", "columns", "variables"),
    [
        pytest.param([ODD[0], *QUIET[-5:], HELP[0], HELP[2]], 1, {"TERM": "dumb"}, id="few"),
        pytest.param([*ODD, *HELP], 20, {"TERM": "", "LC_ALL": "C"}, id="all"),
    ],
)
@pytest.mark.slow
def test_odd_terminals_get_plain_output(varied, tmp_path, commands, columns, variables):
    runs = runs_of(commands, tmp_path / "odd", columns)
    sessions = run_several_in_terminal(runs, ORBITDB_DB=str(varied), **variables)
    for run, session in zip(runs, sessions, strict=True):
        well_behaved(session)
        assert (session.code == 0) == (run.arguments not in [list(each) for each in QUIET[-5:]]), session.text
        if "TERM" in variables:
            assert not session.had_bar
