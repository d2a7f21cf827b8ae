"""What readings are shown on: the robot, skin and map of a scene."""

from __future__ import annotations

from dataclasses import replace

from tactile_maps.core.file_kinds import FileKind
from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.maps.formats.map_file import load_map
from tactile_maps.scene.scene import Scene
from tactile_maps.session.prepare import PreparedScene, load_robot_and_skin
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.skin.formats.identify import kind_of

MEASURED_TICK = 1e-4
"""Seconds between two ticks of a measured session: finer than any skin is read, so that each reading has its own."""


def prepare_measured(scene: Scene, *, progress: Progress = no_progress) -> PreparedScene:
    """The robot, skin and map of a scene, to show readings on. A map in the scene's file of taxels is kept as it is.

    Args:
        scene: Its objects, script and motion are left out: nothing is simulated.
        progress: Told what is being done and how far it is, 0 to 1.

    Raises:
        TactileMapsError: Any part says what is wrong with it.
    """
    scene = as_measured_scene(scene)
    if kind_of(scene.taxel_file) is not FileKind.MAP:
        return prepare_cached(scene, progress=progress)
    robot, _skin = load_robot_and_skin(scene, progress=progress)  # checks that the robot has the links
    map_ = load_map(scene.taxel_file)
    progress("Done", 1.0)
    return PreparedScene(scene, robot, map_.skin, map_)


def as_measured(prepared: PreparedScene) -> PreparedScene:
    """A scene that was prepared to be simulated, to show readings on."""
    return replace(prepared, scene=as_measured_scene(prepared.scene), objects=())


def as_measured_scene(scene: Scene) -> Scene:
    """The same robot and skin, alone, with the ticks of readings."""
    overrides = {**scene.overrides, "timestep": MEASURED_TICK}
    return replace(scene, tick=MEASURED_TICK, overrides=overrides, objects=(), stimuli=(), motion=())
