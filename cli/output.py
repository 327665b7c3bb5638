"""Data on stdout in the requested format."""

import math
import re
import shutil
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_FLOOR
from enum import StrEnum
from textwrap import wrap
from typing import Annotated, Any

import typer

from orbitdb.cli.notes import writes_table
from orbitdb.errors import InputError
from orbitdb.output_files import TEXT_WRITERS
from orbitdb.text import as_sure, format_float, in_brackets, outward, printable, upwards


class Format(StrEnum):
    """Formats of data on stdout."""

    TABLE = "table"
    CSV = "csv"
    TSV = "tsv"
    JSON = "json"
    JSONL = "jsonl"
    MARKDOWN = "markdown"
    LATEX = "latex"


FOR_PEOPLE = (Format.TABLE, Format.MARKDOWN, Format.LATEX)
"""The formats that have few columns and rounded numbers."""

_DECIMALS = {
    "turns": 2, "share": 2, "probability": 3, "repetitions": 1,
    **dict.fromkeys(("length", "total", "lyapunov"), 7),
    "estimate": 8,
    **dict.fromkeys(("coordinate", "x", "y", "arclength", "sine"), 12),
}  # fmt: skip
"""Decimals shown in tables. Columns not listed have 6; formats for programs give all digits."""

_ROUNDING = 1e-15
"""Tables show smaller coordinates as zero, because they are less than a last digit of the radius."""

_BOUNDS = {"lower": ROUND_FLOOR, "upper": ROUND_CEILING}
"""Proved bounds, which are rounded outward."""

ON_SCREEN = 40
"""Maximum number of rows of a table, unless the user gives another limit."""

LONG_CODE = 24
"""Longer codes are shown in run notation."""

_LONGEST_CODE = 80
"""Longer texts in run notation are cut."""

_TINY = ("residual", "distance", "difference", "_max", "_median", "setting", "worst")
"""Columns whose names end in these are shown with few digits: only their order of magnitude matters."""

_TIMES = (
    "seconds", "processor_seconds", "enumeration", "enumerating", "classification", "cutting", "newton",
    "solving", "assessment", "balls", "storing",
)  # fmt: skip


def number(name: str, value: Any, digits: int | None = None) -> str:
    """Return a value as text for people, rounded to significant digits, or else as its column requires."""
    if value is None:
        return ""
    if isinstance(value, float):
        if name in _BOUNDS:
            places = 8 if digits is None else max(0, digits - 1 - math.floor(math.log10(abs(value) or 1.0)))
            return outward(value, _BOUNDS[name], places)
        if name.startswith(_TIMES):
            return f"{value:.3g}"
        if name.endswith("error"):
            return upwards(value)
        if abs(value) < _ROUNDING and _DECIMALS.get(name) == 12:
            value = 0.0
        if name.endswith(_TINY) or (value and abs(value) < 1e-4):
            return f"{value:z.1e}"
        if name == "K_0" and digits is None:
            return f"{math.floor(value * 1000) / 1000:.3f}"  # truncated, not rounded, as in the paper
        if name in ("a", "kappa"):
            return format_float(value)
        return (
            f"{value:z.{_DECIMALS.get(name, 6)}f}" if digits is None else f"{value:z#.{digits}g}".rstrip(".")
        )
    if isinstance(value, list | tuple):
        return " ".join(number(name, item, digits) for item in value)
    return printable(str(value))


def code_text(code: str, most: int = LONG_CODE) -> str:
    """Return a code as text for people; long codes are in run notation, truncated if still long."""
    if len(code) <= most:
        return code
    from orbitdb.symbols.words import run_notation

    text = run_notation(code)
    return text if len(text) <= _LONGEST_CODE else f"{text[:_LONGEST_CODE]}... ({len(code)} symbols)"


def repeats(word: str, root: str) -> str:
    """Return a message that a word repeats a shorter one, which is used instead."""
    count = len(word) // len(root)
    times = "twice" if count == 2 else f"{count} times"
    return f"{code_text(word)} repeats {code_text(root)} ({times}): using {code_text(root)}"


def write(
    columns: Sequence[str],
    rows: Iterable[Sequence[Any]],
    form: Format,
    digits: int | None = None,
    uncertainty: bool = False,
) -> int:
    """Write rows to stdout, and return their number; `digits` and `uncertainty` are as in `Output`."""
    if form in FOR_PEOPLE:
        texts, left = _cells(columns, rows, digits, uncertainty)
        if texts:
            writes_table(columns)
        if uncertainty:
            kept = [place for place, name in enumerate(columns) if bounded_by(name, columns) is None]
            columns, left = [columns[place] for place in kept], [left[place] for place in kept]
            texts = [[cells[place] for place in kept] for cells in texts]
        columns = [printable(name) for name in columns]
        lines = {Format.TABLE: _table, Format.MARKDOWN: _markdown, Format.LATEX: _latex}[form]
        sys.stdout.writelines(f"{line}\n" for line in lines(columns, texts, left) if texts)
        return len(texts)
    return TEXT_WRITERS[form](sys.stdout, columns, rows)


