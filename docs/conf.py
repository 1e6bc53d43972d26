"""Sphinx configuration."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "extensions"))

project = "tactogram"
copyright = "The tactogram authors"
extensions = [
    "myst_parser",
    "request_parameters",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
]
html_theme = "furo"
html_title = "tactogram"
smartquotes_action = "q"  # no dashes: options begin with two hyphens
exclude_patterns = ["_build", "plan.md"]
default_role = "py:obj"
autodoc_member_order = "bysource"
autodoc_typehints = "none"
myst_enable_extensions = ["dollarmath"]
nitpicky = False
suppress_warnings = ["myst.xref_missing", "myst.header"]
