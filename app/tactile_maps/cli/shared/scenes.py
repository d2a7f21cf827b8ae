"""Scene that a command uses."""

from __future__ import annotations

import argparse
import os
from dataclasses import replace

from tactile_maps.cli.shared.robot_options import home_of, package_roots
from tactile_maps.cli.shared.unused_options import refuse_with_input
from tactile_maps.core.errors import SkinError, UsageError
from tactile_maps.core.file_kinds import FileKind
from tactile_maps.scene.scene import Scene, with_package_roots
from tactile_maps.scene.scene_file import scene_for, scene_for_taxels, scene_names, with_taxels
from tactile_maps.session.prepare import open_scene
from tactile_maps.session.prepared_cache import load_robot_cached
from tactile_maps.skin.formats.identify import kind_of
from tactile_maps.skin.formats.import_skin import NO_ROBOT
from tactile_maps.stimuli.stimulus_file import load_stimuli


def scene_from_arguments(arguments: argparse.Namespace) -> Scene:
    """Return the scene named by ``SCENE``, ``--scene`` or ``--robot``; by default that of the arm.

    With both a scene and a robot, the robot replaces that of the scene, on its own links. ``--skin`` puts the taxels
    of files on the robot; alone it also selects the robot. ``--stimuli`` replaces the script of the scene.

    Raises:
        UsageError: Two scenes are named, or a link without a skin.
        SceneError: The scene or script does not exist.
    """
    scene = _skinned_scene(arguments)
    script = getattr(arguments, "stimuli", None)
    scene = with_home(with_package_roots(scene, package_roots(arguments)), arguments)
    return replace(scene, stimuli=load_stimuli(script)) if script else scene


def with_home(scene: Scene, arguments: argparse.Namespace) -> Scene:
    """Return the scene with the positions of ``--home``; other joints keep those of the scene."""
    return replace(scene, home={**scene.home, **home_of(arguments)})


def _skinned_scene(arguments: argparse.Namespace) -> Scene:
    """Return the scene with the taxels of each ``--skin``."""
    paths = getattr(arguments, "skin", None)
    link = getattr(arguments, "link", None)
    if not paths:
        if link:
            raise UsageError("--link requires a skin file", value=link, remedy="Add --skin FILE")
        return _named_scene(arguments)
    named = any(getattr(arguments, name, None) for name in ("scene_file", "scene", "robot"))
    bare = getattr(arguments, "robot", None) == NO_ROBOT
    for path in paths:
        if not os.path.exists(path):
            raise SkinError("the file does not exist", file=path)
    if link and len(paths) == 1 and kind_of(paths[0]) in (FileKind.SKIN, FileKind.MAP):
        purpose = "It names the link that carries taxels, and this skin states it"
        refuse_with_input(arguments, ["--link"], "skin", paths[0], purpose=purpose)
    scene = _named_scene(arguments) if named and not bare else scene_for_taxels(*paths)
    return with_taxels(replace(scene, robot=NO_ROBOT) if bare else scene, paths, links=(link,) if link else ())


def _named_scene(arguments: argparse.Namespace) -> Scene:
    first = getattr(arguments, "scene_file", None)
    second = getattr(arguments, "scene", None)
    if first and second:
        raise UsageError("two scenes are named", value=f"{first}, {second}", remedy="Name one")
    name = first or second
    robot = getattr(arguments, "robot", None)
    if name and is_skin_folder(name):
        return with_taxels(scene_for(robot), (name,)) if robot else scene_for_taxels(name)
    if name and robot:
        scene = open_scene(name, package_roots=package_roots(arguments), load=load_robot_cached)
        cover = replace(scene.cover, links=(), bare=())
        scene = replace(scene, cover=cover, more_covers=())
        return replace(scene, robot=robot, stimuli=scene_for(robot).stimuli, motion=(), home={})
    return (
        open_scene(name, package_roots=package_roots(arguments), load=load_robot_cached)
        if name
        else scene_for(robot or "arm")
    )


def is_skin_folder(name: str) -> bool:
    """Return whether ``name`` is a folder of a skin's files, which selects the scene of the usual robot.

    Raises:
        UsageError: It is a folder without files of a skin.
    """
    if not os.path.isdir(name) or name in scene_names():
        return False
    if kind_of(name) is not FileKind.TAXELS:
        remedy = "Give a scene, or a folder of a skin's positions files (*.txt)"
        raise UsageError("a folder is not a scene", file=name, remedy=remedy)
    return True
