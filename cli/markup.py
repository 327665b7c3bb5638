"""Tables for papers and pages: Markdown and LaTeX."""

from collections.abc import Iterator, Sequence

_LATEX = {
    "\\": r"\textbackslash{}", "^": r"\textasciicircum{}", "~": r"\textasciitilde{}",
    **{sign: f"\\{sign}" for sign in "_&%#${}"},
}  # fmt: skip
_MARKDOWN = {sign: f"\\{sign}" for sign in "\\`*_{}[]<>|"}


def markdown(names: Sequence[str], rows: Sequence[Sequence[str]], left: Sequence[bool]) -> Iterator[str]:
    """Yield the lines of a table in Markdown; columns of texts, which `left` marks, to the left."""
    yield _pipes(_escaped(names, _MARKDOWN))
    yield _pipes([":--" if of_texts else "--:" for of_texts in left])
    yield from (_pipes(_escaped(row, _MARKDOWN)) for row in rows)


def latex(names: Sequence[str], rows: Sequence[Sequence[str]], left: Sequence[bool]) -> Iterator[str]:
    """Yield the lines of a tabular in LaTeX, which needs no package."""
    yield rf"\begin{{tabular}}{{{''.join('l' if of_texts else 'r' for of_texts in left)}}}"
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
