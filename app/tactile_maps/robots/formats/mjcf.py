"""Robots from MJCF files: includes unfolded, meshes gathered, everything MuJoCo need not see taken out first.

What it need not see: scenery, decoration, and orders for absurd amounts of anything (``strip_mjcf``).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path, PurePosixPath
from xml.etree.ElementTree import Element, tostring

from tactile_maps.core.errors import Finding, RobotError, errors_in_file
from tactile_maps.robots.files.mesh_files import AssetStore, split_scale
from tactile_maps.robots.files.model_files import ModelFiles, files_that_include
from tactile_maps.robots.files.model_limits import NO_ROBOT_SECTIONS, check_amounts
from tactile_maps.robots.files.safe_files import parse_model_xml, read_bytes
from tactile_maps.robots.files.sanitize import Mount, settle_missing_meshes
from tactile_maps.robots.model.build import build_robot
from tactile_maps.robots.model.joint_limits import actuator_limits
from tactile_maps.robots.model.mujoco_spec import parse_spec
from tactile_maps.robots.model.robot import Robot

_UNSUPPORTED = ("composite", "flexcomp", "attach", "model")
_FILE_ASSETS = frozenset(("texture", "hfield", "skin"))


def strip_mjcf(root: Element, path: Path) -> None:
    """Remove from the tree what is not the robot or is only for show.

    Args:
        root: The tree with its includes unfolded; it is changed.
        path: The file, for errors.

    Raises:
        RobotError: The model is not made of rigid links, or asks for absurd amounts.
    """
    for tag in _UNSUPPORTED:
        if root.find(f".//{tag}") is not None:
            remedy = "A robot is made of rigid links: export it as one plain MJCF file"
            raise RobotError(f"<{tag}> is not supported", file=path, remedy=remedy)
    check_amounts(root, path)
    root[:] = [section for section in root if section.tag not in NO_ROBOT_SECTIONS]
    for parent in list(root.iter()):
        files = _FILE_ASSETS if parent.tag == "asset" else frozenset()
        parent[:] = [child for child in parent if child.tag not in files and not _is_plugin_or_relief(child)]
        parent.attrib.pop("user", None)  # numbers of other programs
        if parent.tag == "material":
            parent.attrib.pop("texture", None)
            parent[:] = []


_EXTRAS = ("site", "camera", "light")


def _drop_unneeded(root: Element, mounts: Collection[Mount]) -> None:
    """Remove what ``strip_scene`` would delete: MuJoCo's time to delete grows with the square of the number.

    Of the sites that carry sensors, the first of each element is kept: it marks a body of the robot. Of the keyframes,
    those that ``keyframe_home`` may use are kept.
    """
    for world in root.iterfind("worldbody"):
        inside = list(world.iter())
        for parent in inside:
            carriers = [child for child in parent if child.tag == "site" and ("site", child.get("name")) in mounts]
            parent[:] = [child for child in parent if child.tag not in _EXTRAS or child in carriers[:1]]
        _drop_scenery(world)
    for keys in root.iterfind("keyframe"):
        keys[:] = [key for number, key in enumerate(keys) if not number or key.get("name") == "home"]


def _drop_scenery(element: Element) -> None:
    """Remove the shapes of the world itself, which may be in frames."""
    element[:] = [child for child in element if child.tag != "geom"]
    for child in element:
        if child.tag in ("frame", "replicate"):
            _drop_scenery(child)


def _drop_unknown_materials(root: Element) -> list[Finding]:
    """Materials are for show: a shape whose material is not there, as in a part of a model, is none the less."""
    known = {material.get("name") for material in root.iter("material")}
    users = [element for element in root.iter() if element.get("material") not in (None, *known)]
    names = sorted({element.attrib.pop("material") for element in users})
    note = "there is no such material: its shapes have none"
    return [Finding("material", ", ".join(names), note, len(users))] if users else []


def _is_plugin_or_relief(element: Element) -> bool:
    relief = element.get("hfield") is not None or element.get("type") == "hfield"
    return element.tag == "plugin" or (element.tag == "geom" and relief)


_MAX_INCLUDES = 100
_INCLUDED_ROOTS = ("mujoco", "mujocoinclude")


def load_mjcf(
    path: Path,
    *,
    package_roots: Sequence[Path] = (),
    name: str | None = None,
    home: Mapping[str, float] | None = None,
) -> Robot:
    """The robot in an MJCF file.

    Files it names must be in its tree (``model_tree``) or in a package root. Textures, sensors, tendons and the scene
    are left out, and so are actuators except for the limits that they set to joints. A missing mesh becomes a small box
    and a Finding.

    Args:
        path: The main file.
        package_roots: Further folders its files may lie in.
        name: A short name for people; the model's own by default.
        home: Joint values of the home posture by joint name [rad, m], instead of those of its file.

    Raises:
        RobotError: The file cannot be read, names files elsewhere, or holds no robot that simulates.
        MeshError: One of its meshes is not usable.
    """
    store = AssetStore()
    root, reader = read_mjcf_tree(path, store, package_roots)
    plugins = sorted({element.get("plugin", "(unnamed)") for element in root.iter("plugin")})
    if plugins:
        note = "left out: no library of a model is loaded"
        store.findings.append(Finding("plug-in", ", ".join(plugins), note, len(plugins)))
    mounts = _sensor_mounts(root)
    actuators = list(root.iterfind("actuator/*"))
    strip_mjcf(root, path)
    drives = actuator_limits(actuators, root.findall("default"), store.findings, source=str(path))
    _drop_unneeded(root, mounts)
    store.findings.extend(_drop_unknown_materials(root))
    gather_meshes(root, reader, store)
    if root.find("worldbody//body") is None:
        raise RobotError("the file contains no robot: it has no body", file=path, remedy=files_that_include(path))
    source = str(path)
    spec = parse_spec(tostring(root, encoding="unicode"), store.files, source=source, findings=store.findings)
    with errors_in_file(source):
        missing, left_out = settle_missing_meshes(spec, store.missing, reader)
    notes = [*store.findings, *reader.findings(), *missing]
    return build_robot(
        spec,
        name=name or spec.modelname or path.stem,
        source=source,
        assets=store.files,
        findings=notes,
        home=home,
        mounts=mounts,
        left_out=left_out,
        drives=drives,
    )


def _sensor_mounts(root: Element) -> frozenset[Mount]:
    """The sites and geoms that the model's sensors are fixed to."""
    mounts = set[Mount]()
    for sensor in root.iterfind("sensor/*"):
        on_site = sensor.get("site") or (sensor.get("objname") if sensor.tag == "plugin" else None)
        if on_site:
            mounts.add(("site", on_site))
        elif sensor.tag == "tactile":
            mounts.add(("geom", sensor.get("geom", "")))
    return frozenset(mounts)


