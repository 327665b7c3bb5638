"""Tables for papers and pages: Markdown and LaTeX."""

from collections.abc import Collection, Iterator, Sequence

_LATEX = {
    "\\": r"\textbackslash{}", "^": r"\textasciicircum{}", "~": r"\textasciitilde{}",
    **{sign: f"\\{sign}" for sign in "_&%#${}"},
}  # fmt: skip
_MARKDOWN = {sign: f"\\{sign}" for sign in "\\`*_{}[]<>|"}


def markdown(names: Sequence[str], rows: Sequence[Sequence[str]], left: Collection[str]) -> Iterator[str]:
    """Yield the lines of a table in Markdown; columns that are not left aligned are right aligned."""
    yield _pipes(_escaped(names, _MARKDOWN))
    yield _pipes([":--" if name in left else "--:" for name in names])
    yield from (_pipes(_escaped(row, _MARKDOWN)) for row in rows)


def latex(names: Sequence[str], rows: Sequence[Sequence[str]], left: Collection[str]) -> Iterator[str]:
    """Yield the lines of a tabular in LaTeX, which needs no package."""
    yield rf"\begin{{tabular}}{{{''.join('l' if name in left else 'r' for name in names)}}}"
    yield r"\hline"
    yield _ampersands(names)
    yield r"\hline"
    yield from map(_ampersands, rows)
    yield r"\hline"
    yield r"\end{tabular}"


def _pipes(texts: Sequence[str]) -> str:
    return f"| {' | '.join(texts)} |"


def _ampersands(texts: Sequence[str]) -> str:
    return " & ".join(_escaped(texts, _LATEX)) + r" \\"


def _escaped(texts: Sequence[str], signs: dict[str, str]) -> list[str]:
    return ["".join(signs.get(sign, sign) for sign in text) for text in texts]
