"""Sphinx configuration."""

project = "tactogram"
copyright = "The tactogram authors"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
html_theme = "furo"
exclude_patterns = ["_build", "plan.md"]
autodoc_member_order = "bysource"
autodoc_typehints = "none"
myst_enable_extensions = ["dollarmath"]
nitpicky = False
suppress_warnings = ["myst.xref_missing", "myst.header"]
