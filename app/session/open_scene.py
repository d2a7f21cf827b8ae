"""Opening a person's own scene file: what only robot, controller and other files can tell is checked with its line."""

from __future__ import annotations

from pathlib import Path

from app.contacts.reading_settings import reading_from
from app.control.behaviour import behaviours_from
from app.control.contact_motion import settings_from
from app.errors import SceneError, TactileMapsError
from app.robots.library import find_robot
from app.scene.bodies import make_bodies
from app.scene.motion import Motion
from app.scene.scene import Scene
from app.scene.scene_file import load_scene, scene_names


def open_scene(name: str) -> Scene:
    """The scene of that name or file, as ``load_scene``; in a file, also names of joints, settings and files are right.

    Raises:
        SceneError: There is none, or it has a mistake; the message names the line and the key.

    Cost: that of loading the robot, for a file; none for a scene that ships with the app.
    """
    return load_scene(name) if name in scene_names() else load_scene(name, check=_check)


def _check(scene: Scene) -> None:
    """Refuse what a session of the scene would refuse, with its place in the scene."""
    try:
        robot = find_robot(scene.robot)
    except TactileMapsError as error:
        raise SceneError(error.problem, place="robot", value=error.value or scene.robot, remedy=error.remedy) from error
    if scene.taxel_file and not Path(scene.taxel_file).is_file():
        remedy = "Name a file relative to the scene's folder"
        raise SceneError("there is no such file", place="taxel_file", value=scene.taxel_file, remedy=remedy)
    for number, link in enumerate(scene.cover.links):
        try:
            robot.link(link)
        except TactileMapsError as error:
            place = f"cover.links.{number}"
            raise SceneError(error.problem, place=place, value=error.value, remedy=error.remedy) from error
    settings_from(dict(scene.control))
    behaviours_from(scene.behaviours)
    reading_from(scene.reading)
    Motion(robot, scene.motion)
    make_bodies(scene)
