"""Sphinx configuration; build the documentation with ``sphinx-build -W --keep-going -b html docs BUILD``."""

import sys
import tempfile
from pathlib import Path

from sphinx.application import Sphinx

sys.path.insert(0, str(Path(__file__).parent))

import program

import orbitdb

project = "orbitdb"
author = "The orbitdb founders"
version = release = orbitdb.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.doctest",
    "cells",
    "mathml",
    "numpydoc",
    "sphinx_copybutton",
    "sphinx_design",
]
exclude_patterns = ["_build"]
default_role = "py:obj"
nitpicky = False

myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "colon_fence"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_typehints = "none"
add_module_names = False
numpydoc_show_class_members = False

doctest_global_setup = """
import os, tempfile
import console
from pathlib import Path
_folder = tempfile.TemporaryDirectory()
_catalogue = console.first_catalogue(Path(_folder.name))
os.environ["ORBITDB_DB"] = str(_catalogue)
os.chdir(_catalogue.parent)
from orbitdb import *
catalogue = Catalogue()
"""
doctest_global_cleanup = """
catalogue.close()
os.chdir("/")
_folder.cleanup()
"""

smartquotes = False
html_theme = "furo"
html_static_path = ["_static"]
html_css_files = ["pages.css"]
html_math_renderer = "mathml"
html_title = f"orbitdb {release}"
html_show_copyright = False
html_theme_options = {"sidebar_hide_name": False}
copybutton_prompt_text = r"\$ |>>> "
copybutton_prompt_is_regexp = True
copybutton_only_copy_prompt_lines = True
copybutton_line_continuation_character = "\\"


def write_atlas(app: Sphinx, error: Exception | None) -> None:
    """Write the atlas that the gallery links to."""
    if error is None and app.builder.name == "html":
        with tempfile.TemporaryDirectory() as folder:
            catalogue = orbitdb.Catalogue.create(Path(folder) / "orbits.db", a=1.6)
            catalogue.fill(9)
            catalogue.fill_births(9)
            catalogue.atlas(Path(app.outdir) / "atlas.html", force=True)


def setup(app: Sphinx) -> None:
    """Let `program` fill in the parts of the pages that come from the program itself."""
    app.connect("source-read", program.fill_in)
    app.connect("build-finished", write_atlas)
