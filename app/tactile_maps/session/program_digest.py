"""Digest of everything that computes: the source of the program, Python, the libraries and the type of machine.

Cached results (prepared scenes, measured cases) are stored under this digest, so that an older or newer program never
uses them.
"""

from __future__ import annotations

import platform
import sys
from collections.abc import Collection
from functools import cache
from hashlib import blake2b
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

_LIBRARIES = ("numpy", "scipy", "mujoco-core", "libigl", "daqp", "qdldl", "rslab", "trimesh")


@cache
def program_digest(*, without: Collection[str] = ()) -> str:
    """Return the digest.

    Args:
        without: Packages of ``tactile_maps`` that do not count, by name; a tuple.

    Cost: about 20 ms, once.
    """
    digest = blake2b(digest_size=16)
    for word in (sys.version, platform.machine(), *map(_version, _LIBRARIES)):
        digest.update(word.encode() + b"\0")
    root = Path(__file__).parents[1]
    for path in sorted(root.rglob("*.py")):
        place = path.relative_to(root)
        if place.parts[0] not in without:
            digest.update(str(place).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return ""
