"""The settings of the site, for `./run docs`. `_tools/gathering.py` gathers its sources."""

import re
import sys
from importlib.metadata import version as version_of
from pathlib import Path

import nbclient
from docutils import nodes

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_tools"))

import gathering  # noqa: E402
import mathml  # noqa: E402

project = "robsim"
author = "the authors of robsim"
copyright = "the authors of robsim; GPL, version 3 or later"
version = release = version_of("robsim")

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx_design",
    "sphinx_llms_txt",
]
templates_path = [str(HERE / "_templates")]  # autosummary has no other way to find them
source_suffix = {".rst": "restructuredtext", ".md": "myst-nb", ".ipynb": "myst-nb"}

myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 4

nb_execution_mode = "cache"
nb_execution_cache_path = str(HERE.parents[1] / "build/docs/notebooks")
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 600  # s
nb_ipywidgets_js = {}  # scripts from the internet
nb_merge_streams = True
nb_output_stderr = "error"
nb_render_markdown_format = "gfm"  # with tables

autodoc_typehints = "none"  # docstrings name the types
numpydoc_show_class_members = False  # the class template lists them

html_theme = "pydata_sphinx_theme"
html_title = "robsim"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_math_renderer = "mathml"
html_show_sourcelink = False
html_sidebars = {"gallery": []}
html_theme_options = {
    "header_links_before_dropdown": 6,
    "navbar_align": "left",
    "navigation_with_keys": False,
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


def without_files_of_notebooks(app, doctree):
    """Replace each frame that shows a file of the executed notebook: the site lacks the file."""
    for node in list(doctree.findall(nodes.raw)):
        shown = re.search(r'<iframe\s[^>]*?src="([^":]+)"', node.astext())
        if shown:
            text = nodes.emphasis("", f"In the notebook you see {shown[1]} here.")
            node.replace_self(nodes.paragraph("", "", text))


def setup(app):
    """Gather the sources, and prepare formulas and notebooks."""
    gathering.gather(Path(app.srcdir))
    mathml.add_to(app)
    app.connect("doctree-read", without_files_of_notebooks)
    nbclient.client.NotebookClient = Client
