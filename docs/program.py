"""Write the parts of the pages that come from the program: commands, columns, checks, keys and public names.

    python docs/program.py            lists the pages that differ from the program
    python docs/program.py --write    updates these parts in the pages

Such a part is between two comments, such as ``<!-- here: columns_of_word -->`` and ``<!-- end -->``. When
Sphinx reads a page, `fill_in` inserts the public names and reveals the output of notebook cells.
"""

import inspect
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from enum import Enum
from functools import partial
from typing import Any

from orbitdb.columns import GROUPS, OF_ORBITS, Column

_NAMES = "<!-- here: names -->"
_NAME = re.compile(r"<!-- here: name (\w+) -->")
_LISTED = re.compile(r"^\| `(\w+)` \|", re.MULTILINE)
"""A public name in a table of the page on the API."""
_SHOWN = re.compile(r"^<!-- shows\n(.*?)^-->$", re.MULTILINE | re.DOTALL)
"""The output of a notebook cell, in a comment because Jupyter shows its own output."""
_WRITTEN = re.compile(r"^<!-- here: (\w+) -->\n.*?^<!-- end -->$", re.MULTILINE | re.DOTALL)


def fill_in(app: Any, page: str, source: list[str]) -> None:
    """Insert the public names, link those in tables, and reveal outputs of cells as Sphinx reads a page."""
    text = _NAME.sub(lambda mark: _directive(mark[1]), source[0].replace(_NAMES, names()))
    if page == "api":  # a role would be noise in the file itself
        text = _LISTED.sub(r"| {py:obj}`~orbitdb.\1` |", text)
    source[0] = _SHOWN.sub(r"\1", text)


def renewed(text: str) -> str:
    """Return the text of a page with the parts from the program up to date."""
    return _WRITTEN.sub(lambda mark: f"<!-- here: {mark[1]} -->\n\n{_TEXTS[mark[1]]()}\n\n<!-- end -->", text)


def commands() -> str:
    """Return Markdown with a section for every command, after the options that many commands share."""
    listed = command_list()
    shared = _shared(listed)
    first = [
        "## Options of several commands",
        "",
        "Each command below names those that it takes.",
        "",
        *_HEADING,
        *sorted(shared, key=lambda row: shared[row].lstrip("-")),
    ]
    return "\n\n".join(["\n".join(first), *(_command(name, command, shared) for name, command in listed)])


def _shared(listed: list[tuple[str, Any]]) -> dict[str, str]:
    """Return the name of each option of at least `_MANY` commands by its row, the most frequent one."""
    uses: dict[str, Counter[str]] = {}
    for _, command in listed:
        for each, row in zip(_shown(command.params), _rows(command.params), strict=True):
            if each.param_type_name == "option":
                uses.setdefault(each.opts[0], Counter())[row] += 1
    most = {name: rows.most_common(1)[0] for name, rows in uses.items()}
    return {row: name for name, (row, count) in most.items() if count >= _MANY}


def command_list(hidden: bool = False) -> list[tuple[str, Any]]:
    """Return the commands with their names, as ``orbitdb --help`` lists them; hidden ones on request."""
    import typer

    from orbitdb.cli.app import program

    known = typer.main.get_command(program()).commands  # type: ignore[attr-defined]
    return [(name, command) for name, command in known.items() if hidden or not command.hidden]


def _command(name: str, command: Any, shared: Mapping[str, str]) -> str:
    rows = [*_rows(command.params)]
    own = [row for row in rows if row not in shared]
    others = ", ".join(f"`{shared[row]}`" for row in rows if row in shared)
    arguments = [each for each in command.params if each.param_type_name == "argument"]
    names = "".join(f" {_placeholder(each)}" for each in arguments)
    return "\n".join([
        f"({name})=",
        f"## {name}",
        "",
        f"```text\norbitdb {name}{names} [OPTIONS]\n```",
        "",
        _paragraphs(command.help),
        "",
        *([*_HEADING, *own, ""] if own else []),
        f"{'Also' if own else 'Options'}, as [above](#options-of-several-commands): {others or 'none'}.",
        "",
        *_epilog(command.epilog or ""),
    ])  # fmt: skip


def _placeholder(argument: Any) -> str:
    name = str(argument.metavar or argument.name.upper())
    return name if argument.required or name.startswith("[") else f"[{name}]"


def _paragraphs(text: str) -> str:
    """Return the plain text of a help as Markdown."""
    return "\n\n".join(_plain(part) for part in inspect.cleandoc(text).split("\n\n"))


def _plain(text: str) -> str:
    return re.sub(r"([\\*_<>\[\]|$`])", r"\\\1", " ".join(text.split()))


_HEADING = ("| option | means | takes | default |", "|---|---|---|---|")
"""The columns of a table of options; on a narrow screen, the end of a row is out of sight."""
_MANY = 3
"""Number of commands from which on they share an option."""


def _shown(params: list[Any]) -> list[Any]:
    return [each for each in params if not getattr(each, "hidden", False)]


