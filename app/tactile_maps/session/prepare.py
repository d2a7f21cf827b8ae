"""Preparation of a scene: the slow work before a session can start, done once.

``open_scene`` opens a scene file of the user and also checks what depends on the robot, the controller and other files,
so that errors name the line. ``prepare`` loads the robot, fits its skin and builds the map.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from tactile_maps.core.errors import Finding, SceneError, SkinError, TactileMapsError
from tactile_maps.core.progress import Progress, no_progress, part_of_progress
from tactile_maps.core.toml import TomlReader
from tactile_maps.geometry.surface.mesh import join_meshes
from tactile_maps.maps.build import build_map
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.robots.formats.touch_sensors import states_touch_sensors
from tactile_maps.robots.library import load_robot
from tactile_maps.robots.load import robot_of_mesh
from tactile_maps.robots.model.home_posture import check_home
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.motion import Motion
from tactile_maps.scene.object_meshes import make_objects
from tactile_maps.scene.objects import SceneObject
from tactile_maps.scene.scene import Scene, with_package_roots
from tactile_maps.scene.scene_file import load_scene, scene_names
from tactile_maps.skin.fitting.cover import cover_robot, with_covers
from tactile_maps.skin.fitting.grid import add_grids
from tactile_maps.skin.formats.import_skin import NO_ROBOT
from tactile_maps.skin.formats.several_files import TaxelFiles
from tactile_maps.skin.link_pieces import shape_finding
from tactile_maps.skin.model.skin import Skin
from tactile_maps.stimuli.stimulus_player import StimulusPlayer
from tactile_maps.tactile.mechanics.receptive_field import sparse_pads_findings


@dataclass(frozen=True, eq=False)
class PreparedScene:
    """A scene with its robot, skin, map and objects. A plain value that is sent to other processes and recorded.

    Attributes:
        scene: The scene.
        robot: Its robot.
        skin: The skin on the robot's links.
        map: The map of the skin.
        objects: The objects of the scene, in its order.
        findings: Findings about the collision shapes of links, if something in the scene can touch them.

    Raises:
        SkinError: The skin is on a link that the robot does not have.
    """

    scene: Scene
    robot: Robot
    skin: Skin
    map: TactileMap
    objects: tuple[SceneObject, ...] = ()
    findings: tuple[Finding, ...] = ()

    def __post_init__(self) -> None:
        links = [link.name for link in self.robot.links]
        for patch in self.skin.patches:
            if patch.link not in links:
                raise SkinError(
                    "the skin is on a link that the robot does not have",
                    file=self.robot.source,
                    value=patch.link,
                    remedy=f"Use a skin on links of this robot: {', '.join(links)}",
                )


def findings_of(prepared: PreparedScene) -> tuple[Finding, ...]:
    """Return the findings about robot, skin, objects, map, collision shapes, effects and pads, in this order."""
    parts: tuple[Iterable[Finding], ...] = (
        prepared.robot.findings,
        prepared.skin.findings,
        *(body.findings for body in prepared.objects),
        *(chart.findings for chart in prepared.map.charts),
        prepared.findings,
        prepared.scene.decision.warnings,
        pad_findings(prepared),
    )
    return tuple(finding for part in parts for finding in part)


def pad_findings(prepared: PreparedScene) -> list[Finding]:
    """Return the finding about pads that cover little of the skin, if area averaging is on."""
    averaging = prepared.scene.effects.sensor.area_averaging
    return [] if averaging is None else sparse_pads_findings(prepared.skin, averaging.radius)


def no_robot(_robot: Robot) -> None:
    """Ignore the loaded robot."""


def prepare(
    scene: Scene, *, progress: Progress = no_progress, loaded: Callable[[Robot], None] = no_robot
) -> PreparedScene:
    """Create the objects, load the robot, fit its skin and build the map.

    Args:
        scene: The scene.
        progress: Receives the current step and the completed share, 0 to 1; may raise to cancel.
        loaded: Receives the robot before its skin is fitted.

    Raises:
        TactileMapsError: The scene, its objects, the robot or the skin is invalid.

    Example:
        >>> scene = tm.Scene("touch", robot="arm", cover=tm.CoverSpec(links=("hand",), taxels=40))
        >>> prepared = tm.prepare(scene)
        >>> len(prepared.skin), prepared.map.taxel_points.shape
        (40, (40, 2))

    Cost: 2 to 5 s for 1000 taxels.
    """
    objects = make_objects(scene)  # first, because it is fast and may fail
    robot, skin = load_robot_and_skin(scene, progress=progress, loaded=loaded)
    map_ = build_map(skin, progress=part_of_progress(progress, 0.4, 1.0))
    started = check_start(scene, robot, skin, objects)
    return PreparedScene(scene, robot, skin, map_, started, check_shapes(scene, robot, skin))


def check_start(scene: Scene, robot: Robot, skin: Skin, objects: Sequence[SceneObject]) -> tuple[SceneObject, ...]:
    """Return the objects with a finding for each that overlaps the robot at the start, see ``with_overlaps``."""
    if not objects:
        return ()
    from tactile_maps.simulation.start_overlaps import with_overlaps  # not needed for maps and skins alone

    return with_overlaps(robot, skin, scene.effects, objects)


def check_shapes(scene: Scene, robot: Robot, skin: Skin) -> tuple[Finding, ...]:
    """Return the findings about the collision shapes of links; none if nothing in the scene can touch them.

    Cost: 10 ms a link, and 1 ms for each of its convex pieces; making the pieces takes longer, see ``link_pieces``.
    """
    from tactile_maps.simulation.model.contact_pairs import (  # not needed for maps and skins alone
        collides_by_shapes,
    )

    if not collides_by_shapes(scene.objects, scene.effects):
        return ()
    found = (shape_finding(robot, skin, link) for link in skin.links)
    return tuple(finding for finding in found if finding is not None)


def load_robot_and_skin(
    scene: Scene, *, progress: Progress = no_progress, loaded: Callable[[Robot], None] = no_robot
) -> tuple[Robot, Skin]:
    """Load the scene's robot and fit its skin, without a map.

    Args:
        scene: The scene.
        progress: Receives progress as in ``prepare``, up to 0.4.
        loaded: Receives the robot before its skin is fitted; not called without a robot.

    Raises:
        TactileMapsError: The robot cannot be loaded or the skin cannot be fitted.
    """
    if scene.robot == NO_ROBOT:
        progress("Importing taxels", 0.1)
        robot, alone = _skin_alone(scene)
        return robot, add_grids(robot, alone, scene.grids, thickness=scene.cover.thickness)
    progress(f"Loading {scene.robot}", 0.0)
    robot = load_robot_of(scene)
    loaded(robot)
    return robot, fit_skin(scene, robot, progress=progress)


def fit_skin(scene: Scene, robot: Robot, *, progress: Progress = no_progress) -> Skin:
    """Fit the skin of a scene to its loaded robot; arguments and errors as in ``load_robot_and_skin``."""
    skin: Skin | None = None
    if scene.taxel_files:
        progress("Importing taxels", 0.1)
        links = scene.cover.links
        thickness = scene.cover.thickness
        files = TaxelFiles(scene.taxel_files, package_roots=scene.package_roots)
        skin = files.skin(robot, links=links, thickness=thickness)
    elif scene.cover.links or not scene.grids:
        skin = cover_robot(robot, scene.cover, progress=part_of_progress(progress, 0.1, 0.3))
        skin = replace(skin, findings=(*skin.findings, *_unused_sensors(scene)))
    progress("Placing grids", 0.3)
    skin = add_grids(robot, skin, scene.grids, thickness=scene.cover.thickness)
    more = [cover_robot(robot, cover, progress=part_of_progress(progress, 0.3, 0.4)) for cover in scene.more_covers]
    return with_covers(skin, more) if more else skin


def _unused_sensors(scene: Scene) -> list[Finding]:
    """Return a finding if the robot's file states touch sensors, which a cover replaces."""
    path = Path(scene.robot)
    roots = [Path(root) for root in scene.package_roots]
    if path.suffix != ".xml" or not states_touch_sensors(path, package_roots=roots):
        return []
    what = "its touch sensors are not used, since the skin covers it; import the file as taxels to use them"
    return [Finding("touch-sensors", str(path), what)]


