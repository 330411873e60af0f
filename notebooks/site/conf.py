"""The settings of the site; see ./run docs. Its sources are gathered by `gathering`."""

import sys
from importlib.metadata import version as version_of
from pathlib import Path

import nbclient

sys.path.insert(0, str(Path(__file__).parent / "_tools"))

import gathering
import mathml

project = "robsim"
author = "the authors of robsim"
version = release = version_of("robsim")

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx_design",
    "sphinx_llms_txt",
]
templates_path = [str(Path(__file__).with_name("_templates"))]
source_suffix = {".rst": "restructuredtext", ".md": "myst-nb", ".ipynb": "myst-nb"}

myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 4

nb_execution_mode = "cache"
nb_execution_cache_path = str(Path(__file__).parents[2] / "build/docs/notebooks")
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 600  # s
nb_ipywidgets_js = {}  # the page would load them from the internet
nb_merge_streams = True

autodoc_typehints = "none"  # the docstrings name types
autosummary_generate = True
numpydoc_show_class_members = False  # the class template lists them

html_theme = "pydata_sphinx_theme"
html_title = "robsim"
html_static_path = []
html_math_renderer = "mathml"
html_show_sourcelink = False
html_theme_options = {
    "header_links_before_dropdown": 6,
    "navbar_align": "left",
    "navigation_with_keys": False,
    "show_toc_level": 2,
    "footer_start": ["copyright"],
    "footer_end": [],
}
copyright = "the authors of robsim; GPL, version 3 or later"


def setup(app):
    """Gather the sources, and say how formulas and notebooks are treated."""
    gathering.gather(Path(app.srcdir))
    mathml.add_to(app)
    # An answer to a widget, sent while a reply is awaited, may leave both sides waiting.
    nbclient.NotebookClient.handle_comm_msg = lambda *_: None
