"""How the guide is built: these pages and the references as one site. `cargo xtask guide` does, into target/guide."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from docutils import nodes

import palpate

if TYPE_CHECKING:
    from sphinx.application import Sphinx
    from sphinx.writers.html5 import HTML5Translator

project = "palpate"
author = "The palpate developers"
version = release = palpate.__version__
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "numpydoc"]
html_theme = "furo"
html_title = f"palpate {version}"
html_show_sphinx = html_show_copyright = False
html_copy_source = False
html_static_path = ["../../crates/palpate/katex", "static"]
html_css_files = ["katex.min.css", "guide.css"]
html_js_files = ["katex.min.js", "formulas.js"]
html_extra_path = ["front"]
html_math_renderer = "katex"
templates_path: list[str] = []

# Pages lie where they lie in the repository, so that links between them hold here and there.
root_doc = "docs/index"
include_patterns = [
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "SECURITY.md",
    "docs/**",
    "examples/README.md",
    "fuzz/README.md",
]
exclude_patterns = ["target", "docs/guide", "docs/python-api/README.md", "crates/palpate/katex/README.md"]
myst_enable_extensions = ["dollarmath"]
myst_fence_as_directive = ["math"]
myst_heading_anchors = 4
# The notebook is shown as it was saved; a test runs it.
nb_execution_mode = "off"
suppress_warnings = ["misc.highlighting_failure"]

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

# The pages by what they are for. Elsewhere the table of docs/index.md does.
CHAPTERS = {
    "Use": [
        "tutorial",
        "Python tutorial <python-tutorial>",
        "how-to-own-sensor",
        "hardware",
        "live",
        "sweeps",
        "/examples/README",
    ],
    "Look up": ["formats", "Verdicts <verdict>", "Python <python-api/index>", "Rust <rust-api>"],
    "Understand": ["theory", "monte-carlo", "paper", "related-work", "performance"],
    "Change": ["architecture", "constants", "/fuzz/README", "/CONTRIBUTING", "/SECURITY", "/CHANGELOG"],
}


def chapters() -> str:
    """What the side bar of the site shows."""
    trees = (f":caption: {caption}\n:hidden:\n\n" + "\n".join(pages) for caption, pages in CHAPTERS.items())
    return "".join(f"\n```{{toctree}}\n{tree}\n```\n" for tree in trees)


def rust_reference(crate: re.Match[str]) -> str:
    """Link a row of the table of crates to the reference of its crate."""
    return f'| <a href="../rust/{crate[1].replace("-", "_")}/index.html"><code>{crate[1]}</code></a> |'


def adapt(_: Sphinx, page: str, source: list[str]) -> None:
    """Turn what other readers of Markdown need into what this one needs."""
    # Formulas between backticks, which keep their backslashes in Rust's documentation too.
    text = re.sub(r"\$`([^`]+)`\$", r"$\1$", source[0])
    if page == root_doc:
        text += chapters()
        text = text.replace("(python-api/README.md)", "(python-api/index.rst)")
    if page == "docs/rust-api":
        text = re.sub(r"^\| `([a-z-]+)` \|", rust_reference, text, flags=re.MULTILINE)
    source[0] = text


def inline_formula(writer: HTML5Translator, node: nodes.math) -> None:
    """Leave it to the script that renders formulas."""
    writer.body.append(f'<span class="formula">{writer.encode(node.astext())}</span>')
    raise nodes.SkipNode


def displayed_formula(writer: HTML5Translator, node: nodes.math_block) -> None:
    """Leave it to the script that renders formulas."""
    writer.body.append(f'<div class="formula">{writer.encode(node.astext())}</div>')
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """Register both."""
    app.connect("source-read", adapt)
    app.add_html_math_renderer("katex", (inline_formula, None), (displayed_formula, None))