def bounded_by(name: str, columns: Sequence[str]) -> str | None:
    """Return the column whose error this column has, if both are there."""
    names = ("k", "survival") if name == "error" else (name.removesuffix("_error"),)
    return next((of for of in names if of != name and of in columns), None)


def _cells(
    columns: Sequence[str], rows: Iterable[Sequence[Any]], digits: int | None, uncertainty: bool
) -> tuple[list[list[str]], list[bool]]:
    """Return the texts of all cells, and for each column whether it is text and thus aligned left."""
    texts: list[list[str]] = []
    left = [False] * len(columns)
    errors = [
        (columns.index(of), place)
        for place, name in enumerate(columns)
        if (of := bounded_by(name, columns)) is not None
        and (uncertainty or (of in _SAMPLED and digits is None))
    ]
    shown = in_brackets if uncertainty else as_sure
    for row in rows:
        if len(texts) == _MOST_IN_TABLE:
            raise InputError(f"more than {_MOST_IN_TABLE:,} rows make no table: use --format csv, or a limit")
        cells = [
            printable(code_text(value))
            if name in _CODES and value is not None
            else number(name, value, digits)
            for name, value in zip(columns, row, strict=True)
        ]
        for place, beside in errors:
            value, error = row[place], row[beside]
            if isinstance(value, float) and isinstance(error, float):  # in SQL, they can be anything
                cells[place] = shown(value, error)
        texts.append(cells)
        left = [is_text or not _is_number(value) for is_text, value in zip(left, row, strict=True)]
    return texts, left


_MOST_IN_TABLE = 200_000
"""A table needs all its rows at once, to find the widths of its columns."""


def _is_number(value: Any) -> bool:
    return value is None or (isinstance(value, int | float) and not isinstance(value, bool))


_CODES = {"code", "word", "representative"}
_SAMPLED = ("lambda_d", "lambda_c", "mean_free_path")
"""Averages with a statistical error, shown with as many decimals as the error has."""


def write_facts(facts: Sequence[tuple[str, str]]) -> None:
    """Write names and values in two aligned columns; on a terminal, long values are wrapped."""
    writes_table([name for name, _ in facts])
    width = max(len(name) for name, _ in facts)
    columns = shutil.get_terminal_size().columns if sys.stdout.isatty() else sys.maxsize
    for name, text in facts:
        sys.stdout.writelines(wrap_after(f"{name.ljust(width)}  ", printable(text), columns))


def wrap_after(start: str, text: str, columns: int) -> Iterator[str]:
    """Yield the lines of a text that is wrapped beside the start of its first line, if there is room."""
    room = max(columns - len(start), _LEAST_WIDTH)
    for part in wrap(text, room, break_long_words=False, break_on_hyphens=False) or [""]:
        yield f"{start}{part}".rstrip() + "\n"
        start = " " * len(start)


_LEAST_WIDTH = 24


def _table(names: Sequence[str], rows: Sequence[Sequence[str]], left: Sequence[bool]) -> Iterator[str]:
    """Yield lines with columns as wide as their content; those marked in `left` are aligned left."""
    lines = [names, *rows]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    for values in lines:
        cells = (
            text.ljust(width) if of_texts else text.rjust(width)
            for text, width, of_texts in zip(values, widths, left, strict=True)
        )
        yield "  ".join(cells).rstrip()


_IN_LATEX = str.maketrans({
    "\\": r"\textbackslash{}", "^": r"\textasciicircum{}", "~": r"\textasciitilde{}",
    **{sign: f"\\{sign}" for sign in "_&%#${}"},
})  # fmt: skip
_IN_MARKDOWN = str.maketrans({sign: f"\\{sign}" for sign in "\\`*_{}[]<>|"})


def _markdown(names: Sequence[str], rows: Sequence[Sequence[str]], left: Sequence[bool]) -> Iterator[str]:
    """Yield the lines of a table in Markdown."""
    heading, *lines = [[text.translate(_IN_MARKDOWN) for text in row] for row in (names, *rows)]
    sides = [":--" if of_texts else "--:" for of_texts in left]
    for texts in (heading, sides, *lines):
        yield f"| {' | '.join(texts)} |"


