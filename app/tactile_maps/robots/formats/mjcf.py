"""Robots from MJCF files; includes are resolved, meshes collected and unneeded elements removed before MuJoCo reads it.

Unneeded elements are the scene, decoration, and everything else that ``strip_mjcf`` removes.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path, PurePosixPath
from xml.etree.ElementTree import Element, tostring

from tactile_maps.core.errors import Finding, RobotError, errors_in_file, places_finding
from tactile_maps.robots.files.mesh_files import AssetStore, split_scale
from tactile_maps.robots.files.model_files import ModelFiles, files_that_include
from tactile_maps.robots.files.model_limits import NO_ROBOT_SECTIONS, check_amounts
from tactile_maps.robots.files.safe_files import parse_model_xml, read_bytes
from tactile_maps.robots.model.build import build_robot
from tactile_maps.robots.model.joint_limits import actuator_limits
from tactile_maps.robots.model.mujoco_spec import parse_spec
from tactile_maps.robots.model.robot import Robot
from tactile_maps.robots.model.sanitize import Mount, settle_missing_meshes

_UNSUPPORTED = ("composite", "flexcomp", "attach", "model")
_FILE_ASSETS = frozenset(("texture", "hfield", "skin"))


def strip_mjcf(root: Element, path: Path) -> None:
    """Remove everything from the tree that is not the robot or only decoration.

    Args:
        root: The tree with resolved includes; it is changed.
        path: The file, for errors.

    Raises:
        RobotError: The model is not made of rigid links, or exceeds a limit of ``check_amounts``.
    """
    for tag in _UNSUPPORTED:
        if root.find(f".//{tag}") is not None:
            remedy = "Export the robot with rigid links, as one plain MJCF file"
            raise RobotError(f"<{tag}> is not supported", file=path, remedy=remedy)
    check_amounts(root, path)
    root[:] = [section for section in root if section.tag not in NO_ROBOT_SECTIONS]
    for parent in list(root.iter()):
        files = _FILE_ASSETS if parent.tag == "asset" else frozenset()
        parent[:] = [child for child in parent if child.tag not in files and not _is_plugin_or_relief(child)]
        parent.attrib.pop("user", None)  # data of other programs
        if parent.tag == "material":
            parent.attrib.pop("texture", None)
            parent[:] = []


_EXTRAS = ("site", "camera", "light")


def _drop_unneeded(root: Element, mounts: Collection[Mount]) -> None:
    """Remove elements that ``strip_scene`` would delete, because its time grows with the square of their number.

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
    """Remove the shapes of the world, which may be in frames."""
    element[:] = [child for child in element if child.tag != "geom"]
    for child in element:
        if child.tag in ("frame", "replicate"):
            _drop_scenery(child)


def _drop_unknown_materials(root: Element) -> list[Finding]:
    """Remove references to missing materials, for example in a part of a model."""
    known = {material.get("name") for material in root.iter("material")}
    users = [element for element in root.iter() if element.get("material") not in (None, *known)]
    names = sorted({element.attrib.pop("material") for element in users})
    return places_finding("material", names, "unknown material: its shapes have none", count=len(users))


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
    """Load the robot in an MJCF file.

    Its files must be in its tree (``model_tree``) or in a package root. Textures, sensors, tendons and the scene are
    left out, and also actuators, except for the limits that they set to joints. A missing mesh is replaced by a small
    box (a Finding).

    Args:
        path: The main file.
        package_roots: Additional folders for its files.
        name: Short name for the user; the model's by default.
        home: Joint values of the home posture by joint name [rad, m], instead of those of its file.

    Raises:
        RobotError: The file cannot be read, names other files, or does not contain a robot that can be simulated.
        MeshError: A mesh is not usable.
    """
    store = AssetStore()
    root, files = read_mjcf_tree(path, store, package_roots)
    plugins = sorted({element.get("plugin", "(unnamed)") for element in root.iter("plugin")})
    store.findings += places_finding("plug-in", plugins, "left out: libraries of a model are not loaded")
    mounts = _sensor_mounts(root)
    actuators = list(root.iterfind("actuator/*"))
    strip_mjcf(root, path)
    drives = actuator_limits(actuators, root.findall("default"), store.findings, source=str(path))
    _drop_unneeded(root, mounts)
    store.findings.extend(_drop_unknown_materials(root))
    gather_meshes(root, files, store)
    if root.find("worldbody//body") is None:
        raise RobotError("the file contains no robot: it has no body", file=path, remedy=files_that_include(path))
    source = str(path)
    spec = parse_spec(tostring(root, encoding="unicode"), store.files, source=source, findings=store.findings)
    with errors_in_file(source):
        missing, left_out = settle_missing_meshes(spec, store.missing, files)
    notes = [*store.findings, *files.findings(), *missing]
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
    """Return the sites and geoms to which the model's sensors are fixed."""
    mounts = set[Mount]()
    for sensor in root.iterfind("sensor/*"):
        on_site = sensor.get("site") or (sensor.get("objname") if sensor.tag == "plugin" else None)
        if on_site:
            mounts.add(("site", on_site))
        elif sensor.tag == "tactile":
            mounts.add(("geom", sensor.get("geom", "")))
    return frozenset(mounts)


