"""Where the files lie that a model names: in its own tree, in packages, and under roots that a person gives.

Models in the wild name their meshes as ``../meshes/hand.stl`` or ``package://robot/meshes/hand.stl``. The tree is what
belongs to the model by the marks that people leave at the top of a package or repository; of what lies there beside the
model's own folder, only models and meshes are opened. Links are followed before anything is decided.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

from tactile_maps.core.errors import Finding, RobotError
from tactile_maps.core.file_kinds import FileKind
from tactile_maps.robots.files.mesh_files import MESH_SUFFIXES
from tactile_maps.robots.files.safe_files import parse_xml, read_bytes, resolve_inside

MODEL_SUFFIXES = (*FileKind.ROBOT.suffixes, ".yaml", ".yml")
_MARKS = ("package.xml", "manifest.xml", ".git", ".hg", "pyproject.toml", "setup.py", "setup.cfg")
_PYTHON_PACKAGE = "__init__.py"
_SHARED = ("site-packages", "dist-packages", "share", "lib")
"""Folders where packages of any origin lie beside each other."""


def model_tree(file: Path) -> Path:
    """The folder whose models and meshes the model in ``file`` may name.

    It is the nearest folder at or above the file's that looks like the top of a package or repository (package.xml,
    .git, pyproject.toml, the topmost ``__init__.py``, ...); where none does, the nearest one called ``assets`` or
    ``..._description``; otherwise the file's own folder. Never a folder in which files of several origins lie: a home
    folder or what is above it, the top of a disk, a folder of a few letters below the root, or ``site-packages``.
    """
    folder = file.resolve().parent
    private = list(_private_folders(folder))
    for candidate in private:
        if any((candidate / mark).exists() for mark in _MARKS):
            return candidate
        if (candidate / _PYTHON_PACKAGE).is_file():
            return _top_of_python_package(candidate, private)
    named = (candidate for candidate in private if candidate.name == "assets" or "_description" in candidate.name)
    return next(named, folder)


def _private_folders(folder: Path) -> Iterator[Path]:
    """``folder`` and those above it, up to the first that may hold files of others."""
    for candidate in (folder, *folder.parents):
        if _is_shared(candidate):
            return
        yield candidate


def _is_shared(folder: Path) -> bool:
    homes = {Path.home(), Path.home().resolve()}
    people = {home.parent for home in homes} | {Path("/home"), Path("/Users")}
    above = {parent for home in homes for parent in home.parents}
    return (
        len(folder.parts) <= 2
        or folder in above
        or folder.parent in people
        or folder.name in _SHARED
        or os.path.ismount(folder)
    )


def _top_of_python_package(folder: Path, private: Sequence[Path]) -> Path:
    while folder.parent in private and (folder.parent / _PYTHON_PACKAGE).is_file():
        folder = folder.parent
    return folder


class ModelFiles:
    """Finds the files that one model names. Mutable: it remembers which lay beside the model's own folder.

    Args:
        file: The model.
        roots: Further folders its files may lie in; folders that hold packages, or are packages themselves.

    Attributes:
        folder: The model's own; relative names start there.
        tree: As ``model_tree``.
    """

    def __init__(self, file: Path, roots: Sequence[Path] = ()) -> None:
        self.file = file
        self.roots = tuple(roots)
        self.folder = file.resolve().parent
        self.tree = model_tree(file)
        self._beside: dict[Path, None] = {}

    def place(self, path: Path, *, named: str) -> Path:
        """``path``, relative to the model's folder, where the model may open it; the file need not exist.

        Args:
            path: Where it would be.
            named: As the model writes it, for errors.

        Raises:
            RobotError: It lies in neither tree nor root, or beside the model's folder and is no model or mesh.
        """
        try:
            found = resolve_inside(
                self.folder / path, (self.folder, self.tree, *self.roots), file=self.file, named=named
            )
        except RobotError as error:
            if error.value != named:
                raise
            raise error.at(remedy=self._remedy(path)) from error
        if not found.is_relative_to(self.folder):
            if found.suffix.lower() not in (*MODEL_SUFFIXES, *MESH_SUFFIXES):
                problem = "only models and meshes are read from beside the robot's folder"
                raise RobotError(problem, file=self.file, value=named, remedy="Put the file inside the robot's folder")
            self._beside[found] = None
        return found

    def findings(self) -> list[Finding]:
        """How many files of the tree were opened beside the model's own folder; those under given roots are known."""
        opened = [
            path
            for path in self._beside
            if os.path.isfile(path) and not any(path.is_relative_to(root.resolve()) for root in self.roots)
        ]
        note = "models and meshes of this folder, the robot's package or repository, were opened"
        return [Finding("files-beside", str(self.tree), note, len(opened))] if opened else []

    def similar_meshes(self, missing: Sequence[Path]) -> dict[Path, list[str]]:
        """Return for each missing file the mesh files that may be meant, the most likely first, at most three.

        These have the same name without its extension, in any folder of the tree or the roots and in any case of
        letters. Their paths are relative to the model's folder where they are below it.
        """
        wanted = {path.stem.casefold() for path in missing}
        found: dict[str, list[Path]] = {}
        for path in _mesh_files([self.folder, self.tree, *self.roots]):
            if path.stem.casefold() in wanted:
                found.setdefault(path.stem.casefold(), []).append(path)
        return {path: self._likeliest(path, found.get(path.stem.casefold(), [])) for path in missing}

    def _likeliest(self, missing: Path, found: Sequence[Path]) -> list[str]:
        def unlike(path: Path) -> tuple[bool, bool, bool, int, str]:
            other_name = path.name.casefold() != missing.name.casefold()
            outside = not path.is_relative_to(self.folder)
            return other_name, path.parent != missing.parent, outside, len(path.parts), str(path)

        others = sorted((path for path in found if path != missing), key=unlike)[:_SIMILAR]
        return [str(path.relative_to(self.folder) if path.is_relative_to(self.folder) else path) for path in others]

    def _remedy(self, path: Path) -> str:
        try:
            root = os.path.commonpath([self.folder, (self.folder / path).resolve()])
        except (OSError, ValueError, RuntimeError):
            root = ""
        how = f"give {root} as a package root" if root and not _is_shared(Path(root)) else PACKAGE_ROOT_REMEDY
        return f"Put the file inside that folder, or {how} ({PACKAGE_ROOT_OPTION})"


