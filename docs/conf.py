"""How Sphinx makes the site of these pages: `make docs`."""
# ruff: noqa: E402 (imports below need the folders that are named before them)

import logging
import os
import re
import sys
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

os.environ.setdefault("MUJOCO_GL", "disable")  # nothing is drawn here, and dm_control looks for a screen otherwise
logging.getLogger("absl").setLevel(logging.WARNING)  # dm_control tells which OpenGL it has found

from markdown_docstrings import as_restructured_text

from mjbiped.version import __version__

project = "mjbiped"
author = "The mjbiped authors"
release = __version__

extensions = [
    "csv_tables",
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx.ext.napoleon",
    "sphinx_click",
    "sphinx_copybutton",
]
templates_path = ["_templates"]
exclude_patterns = ["_templates"]

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3  # the anchors that GitHub gives to headings
nb_execution_mode = "off"  # notebooks are shown as they were executed

smartquotes = False  # they would make a dash of the two hyphens before an option
default_role = "code"  # docstrings have code between single backquotes
autodoc_typehints = "description"  # beside each parameter's meaning: signatures with types are too long to read
autodoc_typehints_description_target = "documented_params"  # and nothing of those that say nothing more
autodoc_member_order = "bysource"  # sources begin with what matters most
autodoc_default_options = {"members": True}  # of a class, all that is public
napoleon_numpy_docstring = False
napoleon_use_ivar = True

html_theme = "furo"
html_title = "mjbiped"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_copyright = False
mathjax_path = "mathjax/tex-svg.js"  # MathJax 3.2.2 as one file: formulas are drawn without a network
mathjax_options = {"defer": "defer"}


PAGE = re.compile(r"\bdocs/([\w/]+)\.md\b")  # as docstrings name a page


# what Sphinx calls takes all that Sphinx gives, used or not: hence ARG001 below
def read_markdown(app: Sphinx, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:  # noqa: ARG001
    """Turn a docstring's Markdown into what Sphinx reads."""
    lines[:] = [PAGE.sub(r":doc:`/\1`", line) for line in as_restructured_text(lines)]
    if what in ("property", "attribute", "data"):
        lines.insert(0, "")  # napoleon would take what stands before a colon in the first line for a type


def set_dashes(app: Sphinx, tree: nodes.document, page: str) -> None:  # noqa: ARG001
    """Between a parameter and its meaning Sphinx writes two hyphens, which smart quotes would make a dash."""
    for text in list(tree.findall(nodes.Text)):
        if text == " -- ":
            text.parent.replace(text, nodes.Text(" – "))


def setup(app: Sphinx) -> None:
    """Connect what is above."""
    app.connect("autodoc-process-docstring", read_markdown, priority=400)  # before napoleon, which has 500
    app.connect("doctree-resolved", set_dashes)
