"""Settings of the site: Sphinx makes it of README.md, these pages, and those that `tools/make_site.py` writes."""

from typing import Any

import vireport

project = "vireport"
html_title = f"vireport {vireport.__version__}"
html_theme = "furo"
html_theme_options = {"source_view_link": "", "top_of_page_buttons": []}
html_static_path, html_css_files = ["site.css"], ["site.css"]
html_copy_source = False
html_show_copyright = False
html_show_sphinx = False
extensions = ["myst_parser", "sphinx.ext.autodoc", "numpydoc"]
myst_enable_extensions = ["deflist"]
myst_heading_anchors = 4
numpydoc_show_class_members = False
autodoc_default_options = {"members": True, "no-value": True, "exclude-members": "__init__, __new__"}
autodoc_typehints = "none"  # the docstrings have them, with units and shapes
autodoc_class_signature = "separated"  # none: records are made by functions, and their docstrings have the fields
pygments_style, pygments_dark_style = "xcode", "github-dark"  # of enough contrast

root_doc = "README"
include_patterns = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/**.md"]

CONTENTS = """
```{toctree}
:hidden:
:caption: Learn
docs/tutorial
docs/how-to
docs/examples
```

```{toctree}
:hidden:
:caption: Look up
docs/commands
docs/scenario
docs/results
docs/compare
docs/ci
docs/chart
docs/map
docs/optimise
docs/explore
docs/escape
docs/identify
docs/recordings
docs/paper
docs/templates
docs/made/glossary
docs/made/alerts
docs/made/python
```

```{toctree}
:hidden:
:caption: Understand
docs/model
docs/accuracy
docs/validation
docs/bouncing-ball
CONTRIBUTING
CHANGELOG
```
"""
"""What only a site has: on GitHub, README.md itself leads to the pages."""


def _with_contents(app: Any, name: str, source: list[str]) -> None:
    if name == root_doc:
        source[0] += CONTENTS


def setup(app: Any) -> None:
    """Called by Sphinx."""
    app.connect("source-read", _with_contents)
