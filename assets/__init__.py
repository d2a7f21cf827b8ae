"""Robots, scenes and icons that ship with the app, and the one way to find them."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path


def asset(*parts: str) -> Path:
    """Path of a shipped file, e.g. ``asset("scenes", "arm.toml")``; it need not exist."""
    return Path(str(files(__name__))).joinpath(*parts)