_SIMILAR = 3
_LOOKED_AT = 20_000


def _mesh_files(folders: Sequence[Path]) -> Iterator[Path]:
    """Mesh files below the folders, each once; the search ends after ``_LOOKED_AT`` files."""
    seen = set[Path]()
    looked_at = 0
    for top in folders:
        for folder, below, names in os.walk(top):
            below[:] = [name for name in below if not name.startswith(".") and Path(folder, name) not in seen]
            if Path(folder) in seen:
                continue
            seen.add(Path(folder))
            looked_at += len(names) + 1
            if looked_at > _LOOKED_AT:
                return
            yield from (Path(folder, name) for name in names if Path(name).suffix.lower() in MESH_SUFFIXES)


def files_that_include(file: Path) -> str:
    """What to open instead of ``file``, which holds no robot alone: the models beside it that include it."""
    named = file.name.encode()
    found = list[str]()
    try:
        beside = sorted(path for path in file.resolve().parent.iterdir() if path.suffix.lower() in MODEL_SUFFIXES)
    except OSError:
        beside = []
    for path in beside[:_LOOKED_INTO]:
        try:
            if path.name != file.name and _includes(read_bytes(path), named):
                found.append(path.name)
        except RobotError:
            continue
    if not found:
        return "Open the file that includes it, or one with a link or body"
    return f"It is a part of others: open {', '.join(found[:5])}{', …' if len(found) > 5 else ''}"


def _includes(text: bytes, named: bytes) -> bool:
    return re.search(rb"<(?:xacro:)?include\b[^>]*[\"'/\\]" + re.escape(named) + rb"[\"']", text) is not None


_LOOKED_INTO = 200
PACKAGE_ROOT_OPTION = "--package-root DIR"
PACKAGE_ROOT_REMEDY = "give its folder as a package root"


