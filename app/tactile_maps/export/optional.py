"""Packages that only some formats need: imported where they are used, with the command that installs missing ones."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, requires, version
from importlib.util import find_spec

from tactile_maps.core.errors import ExportError

_PROGRAM = "tactile-maps"


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
        problem = "this format needs a package that is not installed"
        raise ExportError(problem, value=package, remedy=install_line(extra)) from error


def is_installed(module: str) -> bool:
    """Whether a module can be imported; it is not imported. ``module`` is a name without dots."""
    try:
        return find_spec(module) is not None
    except ValueError:  # it is known to be missing
        return False


def install_line(extra: str) -> str:
    """Return the command that installs the missing packages of an extra of this program into this environment.

    It names all packages of the extra if none is missing.
    """
    try:
        stated = requires(_PROGRAM) or []
    except PackageNotFoundError:  # used from its source, without having been installed
        stated = []
    needed = [one.partition(";")[0].strip() for one in stated if one.endswith(f"extra == '{extra}'")]
    missing = [one for one in needed if not _has(one)]
    words = [sys.executable, "-m", "pip", "install", *(missing or needed or [f"{_PROGRAM}[{extra}]"])]
    return subprocess.list2cmdline(words) if os.name == "nt" else shlex.join(words)


def _has(requirement: str) -> bool:
    """Whether the package of a requirement such as ``av>=12`` is installed, in any version."""
    name = requirement.partition(">")[0].partition("[")[0].strip()
    try:
        version(name)
    except PackageNotFoundError:
        return False
    return True
