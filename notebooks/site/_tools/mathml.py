"""Formulas as MathML, which browsers draw by themselves: no program from the internet."""

from docutils.utils.math import latex2mathml
from sphinx.errors import SphinxError


def add_to(app):
    """Make `mathml` known as a renderer of formulas."""
    app.add_html_math_renderer("mathml", (inline, None), (block, None))


def inline(writer, node):
    """Write a formula within a line."""
    _write(writer, node, as_block=False)


def block(writer, node):
    """Write a formula as a block."""
    _write(writer, node, as_block=True)


def _write(writer, node, *, as_block):
    from docutils import nodes

    code = node.astext()
    if as_block and "\\\\" in code and "\\begin" not in code:
        code = f"\\begin{{aligned}}{code}\\end{{aligned}}"
    try:
        tree = latex2mathml.tex2mathml(code, as_block=as_block)
    except Exception as error:
        raise SphinxError(f"{node.source}:{node.line}: no MathML for {code!r}: {error}") from error
    writer.body.append(tree)
    raise nodes.SkipNode
