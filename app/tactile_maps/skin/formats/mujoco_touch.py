"""Touch sensors of MuJoCo as a skin, and a skin as sensors: sites with ``<touch>`` or ``<contact>`` sensors in MJCF.

The id of a taxel is the number of its sensor among the touch sensors of the file, its name is that of the sensor, and
its channel is the number of its cell or vertex.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, fromstring, indent, tostring

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import Finding, SkinError, add_finding
from tactile_maps.core.files import make_output_folder, write_atomically
from tactile_maps.geometry.surface.points import nearest_others
from tactile_maps.robots.formats.touch_sensors import TouchSensor, read_touch_sensors
from tactile_maps.robots.model.mujoco_spec import compile_spec, robot_spec, spec_text
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.fitting.measured_taxels import place_taxels
from tactile_maps.skin.model.skin import Skin, merge_skins
from tactile_maps.skin.model.taxel_axes import stated_frames, unit_rows
from tactile_maps.skin.model.taxel_set import MAX_TAXELS, TaxelSet

_MOST_RAY_TESTS = 50_000_000
_NEAR = 1e-7
"""Distance [m] below which sensors are at the same position."""
_RADIUS = 5e-3
"""Radius of the site of a single taxel [m]."""
_LEAST_RADIUS = 1e-4
"""Smallest radius of a site [m]."""
_HALF_HEIGHT = 5e-3
"""Half height of the site of a taxel with three axes [m]: contacts are on the link below the cover."""


def skin_of_touch_sensors(
    robot: Robot, path: Path, *, links: Sequence[str] = (), thickness: float = 0.003, package_roots: Sequence[Path] = ()
) -> Skin:
    """Return the skin whose taxels are the touch sensors in the MJCF file of ``robot``.

    Args:
        robot: Robot in the file.
        path: The file.
        links: Links whose sensors are used; empty for all.
        thickness: Thickness of the cover over the mesh of a link [m].
        package_roots: Further folders that may contain files that the file names.

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
            skins.append(place_taxels(robot, str(taxels.link), taxels, thickness=thickness, file=path))
        except SkinError as error:
            note = f"its touch sensors are left out: {error.problem}"
            notes.append(Finding("touch-sensor", str(taxels.link), note, len(taxels)))
    if not skins:
        problem = "none of its touch sensors can be a taxel"
        raise SkinError(problem, file=path, value="; ".join(note.action for note in notes) or None)
    skin = merge_skins(skins)
    return replace(skin, findings=(*notes, *skin.findings))


def touch_taxels(
    robot: Robot, sensors: Sequence[TouchSensor], notes: list[Finding], *, file: Path
) -> tuple[TaxelSet, ...]:
    """Return the taxels of ``sensors``, one set for each link, in the order of the file.

    Args:
        robot: Robot with the meshes that a touch grid senses.
        sensors: Sensors of the file.
        notes: Receives findings of sensors on bodies that are not links.
        file: The file, for errors.

    Raises:
        SkinError: There are more than 100,000 taxels, or their rays would take too long.
    """
    if sum(len(sensor.origins) for sensor in sensors) > MAX_TAXELS:
        raise SkinError(f"the file has more than {MAX_TAXELS} taxels", file=file)
    _check_rays(robot, sensors, file)
    by_link: dict[str, list[tuple[int, TouchSensor]]] = {}
    for number, sensor in enumerate(sensors):
        by_link.setdefault(sensor.link, []).append((number, sensor))
    foreign = [sensor.name for sensor in sensors if sensor.link not in robot.link_index]
    note = "left out: its body is not a link of the robot"
    add_finding(notes, "touch-sensor", ", ".join(foreign), note, len(foreign))
    return tuple(_joined(robot, link, own) for link, own in by_link.items() if link in robot.link_index)


def _check_rays(robot: Robot, sensors: Sequence[TouchSensor], file: Path) -> None:
    """Raise an error if the rays of all cells of grids against all triangles of their links take too long."""
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
    slips = [sensor.name for _, sensor in sensors if sensor.kind == "tactile" and sensor.t1 is not None]
    action = "channels 1 and 2 of <tactile> are speeds of slip along t1 and t2, not tractions"
    add_finding(findings, "slip-channels", ", ".join(slips), action, len(slips))
    axes = np.concatenate([np.full(len(one.origins), 1 if one.t1 is None else 3) for _, one in sensors])
    tangents = np.concatenate([_tangents(one, findings) for _, one in sensors])
    lost = np.setdiff1d(np.arange(len(positions)), first)
    left_out = ", ".join(dict.fromkeys(sensor_names[row] for row in lost.tolist()))
    action = f"{left_out}: left out, another sensor is at the same position"
    add_finding(findings, "duplicate-taxel", link, action, len(lost))
    return TaxelSet(
        link,
        link,
        np.arange(len(first)),
        positions[first],
        ids=ids[first],
        channels=channels[first] if channels.any() else None,
        names=tuple(sensor_names[row] for row in first.tolist()),
        axes=axes[first],
        tangents=tangents[first],
        findings=tuple(findings),
    )


