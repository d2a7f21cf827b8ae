"""Catalogue of difficult contacts: contact locations on the skin, and extreme states of bodies.

``PLACES[name]()`` is skin on a fixed link and the paths of one or two contacts over it. ``dropped``, ``teleported``,
``jammed`` and ``whip`` are scenes with bodies that are too deep, fast, light, heavy, stiff or confined. All are plain
``PreparedScene`` values and can be recorded and replayed; ``touch_checks`` has the properties that must hold.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from typing import get_args

import numpy as np
import trimesh

from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import Mesh, SurfacePoint
from tactile_maps.maps.build import build_map
from tactile_maps.robots.model.robot import Joint, Link, Robot
from tactile_maps.scene.effects import Integrator
from tactile_maps.scene.object_meshes import make_objects
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.scene.scene import Scene
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.sampling import place_evenly, taxels_at_points
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tests.hard_cases.meshes import moved, one_link
from tests.support.surfaces import frustum, sheet
from tests.support.touch import bar, bar_skin, pair

MODELS = ("point", "water-fill", "punch", "half-space", "foundation", "depth")
EXACT = MODELS[:-1]
"""Models whose pressures sum to the force; ``depth`` promises no such thing."""
INTEGRATORS: tuple[Integrator, ...] = get_args(Integrator)
TOP = 0.02
"""Height of the bar's skin [m]."""
TUBE = 0.04
TUBE_LENGTH = 0.2
"""Radius and length of the tube [m]."""
SPRING = 1000.0
"""Stiffness of a probe's motors [N/m], as in ``object_geoms``: the reference for its force."""
_AWAY = 0.003
_DEPTH = 0.004
_PRESS = 0.15
_REST = 0.2


@dataclass(frozen=True, eq=False)
class Place:
    """Skin on a fixed link at the world origin, and the paths of the contacts on it.

    Attributes:
        prepared: The scene, without objects.
        ways: Path of each contact centre on the skin, (k, 3) each [m].
        radius: Radius of the fingertip or probe [m].
        jump: Largest allowed step of the centre of pressure [taxel pitches].
    """

    prepared: PreparedScene
    ways: tuple[np.ndarray, ...]
    radius: float = 0.008
    jump: float = 0.5

    @property
    def pitch(self) -> float:
        """Side of a square as large as the mean taxel [m]."""
        areas = self.prepared.skin.areas
        return float(np.sqrt(areas.mean()))

    def points(self, way: int) -> list[SurfacePoint]:
        """The places of one way, on the nearest patch."""
        surfaces = [ClosestPoint(patch.surface).query(self.ways[way]) for patch in self.prepared.skin.patches]
        nearest = np.argmin([away for *_, away in surfaces], axis=0)
        found = [(patch, *(part[k] for part in surfaces[patch][:2])) for k, patch in enumerate(nearest)]
        return [SurfacePoint(int(p), int(face), tuple(weights.tolist())) for p, face, weights in found]

    def probed(self, model: str, *, seconds: float = 0.6) -> PreparedScene:
        """The scene with a probe on each way: it comes, presses with a few newtons, goes along and rests at the end."""
        specs = tuple(self._probe(number, seconds) for number in range(len(self.ways)))
        return with_scene(self.prepared, objects=specs, overrides={"skin": model, "contact": "probe", "fingers": "off"})

    def _probe(self, number: int, seconds: float) -> ObjectSpec:
        skin = self.prepared.skin
        points = self.points(number)
        normals = np.array([skin.normal(at) for at in points])
        depth = min(_DEPTH, 0.5 * self.radius)
        times = np.linspace(0, seconds, len(points))
        middles = self.ways[number] + (self.radius - depth) * normals
        start = self.ways[number][0] + (self.radius + _AWAY) * normals[0]
        rows = [(0.0, *start), *((_PRESS + t, *at) for t, at in zip(times, middles, strict=True))]
        rows.append((_PRESS + seconds + _REST, *middles[-1]))
        return ObjectSpec(
            f"probe {number}",
            "probe",
            size=(self.radius,),
            mass=0.1,
            friction=0.0,
            max_force=100.0,
            path=tuple(tuple(map(float, row)) for row in rows),
        )

    @staticmethod
    def resting(seconds: float = 0.6) -> float:
        """Return the time at which a probe of ``probed`` has come to rest at the end of its path [s]."""
        return _PRESS + seconds + 0.9 * _REST


def with_scene(prepared: PreparedScene, **changes) -> PreparedScene:
    """The same robot and skin in a scene changed so, with its objects made."""
    scene = replace(prepared.scene, **changes)
    return replace(prepared, scene=scene, objects=make_objects(scene))


def dressed(robot: Robot, skin: Skin, **scene) -> PreparedScene:
    """A robot in its skin as a scene."""
    made = Scene(name="hard", robot=robot.name, **scene)
    return PreparedScene(made, robot, skin, build_map(skin), make_objects(made))


