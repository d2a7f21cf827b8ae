"""Touch sensors that an MJCF file states for its bodies, read from its text without loading plug-ins.

A ``<touch>`` sensor sums the normal forces inside its site's volume: one taxel, at the site. A ``<contact>`` sensor of
a site with ``data="force"`` and ``reduce="netforce"`` sums the whole forces, in the world frame: one taxel with three
axes, in the frame of the site. The plug-in
``mujoco.sensor.touch_grid`` views the scene from its site along -z, x right and y up, through a grid of angles up to
``fov`` to either side, which is finer in the middle for larger ``gamma``: one taxel per cell, where its ray meets the
link. ``<tactile>`` has a taxel at each vertex of a mesh, in the frame of a geom.

Taxels have three axes in a touch grid with three channels or more, whose forces are along the axes of its site, and on
a mesh that states three normals for each vertex: the normal and two tangents.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree.ElementTree import Element, tostring

import mujoco
import numpy as np

from tactile_maps.core.arrays import ArrayFields, FloatArray
from tactile_maps.core.errors import Finding, RobotError, places_finding
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.files.mesh_files import AssetStore
from tactile_maps.robots.formats.mjcf import gather_meshes, read_mjcf_tree, strip_mjcf
from tactile_maps.robots.model.mujoco_spec import compile_spec, parse_spec, rotation_of

GRID = "mujoco.sensor.touch_grid"
MAX_GRID = 100_000
MAX_CHANNELS = 6
_WITH_SHEAR = 3
_GRID_REACH = 0.02  # m, length of a ray that meets nothing
_EDGE = 1e-9  # tolerance at the edge of a triangle, so that no ray passes between two
_MOVING = ("joint", "freejoint")
_LOOSE_SECTIONS = ("contact", "equality", "keyframe")


@dataclass(frozen=True, eq=False)
class TouchSensor(ArrayFields):
    """A sensor of the file.

    Attributes:
        name: Stated name, or its kind and number.
        kind: ``touch``, ``contact``, ``touch_grid`` or ``tactile``.
        link: Body of the sensor.
        origins: (n, 3) [m] position or ray origin of each taxel, link frame.
        directions: (n, 3) unit vectors of the rays to the skin, link frame; None without rays.
        t1: (n, 3) first tangents of taxels with three axes, link frame; None for one axis.
        t2: (n, 3) second tangents, link frame, or None.
        normals: (n, 3) stated normals, link frame, or None.
    """

    name: str
    kind: str
    link: str
    origins: FloatArray
    directions: FloatArray | None = None
    t1: FloatArray | None = None
    t2: FloatArray | None = None
    normals: FloatArray | None = None

    def places(self, mesh: Mesh | None) -> FloatArray:
        """Return the taxels (n, 3) [m] on the link's mesh, link frame: the exits of the rays, or the origins."""
        if self.directions is None:
            return self.origins
        reach = np.full(len(self.origins), _GRID_REACH)
        if mesh is not None:
            reach = np.array([_leaves(mesh, o, d) for o, d in zip(self.origins, self.directions, strict=True)])
        return self.origins + reach[:, None] * self.directions


def states_touch_sensors(path: Path, *, package_roots: Sequence[Path] = ()) -> bool:
    """Whether the MJCF file at ``path``, or one that it includes, states a touch sensor; False if it is unreadable."""
    try:
        root, _ = read_mjcf_tree(path, AssetStore(), package_roots)
    except RobotError:
        return False  # opening the file reports the error
    return bool(_stated(root))