def read_mjcf_tree(path: Path, store: AssetStore, package_roots: Sequence[Path] = ()) -> tuple[Element, MjcfFiles]:
    """The tree of an MJCF file with its includes unfolded, all sections still in it, and what finds its files.

    Args:
        path: The main file.
        store: Gets the findings of reading it.
        package_roots: Further folders its files may lie in.

    Raises:
        RobotError: The file cannot be read, is no MJCF, or includes files elsewhere.
    """
    reader = MjcfFiles(path, package_roots, store.findings)
    root = reader.unfold(parse_model_xml(read_bytes(path), file=path, findings=store.findings), reader.folder)
    if root.tag == "mujocoinclude":
        raise RobotError("this is a part of an MJCF file", file=path, remedy=files_that_include(path))
    if root.tag != "mujoco":
        raise RobotError(
            "this XML file is not MJCF",
            file=path,
            value=f"<{root.tag}>",
            remedy="Open an MJCF file (<mujoco>) or a URDF file (<robot>)",
        )
    return root, reader


def gather_meshes(root: Element, reader: MjcfFiles, store: AssetStore) -> None:
    """Read each mesh file that ``root`` names into ``store``, and let the model name the copies.

    Raises:
        RobotError: A file is where the model may not read, or files are used under too many names.
        MeshError: One is not usable.
    """
    folder = _mesh_folder(root)
    known = set[str]()
    for mesh in root.iter("mesh"):
        if mesh.get("file") is not None:
            path = _gather(mesh, folder, reader, store)
            if (name := mesh.get("file", "")) in known:
                store.repeat(name, path)
            known.add(name)


