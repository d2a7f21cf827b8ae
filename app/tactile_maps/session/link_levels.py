"""Coarser surfaces of a robot's links, for views in which their triangles are smaller than a pixel.

They are only drawn; picking, measuring and simulation use the full meshes.
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
"""Approximate distances from the link [m]: half a pixel is 0.9 mm where the whole iCub is shown in 600 px."""
MANY_FACES = 50_000
"""Number of faces of all links below which a robot is drawn fast enough without coarser surfaces."""
_LEAST_FACES = 200
"""Number of faces below which a link has no coarser surfaces."""


@dataclass(frozen=True, eq=False)
class LinkLevels:
    """Coarser surfaces of the links of one robot.

    Attributes:
        digest: Digest of the meshes of its links.
        links: For each link, its useful coarser surfaces in ascending order of error.
    """

    digest: str
    links: tuple[tuple[CoarseSurface, ...], ...]

    @staticmethod
    def make(robot: Robot) -> LinkLevels:
        """Create those of ``robot``; placeholders of missing meshes have none. Cost: 0.1 ms a face."""
        found = []
        for link in robot.links:
            few = link.mesh is None or len(link.mesh.faces) < _LEAST_FACES or bool(link.missing)
            found.append(() if few or link.mesh is None else _worthwhile(simplify(link.mesh, TOLERANCES)))
        return LinkLevels(links_digest(robot), tuple(found))

    def to_bytes(self) -> bytes:
        """Return the surfaces as an npz file."""
        arrays: dict[str, NDArray[np.int32]] = {
            f"{link}-{level}": surface.faces.astype(np.int32)
            for link, levels in enumerate(self.links)
            for level, surface in enumerate(levels)
        }
        return pack_arrays({"errors": [[surface.error for surface in levels] for levels in self.links]}, arrays)

    @staticmethod
    def from_bytes(data: bytes, robot: Robot) -> LinkLevels:
        """Read the surfaces of ``robot`` that ``to_bytes`` wrote.

        Raises:
            RecordingError: The data are damaged or belong to another robot.
        """
        header, arrays = unpack_arrays(data, error=RecordingError)
        errors = header.get("errors")
        if not isinstance(errors, list) or len(errors) != len(robot.links):
            raise RecordingError("the surfaces do not belong to the links of the robot", value=robot.name)
        found = []
        for number, (link, own) in enumerate(zip(robot.links, errors, strict=True)):
            count = 0 if link.mesh is None else len(link.mesh.vertices)
            faces = [arrays.get(f"{number}-{level}") for level in range(len(own))]
            if any(part is None or part.shape[1:] != (3,) or not _within(part, count) for part in faces):
                raise RecordingError("faces of a link refer to vertices that it does not have", value=link.name)
            pairs = zip(faces, own, strict=True)
            found.append(tuple(CoarseSurface(part, float(error)) for part, error in pairs if part is not None))
        return LinkLevels(links_digest(robot), tuple(found))


def _within(faces: NDArray[np.int32], count: int) -> bool:
    return faces.dtype.kind in "iu" and bool(len(faces)) and bool((faces >= 0).all() and (faces < count).all())


def _worthwhile(levels: tuple[CoarseSurface, ...]) -> tuple[CoarseSurface, ...]:
    """Return the levels whose error is smaller than that of every coarser level."""
    return tuple(level for i, level in enumerate(levels) if all(level.error < other.error for other in levels[i + 1 :]))


def faces_of_links(robot: Robot) -> int:
    """Return the number of triangles of all links."""
    return sum(0 if link.mesh is None else len(link.mesh.faces) for link in robot.links)


def links_digest(robot: Robot) -> str:
    """Return the digest of the meshes of all links. Cost: 20 ms for the whole iCub."""
    digest = blake2b(digest_size=16)
    for link in robot.links:
        digest.update(f"{link.name} {bool(link.missing)}\0".encode())
        if link.mesh is not None:
            digest.update(link.mesh.vertices.tobytes() + link.mesh.faces.tobytes())
    return digest.hexdigest()
