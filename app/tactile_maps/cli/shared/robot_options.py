"""Values of the options that load a robot: ``--home`` and ``--package-root``."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path


def home_of(arguments: argparse.Namespace) -> Mapping[str, float]:
    """Return the joint positions of ``--home`` by joint name [rad, m]."""
    found: Mapping[str, float] = getattr(arguments, "home", {})
    return found


def package_roots(arguments: argparse.Namespace) -> tuple[str, ...]:
    """Return the folders of ``--package-root`` as absolute paths."""
    return tuple(str(Path(root).absolute()) for root in getattr(arguments, "package_root", None) or ())
