"""Formulas as MathML, which browsers draw without a script from the internet."""

from docutils import nodes
from docutils.utils.math import latex2mathml
from sphinx.errors import SphinxError


def add_to(app):
    """Add `mathml` to the renderers of formulas."""
    app.add_html_math_renderer("mathml", (inline, None), (block, None))


def inline(writer, node):
    """Write a formula of a line of text."""
    _write(writer, node, as_block=False)


def block(writer, node):
    """Write a formula on separate lines."""
    _write(writer, node, as_block=True)


def _write(writer, node, *, as_block):
    try:
        formula = latex2mathml.tex2mathml(node.astext(), as_block=as_block)
    except Exception as error:
        raise SphinxError(f"{node.source}: no MathML for {node.astext()!r}: {error}") from error
    # In a font without tables for mathematics an accent lies on its letter.
    writer.body.append(formula.replace(' accent="true"', ""))
    raise nodes.SkipNode