def _tangents(sensor: TouchSensor, findings: list[Finding]) -> FloatArray:
    """Return the first tangents (n, 3) of the taxels of a sensor; NaN without.

    Raises:
        SkinError: A frame is left-handed or not orthonormal.
    """
    tangents = stated_frames(
        np.full(len(sensor.origins), 3),
        sensor.t1,
        sensor.t2,
        None if sensor.normals is None else unit_rows(sensor.normals),
        where=sensor.name,
        findings=findings,
        place=lambda row: f"sensor {sensor.name}, taxel {row}",
    )
    return np.full((len(sensor.origins), 3), np.nan) if tangents is None else tangents


def write_touch_sensors(skin: Skin, robot: Robot, path: str | Path, *, frames: FloatArray | None = None) -> None:
    """Write ``robot`` as MJCF with a site and a sensor for each taxel of ``skin``, and its meshes.

    Each site reaches half way to the nearest neighbour of its taxel. The file can be compiled unchanged; the sensor
    ``taxel_<i>`` measures taxel i of the skin:

    - One axis: a sphere with a ``<touch>`` sensor, the normal force [N]. MuJoCo assigns a contact to the site that its
      normal intersects, so that contacts with the link below the skin count too.
    - Three axes: a cylinder along the normal with a ``<contact>`` sensor, the sum of the forces [N] on the skin of all
      contacts in it, as a vector in the world frame. Its components along the axes of the site are the force along t1,
      along t2, and minus the normal force.

    Args:
        skin: Skin on links of the robot.
        robot: The robot.
        path: The MJCF file; meshes are written to the folder ``mesh_folder(path)``.
        frames: (taxels, 3, 3) rows t1, t2 and outward normal, link frame, see ``taxel_frames``; for three axes.

    Raises:
        SkinError: The skin is on a link that the robot does not have, frames are missing, or a file cannot be written.
        RobotError: MuJoCo rejects the robot.
    """
    target = Path(path)
    if frames is None and skin.three_axis.any():
        remedy = "Pass taxel_frames(map)"
        raise SkinError("taxels with three axes need frames", file=target, remedy=remedy)
    folder = mesh_folder(target)
    spec = robot_spec(robot)  # without defaults that a site could inherit
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
        radii = np.full(len(positions), _RADIUS)
        if len(positions) > 1:
            radii = np.maximum(0.5 * nearest_others(positions, 1)[0][:, 0], _LEAST_RADIUS)
        for position, radius in zip(positions.tolist(), radii.tolist(), strict=True):
            frame = frames[number] if frames is not None and skin.three_axis[number] else None
            _add_sensor(body, sensors, number, position, radius, frame)
            number += 1
    if robot.assets:
        compiler = root.find("compiler")
        (SubElement(root, "compiler") if compiler is None else compiler).set("meshdir", folder.name)
        make_output_folder(folder, error=SkinError)
    for name, data in robot.assets.items():
        write_atomically(folder / name, data, error=SkinError)
    indent(root)
    write_atomically(target, tostring(root, encoding="utf-8", xml_declaration=True), error=SkinError)


def mesh_folder(model: Path) -> Path:
    """Return the folder of the meshes of a model file: ``<name>_meshes`` next to it."""
    return model.with_name(f"{model.stem}_meshes")


def _add_sensor(
    body: Element, sensors: Element, number: int, position: list[float], radius: float, frame: FloatArray | None
) -> None:
    name = f"taxel_{number}"
    site = SubElement(body, "site", name=name, pos=_numbers(position), size=f"{radius:.9g}", group="4")
    if frame is None:
        SubElement(sensors, "touch", name=name, site=name)
        return
    site.set("type", "cylinder")
    site.set("size", _numbers([radius, max(radius, _HALF_HEIGHT)]))
    site.set("xyaxes", _numbers(frame[:2].ravel().tolist()))
    SubElement(sensors, "contact", name=name, site=name, data="force", reduce="netforce")


def _numbers(values: Sequence[float]) -> str:
    return " ".join(f"{value:.9g}" for value in values)
