"""Transfers of a contact between two random places of a robot's skin, simulated with the whole robot.

A fixed ball touches the first place while the robot is at home; the requested path is at the second place.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import mujoco
import numpy as np

from tactile_maps.control.motion.command import ControlSettings, RegraspState
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.object_meshes import make_objects
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.simulation.model.model_names import body_name
from tests.support.pressed_arm import place_of, pressed_by_ball

RADIUS = 0.03
DEPTH = 0.001
SETTINGS = ControlSettings(
    controller="hybrid", task="follow_path", path_kind="polyline", path_speed=0.002, force_gain=0.015
)
HOLLOW = 0.005
"""A place is drawn only if the hull of its link, which collides, is nearer to it than this [m]."""
LONGEST = 60.0
"""Time limit of a transfer and its return [s]."""
SETTLED = 2.5
"""Observation time after the contact has arrived [s]."""


@cache
def covered(name: str, taxels: int = 400) -> PreparedScene:
    """A shipped scene with fewer taxels and without stimuli."""
    scene = load_scene(name)
    return prepare_cached(replace(scene, cover=replace(scene.cover, taxels=taxels), stimuli=()))


@dataclass(frozen=True)
class Transfer:
    """Result of a transfer.

    Attributes:
        leaves, enters: First and second taxel.
        outcome: ``arrived``, ``refused`` before any motion, ``returned`` to the first place, ``lost`` (neither), or
            ``stopped`` by the safety monitor.
        limit: Reason for the failure.
        planned: Control ticks of planning.
        seconds: Time from the first tick of planning to arrival [s].
        peak: Largest total force on the skin [N].
        force: Force at the second place, mean of the last half second [N].
        course: (k, n) postures from the first tick of planning to arrival.
    """

    leaves: int
    enters: int
    outcome: str
    limit: Limit | None
    planned: int
    seconds: float
    peak: float
    force: float
    course: np.ndarray


def pairs(prepared: PreparedScene, count: int, *, seed: int = 0) -> list[tuple[int, int]]:
    """Random pairs of taxels on different patches that can be touched; the ball touches nothing but the first."""
    lot = np.random.default_rng(seed)
    skin = prepared.skin
    patch_of = np.searchsorted(skin.first, np.arange(len(skin)), side="right") - 1
    found: list[tuple[int, int]] = []
    while len(found) < count:
        first, second = (int(k) for k in lot.integers(0, len(skin), 2))
        if patch_of[first] == patch_of[second] or not (_touchable(prepared, first) and _touchable(prepared, second)):
            continue
        if _alone(prepared, first):
            found.append((first, second))
    return found


def _touchable(prepared: PreparedScene, taxel: int) -> bool:
    """Whether the ball can touch the skin there: hulls are convex, and over hollows they are felt nowhere."""
    return touching_depth(prepared, taxel) > -HOLLOW


def _alone(prepared: PreparedScene, taxel: int) -> bool:
    """Whether a ball that touches there touches only the link of the taxel, with the robot at home."""
    link = prepared.skin.link(prepared.skin.taxel_point(taxel))
    reference = collision_reference(prepared)
    reference.move_ball(place_of(taxel, RADIUS - touching_depth(prepared, taxel), prepared=prepared))
    contacts = reference.contacts(prepared.robot.home)
    return all(link in pair for pair, _ in contacts if "ball" in pair)


@cache
def touching_depth(prepared: PreparedScene, taxel: int) -> float:
    """Return the depth of the ball in the skin [m] when it is 1 mm inside the link's hull; negative over a hollow."""
    link = prepared.skin.link(prepared.skin.taxel_point(taxel))
    low = -0.2
    high = DEPTH
    reference = collision_reference(prepared)
    for _ in range(12):
        depth = (low + high) / 2
        reference.move_ball(place_of(taxel, RADIUS - depth, prepared=prepared))
        deep = max((d for pair, d in reference.contacts(prepared.robot.home) if pair == {link, "ball"}), default=0.0)
        low, high = (low, depth) if deep > DEPTH else (depth, high)
    return high


