"""Distances of the robot's shapes from each other and from obstacles, at a posture and along a motion.

The shapes are the convex hulls of links with skin, and the collision shapes of the other links. A link that collides in
pieces is inside its hull, so its true distance is at least the one reported here. Where the hulls of two links overlap
at home but the shapes with which they collide do not, their distance is that of these shapes (``_Pieces``). Links
that never collide in the simulation are not checked against each other. Bounding spheres exclude most pairs;
``mj_geomDistance`` measures the rest.

Decision: hulls where possible, because a plan checks thousands of postures. With the pieces of the simulation a posture
of UR5e has 1,145 pairs of shapes instead of 13 and takes 0.49 ms instead of 0.04, and one of iCub 102,214 pairs instead
of 45 and 15.7 ms instead of 0.11.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from copy import copy
from dataclasses import dataclass
from typing import TypeAlias, assert_never

import mujoco
import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.caches import weak_cache
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.robots.model.mujoco_spec import OWN_NAMES, compile_spec
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.collision_shapes import excluded_pairs, pieces_model
from tactile_maps.skin.link_hulls import hulls_spec, overlapping_hulls
from tactile_maps.skin.link_pieces import spans_hollows
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.loads import Box, Cylinder, Plane, Sphere

MARGIN = 0.008
"""Required distance between any two shapes [m]; those that are nearer at the start may stay as near."""
TOUCHED_MARGIN = 0.002
"""Required distance between the touched object and the links next to the touching one [m]."""
SLACK = 0.001
"""Distance by which shapes may come nearer than at the start [m]."""
FAR = 0.12
"""Largest distance that is measured [m]."""
CLOSE_MARGIN = 0.001
"""Required distance between links that collide in pieces and are nearer than ``MARGIN`` at home [m]: that by which
pieces may protrude from the links. The joints between such links keep them apart."""
_PIECES_FAR = 0.002
"""Distance in excess of the required one up to which links are measured in pieces [m]; the cost grows with it."""
TOUCHES = 0.005
"""Distance from the touched link [m] within which an obstacle may be the touching object."""
TOUCHED = "the touched object"
"""Name of the touched object if it is not a known obstacle."""
_ROOM = Cylinder(0.032, 0.125)
"""Space reserved for an unknown object, along the normal from the place of the contact."""
_BEYOND = 0.5
"""Distance from which a ray is cast back to a hull [m]."""
_AWAY = np.array([0.0, 0.0, -1e3])

ObstacleShape: TypeAlias = Sphere | Box | Cylinder | Plane | Mesh
"""Shape of an obstacle; a mesh represents its convex hull."""


@dataclass(frozen=True, eq=False)
class Obstacle:
    """Object around the robot.

    Attributes:
        name: Name shown to users.
        shape: Shape in its own frame.
        pose: ``T_world_obstacle``.
    """

    name: str
    shape: ObstacleShape
    pose: Pose


Surroundings: TypeAlias = Callable[[], tuple[Obstacle, ...]]
"""Returns the obstacles at their current places: always the same ones in the same order."""


def nothing_around() -> tuple[Obstacle, ...]:
    """Return no obstacles."""
    return ()


@dataclass(frozen=True)
class Gap:
    """Pair of shapes with the least room.

    Attributes:
        room: Distance in excess of the required one [m], negative if they are too near; at most ``FAR``.
        between: Names of their links or obstacles.
    """

    room: float
    between: tuple[str, str]


class Clearance:
    """Distances at postures of a robot. Mutable: ``begin`` sets the places of obstacles and which shapes may be near.

    Args:
        robot: The robot.
        skin: Skin whose links have convex hulls.
        obstacles: All obstacles; ``begin`` moves them.

    Raises:
        RobotError: MuJoCo rejects the model.

    Attributes:
        cost: Usual time of checking a posture, over that of a robot without pairs of links in pieces.

    Cost: 0.1 to 0.3 s to build (convex hulls of all links, and ``excluded_pairs`` if it was not called before), a few
    ms if the last one of this robot and skin had the same obstacles; 20 to 60 µs a posture. With pairs in pieces, as
    on iCub, 0.7 s to build and 0.7 ms a posture.
    """

    def __init__(self, robot: Robot, skin: Skin, obstacles: Sequence[Obstacle] = ()) -> None:
        links = {link.name for link in robot.links}
        names = [f"{each.name} (object)" if each.name in links else each.name for each in obstacles]
        shapes: list[ObstacleShape] = [obstacle.shape for obstacle in obstacles]
        self._model = model = collision_model(robot, skin, (*shapes, _ROOM, Sphere(1e-4)))
        self._data = mujoco.MjData(model)
        self._joints = len(robot.joints)
        first = model.nbody - len(shapes) - 2
        self._names = [*(model.body(body).name for body in range(first)), *names, TOUCHED, ""]
        self._room = first + len(shapes)
        self._tip = first + len(shapes) + 1
        self._first = first
        self._robot = robot
        self._skin = skin
        self._hollow: dict[str, bool] = {}
        apart = excluded_pairs(robot, skin)
        self._pairs = self._meetings(apart)
        self._bodies = model.geom_bodyid[self._pairs]
        divided = overlapping_hulls(robot, skin)[1] - apart
        self._pieces = _Pieces(robot, skin) if divided else None
        self.cost = 5 if divided else 1
        self._in_pieces = np.array(
            [frozenset((self._names[one], self._names[other])) in divided for one, other in self._bodies], dtype=bool
        )
        self._radii = model.geom_rbound[self._pairs].sum(axis=1)
        self._margins = np.full(len(self._pairs), MARGIN)
        self._move(robot.home)
        self._margins[self._in_pieces & (self._distances() < MARGIN)] = CLOSE_MARGIN
        self._required = self._margins
        self._touched = self._room
        self._allowed = self._required
        self._near = self._required
        self._exempt = self._with_touched = np.zeros(len(self._pairs), dtype=bool)
        self._checked: list[IntArray] = []
        self._weights = _joint_reaches(model, first)[: self._joints]

    @property
    def touched(self) -> str:
        """Name of the touched object."""
        return self._names[self._touched]

    def begin(
        self, posture: FloatArray, obstacles: Sequence[Obstacle], link: str, place: FloatArray, normal: FloatArray
    ) -> None:
        """Move the obstacles to their poses; shapes that are near at ``posture`` may stay as near.

        Args:
            posture: (n,) posture at which ``place`` is touched.
            obstacles: The obstacles of the constructor, in the same order.
            link: Link of the place.
            place: (3,) touched place of the skin, world [m].
            normal: (3,) the skin's outward normal there.
        """
        for number, obstacle in enumerate(obstacles):
            self._put(self._first + number, obstacle.pose)
        self._put(self._tip, Pose(np.eye(3), place))
        self._put(self._room, Pose(np.eye(3), _AWAY))
        self._move(posture)
        self._touched = self._touching(link, len(obstacles))
        if self._touched == self._room:
            self._put(self._room, Pose(_upright(normal), place + (_ROOM.half + SLACK) * normal))
            self._move(posture)
        self._near = self._distances() - SLACK
        self._required = np.minimum(self._margins, self._near)
        self._with_touched = (self._bodies == self._touched).any(axis=1)
        self._required[self._with_touched & self._of(link)] = MARGIN
        self.meeting(None)

    def _touching(self, link: str, obstacles: int) -> int:
        """Return the body of the obstacle at the contact point that touches the link; that of ``_ROOM`` without one."""
        model = self._model
        data = self._data
        near = {
            int(self._bodies[pair].max()) for pair in np.flatnonzero(self._of(link) & (self._distances() < TOUCHES))
        } & set(range(self._first, self._first + obstacles))
        tip = model.body_geomadr[self._tip]
        away = {
            body: mujoco.mj_geomDistance(model, data, tip, model.body_geomadr[body], 10 * FAR, None)
            for body in sorted(near)
        }
        return min(away, key=lambda body: away[body], default=self._room)

    def on_hull(self, link: str, point: FloatArray, normal: FloatArray) -> FloatArray:
        """Return the point (3,), link frame, where a line from a place of the skin along its normal leaves the
        collision shape.

        The place is touched there: a hull is convex, the skin need not be. A link whose hull would span hollows of its
        skin is touched on the skin itself; only distances are those of its hull.
        """
        if link not in self._hollow:
            self._hollow[link] = spans_hollows(self._robot, self._skin, link)
        if self._hollow[link]:
            return point
        model = self._model
        data = self._data
        body = self._names.index(link)
        rotation = data.xmat[body].reshape(3, 3)
        origin = data.xpos[body]
        start = rotation @ (point + _BEYOND * normal) + origin
        first = int(model.body_geomadr[body])
        hits = [
            mujoco.mj_rayMesh(model, data, geom, start, -(rotation @ normal), None)
            for geom in range(first, first + int(model.body_geomnum[body]))
            if model.geom_contype[geom] and model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH
        ]
        height = max((_BEYOND - hit for hit in hits if hit >= 0), default=0.0)
        return point + max(height, 0.0) * normal

    def distance(self, posture: FloatArray, one: str, other: str) -> float:
        """Return the distance of two links or obstacles at a posture (n,) [m], at most ``FAR``; negative overlaps."""
        self._move(posture)
        between = np.flatnonzero(self._of(one) & self._of(other))
        return float(self._distances(between).min(initial=FAR))

    def _of(self, name: str | None) -> BoolArray:
        """Return the pairs (pairs,) that contain a link or obstacle; none for None."""
        return (self._bodies == (-1 if name is None else self._names.index(name))).any(axis=1)

    def meeting(self, link: str | None, *, leaves: bool = False) -> None:
        """Allow ``link`` to touch the touched object from now on; other links may be as near to it as
        ``TOUCHED_MARGIN``.

        Args:
            link: Name of the link; None if none may touch it.
            leaves: Whether the link is lifted off: it may not press deeper than at the start.
        """
        own = self._with_touched & self._of(link)
        self._exempt = own & (not leaves)
        near_touched = self._with_touched & (link is not None)
        self._allowed = np.where(near_touched, np.minimum(self._required, TOUCHED_MARGIN), self._required)
        self._allowed[own] = self._near[own]
        kinds = (~self._in_pieces & ~self._exempt, self._in_pieces & ~self._exempt)  # pieces last: they take longer
        self._checked = [np.flatnonzero(chosen) for chosen in kinds if chosen.any()]

    def at(self, posture: FloatArray) -> Gap:
        """Return the pair with the least room at a posture (n,)."""
        self._move(posture)
        room = np.full(len(self._pairs), FAR)
        for chosen in self._checked:
            room[chosen] = self._distances(chosen) - self._allowed[chosen]
            if room.min(initial=FAR) < 0:
                break
        worst = int(room.argmin())
        one, other = (self._names[body] for body in self._bodies[worst])
        return Gap(min(float(room[worst]), FAR), (one, other))

    def along(self, start: FloatArray, end: FloatArray) -> Iterator[Gap]:
        """Yield gaps along the straight line of the joints from ``start`` (n,) to ``end``, until one has no room.

        Each step is at most as long as no shape can move by more than its room and margin: nothing touches between two
            postures.
        """
        length = self.motion(end - start)
        way = 0.0
        while True:
            gap = self.at(start + (end - start) * (way / length if length > 0 else 0.0))
            yield gap
            if gap.room < 0 or way >= length:
                return
            way = min(way + gap.room + 0.9 * MARGIN, length)

    def motion(self, step: FloatArray) -> float:
        """Return the largest distance by which a step (n,) of the joints can move any shape [m]."""
        return float(self._weights @ np.abs(step))

    def _meetings(self, apart: frozenset[frozenset[str]]) -> np.ndarray[tuple[int, int], np.dtype[np.intp]]:
        model = self._model
        body = self._model.geom_bodyid
        names = self._names
        solid = np.flatnonzero((model.geom_contype != 0) | (model.geom_conaffinity != 0))
        moves = model.body_weldid != 0
        moves[self._first :] = False
        pairs = [
            (g, h)
            for i, g in enumerate(solid)
            for h in solid[i + 1 :]
            if body[g] != body[h]
            and (moves[body[g]] or moves[body[h]])
            and body[h] != self._tip
            and (body[h] >= self._first or frozenset((names[body[g]], names[body[h]])) not in apart)
        ]
        return np.array(pairs, dtype=np.intp).reshape(-1, 2)

    def _put(self, body: int, pose: Pose) -> None:
        mocap = self._model.body_mocapid[body]
        self._data.mocap_pos[mocap] = pose.translation
        mujoco.mju_mat2Quat(self._data.mocap_quat[mocap], np.ascontiguousarray(pose.rotation).ravel())

    def _move(self, posture: FloatArray) -> None:
        self._data.qpos[: self._joints] = posture
        mujoco.mj_kinematics(self._model, self._data)

    def _distances(self, pairs: IntArray | None = None) -> FloatArray:
        """Return distances of pairs of shapes, or of all [m]; beyond ``FAR`` those of the bounding spheres."""
        chosen = np.arange(len(self._pairs)) if pairs is None else pairs
        shapes = self._pairs[chosen]
        centres = self._data.geom_xpos[shapes]
        apart: FloatArray = np.linalg.norm(centres[:, 0] - centres[:, 1], axis=1) - self._radii[chosen]
        for place in np.flatnonzero(apart < FAR):
            one, other = shapes[place]
            apart[place] = mujoco.mj_geomDistance(self._model, self._data, one, other, FAR, None)
        if self._pieces is not None:
            farthest = self._margins[chosen] + _PIECES_FAR
            near = np.flatnonzero(self._in_pieces[chosen] & (apart < farthest))
            if len(near):
                self._pieces.move(self._data.qpos[: self._joints])
            for place in near:
                one, other = self._bodies[chosen[place]]
                apart[place] = self._pieces.distance(one, other, farthest[place])
        return apart


class _Pieces:
    """Distances of links by the shapes with which they collide: pieces, hulls and those of links without skin. Mutable.

    MuJoCo's collision detection finds them, because bounding volumes exclude most pairs of pieces.

    Args:
        robot: The robot.
        skin: Its skin.
    """

    def __init__(self, robot: Robot, skin: Skin) -> None:
        self._model = copy(pieces_model(robot, skin))
        self._data = mujoco.MjData(self._model)
        self._solid = self._model.geom_contype != 0

    def move(self, posture: FloatArray) -> None:
        """Move the links to a posture (n,)."""
        self._data.qpos[:] = posture
        mujoco.mj_kinematics(self._model, self._data)

    def distance(self, one: int, other: int, most: float) -> float:
        """Return the distance of two bodies [m], at most ``most``; negative overlaps."""
        model = self._model
        model.geom_contype[:] = self._solid & (model.geom_bodyid == one)
        model.geom_conaffinity[:] = self._solid & (model.geom_bodyid == other)
        model.geom_margin[:] = most
        mujoco.mj_collision(model, self._data)
        return float(self._data.contact.dist.min(initial=most))


def collision_model(robot: Robot, skin: Skin, obstacles: tuple[ObstacleShape, ...]) -> mujoco.MjModel:
    """Return a model of all collision shapes of the robot and of obstacles that move freely; it must not be modified.

    Raises:
        RobotError: MuJoCo rejects the model.

    Cost: see ``Clearance``.
    """
    known = _latest_model(robot, skin)
    model = known.get(obstacles)
    if model is None:
        model = _build_model(robot, skin, obstacles)
        known.clear()
        known[obstacles] = model
    return model


@weak_cache
def _latest_model(_robot: Robot, _skin: Skin) -> dict[tuple[ObstacleShape, ...], mujoco.MjModel]:
    """Return the dictionary that stores the latest model of a robot and a skin by its obstacles."""
    return {}


def _build_model(robot: Robot, skin: Skin, obstacles: tuple[ObstacleShape, ...]) -> mujoco.MjModel:
    spec = hulls_spec(robot, skin)
    for number, shape in enumerate(obstacles):
        _add_obstacle(spec, number, shape)
    return compile_spec(spec, source=robot.source)


def _add_obstacle(spec: mujoco.MjSpec, number: int, shape: ObstacleShape) -> None:
    name = f"{OWN_NAMES}obstacle {number}"
    body = spec.worldbody.add_body(name=name, mocap=True)
    geom = body.add_geom(name=name, contype=1, conaffinity=1)
    match shape:
        case Sphere():
            geom.type = mujoco.mjtGeom.mjGEOM_SPHERE
            geom.size = [shape.radius, 0, 0]
        case Box():
            geom.type = mujoco.mjtGeom.mjGEOM_BOX
            geom.size = list(shape.half)
        case Cylinder():
            geom.type = mujoco.mjtGeom.mjGEOM_CYLINDER
            geom.size = [shape.radius, shape.half, 0]
        case Plane():
            geom.type = mujoco.mjtGeom.mjGEOM_BOX
            geom.size = [10.0, 10.0, 1.0]
            geom.pos = [0.0, 0.0, -1.0]
        case Mesh():
            spec.add_mesh(
                name=name,
                uservert=shape.vertices.ravel().tolist(),
                userface=shape.faces.ravel().tolist(),
                inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX,
            )
            geom.type = mujoco.mjtGeom.mjGEOM_MESH
            geom.meshname = name
        case _:
            assert_never(shape)


def _joint_reaches(model: mujoco.MjModel, bodies: int) -> FloatArray:
    """Return the largest distance of any shape from a joint's axis [m], (joints,), at any posture; 1 for a slide."""
    reach = np.zeros(bodies)
    for geom in range(model.ngeom):
        body = model.geom_bodyid[geom]
        if body < bodies:
            reach[body] = max(reach[body], np.linalg.norm(model.geom_pos[geom]) + model.geom_rbound[geom])
    slides = model.jnt_type == mujoco.mjtJoint.mjJNT_SLIDE
    for body in range(bodies - 1, 0, -1):
        own = range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body])
        travel = sum(float(np.ptp(model.jnt_range[joint])) for joint in own if slides[joint])
        parent = model.body_parentid[body]
        reach[parent] = max(reach[parent], np.linalg.norm(model.body_pos[body]) + travel + reach[body])
    off = np.linalg.norm(model.jnt_pos, axis=1)
    return np.where(slides, 1.0, off + reach[model.jnt_bodyid])


def _upright(axis: FloatArray) -> FloatArray:
    """Return a rotation (3, 3) whose z axis is ``axis`` (3,)."""
    side = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    side /= np.linalg.norm(side)
    return np.column_stack([side, np.cross(axis, side), axis])