def read_touch_sensors(
    path: Path, *, package_roots: Sequence[Path] = ()
) -> tuple[tuple[TouchSensor, ...], tuple[Finding, ...]]:
    """Return the touch sensors of an MJCF file in its order, and findings about unusable ones.

    Args:
        path: The main file.
        package_roots: Additional folders for its files.

    Raises:
        RobotError: The file cannot be read, or MuJoCo cannot place its sites.
        MeshError: The mesh of a ``<tactile>`` sensor is not usable.

    Cost: that of reading the text; only meshes with taxels are opened.
    """
    store = AssetStore()
    root, files = read_mjcf_tree(path, store, package_roots)
    stated = _stated(root)
    strip_mjcf(root, path)
    tactile = [element for element, _ in stated if element.tag == "tactile"]
    _keep_only_places(root, {each.get("geom", "") for each in tactile}, {each.get("mesh", "") for each in tactile})
    gather_meshes(root, files, store)
    absent = {mesh.get("name") for mesh in root.iter("mesh") if mesh.get("file") in store.missing}
    absent |= {geom.get("name") for geom in root.iter("geom") if geom.get("mesh") in absent}
    source = str(path)
    model = compile_spec(parse_spec(tostring(root, encoding="unicode"), store.files, source=source), source=source)
    sensors = list[TouchSensor]()
    left = list[str]()
    unplaced = list[str]()
    for number, (element, config) in enumerate(stated):
        name = element.get("name") or f"{element.tag} {number}"
        if element.tag == "tactile" and absent & {element.get("mesh"), element.get("geom")}:
            unplaced.append(name)
        elif (sensor := _placed(model, element, config, name, path)) is None:
            left.append(name)
        else:
            sensors.append(sensor)
    findings = [
        *places_finding("touch-sensor", left, "left out: its site or geom is not on a named body of the model"),
        *places_finding(
            "touch-sensor", unplaced, "left out: the mesh that states its taxels or their frame is missing"
        ),
    ]
    return tuple(sensors), tuple(findings)


def _stated(root: Element) -> list[tuple[Element, dict[str, str]]]:
    """Return the touch sensors with the settings of grids, which a plug-in instance states in ``<extension>``."""
    instances = {
        instance.get("name"): (plugin.get("plugin"), _config(instance))
        for plugin in root.iterfind("extension/plugin")
        for instance in plugin.findall("instance")
    }
    found: list[tuple[Element, dict[str, str]]] = []
    for element in root.iterfind("sensor/*"):
        if element.tag in ("touch", "tactile") or _sums_forces(element):
            found.append((element, {}))
        elif element.tag == "plugin":
            kind, config = instances.get(element.get("instance"), (element.get("plugin"), {}))
            if kind == GRID:
                found.append((element, {**config, **_config(element)}))
    return found


def _sums_forces(element: Element) -> bool:
    """Whether a sensor is the sum of the forces of contacts at a site."""
    is_force = element.get("data", "").split() == ["force"] and element.get("reduce") == "netforce"
    return element.tag == "contact" and bool(element.get("site")) and is_force


def _config(element: Element) -> dict[str, str]:
    return {config.get("key", ""): config.get("value", "") for config in element.findall("config")}


def _keep_only_places(root: Element, geoms: set[str], meshes: set[str]) -> None:
    """Remove everything that has mass, moves or is visible, except the geoms and meshes with taxels."""
    root[:] = [section for section in root if section.tag not in _LOOSE_SECTIONS]
    kept = meshes | {geom.get("mesh", "") for geom in root.iter("geom") if geom.get("name") in geoms}
    for parent in list(root.iter()):
        if parent.tag == "default":
            continue
        parent[:] = [child for child in parent if _is_place(parent, child, geoms, kept)]


def _is_place(parent: Element, child: Element, geoms: set[str], meshes: set[str]) -> bool:
    if child.tag == "geom":
        return bool(child.get("name")) and child.get("name") in geoms
    if parent.tag == "asset" and child.tag == "mesh":
        stem = Path(child.get("file", "").replace("\\", "/")).stem
        return (child.get("name") or stem) in meshes
    return child.tag not in _MOVING


def _placed(
    model: mujoco.MjModel, element: Element, config: dict[str, str], name: str, path: Path
) -> TouchSensor | None:
    if element.tag == "tactile":
        return _on_mesh(model, element, name)
    if element.tag == "plugin" and element.get("objtype", "site") != "site":
        return None
    site = _number(model, mujoco.mjtObj.mjOBJ_SITE, element.get("site") or element.get("objname"))
    link = "" if site is None else model.body(int(model.site_bodyid[site])).name
    if site is None or not link or link == "world":
        return None
    origin = model.site_pos[site].copy()
    turn = rotation_of(model.site_quat[site])
    if element.tag == "touch":
        return TouchSensor(name, "touch", link, origin[None, :])
    if element.tag == "contact":
        return TouchSensor(name, "contact", link, origin[None, :], None, turn[None, :, 0], turn[None, :, 1])
    directions = _grid_directions(config, name, path) @ turn.T
    origins = np.tile(origin, (len(directions), 1))
    across = np.tile(turn[:, 0], (len(directions), 1)) if _channels(config, name, path) >= _WITH_SHEAR else None
    return TouchSensor(name, "touch_grid", link, origins, directions, across)


