"""The commands of ``orbitdb``, each imported when it is used, and their help, grouped into panels."""

import logging
import os
import re
import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from functools import cache
from importlib import import_module
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from orbitdb import __version__
from orbitdb.cli.options import GONE, with_groups
from orbitdb.text import guess, quoted

ParsingError = typer.TyperException

PANELS = {
    "Make data": {
        "fill": "Fill periods: find every word, its status and its orbit",
        "births": "Find the ranges of a in which each word is an orbit",
        "sweep": "Count orbits and average over further periods without storing rows",
        "simulate": "Average over random trajectories, for comparison",
        "escape": "Open the stadium, and find how fast trajectories escape",
        "bounds": "Prove bounds on the topological entropy",
        "levels": "Find the levels of the quantum stadium",
    },
    "Ask": {
        "query": "Show one orbit by its code, or rows of the catalogue",
        "count": "Count words and classes, by any columns",
        "browse": "Browse the catalogue in the terminal",
        "identify": "Find orbits by starting point, by bounces or by length",
        "sql": "Run a SELECT statement on the catalogue",
        "columns": "Explain the columns: their units, error bounds and meanings",
    },
    "Average": {
        "table": "Show the paper's Table 1 for any a",
        "entropy": "Compute the topological entropy by period",
        "lyapunov": "Compute average Lyapunov exponents by period",
        "spectrum": "Compare the length spectra of quantum levels and orbits",
        "assess": "Find levels missing from a list, or show level statistics",
        "scars": "Measure how strongly orbits scar quantum levels",
        "field": "Follow orbits into a magnetic field, where paths are arcs",
    },
    "Files and figures": {
        "export": "Write rows to a file for other tools",
        "plot": "Draw an orbit, or a figure of a chosen subset",
    },
    "Maintenance": {
        "info": "Show where the catalogue is and what it contains",
        "verify": "Recompute the catalogue and compare the results",
        "merge": "Join catalogues that were filled apart",
        "delete": "Delete what is stored at one half length",
        "migrate": "Update an older catalogue to the latest schema",
        "bench": "Measure run time against error, or solve hard cases",
    },
}
"""The commands in each panel of the help, with one-line summaries."""

_MODULES = {name: name for names in PANELS.values() for name in names}
_MODULES |= dict.fromkeys(("table", "entropy", "lyapunov", "simulate"), "averages")
_MODULES |= {"sweep": "fill", "births": "fill", "sql": "query", "columns": "query", "scars": "spectrum"}
_MODULES |= dict.fromkeys(("delete", "migrate"), "info")
"""The module of each command in `orbitdb.cli.commands`. It contains the function of the command, `EXAMPLES`
(a dict if the module has several commands) and optionally an `AFTERWORD`."""

_OPTIONS = {
    "Catalogue": ("a", "db"),
    "Choose": (
        "p", "status", "time_reversal", "symmetry", "contains", "without", "opening", "exists", "not_at",
        "bounds", "where", "parameters",
    ),
    "Output": (
        "classes", "order", "limit", "offset", "columns", "by_bounce", "format_", "form", "json", "digits",
        "uncertainty", "output", "force",
    ),
    "Other": ("quiet", "help"),
}  # fmt: skip
"""Panels of the options that commands share; the help lists the other options of a command first."""


