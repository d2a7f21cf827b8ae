"""Session of the arm in contact with a ball."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from typing import Any

import mujoco
import numpy as np

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.geometry.surface.closest_point import closest_point
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.mujoco_spec import OWN_NAMES
from tactile_maps.scene.object_meshes import make_objects
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.session import Session
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tests.support.recordings import prepare_once

TICK = 0.005
Act = Callable[[Session], None]
Way = tuple[tuple[float, float], ...]
"""Motion of a ball: (time [s], distance along the skin's normal from its start [m])."""


@cache
def forearm() -> PreparedScene:
    """The shipped arm with 400 taxels on its forearm: a pitch of 12 mm."""
    scene = load_scene("arm")
    return prepare_once(replace(scene, cover=replace(scene.cover, links=("forearm",), taxels=400), stimuli=()))


def place_of(taxel: int, height: float, *, prepared: PreparedScene | None = None) -> np.ndarray:
    """Return the point (3,) at a height above a taxel with the arm at home [m], world frame."""
    prepared = prepared or forearm()
    at = prepared.skin.taxel_point(taxel)
    pose = Configuration(prepared.robot).pose(prepared.skin.link(at))
    return pose.points(prepared.skin.position(at)) + height * pose.directions(prepared.skin.normal(at))


def pressed_by_ball(
    settings: ControlSettings,
    *,
    prepared: PreparedScene | None = None,
    taxel: int = 150,
    radius: float = 0.03,
    depth: float = 0.001,
    friction: float = 0.5,
    leaves: bool = False,
    way: Way = (),
    along: Way = (),
    stiffness: float | None = None,
    layer: Mapping[str, float] | None = None,
    overrides: Mapping[str, Any] | None = None,
    tick: float = TICK,
    seed: int = 0,
    believed: TactileMap | None = None,
) -> Session:
    """Return a session in which a ball is pressed into the skin at the start.

    Args:
        settings: Settings of the controller.
        prepared: Robot, skin and map; by default ``forearm``.
        taxel: Taxel at the contact.
        radius: Radius of the ball [m].
        depth: Initial depth of the ball in the skin [m].
        friction: Friction coefficient of the contact.
        leaves: Whether the ball retreats by 5 mm after 2 s and returns at 4 s, instead of staying fixed.
        way: Motion of the ball along the normal.
        along: Motion along the forearm, first coordinate of the tangent plane, at the times of ``way``.
        stiffness: Stiffness of the cover [N/m], or None for the scene's own.
        layer: Other properties of the cover that differ from the scene's.
        overrides: Effects of the scene.
        tick: Control period [s].
        seed: Seed of the sensor.
        believed: Map of the controller, if it differs from the true one.
    """
    prepared = prepared or forearm()
    if leaves:
        way = ((0.0, 0.0), (2.0, 0.0), (2.02, 0.005), (4.0, 0.005), (4.1, 0.0), (60.0, 0.0))
    here = place_of(taxel, radius - depth, prepared=prepared)
    out = place_of(taxel, 1.0, prepared=prepared) - place_of(taxel, 0.0, prepared=prepared)
    said: dict[str, Any] = {}
    if way:
        side = np.cross(out, np.eye(3)[np.abs(out).argmin()])
        side /= np.linalg.norm(side)
        aside = along or tuple((time, 0.0) for time, _ in way)
        ways = [here + high * out + far * side for (_, high), (_, far) in zip(way, aside, strict=True)]
        rows = [(time, *map(float, at)) for (time, _), at in zip(way, ways, strict=True)]
        said = {"path": tuple(rows), "mass": 0.5, "max_force": 60.0}
    ball = ObjectSpec(
        "ball", "probe" if way else "sphere", (radius,), at=tuple(map(float, here)), friction=friction, **said
    )
    cover = ElasticLayer(
        friction=friction, **{**({} if stiffness is None else {"stiffness": stiffness}), **(layer or {})}
    )
    scene = replace(
        prepared.scene,
        objects=(ball,),
        task="slide",
        outputs=("force", "pressure"),
        layer=cover,
        overrides={**prepared.scene.overrides, **(overrides or {})},
        tick=tick,
        seed=seed,
    )
    return Session(replace(prepared, scene=scene, objects=make_objects(scene)), settings=settings, map_=believed)


def force_off_skin(session: Session) -> float:
    """Return the sum of normal forces of the solver's contacts in which no surface with skin takes part [N]."""
    model = session._simulation._model
    data = session._simulation._data
    force = np.zeros(6)
    total = 0.0
    for index, contact in enumerate(data.contact):
        names = [model.geom(geom).name for geom in contact.geom]
        if not any(name.startswith(f"{OWN_NAMES}skin ") for name in names):
            mujoco.mj_contactForce(model, data, index, force)
            total += float(force[0])
    return total


def nearest(surface: Mesh, point: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the distance [m] of a surface from a point (3,), and its nearest point (3,)."""
    faces, weights, distances = closest_point(surface).query(point)
    return float(distances[0]), weights[0] @ surface.vertices[surface.faces[faces[0]]]


class Course:
    """Record of a session at each tick.

    Attributes:
        force: (k,) force read of the strongest contact [N].
        pressed: (k,) true total force on the skin [N].
        bare: (k,) normal force of all contacts of links without skin [N].
        speed: (k,) speed of the fastest joint [rad/s].
        posture: (k, n) posture.
        error: (k,) distance on the map from the contact to the goal of the task [m]; NaN without contact.
        body_error: (k,) true distance on the body from the ball to that goal, according to the controller's map [m].
        way: (k,) distance covered along the path [m].
        given: (k,) energy given to contacts [J].
        why: All limits of the controller that occurred.
        said: (k,) the limits at each tick.
    """

    def __init__(self, session: Session, seconds: float, *, acts: Mapping[float, Act] | None = None) -> None:
        tick = session.prepared.scene.tick
        count = round(seconds / tick)
        due = {round(time / tick): act for time, act in (acts or {}).items()}
        self.tick = tick
        self.session = session
        self.force, self.pressed, self.bare, self.speed = np.zeros((4, count))
        self.error, self.body_error, self.way, self.given = np.zeros((4, count))
        self.posture = np.zeros((count, len(session.prepared.robot.joints)))
        self.why: set[LimitKind] = set()
        self.said: list[tuple[Limit, ...]] = []
        self._configuration = Configuration(session.prepared.robot)
        for k in range(count):
            if k in due:
                due[k](session)
            self._see(k, session)

    def _see(self, k: int, session: Session) -> None:
        frame = session.tick()
        region = frame.regions[0] if frame.regions else None
        self.force[k] = region.force if region else 0.0
        self.pressed[k] = session.total_normal_force
        self.bare[k] = force_off_skin(session)
        self.speed[k] = np.abs(frame.velocity).max(initial=0.0)
        self.posture[k] = frame.posture
        self.said.append(frame.why_limited)
        self.why |= {limit.kind for limit in frame.why_limited}
        self.error[k] = self.body_error[k] = np.nan
        task = frame.task
        if task is None:
            return
        self.way[k] = task.way
        self.given[k] = task.energy
        if region and task.target is not None:
            self.error[k] = np.linalg.norm(session.map.to_map(task.target) - region.map_point)
        if region and task.target is not None and len(frame.objects):
            skin = session.map.skin
            link = skin.link(task.target)
            self._configuration.update(frame.posture)
            ball = self._configuration.pose(link).inverse.points(frame.objects[0][:3, 3])
            surfaces = [patch.surface for patch in skin.patches if patch.link == link]
            _, touched = min((nearest(surface, ball) for surface in surfaces), key=lambda found: found[0])
            self.body_error[k] = np.linalg.norm(skin.position(task.target) - touched)

    def last(self, values: np.ndarray, seconds: float = 1.0) -> np.ndarray:
        """The end of ``values`` (k,)."""
        return values[-round(seconds / self.tick) :]
