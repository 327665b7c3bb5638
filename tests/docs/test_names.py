"""README and pages only name modules, files, tests, commands, options and columns that exist."""

import importlib
import re
from functools import cache
from importlib.metadata import metadata
from pathlib import Path

import pages
import program
import pytest

import orbitdb

PATHS = re.compile(r"(?<![\w./-])((?:orbitdb|cli|tests|docs|migrations)/[\w./-]*\w/?)")
MODULES = re.compile(r"(?<![\w./-])orbitdb(?:\.[A-Za-z_]\w*)+")
TESTS = re.compile(r"`(test_\w+)`")
INLINE = re.compile(r"`([^`\n]+)`")
OPTION = re.compile(r"(?<![\w-])--?[A-Za-z][\w-]*")
OF_OTHERS = {"--scheduler-file", "--write"}
"""Options of dask, and of the tool that rewrites examples."""

each_page = pytest.mark.parametrize("page", pages.PAGES, ids=lambda page: page.stem)


def prose(page: Path) -> str:
    """Return a page without its code blocks."""
    lines = page.read_text(encoding="utf-8").splitlines()
    for block in reversed(pages.blocks(lines)):
        del lines[block.start - 1 : block.end + 1]
    return "\n".join(lines)


def exists(name: str) -> bool:
    """Tell whether a dotted name is a module, or something in one."""
    parts = name.split(".")
    for end in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(parts[:end]))
        except ModuleNotFoundError:
            continue
        for part in parts[end:]:
            if not hasattr(found, part):
                return False
            found = getattr(found, part)
        return True
    return False


@each_page
def test_the_files_a_page_names_exist(page):
    assert [path for path in PATHS.findall(prose(page)) if not (pages.ROOT / path).exists()] == []


@each_page
def test_the_modules_a_page_names_exist(page):
    assert [name for name in MODULES.findall(prose(page)) if not exists(name)] == []


def test_the_tests_that_pages_name_exist():
    written = "\n".join(file.read_text(encoding="utf-8") for file in pages.ROOT.glob("tests/**/*.py"))
    named = [name for page in pages.PAGES for name in TESTS.findall(prose(page))]
    assert [name for name in named if f"def {name}(" not in written] == []


@cache
def options() -> dict[str, set[str]]:
    """Return the options of every command."""
    return {
        name: {text for each in command.params for text in (*each.opts, *each.secondary_opts)} | {"--help"}
        for name, command in program.command_list(hidden=True)
    }


@each_page
def test_the_commands_and_options_a_page_names_exist(page):
    known = options()
    every = set().union(*known.values()) | OF_OTHERS | {"--version"}
    unknown = []
    for text in INLINE.findall(prose(page)):
        words = text.split()
        if words[0] == "orbitdb" and len(words) > 1 and words[1].isalpha() and words[1].islower():
            mine = known.get(words[1])
            unknown += [text] if mine is None else [each for each in OPTION.findall(text) if each not in mine]
        elif words[0].startswith("--"):
            unknown += [each for each in OPTION.findall(text) if each not in every]
    assert unknown == []


def test_usage_lines_include_arguments():
    written = program.commands()
    for usage in ("plot FIGURE [WORD]...", "query [WORD]...", "export [FILE]", "sql SELECT"):
        assert f"\norbitdb {usage} [OPTIONS]\n" in written


def test_all_pages_install_extras_in_the_same_way():
    """From the sources: ``pip install 'orbitdb[plot]'`` only works once the program is installed."""
    known = set(metadata("orbitdb").get_all("Provides-Extra", []))
    written = [page.read_text(encoding="utf-8") for page in (*pages.PAGES, pages.ROOT / "CHANGELOG.md")]
    lines = re.findall(r"pip install (?:-e )?['\"](\S+)\[(\S+)\]", "\n".join(written))
    named = {extra for name, extras in lines for extra in extras.split(",") if name == "."}
    assert {name for name, _ in lines} - {"."} == {"pyright"}
    assert {"test", "plot", "pandas", "dask", "docs"} <= named <= known


def test_every_column_is_in_the_data_dictionary():
    """Each has a unit or type, a meaning, and a note when it is empty."""
    columns = [column.name for column in orbitdb.columns.IN_CATALOGUE]
    page = [(pages.ROOT / "docs/columns.md").read_text(encoding="utf-8")]
    program.fill_in(None, "columns", page)
    told = dict(re.findall(r"(?m)^\| `(\w+)` \|(.+)\|$", page[0].partition("## Statuses")[0]))
    assert set(columns) < set(told)
    assert "length of one traversal, L | number | radius | `length_error`" in page[0]
    assert {len(row.split("|")) for row in told.values()} == {5}


def test_the_data_dictionary_has_every_status_and_rule():
    page = (pages.ROOT / "docs/columns.md").read_text(encoding="utf-8")
    assert [status for status in orbitdb.Status if f"\n| `{status}` |" not in page] == []
    assert re.findall(r"(?m)^\| (\d) \|", page) == [str(number) for number in range(1, 7)]


def test_the_gallery_has_every_figure_with_its_command():
    from orbitdb.plots.registry import NAMES

    page = (pages.ROOT / "docs/gallery.md").read_text(encoding="utf-8")
    shown = re.findall(r"(?ms)^!\[[^]]*\]\((\S+)\)\n\n\*\*.+?\n\n<!--[^>]*-->\n```sh\n(.+?)```$", page)
    assert len(shown) == page.count("![")
    assert all((pages.ROOT / "docs" / picture).exists() for picture, _ in shown)
    drawn = [re.findall(r"(?m)^orbitdb plot (\S+) .*-o figure.svg$", commands) for _, commands in shown]
    assert {kind for kinds in drawn for kind in kinds} == set(NAMES)


def test_every_page_is_in_the_table_of_contents():
    index = (pages.ROOT / "docs/index.md").read_text(encoding="utf-8")
    trees = re.findall(r"```\{toctree\}(.*?)```", index, flags=re.DOTALL)
    listed = {line for tree in trees for line in tree.split() if not line.startswith(":")}
    assert {page.stem for page in (pages.ROOT / "docs").glob("*.md")} - {"index"} <= listed


def test_outputs_of_the_notebook_are_in_comments_and_on_the_page():
    """Jupyter shows its own; outside a comment, each would stand there twice."""
    written = (pages.ROOT / "docs/notebook.md").read_text(encoding="utf-8")
    built = [written]
    program.fill_in(None, "notebook", built)
    output = r"(?m)^(?:```text|!\[)"
    assert not re.search(output, re.sub(r"(?s)<!--.*?-->", "", written))
    assert len(re.findall(output, re.sub(r"(?s)<!--.*?-->", "", built[0]))) == written.count("<!-- shows") > 5


def test_every_name_in_the_tables_of_the_api_is_a_link():
    built = [(pages.ROOT / "docs/api.md").read_text(encoding="utf-8")]
    program.fill_in(None, "api", built)
    rows = re.findall(r"(?m)^\| ([^|]+) \| .+ \|$", built[0])
    first = [cell for cell in rows if cell not in ("name", "---")]
    linked = [re.fullmatch(r"\{py:obj\}`~orbitdb\.(\w+)`|\[`(\w+)`\]\(\S+\)", cell) for cell in first]
    named = [link[1] or link[2] for link in linked if link]
    assert sorted(["__version__", *named]) == sorted(orbitdb.__all__)


@pytest.mark.parametrize("page", pages.PAGES, ids=lambda page: page.stem)
def test_generated_tables_are_up_to_date(page):
    """`python docs/program.py --write` writes them."""
    text = page.read_text(encoding="utf-8")
    assert program.renewed(text) == text
