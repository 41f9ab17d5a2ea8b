"""How the reference of the Python package is built; `cargo xtask test` does, into target/."""

from __future__ import annotations

import palpate

project = "palpate"
author = "The palpate developers"
version = release = palpate.__version__
extensions = ["sphinx.ext.autodoc", "sphinx.ext.autosummary", "numpydoc"]
html_theme = "alabaster"
html_theme_options = {"page_width": "1100px", "sidebar_width": "240px"}
exclude_patterns = ["README.md"]
add_module_names = False
autodoc_member_order = "bysource"
autosummary_generate = True
numpydoc_show_class_members = False
nitpicky = False
# Docstrings must be complete: every parameter, every return value, in order. Left out: examples, further reading and
# extended summaries where there is nothing to add, and details of punctuation.
numpydoc_validation_checks = {
    "all",
    "ES01",
    "EX01",
    "SA01",
    "GL01",
    "GL02",
    "GL03",
    "SS02",
    "SS05",
    "RT03",
    "RT05",
    "PR08",
    "PR09",
    "YD01",
}
