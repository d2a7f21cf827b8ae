"""Coarser surfaces of a robot's links, for pictures in which their triangles are smaller than a pixel.

Only what is drawn: nothing is picked, measured or simulated on them.
"""

from __future__ import annotations

from dataclasses import dataclass
from hashlib import blake2b

import numpy as np
from numpy.typing import NDArray

from tactile_maps.core.errors import RecordingError
from tactile_maps.core.files import pack_arrays, unpack_arrays
from tactile_maps.geometry.remesh.simplify import CoarseSurface, simplify
from tactile_maps.robots.model.robot import Robot

TOLERANCES = (0.4e-3, 0.7e-3, 1.0e-3, 2.0e-3)
"""About how far each is from the link [m]: half a pixel is 0.9 mm where the whole of iCub is seen in 600 px."""
MANY_FACES = 50_000
"""A robot whose links have fewer in all is drawn as fast as it is."""
_LEAST_FACES = 200
"""A link with fewer is drawn as it is."""


@dataclass(frozen=True, eq=False)
class LinkLevels:
    """Of one robot.

    Attributes:
        digest: Of the meshes of its links.
        links: For each link, its coarser surfaces in rising order of error; none where none is worth it.
    """

    digest: str
    links: tuple[tuple[CoarseSurface, ...], ...]

    @staticmethod
    def make(robot: Robot) -> LinkLevels:
        """Those of ``robot``; none for stand-ins of missing meshes. Cost: 0.1 ms a face."""
        found = []
        for link in robot.links:
            few = link.mesh is None or len(link.mesh.faces) < _LEAST_FACES or bool(link.missing)
            found.append(() if few or link.mesh is None else _worthwhile(simplify(link.mesh, TOLERANCES)))
        return LinkLevels(links_digest(robot), tuple(found))

    def to_bytes(self) -> bytes:
        """As one npz."""
        arrays: dict[str, NDArray[np.int32]] = {
            f"{link}-{level}": surface.faces.astype(np.int32)
            for link, levels in enumerate(self.links)
            for level, surface in enumerate(levels)
        }
        return pack_arrays({"errors": [[surface.error for surface in levels] for levels in self.links]}, arrays)

    @staticmethod
    def from_bytes(data: bytes, robot: Robot) -> LinkLevels:
        """Those that ``to_bytes`` of the levels of ``robot`` wrote.

        Raises:
            RecordingError: They are damaged, or not of this robot.
        """
        header, arrays = unpack_arrays(data, error=RecordingError)
        errors = header.get("errors")
        if not isinstance(errors, list) or len(errors) != len(robot.links):
            raise RecordingError("these are not the links of the robot", value=robot.name)
        found = []
        for number, (link, own) in enumerate(zip(robot.links, errors, strict=True)):
            count = 0 if link.mesh is None else len(link.mesh.vertices)
            faces = [arrays.get(f"{number}-{level}") for level in range(len(own))]
            if any(part is None or part.shape[1:] != (3,) or not _within(part, count) for part in faces):
                raise RecordingError("a link's faces name vertices that it does not have", value=link.name)
            pairs = zip(faces, own, strict=True)
            found.append(tuple(CoarseSurface(part, float(error)) for part, error in pairs if part is not None))
        return LinkLevels(links_digest(robot), tuple(found))


def _within(faces: NDArray[np.int32], count: int) -> bool:
    return faces.dtype.kind in "iu" and bool(len(faces)) and bool((faces >= 0).all() and (faces < count).all())


def _worthwhile(levels: tuple[CoarseSurface, ...]) -> tuple[CoarseSurface, ...]:
    """Those than which none coarser is as near."""
    best = [np.inf]
    for level in reversed(levels):
        best.append(min(level.error, best[-1]))
    nearer = best[-2::-1]  # the least error among those that are coarser
    return tuple(level for level, other in zip(levels, nearer, strict=True) if level.error < other)


def faces_of_links(robot: Robot) -> int:
    """How many triangles all links have together."""
    return sum(0 if link.mesh is None else len(link.mesh.faces) for link in robot.links)


def links_digest(robot: Robot) -> str:
    """Of the meshes of all links. Cost: 20 ms for the whole iCub."""
    digest = blake2b(digest_size=16)
    for link in robot.links:
        digest.update(f"{link.name} {bool(link.missing)}\0".encode())
        if link.mesh is not None:
            digest.update(link.mesh.vertices.tobytes() + link.mesh.faces.tobytes())
    return digest.hexdigest()