def _rows(params: list[Any]) -> Iterator[str]:
    """Yield a row of the table of options for each parameter of a command."""
    for each in _shown(params):
        names = ", ".join(f"`{name}`" for name in (*each.opts, *each.secondary_opts))
        if each.param_type_name == "argument":
            names = f"`{_placeholder(each)}`"
        yield f"| {names} | {_plain(each.help or '')} | {_takes(each)} | {_default(each)} |"


def _takes(option: Any) -> str:
    if getattr(option, "is_flag", False):
        return ""
    choices = getattr(option.type, "choices", None)
    if option.metavar:
        text = option.metavar
    elif choices:
        text = "|".join(str(getattr(choice, "value", choice)) for choice in choices)
    else:
        text = option.opts[0].strip("-").upper()
    shown = "`" + text.replace("|", "\\|") + "`"
    return f"{shown}, repeatable" if option.multiple else shown


def _default(option: Any) -> str:
    if option.required:
        return "required"
    value = option.default
    if value in (None, (), False) or "[default" in (option.help or ""):
        return ""
    if value is True:
        return "on"
    return f"`{getattr(value, 'value', value)}`"


def _epilog(text: str) -> Iterator[str]:
    """Yield the examples as a block, and the paragraphs after them."""
    parts = [part for part in inspect.cleandoc(text).split("\n\n") if not re.fullmatch("Examples?:", part)]
    lines = [part.strip() for part in parts if part.startswith("  ")]
    if lines:
        yield "<!-- not run: examples of the help -->\n```console\n" + "\n".join(lines) + "\n```"
    for part in parts:
        kept = part.strip().removeprefix("\b").strip()
        if kept != part.strip():  # \b keeps the lines of a paragraph as they are
            yield f"\n```text\n{kept}\n```\n"
        elif not part.startswith("  "):
            yield "\n" + _plain(part) + "\n"


def columns(shown: Sequence[Column]) -> str:
    """Return a Markdown table that explains columns."""
    lines = ["| column | means | type | unit | bounded by | empty |", "|---|---|---|---|---|---|"]
    for each in shown:
        bound = f"`{each.bound}`" if each.bound in _BOUNDS else each.bound
        means = re.sub(r"(?<!\w)'([^']+)'", r"`\1`", each.means).replace("|", r"\|")
        lines.append(f"| `{each.name}` | {means} | {each.kind} | {each.unit} | {bound} | {each.empty} |")
    return "\n".join(lines)


_BOUNDS = {each.name for each in OF_ORBITS}


def checks() -> str:
    """Return a Markdown table of the checks of ``orbitdb verify``, each with the rule that it checks."""
    from orbitdb.verification.verify import PROMISES

    rows = (f"| {check} | {promise} |" for check, promise in PROMISES.items())
    return "\n".join(["| check | what must be true |", "|---|---|", *rows])


_SUBJECTS = {
    "The catalogue": ("catalogue", "selection", "store", "filling", "verification", "answers.completeness"),
    "Orbits": ("billiard", "orbits"),
    "Averages and entropy": ("averages", "entropy_bounds", "trajectories.ensemble"),
    "The open stadium": ("open_stadium",),
    "Levels": ("quantum", "answers.scars"),
    "In a magnetic field": ("magnetic", "answers.field"),
    "Trajectories and the symbol plane": ("trajectories", "symbols", "answers.identification"),
    "Results": ("answers", "display"),
    "Errors": ("errors",),
}
"""For each subject of the page on the API, the modules or packages whose public names belong to it."""

_OWN_PAGES = {"Catalogue": "api-catalogue.md", "Orbit": "api-orbit.md", "Subset": "api-subset.md"}
"""The large classes, each with its page."""


def by_subject() -> dict[str, list[str]]:
    """Return the public names of each subject; the longest name of a module or package decides."""
    import orbitdb

    homes = {home: subject for subject, every in _SUBJECTS.items() for home in every}
    found: dict[str, list[str]] = {subject: [] for subject in _SUBJECTS}
    for name in orbitdb.__all__:
        if name[0] != "_":
            module = f"{getattr(orbitdb, name).__module__.removeprefix('orbitdb.')}."
            found[homes[max((home for home in homes if module.startswith(f"{home}.")), key=len)]].append(name)
    return found


def names() -> str:
    """Return a section for every subject, with the directives that make autodoc document its names."""
    parts = []
    for subject, members in by_subject().items():
        parts.append(f"## {subject}")
        for name in members:
            page = _OWN_PAGES.get(name)
            shown = _directive(name) if page is None else f"[`{name}`]({page}) has a page of its own."
            parts += [f"### {name}", shown]
    return "\n\n".join(parts)


