"""Cells of a notebook as blocks of a page: ``{code-cell}`` of MyST, which Jupyter opens and Sphinx shows."""

from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import Directive


class CodeCell(Directive):
    """A cell with Python, shown as it is; `console` runs it."""

    has_content = True
    optional_arguments = 1
    option_spec: ClassVar[dict[str, Any]] = {}

    def run(self) -> list[nodes.Node]:
        """Return the block."""
        text = "\n".join(self.content)
        return [nodes.literal_block(text, text, language="python")]


def setup(app: Any) -> None:
    """Add the directive."""
    app.add_directive("code-cell", CodeCell)