def _skin_alone(scene: Scene) -> tuple[Robot, Skin]:
    """Return the skin of the scene's files, and a body of its shape that is fixed in the world."""
    _need_taxel_file(scene)
    skin = TaxelFiles(scene.taxel_files).skin(links=scene.cover.links)
    if len(skin.links) > 1:
        remedy = "Open it with the robot that has these links, or choose one link"
        problem = "the taxels of several links need a robot"
        raise SkinError(problem, file=scene.taxel_files[0], value=", ".join(skin.links), remedy=remedy)
    mesh = join_meshes([patch.surface for patch in skin.patches])
    first = scene.taxel_files[0]
    robot = robot_of_mesh(mesh, name=Path(first).stem, source=first, link=skin.links[0])
    check_home(scene.home, robot.joints, source=scene.name)
    return robot, skin


def _need_taxel_file(scene: Scene) -> None:
    if not scene.taxel_files:
        remedy = "Name a robot, or the file of a skin as taxel_file"
        raise SceneError("the scene names neither a robot nor a skin", file=scene.name, place="robot", remedy=remedy)


def load_robot_of(scene: Scene) -> Robot:
    """Load the robot that a scene names; raises the errors of ``load_robot``."""
    return load_robot(scene.robot, package_roots=scene.package_roots, home=scene.home)


