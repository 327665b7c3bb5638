"""Notebook cells on a page: ``{code-cell}`` blocks of MyST, which Jupyter opens and Sphinx shows as code."""

from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import Directive


class CodeCell(Directive):
    """A cell with Python code, shown unchanged; `console` runs it."""

    has_content = True
    optional_arguments = 1
    option_spec: ClassVar[dict[str, Any]] = {}

    def run(self) -> list[nodes.Node]:
        """Return the code as a literal block."""
        text = "\n".join(self.content)
        return [nodes.literal_block(text, text, language="python")]


def setup(app: Any) -> None:
    """Register the directive with Sphinx."""
    app.add_directive("code-cell", CodeCell)
