"""Folder of the robots, scenes, findings and guide pages that are installed with the program."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).parents[1]
_INSTALLED = _PACKAGE / "assets"
_CHECKOUT = _PACKAGE.parents[1] / "assets"
ASSETS = _INSTALLED if _INSTALLED.is_dir() else _CHECKOUT
"""Inside the package if a wheel is installed; next to ``app`` in a checkout, also with an editable installation."""


def asset(*parts: str) -> Path:
    """Return the path of a shipped file, e.g. ``asset("scenes", "arm.toml")``; it need not exist."""
    return ASSETS.joinpath(*parts)
