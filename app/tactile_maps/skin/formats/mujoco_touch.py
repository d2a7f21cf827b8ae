"""MuJoCo's own touch sensors as a skin, and a skin as MuJoCo's sensors: sites with ``<touch>`` sensors in MJCF.

A taxel's id is the number of its sensor among the touch sensors of the file, its name the sensor's, and the number of
its cell or vertex its channel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, fromstring, indent, tostring

import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import Finding, SkinError
from tactile_maps.core.files import make_output_folder, write_atomically
from tactile_maps.robots.formats.touch_sensors import TouchSensor, read_touch_sensors
from tactile_maps.robots.model.mujoco_spec import compile_spec, robot_spec, spec_text
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.fitting.fit import place_taxels
from tactile_maps.skin.model.skin import Skin, merge_skins
from tactile_maps.skin.model.taxel_set import MAX_TAXELS, TaxelSet

_MOST_RAY_TESTS = 50_000_000
_NEAR = 1e-7  # m, between places that are one
# m, of a lone taxel's site; of any
_RADIUS = 5e-3
_LEAST_RADIUS = 1e-4


def skin_of_touch_sensors(
    robot: Robot, path: Path, *, links: Sequence[str] = (), thickness: float = 0.003, package_roots: Sequence[Path] = ()
) -> Skin:
    """The skin whose taxels are the touch sensors that the MJCF file of ``robot`` states.

    Args:
        robot: As it was read from the file.
        path: The file.
        links: Those whose sensors are wanted; empty for all.
        thickness: Of the cover over a link's mesh [m].
        package_roots: Further folders the file's own files may lie in.

    Raises:
        SkinError: None of its sensors can be a taxel.
        RobotError: The file cannot be read.
    """
    sensors, findings = read_touch_sensors(path, package_roots=package_roots)
    skins = list[Skin]()
    notes = list(findings)
    for taxels in touch_taxels(robot, sensors, notes, file=path):
        if links and taxels.link not in links:
            continue
        try:
            skins.append(_fitted(robot, taxels, thickness, path))
        except SkinError as error:
            note = f"its touch sensors are left out: {error.problem}"
            notes.append(Finding("touch-sensor", str(taxels.link), note, len(taxels)))
    if not skins:
        problem = "none of its touch sensors can be a taxel"
        raise SkinError(problem, file=path, value="; ".join(note.action for note in notes) or None)
    skin = merge_skins(skins)
    return replace(skin, findings=(*notes, *skin.findings))


def _fitted(robot: Robot, taxels: TaxelSet, thickness: float, path: Path) -> Skin:
    return place_taxels(robot, str(taxels.link), taxels, thickness=thickness, file=path)


def touch_taxels(
    robot: Robot, sensors: Sequence[TouchSensor], notes: list[Finding], *, file: Path
) -> tuple[TaxelSet, ...]:
    """The taxels of ``sensors``, one set a link, in the file's order.

    Args:
        robot: Its links' meshes are what a grid looks at.
        sensors: Of the file.
        notes: Where sensors on bodies that are no link, and taxels at one place, are told.
        file: For errors.

    Raises:
        SkinError: There are more than 100,000, or their rays would take too long.
    """
    if sum(len(sensor.origins) for sensor in sensors) > MAX_TAXELS:
        raise SkinError(f"the file has more than {MAX_TAXELS} taxels", file=file)
    _check_rays(robot, sensors, file)
    by_link: dict[str, list[tuple[int, TouchSensor]]] = {}
    for number, sensor in enumerate(sensors):
        by_link.setdefault(sensor.link, []).append((number, sensor))
    away = [sensor.name for link, own in by_link.items() if link not in robot.link_index for _, sensor in own]
    if away:
        note = "left out: its body is no link of the robot"
        notes.append(Finding("touch-sensor", ", ".join(away), note, len(away)))
    return tuple(_joined(robot, link, own) for link, own in by_link.items() if link in robot.link_index)


def _check_rays(robot: Robot, sensors: Sequence[TouchSensor], file: Path) -> None:
    """Each cell of a grid is held against each triangle of its link."""
    tests = 0
    for sensor in sensors:
        mesh = robot.link(sensor.link).mesh if sensor.link in robot.link_index else None
        if sensor.directions is not None and mesh is not None:
            tests += len(sensor.directions) * len(mesh.faces)
    if tests > _MOST_RAY_TESTS:
        remedy = "Simplify the link's mesh, or give the grids fewer cells"
        problem = "touch grids with so many cells on so fine meshes take too long"
        raise SkinError(problem, file=file, value=f"{tests} pairs of cell and triangle", remedy=remedy)


def _joined(robot: Robot, link: str, sensors: Sequence[tuple[int, TouchSensor]]) -> TaxelSet:
    carrier = robot.link(link)
    mesh = None if carrier.missing else carrier.mesh
    positions = np.concatenate([sensor.places(mesh) for _, sensor in sensors])
    ids = np.concatenate([np.full(len(sensor.origins), number) for number, sensor in sensors])
    channels = np.concatenate([np.arange(len(sensor.origins)) for _, sensor in sensors])
    _, first = np.unique(np.round(positions / _NEAR), axis=0, return_index=True)
    first.sort()
    sensor_names = [sensor.name for _, sensor in sensors for _ in range(len(sensor.origins))]
    names = f"taxels {ids[0]} to {ids[-1]}: {', '.join(sensor.name for _, sensor in sensors)}"
    findings = [Finding("touch-sensor", link, names, len(sensors))]
    if len(first) < len(positions):
        lost = np.setdiff1d(np.arange(len(positions)), first)
        who = ", ".join(dict.fromkeys(sensor_names[row] for row in lost.tolist()))
        findings.append(
            Finding("duplicate-taxel", link, f"{who}: left out, another sensor is at the same place", len(lost))
        )
    return TaxelSet(link, link, np.arange(len(first)), positions[first], ids=ids[first],
                    channels=channels[first] if channels.any() else None,
                    names=tuple(sensor_names[row] for row in first.tolist()), findings=tuple(findings))  # fmt: skip


def write_touch_sensors(skin: Skin, robot: Robot, path: str | Path) -> None:
    """Write ``robot`` as MJCF with a site and a ``<touch>`` sensor for each taxel of ``skin``; meshes lie beside it.

    Each site is a ball around the taxel that reaches half way to its nearest neighbour. MuJoCo counts a contact for the
    site that its normal meets, so that one on the link below the skin counts too. It compiles the file as it is; the
    sensor ``taxel_<i>`` reads the normal force [N] on taxel i of the skin.

    Args:
        skin: On links of the robot.
        robot: Wears it.
        path: Of the MJCF file; the meshes go into the folder ``mesh_folder(path)``.

    Raises:
        SkinError: The skin lies on no link of the robot, or a file cannot be written.
        RobotError: MuJoCo refuses the robot.
    """
    target = Path(path)
    folder = mesh_folder(target)
    spec = robot_spec(robot)  # its text has no defaults that a site could inherit
    compile_spec(spec, source=robot.source)
    root = fromstring(spec_text(spec, source=robot.source))
    bodies = {body.get("name"): body for body in root.iter("body")}
    sensors = SubElement(root, "sensor")
    number = 0
    for patch in skin.patches:
        body = bodies.get(patch.link)
        if body is None:
            raise SkinError("the robot has no link of the skin's", file=target, value=patch.link)
        positions = patch.taxels.positions
        radii = _radii(patch.taxels.positions)
        for position, radius in zip(positions.tolist(), radii.tolist(), strict=True):
            _add_sensor(body, sensors, number, position, radius)
            number += 1
    if robot.assets:
        _mesh_folder(root, folder)
    for name, data in robot.assets.items():
        write_atomically(folder / name, data, error=SkinError)
    indent(root)
    write_atomically(target, tostring(root, encoding="utf-8", xml_declaration=True), error=SkinError)


def mesh_folder(model: Path) -> Path:
    """Return the folder of the meshes of a model file: ``<name>_meshes`` next to it."""
    return model.with_name(f"{model.stem}_meshes")


def _mesh_folder(root: Element, folder: Path) -> None:
    """Make the folder, and say in the model that its meshes lie there."""
    compiler = root.find("compiler")
    (SubElement(root, "compiler") if compiler is None else compiler).set("meshdir", folder.name)
    make_output_folder(folder, error=SkinError)


def _add_sensor(body: Element, sensors: Element, number: int, position: list[float], radius: float) -> None:
    name = f"taxel_{number}"
    place = " ".join(f"{value:.9g}" for value in position)
    SubElement(body, "site", name=name, pos=place, size=f"{radius:.9g}", group="4")
    SubElement(sensors, "touch", name=name, site=name)


def _radii(positions: FloatArray) -> FloatArray:
    """(n,) [m] half way to each taxel's nearest neighbour."""
    if len(positions) < 2:
        return np.full(len(positions), _RADIUS)
    apart, _ = cKDTree(positions).query(positions, k=2)
    return np.maximum(0.5 * apart[:, 1], _LEAST_RADIUS)