@cache
def _bar() -> PreparedScene:
    return dressed(bar(hinged=False), bar_skin(160, finer=2))


def _on_top(*xy: tuple[float, float], steps: int = 40) -> np.ndarray:
    """A way on the bar's top through given places."""
    legs = [np.linspace(a, b, steps, endpoint=False) for a, b in pairwise(xy)]
    flat = np.concatenate([*legs, [xy[-1]]])
    return np.column_stack([flat, np.full(len(flat), TOP)])


def _plates(*plates: tuple[float, float, float, float], taxels: tuple[int, ...], grid: float = 0.0025) -> PreparedScene:
    """The bar with several plates of skin on its top, each (x, y, width, height) [m], in faces as large as ``grid``."""
    patches = []
    for number, ((x, y, width, height), count) in enumerate(zip(plates, taxels, strict=True)):
        plate = sheet(round(width / grid), round(height / grid), width=width, height=height)
        plate = moved(plate, (x, y, TOP))
        patches.append(Patch(f"plate {number}", "bar", plate, place_evenly(plate, count, seed=0)))
    return dressed(bar(hinged=False), Skin(tuple(patches)))


@cache
def _tube() -> PreparedScene:
    shell = frustum(TUBE, TUBE, length=TUBE_LENGTH, around=72, along=60)
    return dressed(one_link(shell), Skin((Patch("tube", "part", shell, place_evenly(shell, 160, seed=0)),)))


def seam_angle(prepared: PreparedScene) -> float:
    """Return the angle of the tube's seam at half its height [rad]."""
    (chart,) = prepared.map.charts
    ends = prepared.skin.patches[0].surface.vertices[np.unique(chart.seams)]
    x, y, _ = ends[np.abs(ends[:, 2] - TUBE_LENGTH / 2).argmin()]
    return float(np.arctan2(y, x))


def _seam() -> Place:
    """Round the tube, across the seam by which it was flattened, and back."""
    tube = _tube()
    angle = seam_angle(tube) + np.radians(np.concatenate([np.linspace(-30, 30, 61), np.linspace(29, 0, 30)]))
    ring = np.column_stack([TUBE * np.cos(angle), TUBE * np.sin(angle), np.full(len(angle), TUBE_LENGTH / 2 + 0.001)])
    faces, weights, _ = ClosestPoint(tube.skin.patches[0].surface).query(ring)
    return Place(tube, (tube.skin.patches[0].surface.points(faces, weights),))


def _tiny_taxel() -> Place:
    """A taxel of 16 mm² among four of 900."""
    plate = moved(sheet(30, 30, width=0.06, height=0.06), (0.17, -0.03, TOP))
    middles = plate.vertices[plate.faces].mean(axis=1)
    points = np.array([[0.2, 0.0, TOP], *([0.2 + x, y, TOP] for x in (-0.015, 0.015) for y in (-0.015, 0.015))])
    around = 1 + np.linalg.norm(middles[:, None] - points[1:], axis=2).argmin(axis=1)
    owner = np.where((np.abs(middles - points[0]) < 0.002).all(axis=1), 0, around)
    skin = Skin((Patch("plate", "bar", plate, taxels_at_points(plate, points, owner)),))
    return Place(dressed(bar(hinged=False), skin), (_on_top((0.19, 0.001), (0.21, 0.001)),))


PLACES: dict[str, Callable[[], Place]] = {
    "on a seam": _seam,
    "at a border": lambda: Place(_bar(), (_on_top((0.05, 0.0), (0.0125, 0.0), (0.0125, 0.04)),)),
    "half over a border": lambda: Place(_bar(), (_on_top((0.05, 0.0), (0.0101, 0.0)),)),
    "in a corner": lambda: Place(_bar(), (_on_top((0.05, -0.02), (0.012, -0.048)),)),
    "one taxel": lambda: Place(
        _plates((0.19, -0.01, 0.02, 0.02), taxels=(1,)), (_on_top((0.195, 0.0), (0.205, 0.005)),), jump=0.0
    ),
    "between two patches": lambda: Place(
        _plates((0.1, -0.05, 0.1, 0.1), (0.2, -0.05, 0.1, 0.1), taxels=(40, 40)),
        (_on_top((0.17, 0.003), (0.23, 0.003), (0.2, 0.003)),),
    ),
    "over a gap": lambda: Place(
        _plates((0.1, -0.05, 0.098, 0.1), (0.202, -0.05, 0.098, 0.1), taxels=(40, 40)),
        (_on_top((0.17, 0.0), (0.23, 0.0)),),
        radius=0.02,
        jump=1.0,
    ),
    "below the pitch": lambda: Place(
        _plates((0.17, -0.03, 0.06, 0.06), taxels=(4,), grid=0.0015),
        (_on_top((0.185, -0.01), (0.215, 0.012)),),
        radius=0.002,
    ),
    "one tiny taxel": _tiny_taxel,
    "two that merge": lambda: Place(
        _bar(), (_on_top((0.15, 0.0), (0.189, 0.0), (0.189, 0.0)), _on_top((0.25, 0.0), (0.211, 0.0), (0.211, 0.0)))
    ),
}
"""Makers of places by name."""


