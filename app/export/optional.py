"""Packages that only some formats need: imported where they are used, and their absence told with its remedy."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from app.core.errors import ExportError


def optional_package(name: str, *, extra: str) -> Any:
    """The module ``name``.

    Args:
        name: As in an import.
        extra: Of this program, which installs it.

    Raises:
        ExportError: It is not installed.
    """
    try:
        return import_module(name)
    except ImportError as error:
        package = name.partition(".")[0]
        remedy = f"pip install 'tactile-maps[{extra}]'"
        raise ExportError("this format needs a package that is not installed", value=package, remedy=remedy) from error
