"""Robots from MJCF files: includes unfolded, meshes gathered, everything MuJoCo need not see taken out first.

What it need not see: scenery, decoration, and orders for absurd amounts of anything (``strip_mjcf``).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path, PurePosixPath
from xml.etree.ElementTree import Element, tostring

from app.core.errors import Finding, RobotError
from app.robots.build import build_robot
from app.robots.mesh_files import AssetStore
from app.robots.model_limits import NO_ROBOT_SECTIONS, check_amounts
from app.robots.mujoco_spec import parse_spec
from app.robots.robot import Robot
from app.robots.safe_files import parse_xml, read_bytes, resolve_inside

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
        if parent.tag == "material":
            parent.attrib.pop("texture", None)
            parent[:] = []


def _is_plugin_or_relief(element: Element) -> bool:
    relief = element.get("hfield") is not None or element.get("type") == "hfield"
    return element.tag == "plugin" or (element.tag == "geom" and relief)


_MAX_INCLUDES = 100


def load_mjcf(path: Path, *, package_roots: Sequence[Path] = (), name: str | None = None) -> Robot:
    """The robot in an MJCF file.

    Files it names must lie in its folder or below, or in a package root. Textures, actuators, sensors, tendons and
    the scene are left out; a missing mesh becomes a small box and a Finding.

    Args:
        path: The main file.
        package_roots: Further folders its files may lie in.
        name: A short name for people; the model's own by default.

    Raises:
        RobotError: The file cannot be read, names files elsewhere, or holds no robot that simulates.
        MeshError: One of its meshes is not usable.
    """
    reader = _FileFinder(path, (path.resolve().parent, *package_roots))
    root = reader.unfold(parse_xml(read_bytes(path), file=path))
    if root.tag != "mujoco":
        raise RobotError(
            "this XML file is not MJCF",
            file=path,
            value=f"<{root.tag}>",
            remedy="Open an MJCF file (<mujoco>) or a URDF file (<robot>)",
        )
    folder = _mesh_folder(root)
    store = AssetStore()
    plugins = sorted({element.get("plugin", "(unnamed)") for element in root.iter("plugin")})
    if plugins:
        note = "left out: no library of a model is loaded"
        store.findings.append(Finding("plug-in", ", ".join(plugins), note, len(plugins)))
    strip_mjcf(root, path)
    for mesh in root.iter("mesh"):
        if mesh.get("file") is not None:
            _gather(mesh, folder, reader, store)
    source = str(path)
    spec = parse_spec(tostring(root, encoding="unicode"), store.files, source=source)
    return build_robot(
        spec,
        name=name or spec.modelname or path.stem,
        source=source,
        assets=store.files,
        findings=store.findings,
    )


class _FileFinder:
    """Finds the files that one MJCF file names. Mutable: counts includes."""

    def __init__(self, path: Path, roots: Sequence[Path]) -> None:
        self.path, self.roots = path, roots
        self.folder = path.resolve().parent
        self._included = 0

    def place(self, named: str, *folders: str) -> Path:
        """The file called ``named``, inside the allowed folders."""
        plain = str(PurePosixPath(*folders, named.replace("\\", "/")))
        return resolve_inside(self.folder / plain, self.roots, file=self.path, named=named)

    def unfold(self, element: Element) -> Element:
        """Replace each ``<include>`` below ``element`` by what the file's root holds; returns ``element``."""
        children: list[Element] = []
        for child in element:
            children.extend(self._included_elements(child) if child.tag == "include" else [self.unfold(child)])
        element[:] = children
        return element

    def _included_elements(self, include: Element) -> list[Element]:
        self._included += 1
        if self._included > _MAX_INCLUDES:
            raise RobotError(
                f"more than {_MAX_INCLUDES} files are included",
                file=self.path,
                value=include.get("file"),
                remedy="Look for files that include each other",
            )
        target = self.place(include.get("file", ""))
        return list(self.unfold(parse_xml(read_bytes(target), file=target)))


def _mesh_folder(root: Element) -> tuple[str, bool]:
    """Where meshes lie, relative to the main file, and whether only their bare names count; removes the settings."""
    folder, strip = "", False
    for compiler in root.findall("compiler"):
        assets = compiler.attrib.pop("assetdir", folder)
        folder = compiler.attrib.pop("meshdir", assets)
        strip = compiler.attrib.pop("strippath", str(strip).lower()) == "true"
        compiler.attrib.pop("texturedir", None)
    return folder, strip


def _gather(mesh: Element, folder: tuple[str, bool], reader: _FileFinder, store: AssetStore) -> None:
    """Read one ``<mesh file=...>`` into ``store`` and let the element name the copy."""
    named = mesh.get("file", "")
    pure = PurePosixPath(named.replace("\\", "/"))
    path = reader.place(pure.name if folder[1] else named, folder[0])
    mesh.set("name", mesh.get("name") or pure.stem)  # MuJoCo's default, which the copy's name must not change
    mesh.set("file", store.add(path))
    mesh.attrib.pop("content_type", None)
