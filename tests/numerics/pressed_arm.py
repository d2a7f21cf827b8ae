"""Our arm beside something that stands still and touches its skin, as a session."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from app.control.command import ControlSettings
from app.robots.configuration import Configuration
from app.scene.bodies import make_bodies
from app.scene.objects import ObjectSpec
from app.scene.scene_file import load_scene
from app.session.prepare import Prepared, prepare
from app.session.session import Session
from app.touch.layer import Layer

TICK = 0.005


@cache
def forearm() -> Prepared:
    """Our arm with 400 taxels on its forearm: a pitch of 12 mm."""
    scene = load_scene("arm")
    return prepare(replace(scene, cover=replace(scene.cover, links=("forearm",), taxels=400), stimuli=()))


def place_of(taxel: int, height: float) -> np.ndarray:
    """(3,) the point at a height over a taxel when the arm is at home [m], world frame."""
    prepared = forearm()
    at = prepared.skin.taxel_point(taxel)
    pose = Configuration(prepared.robot).pose("forearm")
    return pose.points(prepared.skin.position(at)) + height * pose.directions(prepared.skin.normal(at))


def beside_ball(
    settings: ControlSettings, *, taxel=150, radius=0.03, stiffness: float | None = None, friction=0.5, leaves=False
) -> Session:
    """A ball pressed 1 mm into a taxel's place at the start.

    Args:
        settings: Of the controller.
        taxel: Where.
        radius: Of the ball [m].
        stiffness: Of the skin's cover [N/m]; as usual by default.
        friction: Of the contact.
        leaves: Whether the ball goes 5 mm away after 2 s, and comes back at 4 s, instead of standing still.
    """
    prepared = forearm()
    here, away = place_of(taxel, radius - 0.001), place_of(taxel, radius + 0.004)
    kind, way = ("probe", ((0.0, *here), (2.0, *here), (2.02, *away), (4.0, *away), (4.1, *here), (60.0, *here)))
    said = {"path": tuple(tuple(map(float, row)) for row in way), "mass": 0.5, "max_force": 60.0} if leaves else {}
    ball = ObjectSpec("ball", kind if leaves else "sphere", (radius,), at=tuple(map(float, here)),
                      friction=friction, **said)  # fmt: skip
    layer = prepared.scene.layer if stiffness is None else Layer(stiffness=stiffness)
    layer = replace(layer, friction=friction)
    scene = replace(prepared.scene, objects=(ball,), task="slide", outputs=("force", "pressure"), layer=layer)
    return Session(replace(prepared, scene=scene, objects=make_bodies(scene)), settings=settings)


class Course:
    """What happened, tick by tick.

    Attributes:
        force: (k,) of the strongest contact [N].
        speed: (k,) of the fastest joint [rad/s].
        error: (k,) from the contact to where the task wants it, on the map [m]; nan without contact.
        body_error: (k,) the same on the body [m].
        why: All that was said to limit the controller.
    """

    def __init__(self, session: Session, seconds: float) -> None:
        self.force, self.speed, self.error, self.body_error = np.zeros((4, round(seconds / TICK)))
        self.why: set[str] = set()
        for k in range(len(self.force)):
            frame = session.tick()
            region = frame.regions[0] if frame.regions else None
            self.force[k] = region.force if region else 0.0
            self.speed[k] = np.abs(frame.velocity).max()
            self.why |= set(frame.why_limited)
            self.error[k] = self.body_error[k] = np.nan
            target = session._controller._keeper.target
            if region and target is not None:
                skin = session.prepared.skin
                self.error[k] = np.linalg.norm(session.map.to_map(target) - region.map_point)
                self.body_error[k] = np.linalg.norm(skin.position(target) - region.point)