def _on_mesh(model: mujoco.MjModel, element: Element, name: str) -> TouchSensor | None:
    geom = _number(model, mujoco.mjtObj.mjOBJ_GEOM, element.get("geom"))
    mesh = _number(model, mujoco.mjtObj.mjOBJ_MESH, element.get("mesh"))
    link = "" if geom is None else model.body(int(model.geom_bodyid[geom])).name
    if geom is None or mesh is None or not link or link == "world":
        return None
    first = int(model.mesh_vertadr[mesh])
    count = int(model.mesh_vertnum[mesh])
    vertices = model.mesh_vert[first : first + count].astype(np.float64)
    turn = rotation_of(model.geom_quat[geom])
    places = vertices @ turn.T + model.geom_pos[geom]
    if int(model.mesh_normalnum[mesh]) != 3 * count:
        return TouchSensor(name, "tactile", link, places)
    first = int(model.mesh_normaladr[mesh])
    frames = model.mesh_normal[first : first + 3 * count].astype(np.float64) @ turn.T
    return TouchSensor(name, "tactile", link, places, None, frames[1::3], frames[2::3], frames[::3])


def _channels(config: dict[str, str], name: str, path: Path) -> int:
    """Return the number of channels of a touch grid; 0 counts as 1."""
    text = config.get("nchannel", "").strip() or "1"
    if not text.isdecimal() or int(text[:3]) > MAX_CHANNELS:
        problem = f"nchannel of a touch grid must be 0 to {MAX_CHANNELS}"
        raise RobotError(problem, file=path, place=f"sensor {name}", value=text)
    return int(text)


def _grid_directions(config: dict[str, str], name: str, path: Path) -> FloatArray:
    """Return the rays (rows * columns, 3) of a grid in the frame of its site: row by row, from the lower left."""
    try:
        columns, rows = (int(word) for word in config.get("size", "").split())
        across, up = (np.radians(float(word)) for word in config.get("fov", "").split())
        gamma = float(config.get("gamma", "").strip() or 0.0)
    except ValueError as error:
        problem = "size and fov of a touch grid must be two numbers each, and gamma a number"
        raise RobotError(problem, file=path, place=f"sensor {name}", value=config) from error
    if not (1 <= columns * rows <= MAX_GRID and min(columns, rows) >= 1):
        problem = f"a touch grid must have 1 to {MAX_GRID} cells"
        raise RobotError(problem, file=path, place=f"sensor {name}", value=config)
    if not (0 < across <= np.pi and 0 < up <= np.pi / 2 and 0 <= gamma <= 1):
        problem = "fov of a touch grid must be up to 180 degrees across and 90 up, and gamma from 0 to 1"
        raise RobotError(problem, file=path, place=f"sensor {name}", value=config)
    azimuth = across * _cell_middles(columns, gamma)
    elevation = up * _cell_middles(rows, gamma)
    e, a = (angles.ravel() for angles in np.meshgrid(elevation, azimuth, indexing="ij"))
    return np.stack([np.cos(e) * np.sin(a), np.sin(e), -np.cos(e) * np.cos(a)], axis=1)


def _cell_middles(count: int, gamma: float) -> FloatArray:
    """Return the middles (count,) of the cells from -1 to 1; edges of the plug-in: g x^5 + (1 - g) x of equal steps."""
    steps = np.linspace(-1.0, 1.0, count + 1)
    edges = gamma * steps**5 + (1.0 - gamma) * steps
    return 0.5 * (edges[1:] + edges[:-1])


def _number(model: mujoco.MjModel, kind: mujoco.mjtObj, name: str | None) -> int | None:
    found = -1 if not name else mujoco.mj_name2id(model, kind, name)
    return None if found < 0 else int(found)


def _leaves(mesh: Mesh, origin: FloatArray, direction: FloatArray) -> float:
    """Return the distance [m] of a ray's last intersection; 20 mm without one (Möller and Trumbore, 1997)."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    normal = np.cross(direction, c - a)
    det = (normal * (b - a)).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = ((origin - a) * normal).sum(axis=1) / det
        other = np.cross(origin - a, b - a)
        v = other @ direction / det
        t = (other * (c - a)).sum(axis=1) / det
        met = (u >= -_EDGE) & (v >= -_EDGE) & (u + v <= 1 + _EDGE) & (t > 0) & np.isfinite(t)
    return float(t[met].max()) if met.any() else _GRID_REACH