_MATHEMATICS = {
    "a": "a", "p": "p", "length": "L", "lyapunov": r"\lambda", "lambda_d": r"\lambda_d",
    "lambda_c": r"\lambda_c", "N": "N", "N_t": "N_t", "N_c": "N_c", "K_0": "K_0", "h_zeta": r"h_\zeta",
    "h": "h", "x": "x", "y": "y", "k": "k", "z0": "z_0",
}  # fmt: skip
"""Columns whose headings LaTeX sets as formulas."""

_POWER_OF_RUN = re.compile(r"\^([0-9]+)")
_POWER = re.compile(r"(-?[0-9.]+)e([+-])0*([0-9]+)")


def _latex(names: Sequence[str], rows: Sequence[Sequence[str]], left: Sequence[bool]) -> Iterator[str]:
    """Yield the lines of a LaTeX tabular that uses the package booktabs."""
    lines = [" & ".join(map(_latex_heading, names)) + r" \\"]
    for row in rows:
        cells = map(_latex_cell, names, row, left)
        lines.append(" & ".join(cells) + r" \\")
    yield r"% \usepackage{booktabs}"
    yield rf"\begin{{tabular}}{{{''.join('l' if of_texts else 'r' for of_texts in left)}}}"
    yield from (r"\toprule", lines[0], r"\midrule", *lines[1:], r"\bottomrule", r"\end{tabular}")


def _latex_heading(name: str) -> str:
    """Return a heading with its variable, if it begins with one, as a formula."""
    of, error, _ = name.partition("_error")
    own = max((each for each in _MATHEMATICS if f"{of}_".startswith(f"{each}_")), key=len, default="")
    rest = (of if own else name).removeprefix(own).replace("_", " ").translate(_IN_LATEX)
    delta = r"\Delta " if error else ""
    return f"${delta}{_MATHEMATICS[own]}${rest}" if own else rest


def _latex_cell(name: str, text: str, is_text: bool) -> str:
    """Return a LaTeX cell: codes in typewriter type, negative numbers and powers of ten in math mode."""
    if name in _CODES and "^" in text:
        return r"$\mathtt{" + _POWER_OF_RUN.sub(r"^{\1}", text) + "}$"
    if name in _CODES and text:
        return rf"\texttt{{{text.translate(_IN_LATEX)}}}"
    if not is_text and (power := _POWER.fullmatch(text)):
        sign = "-" if power[2] == "-" else ""
        return rf"${power[1]} \times 10^{{{sign}{power[3]}}}$"
    return f"${text}$" if not is_text and text.startswith("-") else text.translate(_IN_LATEX)


@dataclass(frozen=True)
class Output:
    """The options for the format of data; contradictory ones are refused."""

    format_: Annotated[
        Format,
        typer.Option("--format", metavar="FORMAT", help="table, csv, tsv, json, jsonl, markdown or latex."),
    ] = Format.TABLE
    json: Annotated[bool, typer.Option("--json", help="Same as --format json.")] = False
    digits: Annotated[
        int | None,
        typer.Option(metavar="COUNT", min=1, max=17, help="Significant digits of the numbers in tables."),
    ] = None
    uncertainty: Annotated[
        bool,
        typer.Option(
            "--uncertainty", help="In tables, write numbers with a bound or an error as 22.454362(3)."
        ),
    ] = False

    def __post_init__(self) -> None:
        if not self.for_people and (self.digits is not None or self.uncertainty):
            raise InputError("--digits and --uncertainty are for tables; other formats have all digits")
        if self.uncertainty and self.digits is not None:
            raise InputError("--uncertainty chooses the digits: leave out --digits")
        if self.json and self.format_ not in (Format.TABLE, Format.JSON):
            raise InputError(
                f"--json and --format {self.format_} contradict each other: leave one of them out"
            )

    @property
    def form(self) -> Format:
        """The requested format."""
        return Format.JSON if self.json else self.format_

    @property
    def table(self) -> bool:
        """Whether the format is a table for the terminal."""
        return self.form is Format.TABLE

    @property
    def for_people(self) -> bool:
        """Whether the format has few columns and rounded numbers."""
        return self.form in FOR_PEOPLE

    def most(self, limit: int | None) -> int | None:
        """Return the maximum number of rows to show: the limit that the user gives, or that of a table."""
        return ON_SCREEN if limit is None and self.table else limit

    def write(self, columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> int:
        """Write rows to stdout, and return their number."""
        return write(columns, rows, self.form, self.digits, self.uncertainty)
