"""Objects in a scene besides the robot: their specification in a scene file, and objects with their surface."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np
from scipy.spatial.transform import Rotation

from tactile_maps.core.errors import Finding, SceneError, check_range
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.pose import Pose

ObjectKind: TypeAlias = Literal["probe", "plane", "box", "cylinder", "sphere", "mesh", "plate"]
OBJECT_KINDS: tuple[ObjectKind, ...] = ("probe", "plane", "box", "cylinder", "sphere", "mesh", "plate")
_SIZES: dict[str, tuple[tuple[str, ...], ...]] = {
    "probe": (("radius",),),
    "sphere": (("radius",),),
    "cylinder": (("radius", "height"),),
    "box": (("x", "y", "z"),),
    "plate": (("x", "y", "z"),),
    "plane": ((), ("x", "y")),
    "mesh": ((), ("scale",)),
}
"""Meaning of the numbers of a size, by kind; a kind with an empty alternative needs no size."""
MIN_MOVING_MASS = 0.05
"""Smallest mass of a probe or plate [kg]: lighter ones would need a smaller time step than the rest of a scene."""
_FARTHEST = 1e3
_LARGEST = 100.0
_SMALLEST = 1e-4
_RANGES = (("mass", 0.0, 1e5), ("stiffness", 1.0, 1e8), ("damping", 0.0, 10.0), ("max_force", 0.0, 1e4))
_METRES = "metres"


@dataclass(frozen=True)
class ObjectSpec:
    """Specification of an object in a scene file.

    Attributes:
        name: Unique in the scene.
        kind: ``probe``: a ball that moves along ``path`` with at most ``max_force``. ``plate``: a box on a spring along
            its z axis. ``plane``: a floor, z up in its frame. ``mesh``: a closed mesh from ``file``.
        size: Size [m]; box and plate: full extents (x, y, z); sphere and probe: (radius,); cylinder: (radius, height),
            its axis along z; plane: drawn extents (x, y); mesh: (scale,), or empty for 1.
        at: Position in the world [m].
        turn: Rotations about the world's x, then y, then z [deg].
        mass: Mass [kg]; 0 is fixed to the world. A probe and a plate have at least 0.05 kg.
        friction: Coulomb coefficient of its contacts with skin; by default that of the cover. In a contact of two
            bodies without skin a stated coefficient counts, the larger of two; if no object states one, the larger of
            0.5 and that of a link.
        stiffness: Stiffness of a plate's spring [N/m].
        damping: Damping ratio of a plate's spring (1 is critical).
        max_force: Largest force of a probe's motors [N].
        path: Path of a probe: (seconds, x, y, z) in the world, repeated; empty for a probe at rest.
        file: File of a mesh, relative to the scene.
        guided: Whether a box, cylinder, sphere or mesh with mass slides only along the world's z, as a weight on a
            guide, instead of being free.

    Raises:
        SceneError: A number is out of range, or the size does not fit the kind.
    """

    name: str
    kind: ObjectKind
    size: tuple[float, ...] = ()
    at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    turn: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mass: float = 0.0
    friction: float | None = None
    stiffness: float = 1000.0
    damping: float = 0.5
    max_force: float = 20.0
    path: tuple[tuple[float, float, float, float], ...] = ()
    file: str = ""
    guided: bool = False

    def __post_init__(self) -> None:
        if not self.name:
            raise SceneError("the object has no name", place="objects.name")
        for name, low, high in _RANGES:
            self._check(name, getattr(self, name), low, high)
        if self.friction is not None:
            self._check("friction", self.friction, 0.0, 5.0)
        for value in self.at:
            self._check("at", value, -_FARTHEST, _FARTHEST, unit=_METRES)
        for value in self.turn:
            self._check("turn", value, -3600.0, 3600.0)
        self._check_size()
        self._check_path()
        if (self.kind == "mesh") != bool(self.file):
            if self.file:
                problem = f"a {self.kind} has no file"
                remedy = 'Remove file, or write kind = "mesh"'
            else:
                problem = "an object of kind mesh needs a mesh file"
                remedy = 'Write file = "FILE.obj" or another format'
            raise SceneError(problem, place="objects.file", value=self.file or self.name, remedy=remedy)
        if self.guided and (self.kind in ("probe", "plane", "plate") or not self.mass):
            remedy = "Give a box, cylinder, sphere or mesh with mass"
            raise SceneError("only free bodies can be guided", place="objects.guided", value=self.kind, remedy=remedy)

    def _check(self, name: str, value: float, low: float, high: float, *, unit: str = "") -> None:
        what = f"a value of {self.name}"
        check_range(what, value, low, high, error=SceneError, place=f"objects.{name}", unit=unit)

    def _check_size(self) -> None:
        meanings = _SIZES[self.kind]
        if len(self.size) not in map(len, meanings):
            remedy = f"Write size = [{', '.join(meanings[-1])}]{'' if self.kind == 'mesh' else ' in metres'}"
            if () in meanings:
                remedy += ", or leave size out"
            count = len(meanings[-1])
            problem = f"the size of a {self.kind} has {count} number{'s'[: count - 1]}"
            raise SceneError(problem, place="objects.size", value=list(self.size), remedy=remedy)
        for value in self.size:
            self._check("size", value, _SMALLEST, _LARGEST, unit=_METRES)

    def _check_path(self) -> None:
        if self.path and self.kind != "probe":
            raise SceneError("only a probe has a path", place="objects.path", value=self.kind)
        times = [row[0] for row in self.path]
        for seconds, *place in self.path:
            self._check("path", seconds, 0.0, 3600.0, unit="seconds")
            for value in place:
                self._check("path", value, -_FARTHEST, _FARTHEST, unit=_METRES)
        if any(later <= earlier for earlier, later in pairwise(times)):
            remedy = "Write rows of [seconds, x, y, z], each with a later time than the row before"
            raise SceneError("the times of a path must rise", place="objects.path", value=times, remedy=remedy)

    @property
    def moving_mass(self) -> float:
        """Effective mass in a contact [kg]; infinite if the object is fixed."""
        if self.kind in ("probe", "plate"):
            return max(self.mass, MIN_MOVING_MASS)
        return self.mass if self.mass and self.kind != "plane" else math.inf

    @property
    def pose(self) -> Pose:
        """``T_world_object`` at the start."""
        return Pose(Rotation.from_euler("xyz", self.turn, degrees=True).as_matrix(), np.array(self.at))


@dataclass(frozen=True, eq=False)
class SceneObject:
    """An object with its surface.

    Attributes:
        spec: Specification in the scene.
        mesh: Surface in its own frame [m], which is drawn; that of a mesh file also touches.
        findings: Findings from reading its file.
    """

    spec: ObjectSpec
    mesh: Mesh
    findings: tuple[Finding, ...] = ()
