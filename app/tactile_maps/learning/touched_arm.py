"""The arm of the environments, prepared once per process, and the ball that touches it."""

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
"""Radius of the ball [m]."""
BALL_DEPTH = 0.001
"""Initial depth of a fixed ball in the skin [m]."""
PROBE_FORCE = 60.0
"""Maximum force of a moving ball [N]."""


@cache
def prepared_arm(taxels: int) -> PreparedScene:
    """Return the arm with skin on its forearm, shared by all environments of a process.

    Args:
        taxels: Number of taxels; with fewer than about 300, the ball is not detected everywhere between them.

    Cost: 1 s for 1000 taxels, once.
    """
    scene = load_scene("arm")
    return prepare_cached(replace(scene, cover=replace(scene.cover, links=("forearm",), taxels=taxels), stimuli=()))


def touched_session(
    prepared: PreparedScene, at: SurfacePoint, settings: ControlSettings, *, seed: int, track: FloatArray | None = None
) -> Session:
    """Return a session in which a ball touches a place of the skin.

    Args:
        prepared: Robot, skin and map; its own objects and script are ignored.
        at: The touched place.
        settings: Settings of the controller.
        seed: Seed of the sensor.
        track: (k, 2) time [s] and height of the ball's lowest point above the skin [m]; fixed by default.

    Cost: 40 ms for 1000 taxels.
    """
    skin = prepared.skin
    pose = Configuration(prepared.robot).pose(skin.link(at))
    place = pose.points(skin.position(at))
    out = pose.directions(skin.normal(at))
    heights = np.array([-BALL_DEPTH]) if track is None else track[:, 1]
    centres = (place + (BALL_RADIUS + heights)[:, None] * out).tolist()
    start = tuple(centres[0])
    ball = ObjectSpec("ball", "sphere", (BALL_RADIUS,), at=start)
    if track is not None:
        rows = tuple((time, *centre) for time, centre in zip(track[:, 0].tolist(), centres, strict=True))
        ball = ObjectSpec("ball", "probe", (BALL_RADIUS,), at=start, path=rows, mass=0.5, max_force=PROBE_FORCE)
    scene = replace(prepared.scene, objects=(ball,), stimuli=(), motion=(), behaviours=(), seed=seed)
    return Session(replace(prepared, scene=scene, objects=make_objects(scene)), settings=settings)