def public_names() -> str:
    """Return Markdown tables of the public names by subject, each with its docstring's first sentence."""
    import orbitdb

    parts = []
    for subject, members in by_subject().items():
        lines = [f"**{subject}**", "", "| name | is |", "|---|---|"]
        for name in members:
            first = inspect.cleandoc(getattr(orbitdb, name).__doc__).split("\n\n")[0]
            sentence = re.split(r"(?<=\.) ", " ".join(first.split()))[0].rstrip(".").replace("``", "`")
            page = _OWN_PAGES.get(name)
            lines.append(f"| {f'`{name}`' if page is None else f'[`{name}`]({page})'} | {sentence} |")
        parts.append("\n".join(lines))
    return "\n\n".join(parts)


def _directive(name: str) -> str:
    import orbitdb

    path, thing = f"orbitdb.{name}", getattr(orbitdb, name)
    if not inspect.isclass(thing):
        lines = [f".. autofunction:: {path}"]
    elif issubclass(thing, Exception):
        lines = [f".. autoexception:: {path}"]
    else:
        ours = [base for base in thing.__mro__ if base.__module__.startswith("orbitdb.")]
        special = [each for each in _SPECIAL if any(each in vars(base) for base in ours)]
        lines = [f".. autoclass:: {path}", "   :members:"]
        if issubclass(thing, Enum):  # its base is a str, whose methods say nothing about it
            lines.append("   :undoc-members:")
        elif len(ours) > 1:
            lines.append("   :inherited-members:")
        lines += [f"   :special-members: {', '.join(special)}"] if special else []
    return "\n".join(["```{eval-rst}", *lines, "```"])


def keys() -> str:
    """Return a Markdown table of the keys of the terminal UI by purpose, with the words of its help."""
    from textual.keys import format_key

    from orbitdb.cli.tui.app import BrowseApp
    from orbitdb.cli.tui.counts_screen import CountsList, CountsScreen
    from orbitdb.cli.tui.help import PURPOSES, explained
    from orbitdb.cli.tui.keys_screen import KeysScreen
    from orbitdb.cli.tui.main_screen import MainScreen
    from orbitdb.cli.tui.panels.paged_table import PagedTable
    from orbitdb.cli.tui.screens import ScrollBox
    from orbitdb.cli.tui.statistics_screen import StatisticsScreen

    groups: dict[str, list[Any]] = {purpose: [] for purpose in (*PURPOSES, "counts", "averages", "keys")}
    own = {CountsScreen: "counts", CountsList: "counts", StatisticsScreen: "averages", KeysScreen: "keys"}
    parts: list[Any] = [PagedTable, ScrollBox, MainScreen, BrowseApp, *own]
    for part in parts:
        for each in part.BINDINGS:
            if not each.system:
                groups[own.get(part, each.id)].append(each)
    lines = ["| | key | does |", "|---|---|---|"]
    for group, bindings in groups.items():
        for place, each in enumerate(bindings):
            names = [each.key_display] if each.key_display else map(format_key, each.key.split(","))
            shown = " ".join(f"`{name}`" for name in names)
            does = _plain(explained(each))
            lines.append(f"| {'' if place else group} | {shown} | {does} |")
    return "\n".join(lines)


def gallery() -> str:
    """Return Markdown that shows every figure of the gallery, with its commands below."""
    from pictures import GALLERY, commands

    shown = []
    for name in GALLERY:
        block = "\n".join(
            ["<!-- not run: the picture above is compared -->", "```sh", *commands(name), "```"]
        )
        shown.append(f"![{name.removesuffix('.svg')}]({name})\n\n{_caption(name)}\n\n{block}")
    return "\n\n".join(shown)


def _caption(name: str) -> str:
    """Return what a picture of the gallery shows, as the help of ``orbitdb plot`` says it."""
    from pictures import commands

    from orbitdb.plots.registry import FIGURES, plain_name

    drawn = commands(name)[-1].split()
    kind = plain_name(drawn[drawn.index("plot") + 1]) if "plot" in drawn else ""
    shows = next(
        (figure.shows for figure in FIGURES if figure.name == kind and figure.shows), "run time against error"
    )
    return f"**{kind or 'bench'}**: {_plain(shows.rstrip('.'))}."


_SPECIAL = ("__contains__", "__getitem__", "__iter__", "__len__")

_TEXTS: dict[str, Callable[[], str]] = {
    "commands": commands,
    "public_names": public_names,
    "checks": checks,
    "keys": keys,
    "gallery": gallery,
    **{f"columns_of_{of}": partial(columns, group) for of, group in GROUPS},
}


def main() -> int:
    """Compare all pages with the program, or update them; return 1 if pages differ and are not updated."""
    from pages import PAGES

    differing = [page for page in PAGES if renewed(text := page.read_text(encoding="utf-8")) != text]
    if "--write" in sys.argv[1:]:
        for page in differing:
            page.write_text(renewed(page.read_text(encoding="utf-8")), encoding="utf-8")
        return 0
    print(*(f"{page.name} differs from the program" for page in differing), sep="\n")
    return int(bool(differing))


if __name__ == "__main__":
    sys.exit(main())
