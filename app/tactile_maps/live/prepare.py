"""Preparation of a scene for measured readings: its robot, skin and map."""

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
"""Time step of a measured session [s]: shorter than any skin's sampling period, so that each reading has its own tick.
"""


def prepare_measured(scene: Scene, *, progress: Progress = no_progress) -> PreparedScene:
    """Prepare the robot, skin and map of a scene for measured readings. A map as the scene's only taxel file is
    kept unchanged.

    Args:
        scene: The scene; its objects, script and motion are ignored because nothing is simulated.
        progress: Receives a description and the progress, 0 to 1.

    Raises:
        TactileMapsError: A part of the scene is invalid.
    """
    scene = as_measured_scene(scene)
    if [kind_of(file) for file in scene.taxel_files] != [FileKind.MAP]:
        return prepare_cached(scene, progress=progress)
    robot, _skin = load_robot_and_skin(scene, progress=progress)  # checks that the robot has the links
    map_ = load_map(scene.taxel_files[0])
    progress("Done", 1.0)
    return PreparedScene(scene, robot, map_.skin, map_)


def as_measured(prepared: PreparedScene) -> PreparedScene:
    """Return a scene that was prepared for simulation, for measured readings."""
    return replace(prepared, scene=as_measured_scene(prepared.scene), objects=())


def as_measured_scene(scene: Scene) -> Scene:
    """Return the scene's robot and skin without objects, script and motion, with ``MEASURED_TICK`` as time step."""
    overrides = {**scene.overrides, "timestep": MEASURED_TICK}
    return replace(scene, tick=MEASURED_TICK, overrides=overrides, objects=(), stimuli=(), motion=())
