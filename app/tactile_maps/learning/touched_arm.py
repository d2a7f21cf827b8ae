"""The arm that learns, prepared once a process, and the ball that touches it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.scene.object_meshes import make_objects
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.session.session import Session

BALL_RADIUS = 0.03
"""[m]"""
BALL_DEPTH = 0.001
"""How deep a ball that stands still is pressed in at the start [m]."""
PROBE_FORCE = 60.0
"""The most with which a moving ball presses [N]."""


@cache
def prepared_arm(taxels: int) -> PreparedScene:
    """The arm with skin on its forearm, shared by all environments of a process.

    Args:
        taxels: How many; with fewer than about 300 some places between them feel nothing of the ball.

    Cost: 1 s for 1000 taxels, once.
    """
    scene = load_scene("arm")
    return prepare_cached(replace(scene, cover=replace(scene.cover, links=("forearm",), taxels=taxels), stimuli=()))


def session_beside_ball(
    prepared: PreparedScene, at: SurfacePoint, settings: ControlSettings, *, seed: int, way: FloatArray | None = None
) -> Session:
    """A session in which a ball touches a place of the skin.

    Args:
        prepared: Robot, skin and map; its own objects and script are left out.
        at: The place.
        settings: Of the controller.
        seed: Of the sensor.
        way: (k, 2) time [s] and height of the ball's lowest point over the skin [m]; by default it stands still.

    Cost: 40 ms for 1000 taxels.
    """
    skin = prepared.skin
    pose = Configuration(prepared.robot).pose(skin.link(at))
    place = pose.points(skin.position(at))
    out = pose.directions(skin.normal(at))
    heights = np.array([-BALL_DEPTH]) if way is None else way[:, 1]
    centres = place + (BALL_RADIUS + heights)[:, None] * out
    start = (float(centres[0][0]), float(centres[0][1]), float(centres[0][2]))
    ball = ObjectSpec("ball", "sphere", (BALL_RADIUS,), at=start)
    if way is not None:
        rows = tuple(
            (float(time), float(centre[0]), float(centre[1]), float(centre[2]))
            for time, centre in zip(way[:, 0], centres, strict=True)
        )
        ball = ObjectSpec("ball", "probe", (BALL_RADIUS,), at=start, path=rows, mass=0.5, max_force=PROBE_FORCE)
    scene = replace(prepared.scene, objects=(ball,), stimuli=(), motion=(), behaviours=(), seed=seed)
    return Session(replace(prepared, scene=scene, objects=make_objects(scene)), settings=settings)