def open_scene(
    name: str,
    *,
    package_roots: Sequence[str] = (),
    load: Callable[[Scene], Robot] = load_robot_of,
) -> Scene:
    """Load the scene of that name or file; in a file, also check joints, settings and further files.

    Args:
        name: Name of a shipped scene, or a path.
        package_roots: Package roots in addition to those of the scene.
        load: Loads the robot of a scene, against which the scene is checked.

    Raises:
        SceneError: The scene does not exist or is invalid; the message names the line and the key.

    Cost: that of loading the robot, for a file; none for a shipped scene.
    """
    if name in scene_names():
        return load_scene(name)
    return with_package_roots(
        load_scene(name, check=lambda scene: _check(with_package_roots(scene, package_roots), load)), package_roots
    )


def check_stimuli(prepared: PreparedScene, name: str) -> None:
    """Raise the error that a session would raise about the stimuli of a scene, with its place in the file.

    ``open_scene`` cannot check them, because the patches are known only after the skin was fitted.

    Args:
        prepared: The scene with its skin.
        name: Name of the shipped scene, or the file with the stimuli: a scene or a script.

    Raises:
        SceneError: A patch is unknown, or a place is not on the skin; the message names the line and the key.
    """
    scene = prepared.scene
    try:
        StimulusPlayer(prepared.skin, scene.stimuli, tick=scene.tick)
    except SceneError:
        path = Path(name)
        if name in scene_names() or not path.is_file():
            raise
        document = TomlReader(path.read_text(encoding="utf8"), file=name)
        with document.locating_errors(document.raw, ()):
            raise


def _check(scene: Scene, load: Callable[[Scene], Robot]) -> None:
    """Raise the errors that a session of the scene would raise, with their place in the scene."""
    from tactile_maps.contacts.pipeline import reading_from  # 0.2 s that shipped scenes do not need
    from tactile_maps.control.behaviours import behaviours_from
    from tactile_maps.control.controller_registry import settings_from

    robot = _checked_robot(scene, load)
    links = {f"grids.{number}.link": grid.link for number, grid in enumerate(scene.grids)}
    if scene.taxel_files:
        _check_taxels(scene, robot)
    else:
        links = {f"cover.links.{number}": link for number, link in enumerate(scene.cover.links)} | links
    for covers, cover in enumerate(scene.more_covers):
        links |= {f"more_covers.{covers}.links.{number}": link for number, link in enumerate(cover.links)}
    for place, link in links.items():
        try:
            if robot is not None:
                robot.link(link)
        except TactileMapsError as error:
            raise error.at(kind=SceneError, place=place) from error
    settings_from(dict(scene.control))
    behaviours_from(scene.behaviours)
    reading_from(scene.reading)
    Motion(load_robot_and_skin(scene)[0] if robot is None else robot, scene.motion)
    make_objects(scene)


def _checked_robot(scene: Scene, load: Callable[[Scene], Robot]) -> Robot | None:
    if scene.robot == NO_ROBOT:
        _need_taxel_file(scene)
        return None
    try:
        return load(scene)
    except TactileMapsError as error:
        place = error.place if error.place is not None and error.place.startswith("home.") else "robot"
        raise error.at(kind=SceneError, place=place, value=error.value or scene.robot) from error


def _check_taxels(scene: Scene, robot: Robot | None) -> None:
    try:
        TaxelFiles(scene.taxel_files).check_links(robot, scene.cover.links)
    except TactileMapsError as error:
        place = ", ".join(str(part) for part in (error.file, error.place) if part)
        problem = error.problem
        remedy = (error.remedy or "").replace("Choose the link", "Name as cover.links the link")
        raise error.at(kind=SceneError, place="taxel_file", problem=f"{place}: {problem}", remedy=remedy) from error