class Command(TyperCommand):
    """A command whose help groups its options into panels.

    An option given twice is refused if only its last value would count.
    """

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the arguments; refuse one dash before a name, and a single value given more than once."""
        if not ctx.resilient_parsing:
            self._refuse_single_dashes(ctx, args)
            *_, order = self.make_parser(ctx).parse_args(args=list(args))
            for option, times in Counter(order).items():
                if (
                    times > 1
                    and not getattr(option, "multiple", True)
                    and not getattr(option, "is_flag", True)
                ):
                    ctx.fail(f"{option.opts[0]} is given {times} times: give it once")
        return super().parse_args(ctx, args)

    def _refuse_single_dashes(self, ctx: Any, args: list[str]) -> None:
        """Refuse ``-format``, which would be read as -f and more letters, wherever an option may stand."""
        options = [each for each in self.params if each.param_type_name == "option"]
        names = {name for each in options for name in (*each.opts, *each.secondary_opts)}
        valued = {name for each in options if not getattr(each, "is_flag", False) for name in each.opts}
        before = ""
        for text in args:
            if text == "--":
                return
            name, _, _ = text.partition("=")
            if before not in valued and name[:1] == "-" and name not in names and f"-{name}" in names:
                ctx.fail(f"options have two dashes: -{name}")
            before = text

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the arguments, then the options panel by panel."""
        panel_of = {name: panel for panel, names in _OPTIONS.items() for name in names}
        panels: dict[str, list[Any]] = {panel: [] for panel in ("Arguments", "Options", *_OPTIONS)}
        for parameter in self.get_params(ctx):
            if getattr(parameter.type, "name", "") == "str":  # as a placeholder, it explains nothing
                parameter.metavar = parameter.metavar or parameter.opts[0].strip("-").upper()
            if (record := parameter.get_help_record(ctx)) is not None:
                is_option = parameter.param_type_name == "option"
                panel = panel_of.get(parameter.name or "", "Options") if is_option else "Arguments"
                panels[panel].append(record)
        for panel, records in panels.items():
            _write(formatter, panel, records)


