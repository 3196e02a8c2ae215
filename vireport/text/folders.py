"""Where the package's templates are."""

from __future__ import annotations

from pathlib import Path

from vireport.base.additions import ADDITIONS

_PACKAGE = Path(__file__).resolve().parent.parent
TEMPLATES = _PACKAGE / "templates" if (_PACKAGE / "templates").is_dir() else _PACKAGE.parent / "templates"
"""Our own templates: inside an installed package, or at the root of a checkout."""

ROOTS = TEMPLATES, *(_PACKAGE.joinpath(*row.packages[0].split("."), "templates") for row in ADDITIONS.values())
"""Folders of our templates: those of an addition stand in its package."""
