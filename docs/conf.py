"""Sphinx configuration."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "extensions"))

project = "tactogram"
copyright = "The tactogram authors"
extensions = [
    "gallery_sounds",
    "myst_parser",
    "repository_pages",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
    "verb_pages",
]
html_theme = "furo"
html_title = "tactogram"
smartquotes_action = "q"  # no dashes: options begin with two hyphens
html_static_path = ["static"]
html_css_files = ["style.css"]
exclude_patterns = ["_build", "gallery/cards.md", "verbs/overview.md", "from-repository/readme.md"]
default_role = "py:obj"
autodoc_member_order = "bysource"
autodoc_typehints = "none"
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence", "dollarmath"]
nitpicky = False
suppress_warnings = ["myst.header"]
sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "ignore_pattern": r"^(?!plot_)",
    "within_subsection_order": "gallery_sounds.in_order",
    "image_scrapers": ("gallery_sounds.scrape_signal", "matplotlib"),
    "capture_repr": (),
    "abort_on_example_error": True,
    "show_memory": False,
    "show_signature": False,
    "min_reported_time": 1e9,
    "write_computation_times": False,
    "download_all_examples": False,
}