_FIND = re.compile(r"^(?:file://)?\$\(find(?:-pkg-share)? +([\w.-]+)\)/")
"""What xacro would have replaced by the package's folder."""


class PackageResolver:
    """Finds the files that one URDF file names.

    A package is looked for in the given roots, in ``ROS_PACKAGE_PATH`` and ``AMENT_PREFIX_PATH``, in the folders above
    the file (those beside them need a package.xml), in the model's tree and in the interpreter's ``share``. A relative
    path may not leave the model's tree or a given root.

    Args:
        file: The URDF file.
        roots: Folders that hold packages, or are packages themselves.

    Attributes:
        files: What may be opened.
    """

    def __init__(self, file: Path, roots: Sequence[Path] = ()) -> None:
        self.files = ModelFiles(file, roots)
        self._file = file
        self._known: dict[str, list[Path]] = {}

    def resolve(self, address: str) -> Path:
        """Where ``address`` points; the file need not exist.

        Raises:
            RobotError: It climbs out of its package or tree, or uses a scheme that is not a file.
        """
        text = _FIND.sub(r"package://\1/", unquote(address.strip()).replace("\\", "/"))
        scheme, found, rest = text.partition("://")
        if found and scheme in ("package", "model"):
            return self._in_package(rest, address)
        if found and scheme != "file":
            raise RobotError(
                "meshes are read from files only",
                file=self._file,
                value=address,
                remedy="Download it beside the robot and name it by its path",
            )
        return self.files.place(Path(rest if found else text), named=address)

    def package(self, name: str) -> Path | None:
        """The folder of that package; None where it is not known."""
        return next((home for home in self._homes_of(name) if os.path.isdir(home)), None)

    def _in_package(self, rest: str, address: str) -> Path:
        """Of an address with a third slash, as Pinocchio writes them, the package must be there."""
        parts = PurePosixPath(rest.lstrip("/")).parts
        homes = self._homes_of(parts[0]) if parts else []
        unsound = len(parts) < 2 or ".." in parts[:1]
        if unsound or (rest.startswith("/") and not any(os.path.isdir(home) for home in homes)):
            raise RobotError(
                "this is not a package address",
                file=self._file,
                value=address,
                remedy="It reads package://name/path/to/file",
            )
        paths = [resolve_inside(home.joinpath(*parts[1:]), [home], file=self._file, named=address) for home in homes]
        return next((path for path in paths if os.path.isfile(path)), paths[0])

    def _homes_of(self, name: str) -> list[Path]:
        if name not in self._known:
            self._known[name] = self._homes(name)
        return self._known[name]

    def _homes(self, name: str) -> list[Path]:
        """Where the package of that name may lie, the likeliest first; never all of a disk or of a person's files."""
        share = Path(sys.prefix, "share")
        searched = [*self.files.roots, *_ros_folders(), *_ament_folders()]
        homes = [home for root in searched for home in _packages_under(root, name)]
        homes += [folder if folder.name == name else folder / name for folder in (self.files.folder, share)]
        for folder in (self.files.folder, *self.files.folder.parents):
            if folder.name == name and not _is_shared(folder):
                homes.append(folder)
            elif (folder / name / "package.xml").is_file():
                homes.append(folder / name)
            elif not _is_shared(folder) and _stated_name(folder) == name:
                homes.append(folder)
        return homes


def _ros_folders() -> list[Path]:
    return [Path(part) for part in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if part]


def _ament_folders() -> list[Path]:
    return [Path(part, "share") for part in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if part]


def _packages_under(root: Path, name: str) -> list[Path]:
    """Where below a trusted folder the package lies: there, one folder deeper, or the folder itself."""
    if root.name == name or _stated_name(root) == name:
        return [root]
    try:
        deeper = sorted(folder / name for folder in root.iterdir() if (folder / name / "package.xml").is_file())
    except OSError:
        deeper = []
    return [root / name, *deeper]


def _stated_name(folder: Path) -> str | None:
    """The name in a folder's package.xml, which need not be the folder's."""
    try:
        return (parse_xml(read_bytes(folder / "package.xml"), file=folder).findtext("name") or "").strip() or None
    except RobotError:
        return None