class Group(TyperGroup):
    """The program, whose help groups the commands into panels."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the arguments; a shell after ``--show-completion`` or ``--install-completion`` is that meant.

        Typer would take the shell that runs this program.
        """
        for option in self.get_params(ctx):
            named = len(args) == 2 and args[0] in option.opts and args[0].endswith("-completion")
            if named and option.callback is not None:
                option.callback(ctx, option, args[1])  # ends the program
        return super().parse_args(ctx, args)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the commands panel by panel, one per line."""
        for panel, commands in PANELS.items():
            _write(formatter, panel, commands.items())


def _write(formatter: Any, panel: str, rows: Iterable[tuple[str, str]]) -> None:
    if listed := list(rows):
        with formatter.section(panel):
            formatter.write_dl(listed)


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"orbitdb {__version__}")
        raise typer.Exit


def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    pass


os.environ["MPLBACKEND"] = "agg"  # files need no display; a notebook leaves a backend that this program lacks
logging.getLogger("matplotlib").setLevel(logging.ERROR)  # it would report missing fonts


def program(commands: Sequence[str] = tuple(_MODULES)) -> typer.Typer:
    """Return the program with the given commands, by default all of them."""
    app = typer.Typer(
        cls=Group,
        help="A certified catalogue of the unstable periodic orbits of the stadium billiard.",
        context_settings={"help_option_names": ["-h", "--help"]},
        rich_markup_mode=None,
    )
    app.callback()(_options)
    for name in commands:
        module = import_module(f"orbitdb.cli.commands.{_MODULES[name]}")
        command = with_groups(getattr(module, name))
        if command.__doc__ is None:  # python -OO
            command.__doc__ = _docstring(module, name)
        app.command(name, cls=Command, epilog=_epilog(module, name))(command)
    return app


def _docstring(module: Any, name: str) -> str | None:
    """Return the docstring of a function from its source."""
    import ast
    from inspect import getsource

    functions = [node for node in ast.parse(getsource(module)).body if isinstance(node, ast.FunctionDef)]
    return next(ast.get_docstring(node) for node in functions if node.name == name)


def _examples(module: Any, name: str) -> Sequence[str]:
    examples: Sequence[str] = module.EXAMPLES[name] if isinstance(module.EXAMPLES, dict) else module.EXAMPLES
    return examples


def _epilog(module: Any, name: str) -> str:
    examples = _examples(module, name)
    several = "s" if len(examples) > 1 else ""
    lines = (f"  orbitdb {example}" for example in examples)
    return "\n\n".join([f"\nExample{several}:", *lines, getattr(module, "AFTERWORD", "")])


def refusal(error: ParsingError) -> str:
    """Say what is wrong with arguments that cannot be parsed, and what to do."""
    text = " ".join(error.format_message().split())
    context, mistyped = getattr(error, "ctx", None), getattr(error, "option_name", None)
    if context is not None and text.startswith("Missing "):
        module = import_module(f"orbitdb.cli.commands.{_MODULES[context.info_name]}")
        example = _examples(module, context.info_name)[0]
        return f"{text.rstrip('.')}, as in 'orbitdb {example}' (--help shows the options)"
    if isinstance(error, typer.BadParameter):
        return text
    if context is not None and (extra := _EXTRA.fullmatch(text)):
        text = f"{text}{_where_it_goes(extra[1], context)}"
    if context is None or mistyped is None:
        return f"{text} (--help shows the options)"
    if context.parent is None:
        return f"{text} (options go after the command, as in 'orbitdb table --db PATH')"
    now = GONE.get(f"{context.info_name} {mistyped}") or GONE.get(mistyped)
    every = [name for parameter in context.command.params for name in parameter.opts]
    if now is not None and now.split()[0] in every:
        return f"No such option: {mistyped} (it is now {now})"
    if elsewhere := _written_otherwise(mistyped, context):
        return f"No such option: {mistyped} ({elsewhere})"
    names = [name for name in every if name[:2] == "--"]
    meant = [name for name in names if mistyped.startswith(name) or name.startswith(mistyped)]
    question = f"did you mean {' or '.join(meant)}? " if meant else guess(mistyped, names)
    return f"No such option: {mistyped} ({question}--help shows the options)"


_EXTRA = re.compile(r"Got unexpected extra argument\S* \((\S+?)[ )].*")


def _written_otherwise(mistyped: str, context: Any) -> str:
    """Say how a command takes what was given as an option that it lacks: a range of a column, or its file."""
    from orbitdb.criteria import MEASURES

    names = {name for parameter in context.command.params for name in parameter.opts}
    column = mistyped.removeprefix("--").replace("-", "_")
    if "--range" in names and column in MEASURES:
        return f"ranges are given with --range: {context.info_name} --range {column}=LOW:HIGH"
    if mistyped in ("-o", "--output") and "file" in names:
        return f"the file is an argument: {context.info_name} orbits.csv"
    return ""


def _where_it_goes(extra: str, context: Any) -> str:
    """Say with which option a command takes what was given without one."""
    from orbitdb.columns import IN_CATALOGUE

    names = {name for parameter in context.command.params for name in parameter.opts}
    option, given, value = extra.partition("=")
    if given and f"--{option}" in names:
        return f": write --{option} {value}"
    if "--p" in names and re.fullmatch(r"(1?[0-9]|20)([-,][-,0-9]+)?", extra):
        return f": periods are given with --p: {context.info_name} --p {extra}"
    if "--code" in names and re.fullmatch(r"[0-5^()]+", extra):
        return f": words are given with --code: {context.info_name} --code {quoted(extra)}"
    if "--by" in names and extra.partition(",")[0] in {column.name for column in IN_CATALOGUE}:
        return f": columns are given with --by: {context.info_name} --by {extra}"
    if "--k" in names and re.fullmatch(r"[0-9.]*:?[0-9.]+", extra):
        return f": the range of k is given with --k: {context.info_name} --k {extra}"
    if "--start" in names and extra.count(",") == 2:
        return f": a start is given with --start: {context.info_name} --start={extra}"
    return ""


@cache
def _command(names: tuple[str, ...]) -> Any:
    """Return the program with the given commands; each process builds it only once."""
    return typer.main.get_command(program(names))


def call(arguments: Sequence[str]) -> Any:
    """Run a command; return its exit code, if it sets one.

    Raises `ParsingError` for bad arguments, KeyboardInterrupt if the input ends early, BrokenPipeError if the
    output is no longer read, and SystemExit after a signal to terminate.
    """
    command = _command((arguments[0],) if arguments[0] in _MODULES else tuple(_MODULES))
    try:
        return command(arguments, prog_name="orbitdb", standalone_mode=False)
    except typer.Abort as end:
        print(file=sys.stderr)  # the line with the question ends here
        raise KeyboardInterrupt from end
    except SystemExit as end:
        if isinstance(end.__context__, BrokenPipeError):  # Typer ends in this way if the output is not read
            raise end.__context__ from None
        raise