def read_mjcf_tree(path: Path, store: AssetStore, package_roots: Sequence[Path] = ()) -> tuple[Element, MjcfFiles]:
    """Return the complete tree of an MJCF file with resolved includes, and the object that finds its files.

    Args:
        path: The main file.
        store: Receives the findings.
        package_roots: Additional folders for its files.

    Raises:
        RobotError: The file cannot be read, is not MJCF, or includes files outside its tree.
    """
    files = MjcfFiles(path, package_roots, store.findings)
    root = files.unfold(parse_model_xml(read_bytes(path), file=path, findings=store.findings), files.folder)
    if root.tag == "mujocoinclude":
        raise RobotError("this is a part of an MJCF file", file=path, remedy=files_that_include(path))
    if root.tag != "mujoco":
        remedy = "Open an MJCF file (<mujoco>) or a URDF file (<robot>)"
        raise RobotError("this XML file is not MJCF", file=path, value=f"<{root.tag}>", remedy=remedy)
    return root, files


def gather_meshes(root: Element, files: MjcfFiles, store: AssetStore) -> None:
    """Read each mesh file of ``root`` into ``store``, and change its name to that of the copy.

    Raises:
        RobotError: A file is outside tree and roots, or files are used under too many names.
        MeshError: A mesh is not usable.
    """
    folder = _mesh_folder(root)
    known = set[str]()
    for mesh in root.iter("mesh"):
        if mesh.get("file") is not None:
            path = _gather(mesh, folder, files, store)
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
        """Return the file called ``named``, relative to ``folders``."""
        return self.place(Path(PurePosixPath(*folders, named.replace("\\", "/"))), named=named)

    def unfold(self, element: Element, folder: Path) -> Element:
        """Replace each ``<include>`` below ``element`` by the content of the file's root; return ``element``.

        Args:
            element: Element of a file in ``folder``.
            folder: Folder to which included files are relative, unless they are relative to the main file's folder.
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
            problem = f"more than {_MAX_INCLUDES} files are included"
            remedy = "Look for files that include each other"
            raise RobotError(problem, file=self.file, value=include.get("file"), remedy=remedy)
        named = include.get("file", "")
        target = self._including(Path(PurePosixPath(named.replace("\\", "/"))), named, folder)
        root = parse_model_xml(read_bytes(target), file=target, findings=self._notes)
        if root.tag not in _INCLUDED_ROOTS and not target.is_relative_to(self.folder):
            raise RobotError("the included file is not MJCF", file=self.file, value=named)
        return list(self.unfold(root, target.parent))

    def _including(self, path: Path, named: str, folder: Path) -> Path:
        """Return the path of an included file, relative to the main file or to the one that includes it."""
        try:
            target = self.place(path, named=named)
            if target.exists() or folder == self.folder:
                return target
        except RobotError:
            if folder == self.folder:
                raise
        return self.place(folder / path, named=named)


def _mesh_folder(root: Element) -> tuple[str, bool]:
    """Return the folder of the meshes, and whether only their bare names count; remove these settings."""
    folder = ""
    strip = False
    for compiler in root.findall("compiler"):
        assets = compiler.attrib.pop("assetdir", folder)
        folder = compiler.attrib.pop("meshdir", assets)
        strip = compiler.attrib.pop("strippath", str(strip).lower()) == "true"
        compiler.attrib.pop("texturedir", None)
    return folder, strip


_REFERENCE = {"refpos", "refquat"}
"""Attributes by which MuJoCo moves the mesh before scaling, so that the signs must remain in the scale."""


def _gather(mesh: Element, folder: tuple[str, bool], files: MjcfFiles, store: AssetStore) -> Path:
    """Read one ``<mesh file=...>`` into ``store`` and change its name; return the path of the file."""
    named = mesh.get("file", "")
    pure = PurePosixPath(named.replace("\\", "/"))
    path = files.mesh(pure.name if folder[1] else named, folder[0])
    mesh.set("name", mesh.get("name") or pure.stem)  # default of MuJoCo, which would otherwise change
    scale, mirror = split_scale(mesh.get("scale", "")) if not _REFERENCE & set(mesh.attrib) else ("", (1.0, 1.0, 1.0))
    if scale:
        mesh.set("scale", scale)
    mesh.set("file", store.add(path, mirror=mirror))
    mesh.attrib.pop("content_type", None)
    return path