class MjcfFiles(ModelFiles):
    """Finds the files that one MJCF file names. Mutable: counts includes."""

    def __init__(self, path: Path, roots: Sequence[Path], notes: list[Finding]) -> None:
        super().__init__(path, roots)
        self._included = 0
        self._notes = notes

    def mesh(self, named: str, *folders: str) -> Path:
        """The file called ``named``, relative to ``folders``."""
        return self.place(Path(PurePosixPath(*folders, named.replace("\\", "/"))), named=named)

    def unfold(self, element: Element, folder: Path) -> Element:
        """Replace each ``<include>`` below ``element`` by what the file's root holds; returns ``element``.

        Args:
            element: Of a file in ``folder``.
            folder: Included files lie relative to the main file's folder, or else to this one.
        """
        children: list[Element] = []
        for child in element:
            children.extend(
                self._included_elements(child, folder) if child.tag == "include" else [self.unfold(child, folder)]
            )
        element[:] = children
        return element

    def _included_elements(self, include: Element, folder: Path) -> list[Element]:
        self._included += 1
        if self._included > _MAX_INCLUDES:
            raise RobotError(
                f"more than {_MAX_INCLUDES} files are included",
                file=self.file,
                value=include.get("file"),
                remedy="Look for files that include each other",
            )
        named = include.get("file", "")
        target = self._including(Path(PurePosixPath(named.replace("\\", "/"))), named, folder)
        root = parse_model_xml(read_bytes(target), file=target, findings=self._notes)
        if root.tag not in _INCLUDED_ROOTS and not target.is_relative_to(self.folder):
            raise RobotError("the included file is not MJCF", file=self.file, value=named)
        return list(self.unfold(root, target.parent))

    def _including(self, path: Path, named: str, folder: Path) -> Path:
        """Where an included file is: relative to the main file, or to the one that includes it."""
        try:
            target = self.place(path, named=named)
            if target.exists() or folder == self.folder:
                return target
        except RobotError:
            if folder == self.folder:
                raise
        return self.place(folder / path, named=named)


def _mesh_folder(root: Element) -> tuple[str, bool]:
    """Where meshes lie, relative to the main file, and whether only their bare names count; removes the settings."""
    folder = ""
    strip = False
    for compiler in root.findall("compiler"):
        assets = compiler.attrib.pop("assetdir", folder)
        folder = compiler.attrib.pop("meshdir", assets)
        strip = compiler.attrib.pop("strippath", str(strip).lower()) == "true"
        compiler.attrib.pop("texturedir", None)
    return folder, strip


_REFERENCE = {"refpos", "refquat"}
"""MuJoCo scales after it has moved the mesh by these, so that its signs must stay in the scale."""


def _gather(mesh: Element, folder: tuple[str, bool], reader: MjcfFiles, store: AssetStore) -> Path:
    """Read one ``<mesh file=...>`` into ``store`` and let the element name the copy; return the path of the file."""
    named = mesh.get("file", "")
    pure = PurePosixPath(named.replace("\\", "/"))
    path = reader.mesh(pure.name if folder[1] else named, folder[0])
    mesh.set("name", mesh.get("name") or pure.stem)  # MuJoCo's default, which the copy's name must not change
    scale, mirror = split_scale(mesh.get("scale", "")) if not _REFERENCE & set(mesh.attrib) else ("", (1.0, 1.0, 1.0))
    if scale:
        mesh.set("scale", scale)
    mesh.set("file", store.add(path, mirror=mirror))
    mesh.attrib.pop("content_type", None)
    return path
