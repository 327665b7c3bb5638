"""Formulas as MathML, which browsers render themselves, so that the pages load nothing from other sites."""

from typing import Any

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.util import logging

_LOG = logging.getLogger(__name__)


def write_inline(translator: Any, node: nodes.math) -> None:
    """Write a formula within a line of text."""
    translator.body.append(_mathml(node, as_block=False))
    raise nodes.SkipNode


def write_block(translator: Any, node: nodes.math_block) -> None:
    """Write a displayed formula."""
    translator.body.append(f'<div class="math">{_mathml(node, as_block=True)}</div>\n')
    raise nodes.SkipNode


def _mathml(node: nodes.Element, as_block: bool) -> str:
    text = node.astext()
    try:
        return tex2mathml(text, as_block=as_block)
    except MathError as error:
        _LOG.warning("this formula cannot be written: %s (%s)", text, error, location=node)
        return text


def setup(app: Any) -> None:
    """Register the renderer that ``html_math_renderer = "mathml"`` names."""
    app.add_html_math_renderer("mathml", (write_inline, None), (write_block, None))
