"""Everything a scene needs, made once: the slow work before a session can start."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from app.maps.build import build_map
from app.maps.tactile_map import TactileMap
from app.robots.library import find_robot
from app.robots.robot import Robot
from app.scene.bodies import make_bodies
from app.scene.objects import Body
from app.scene.scene import Scene
from app.skin.cover import cover
from app.skin.exchange.icub import import_icub
from app.skin.skin import Skin

Progress = Callable[[str, float], None]


@dataclass(frozen=True, eq=False)
class Prepared:
    """A scene made real. A plain value: it crosses processes and is kept in recordings.

    Attributes:
        scene: What was made.
        robot: Which robot.
        skin: On its links.
        map: Of the skin.
        objects: The scene's, in its order.
    """

    scene: Scene
    robot: Robot
    skin: Skin
    map: TactileMap
    objects: tuple[Body, ...] = ()


def _silent(_text: str, _fraction: float) -> None:
    """No progress wanted."""


def prepare(scene: Scene, *, progress: Progress = _silent) -> Prepared:
    """Make the objects, load the robot, put on its skin, make the map.

    Args:
        scene: What to make.
        progress: Told what is being done and how far it is, 0 to 1; may raise to cancel.

    Raises:
        TactileMapsError: Any part says what is wrong with the scene, its objects, the robot or the skin.

    Cost: 2 to 5 s for 1000 taxels.
    """
    objects = make_bodies(scene)  # first, since it costs nothing and may fail
    robot, skin = robot_in_skin(scene, progress=progress)
    map_ = build_map(skin, progress=lambda text, done: progress(text, 0.4 + 0.6 * done))
    return Prepared(scene, robot, skin, map_, objects)


def robot_in_skin(scene: Scene, *, progress: Progress = _silent) -> tuple[Robot, Skin]:
    """The scene's robot and what it wears, without a map.

    Args:
        scene: What to make.
        progress: As for ``prepare``; ends at 0.4.

    Raises:
        TactileMapsError: Robot or skin cannot be made.
    """
    progress(f"Loading {scene.robot}", 0.0)
    robot = find_robot(scene.robot)
    if scene.taxel_file:
        progress("Importing taxels", 0.1)
        skin = import_icub(robot, scene.taxel_file, thickness=scene.cover.thickness)
    else:
        skin = cover(robot, scene.cover, progress=lambda text, done: progress(text, 0.1 + 0.3 * done))
    return robot, skin
