"""A robot at home next to a fixed ball that presses one taxel of its skin, and the choice of a place for such a ball.

``with_fixed_ball`` adds the ball, ``place_to_press`` selects the taxel, ``with_finger`` adds a second finger elsewhere.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import mujoco
import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import SkinError
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.scene.effects import SkinModel
from tactile_maps.scene.object_meshes import make_objects
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.scene.scene_file import scene_for
from tactile_maps.session.prepare import PreparedScene, prepare
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.simulation.model.model_names import body_name
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer

SKIN_LINKS = {"arm": "forearm", "ur5e": "forearm_link", "icub": "l_forearm"}
"""Link that the skin covers, by robot."""
BALL = 0.03
"""Radius [m]."""
DEPTH = 0.001
"""Initial depth of the ball in the skin [m]."""
MARGIN = 0.02
"""Minimum distance of the ball from the border of the skin or a seam [m], if such a place exists."""
REACH_SHARE = 0.6
"""Required share of the best reach."""


@lru_cache(maxsize=4)
def forearm_skin_scene(robot: str, taxels: int, seed: int = 0) -> PreparedScene:
    """Return a robot of ``SKIN_LINKS`` with skin on its forearm only. Cost: 4 s at 1500 taxels; cached.

    Raises:
        RobotError: The robot is not installed.
    """
    scene = scene_for(robot)
    spec = replace(scene.cover, links=(SKIN_LINKS[robot],), taxels=taxels, seed=seed)
    return prepare(replace(scene, cover=spec, stimuli=(), seed=seed))


def with_fixed_ball(
    prepared: PreparedScene,
    *,
    taxel: int | None = None,
    radius: float = BALL,
    depth: float = DEPTH,
    layer: ElasticLayer | None = None,
    model: SkinModel = "foundation",
    tick: float | None = None,
    seed: int | None = None,
) -> PreparedScene:
    """Return the same robot with a fixed ball pressed into its skin at home, and no other objects.

    Args:
        prepared: Robot, skin and map; fingers and motion of its scene are removed.
        taxel: Place of the contact; by default ``place_to_press``.
        radius: Radius of the ball [m].
        depth: Initial depth of the ball in the skin [m].
        layer: The cover; that of the scene by default.
        model: Contact model. The foundation, which has no friction, touches the skin itself; the solver's contacts
            touch the convex hull of the link, on real robots some millimetres away.
        tick: Control period [s]; that of the scene by default.
        seed: Seed of the sensor; that of the scene by default.

    Raises:
        SkinError: The robot has no skin.
    """
    scene = prepared.scene
    where = place_to_press(prepared, radius=radius) if taxel is None else taxel
    x, y, z = points_above(prepared, np.array([where]), radius - depth)[0].tolist()
    cover = layer or scene.layer
    ball = ObjectSpec("ball", "sphere", (radius,), at=(x, y, z), friction=cover.friction)
    alone = replace(scene, objects=(ball,), layer=cover, stimuli=(), motion=(), tick=tick or scene.tick)
    pressed = replace(
        alone,
        description=f"The skin is pressed on a fixed ball of {1e3 * radius:g} mm radius",
        task="slide",
        outputs=("force", "pressure"),
        overrides={**scene.overrides, "skin": model},
        seed=scene.seed if seed is None else seed,
    )
    return replace(prepared, scene=pressed, objects=make_objects(pressed))


_FINGER_RADIUS = 0.012
_BEYOND = 0.03
_APPROACH = 0.2
"""Radius of the finger [m], depth of its path below the skin [m], and time at which it would arrive there [s]."""


def with_finger(prepared: PreparedScene, force: float) -> PreparedScene:
    """Return the scene with a finger that pushes with ``force`` [N] where the skin is farthest from the ball.

    Args:
        prepared: A robot ``with_fixed_ball``.
        force: Maximum force of its spring; it has no friction.
    """
    scene, (ball, *_) = prepared.scene, prepared.scene.objects
    surface = points_above(prepared, np.arange(len(prepared.skin)), 0.0)
    farthest = np.array([int(np.argmax(np.linalg.norm(surface - ball.at, axis=1)))])
    outside, inside = (
        points_above(prepared, farthest, height)[0].tolist() for height in (_FINGER_RADIUS + 0.002, -_BEYOND)
    )
    path = ((0.0, *outside), (_APPROACH, *inside), (3600.0, *inside))
    finger = ObjectSpec("finger", "probe", (_FINGER_RADIUS,), mass=0.1, friction=0.0, max_force=force, path=path)
    description = f"{scene.description}, and a finger pushes elsewhere with {force:g} N"
    both = replace(scene, objects=(ball, finger), description=description)
    return replace(prepared, scene=both, objects=make_objects(both))


def points_above(prepared: PreparedScene, taxels: IntArray, height: float) -> FloatArray:
    """Return the points (k, 3) at a height [m] above ``taxels`` (k,) with the robot at home, world frame [m]."""
    configuration = Configuration(prepared.robot)
    places = []
    for patch in prepared.skin.patches:
        pose = configuration.pose(patch.link)
        places.append(pose.points(patch.taxels.positions + height * patch.taxels.normals))
    return np.asarray(np.concatenate(places)[taxels])


def place_to_press(prepared: PreparedScene, *, radius: float = BALL, bend: float = 0.0) -> int:
    """Return the taxel best suited as the centre of a path: the flattest that the joints move well, with free space.

    Space is free if borders and seams are ``MARGIN`` away on the map, and if a ball is as far from everything else
    that it may touch; if no taxel has as much space, those with the most are used, nearer to borders if the ball would
    touch something else. Joints move a taxel well if the smallest singular value of its Jacobian at home is
    ``REACH_SHARE`` of the largest such value.

    Args:
        prepared: Robot, skin and map.
        radius: Radius of the ball [m].
        bend: Share of the suitable taxels that are flatter than the result, from 0 to 1.

    Raises:
        SkinError: There are no taxels, or the ball touches something else wherever it touches the skin.

    Cost: 0.3 s at 2000 taxels.
    """
    skin = prepared.skin
    configuration = Configuration(prepared.robot)
    if not len(skin):
        raise SkinError("no skin to press", remedy="Cover a link")
    room = np.concatenate([_margin_on_map(prepared.map, number) for number in range(len(skin.patches))])
    room = np.minimum(room, _margin_to_links(skin, configuration, radius))
    curvature = np.concatenate([_curvature(patch) for patch in skin.patches])
    reach = np.array([_least_singular_value(skin, configuration, taxel) for taxel in range(len(skin))])
    for share in (1.0, 0.5, 0.0):
        roomy = room >= share * min(MARGIN, float(room.max()))
        good = np.flatnonzero(roomy & (reach >= REACH_SHARE * float(reach[roomy].max())))
        clear = _clearance(prepared, good, radius)
        if clear.max() > 0:
            good = good[clear >= min(MARGIN, float(clear.max()))]
            return int(good[np.argsort(curvature[good], kind="stable")[round(bend * (len(good) - 1))]])
    problem = "wherever the ball touches the skin, it touches something else too"
    raise SkinError(
        problem, value=f"radius {1e3 * radius:.3g} mm", remedy="Choose another posture, or cover other links"
    )


def _margin_on_map(map_: TactileMap, patch: int) -> FloatArray:
    """(n,) distance of the taxels of a patch from its borders and seams on the map [m]."""
    first, last = map_.skin.first[patch : patch + 2]
    edges = np.concatenate([map_.outlines[patch], map_.seams[patch].reshape(-1, 2)])
    return np.asarray(cKDTree(edges).query(map_.taxel_points[first:last])[0], dtype=np.float64)


def _clearance(prepared: PreparedScene, taxels: IntArray, radius: float) -> FloatArray:
    """(k,) distance of a ball above each of ``taxels`` from all other shapes that it may touch, at home [m]."""
    pressed = with_fixed_ball(prepared, taxel=0, radius=radius)
    scene = pressed.scene
    model = assemble(pressed.robot, pressed.skin, scene.effects, objects=pressed.objects, layer=scene.layer)
    data = mujoco.MjData(model)
    ball = model.body(body_name(pressed.objects[0].spec))
    data.qpos[:] = pressed.robot.home
    touching = (model.geom_contype | model.geom_conaffinity) > 0
    others = np.flatnonzero(touching & (model.geom_bodyid != ball.id)).tolist()
    clear = np.full(len(taxels), MARGIN)
    for number, place in enumerate(points_above(prepared, taxels, radius)):
        model.body_pos[ball.id] = place
        mujoco.mj_kinematics(model, data)
        away = [mujoco.mj_geomDistance(model, data, int(ball.geomadr[0]), geom, MARGIN, None) for geom in others]
        clear[number] = min(away, default=MARGIN)
    return clear


def _margin_to_links(skin: Skin, configuration: Configuration, radius: float) -> FloatArray:
    """(n,) distance of a ball above each taxel from the skin of other links, at home [m]."""
    apart = []
    for patch in skin.patches:
        balls = configuration.pose(patch.link).points(patch.taxels.positions + radius * patch.taxels.normals)
        away = np.full(len(balls), np.inf)
        for other in (other for other in skin.patches if other.link != patch.link):
            places = configuration.pose(other.link).inverse.points(balls)
            away = np.minimum(away, ClosestPoint(other.surface).query(places)[2] - radius)
        apart.append(away)
    return np.concatenate(apart)


def _curvature(patch: Patch) -> FloatArray:
    """(n,) largest angle between the normal of a taxel and those within ``MARGIN`` [rad]."""
    positions = patch.taxels.positions
    normals = patch.taxels.normals
    around = cKDTree(positions).query_ball_point(positions, MARGIN)
    least = [float((normals[near] @ normal).min()) for near, normal in zip(around, normals, strict=True)]
    return np.arccos(np.clip(least, -1.0, 1.0))


def _least_singular_value(skin: Skin, configuration: Configuration, taxel: int) -> float:
    """Smallest motion of a taxel in any direction, by the motion of the joints [m/rad]."""
    at = skin.taxel_point(taxel)
    moves = configuration.jacobian(skin.link(at), skin.position(at))
    return float(np.linalg.svd(moves, compute_uv=False)[-1]) if moves.shape[1] >= 3 else 0.0
