"""Which scene a command means."""

from __future__ import annotations

import argparse
from dataclasses import replace

from app.core.errors import UsageError
from app.scene.scene import Scene
from app.scene.scene_file import scene_for
from app.session.prepare import open_scene
from app.stimuli.stimulus_file import load_stimuli


def scene_from_arguments(arguments: argparse.Namespace) -> Scene:
    """The scene named by ``SCENE``, ``--scene`` or ``--robot``; the arm's by default.

    With both, the scene is played by the other robot, on links chosen by themselves. With ``--stimuli``, that script
    plays instead of the scene's own.

    Raises:
        UsageError: Two scenes are named.
        SceneError: There is no such scene or script.
    """
    scene, script = _named_scene(arguments), getattr(arguments, "stimuli", None)
    return replace(scene, stimuli=load_stimuli(script)) if script else scene


def _named_scene(arguments: argparse.Namespace) -> Scene:
    first, second = getattr(arguments, "scene_file", None), getattr(arguments, "scene", None)
    if first and second:
        raise UsageError("two scenes are named", value=f"{first}, {second}", remedy="Name one")
    name, robot = first or second, getattr(arguments, "robot", None)
    if name and robot:
        scene = open_scene(name)
        cover = replace(scene.cover, links=())
        return replace(scene, robot=robot, cover=cover, stimuli=scene_for(robot).stimuli, motion=())
    return open_scene(name) if name else scene_for(robot or "arm")
