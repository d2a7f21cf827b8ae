"""Packages that only some formats need: imported where they are used, with an error that states how to install them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from tactile_maps.core.errors import ExportError


@contextmanager
def packages_of(extra: str) -> Iterator[None]:
    """Context for imports of packages that the extra ``extra`` of this program installs.

    Raises:
        ExportError: A package is not installed.
    """
    try:
        yield
    except ImportError as error:
        package = (error.name or str(error)).partition(".")[0]
        remedy = f"pip install 'tactile-maps[{extra}]'"
        raise ExportError("this format needs a package that is not installed", value=package, remedy=remedy) from error