@cache
def collision_reference(prepared: PreparedScene) -> CollisionReference:
    """Return the cached collision reference of a scene."""
    return CollisionReference(prepared)


class CollisionReference:
    """MuJoCo's own contacts of the robot with itself and the ball, apart from any planner."""

    def __init__(self, prepared: PreparedScene) -> None:
        ball = ObjectSpec("ball", "sphere", (RADIUS,), at=(0.0, 0.0, 50.0))
        objects = make_objects(replace(prepared.scene, objects=(ball,)))
        self._model = assemble(prepared.robot, prepared.skin, Effects(contact="all"), objects=objects)
        self._data = mujoco.MjData(self._model)
        self._ball = body_name(ball)

    def move_ball(self, at: np.ndarray) -> None:
        """Move the ball to a position (3,) in the world [m]."""
        self._model.body_pos[self._model.body(self._ball).id] = at

    def contacts(self, posture: np.ndarray) -> list[tuple[frozenset[str], float]]:
        """Pairs of bodies that touch, and how deep [m]; the ball is called so."""
        data = self._data
        model = self._model
        data.qpos[: len(posture)] = posture
        mujoco.mj_forward(model, data)
        bodies = model.geom_bodyid[data.contact.geom]
        names = [frozenset(self._name(int(b)) for b in pair) for pair in bodies]
        return [(pair, float(-dist)) for pair, dist in zip(names, data.contact.dist, strict=True) if dist < 0]

    def _name(self, body: int) -> str:
        name = self._model.body(body).name
        return "ball" if name == self._ball else name


def settings_to(prepared: PreparedScene, taxel: int) -> ControlSettings:
    """A short path that begins at a taxel."""
    patch = prepared.skin.taxel_point(taxel).patch
    own = prepared.skin.first[patch] + np.arange(len(prepared.skin.patches[patch].taxels))
    points = prepared.map.taxel_points
    away = np.linalg.norm(points[own] - points[taxel], axis=1)
    away[away == 0] = np.inf
    ends = (points[taxel], points[own[away.argmin()]])
    return replace(SETTINGS, path=tuple((float(x), float(y)) for x, y in ends))


def carry(prepared: PreparedScene, leaves: int, enters: int) -> Transfer:
    """Touch at one taxel with a path at the other, until the contact has arrived or it is refused."""
    depth = touching_depth(prepared, leaves)
    session = pressed_by_ball(
        settings_to(prepared, enters), prepared=prepared, taxel=leaves, radius=RADIUS, depth=depth
    )
    tick = session.prepared.scene.tick
    course = list[np.ndarray]()
    forces = list[float]()
    peak = 0.0
    planned = 0
    moved = 0
    done = 0
    outcome = "lost"
    limit = None
    for k in range(round(LONGEST / tick)):
        frame = session.tick()
        state = frame.task.regrasp
        peak = max(peak, session.total_normal_force)
        if state is RegraspState.PLAN:
            planned += 1
        if state is not None:
            course.append(frame.posture.copy())
        if state is not None and state.moves:
            moved = k
        stops = [one for one in frame.why_limited if one.kind.stops]
        failed = [one for one in frame.why_limited if one.kind is LimitKind.REGRASP_FAILED]
        if stops or (failed and not done):
            limit = (stops or failed)[0]
            outcome = "stopped" if stops else "returned" if moved else "refused"
            break
        here = frame.regions[0] if frame.regions else None
        skin = session.map.skin
        place = skin.taxel_point(enters)
        near = (
            here is not None
            and here.at.patch == place.patch
            and np.linalg.norm(here.link_position - skin.position(place)) < 0.04
        )
        if moved and state is None:
            done += 1
            forces.append(here.force if here is not None and near else 0.0)
            if done * tick > SETTLED:
                break
    force = float(np.mean(forces[-round(0.5 / tick) :])) if forces else 0.0
    if done and outcome != "stopped":
        outcome = "arrived" if abs(force - SETTINGS.force_goal) < 0.5 else "lost"
    return Transfer(leaves, enters, outcome, limit, planned, len(course) * tick, peak, force, np.array(course))
