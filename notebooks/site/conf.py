"""The settings of the site, for `./run docs`. `_tools/gathering.py` gathers its sources."""

import re
import sys
from importlib.metadata import version as version_of
from pathlib import Path

import nbclient
from docutils import nodes
from docutils.utils.math import latex2mathml
from numpydoc.numpydoc import mangle_signature

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_tools"))

import formats  # noqa: E402
import gathering  # noqa: E402
import llms  # noqa: E402

project = "robsim"
copyright = "the authors of robsim; GPL, version 3 or later"
version = release = version_of("robsim")

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autosummary",
    "sphinx_design",
]
exclude_patterns = ["paper/*"]  # a draft for a journal
templates_path = [str(HERE / "_templates")]  # autosummary has no other way to find them
source_suffix = {".rst": "restructuredtext", ".md": "myst-nb", ".ipynb": "myst-nb"}

myst_enable_extensions = ["colon_fence", "dollarmath", "substitution"]
myst_substitutions = formats.tables()
myst_heading_anchors = 4

nb_execution_mode = "cache"
nb_execution_cache_path = str(HERE.parents[1] / "build/docs/notebooks")
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 600  # s
nb_ipywidgets_js = {}  # scripts from the internet
nb_mime_priority_overrides = [("*", "application/vnd.jupyter.widget-view+json", None)]
nb_merge_streams = True
nb_output_stderr = "error"
nb_render_markdown_format = "gfm"  # with tables

autodoc_typehints = "none"  # docstrings name the types
numpydoc_show_class_members = False  # the class template lists them

html_theme = "pydata_sphinx_theme"
html_title = "robsim"
html_context = {"default_mode": "auto"}  # else the console has a warning
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_math_renderer = "mathml"
html_show_sourcelink = False
html_sidebars = {"gallery": []}
html_theme_options = {
    "header_links_before_dropdown": 6,
    "navbar_align": "left",
    "show_toc_level": 2,
    "footer_start": ["copyright"],
    "footer_end": [],
}


class Client(nbclient.NotebookClient):
    """The client of the kernels that execute notebooks."""

    def __init__(self, *given, **more):
        quiet = ["--IPKernelApp.log_level=ERROR"]  # a warning about TCP, in each kernel
        super().__init__(*given, startup_timeout=600, extra_arguments=quiet, **more)

    def handle_comm_msg(self, *_):
        """Send no answer to a widget: during a reply it may block both sides."""


REPLACED = {  # outputs of notebooks that need a kernel or a file: a sentence instead
    r'<iframe\s[^>]*?src="([^":]+)"': "The notebook shows {0} here.",
    r"interactive\(children=": "The notebook has sliders here.",
    r"(\w+:)?\s*\d+%\|": "",  # a progress bar
    r"<robsim\.gui\.Panel: .*>$": "",  # its picture follows
}


def replace_outputs(app, doctree):
    """Replace outputs of notebooks that mean nothing on a page."""
    for node in [*doctree.findall(nodes.raw), *doctree.findall(nodes.literal_block)]:
        for pattern, text in REPLACED.items():
            if shown := re.match(pattern, node.astext().strip()):
                instead = nodes.emphasis("", text.format(*shown.groups()))
                node.parent.replace(node, [nodes.paragraph("", "", instead)] if text else [])
                break


def without_self(*given):
    """Return the signature as numpydoc does, for native methods without `self`."""
    signature, returns = mangle_signature(*given) or ("", "")
    return (re.sub(r"^\(self(, )?", "(", signature), returns) if signature else None


def write_formula(writer, node):
    """Write a formula as MathML, which browsers draw without a script from the internet."""
    is_block = isinstance(node, nodes.math_block)
    formula = latex2mathml.tex2mathml(node.astext(), as_block=is_block)
    # In a font without tables for mathematics an accent lies on its letter.
    writer.body.append(formula.replace(' accent="true"', ""))
    raise nodes.SkipNode


def setup(app):
    """Gather the sources, and prepare formulas and notebooks."""
    gathering.gather(Path(app.srcdir))
    app.add_html_math_renderer("mathml", (write_formula, None), (write_formula, None))
    app.connect("autodoc-process-signature", without_self, priority=400)  # before numpydoc
    app.connect("doctree-read", replace_outputs)
    app.connect("build-finished", llms.write)
    nbclient.client.NotebookClient = Client
