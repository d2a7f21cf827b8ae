"""What computes, as one short word: the text of the program's modules, Python, the libraries and the kind of machine.

Whatever is kept to be used again (prepared scenes, measured cases) is kept under this word: another program, be it
older or newer, never takes it for its own.
"""

from __future__ import annotations

import platform
import sys
from collections.abc import Collection
from functools import cache
from hashlib import blake2b
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

_LIBRARIES = ("numpy", "scipy", "mujoco-core", "libigl", "qdldl", "rslab", "trimesh")


@cache
def program_digest(*, without: Collection[str] = ()) -> str:
    """A digest of everything that computes.

    Args:
        without: Packages of ``tactile_maps`` that have no part in it, by name; a tuple.

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