def weight(mass: float, *, above: float = 0.0, radius: float = 0.02) -> ObjectSpec:
    """A ball on a guide that starts ``above`` the bar's middle [m], or below its top where that is negative."""
    at = (0.2, 0.0, TOP + radius + above)
    return ObjectSpec("weight", "sphere", size=(radius,), at=at, mass=mass, friction=0.0, guided=True)


def dropped(
    mass: float, *, above: float = 0.0, radius: float = 0.02, stiffness: float = 2e4, tick: float = 0.008, **overrides
) -> PreparedScene:
    """Return a weight above a fixed bar; the skin effect is water-fill unless ``skin`` is given."""
    effects = {"contact": "environment", "fingers": "off", "skin": "water-fill", **overrides}
    objects = (weight(mass, above=above, radius=radius),)
    layer = ElasticLayer(stiffness=stiffness)
    return with_scene(_bar(), objects=objects, layer=layer, overrides=effects, tick=tick)


def teleported(*, stiffness: float = 2e4, force: float = 200.0, **overrides) -> PreparedScene:
    """Return a probe next to the bar whose target jumps to 70 mm inside the bar within 0.1 ms and stays there."""
    out = (0.2, 0.0, TOP + 0.015)
    inside = (0.2, 0.0, TOP + 0.015 - 0.07)
    path = ((0.0, *out), (0.1, *out), (0.1001, *inside), (600.0, *inside))
    spec = ObjectSpec("probe", "probe", size=(0.012,), mass=0.1, friction=0.0, max_force=force, path=path)
    effects = {"contact": "probe", "fingers": "off", "skin": "water-fill", **overrides}
    return with_scene(_bar(), objects=(spec,), layer=ElasticLayer(stiffness=stiffness), overrides=effects, tick=0.008)


JAM = 0.004
"""Overlap of the jammed block with the walls on each side [m]."""


def jammed(*, stiffness: float = 2e4, **overrides) -> PreparedScene:
    """A block on a slide between two walls that are 8 mm too close; its skin is on one of the sides that touch."""
    robot, skin = pair()
    thick = 0.04
    far = 0.065
    back = ObjectSpec("back", "box", size=(thick, 0.2, 0.2), at=(-far - 0.05 - thick / 2 + JAM, 0.0, 0.0))
    front = ObjectSpec("front", "box", size=(thick, 0.2, 0.2), at=(-far + 0.05 + thick / 2 - JAM, 0.0, 0.0))
    effects = {"contact": "environment", "fingers": "off", "skin": "water-fill", **overrides}
    return dressed(
        robot, skin, objects=(back, front), layer=ElasticLayer(stiffness=stiffness), overrides=effects, tick=0.008
    )


def _box(*edges: float) -> Mesh:
    made = trimesh.creation.box(edges)
    return Mesh(np.asarray(made.vertices), np.asarray(made.faces))


_WHIP = """<mujoco model="whip"><compiler angle="radian"/><worldbody>
<body name="arm"><inertial pos="0.1 0 0" mass="0.2" diaginertia="1e-4 8e-4 8e-4"/><joint name="root" axis="0 1 0"/>
<geom type="box" pos="0.1 0 0" size="0.1 0.01 0.01"/>
<body name="tip" pos="0.2 0 0"><inertial pos="0.02 0 0" mass="0.002" diaginertia="1e-7 3e-7 3e-7"/>
<joint name="end" axis="0 1 0"/><geom type="box" pos="0.02 0 0" size="0.02 0.01 0.01"/></body></body>
</worldbody></mujoco>"""


def whip(**overrides) -> PreparedScene:
    """An arm of two hinges without armature or damping, its tip of 2 g in skin and tapped by a probe from above."""
    tip = moved(_box(0.04, 0.02, 0.02), (0.02, 0.0, 0.0))
    top = 0.01
    plate = moved(sheet(16, 8, width=0.04, height=0.02), (0.0, -0.01, top))
    robot = Robot(
        "whip",
        "by hand",
        _WHIP,
        {},
        (Link("arm", None), Link("tip", tip)),
        (Joint("root", -np.inf, np.inf), Joint("end", -np.inf, np.inf)),
        np.zeros(2),
    )
    up = (0.22, 0.0, top + 0.02)
    down = (0.22, 0.0, top + 0.005)
    path = ((0.0, *up), (0.2, *down), (0.4, *down), (0.6, *up), (600.0, *up))
    spec = ObjectSpec("probe", "probe", size=(0.01,), mass=0.1, friction=0.0, max_force=2.0, path=path)
    skin = Skin((Patch("tip", "tip", plate, place_evenly(plate, 12, seed=0)),))
    effects = {"contact": "probe", "fingers": "off", "skin": "water-fill", **overrides}
    return dressed(robot, skin, objects=(spec,), overrides=effects, tick=0.008)
