"""Search for the files that a model names: in its tree, in packages, and in package roots of the user.

Models name their meshes as ``../meshes/hand.stl`` or ``package://robot/meshes/hand.stl``. The tree of a model is the
package or repository that contains it, recognised by the usual files at its top. Outside the model's folder, only
models and meshes of the tree are opened. Links are resolved first.
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
"""Folders that contain packages of different origin."""


def model_tree(file: Path) -> Path:
    """Return the folder whose models and meshes the model in ``file`` may name.

    It is the nearest folder at or above the file that is the top of a package or repository (package.xml, .git,
    pyproject.toml, the topmost ``__init__.py``, ...), or else the nearest one called ``assets`` or
    ``..._description``, or else the file's folder. It is never a folder with files of different origin: a home folder
    or a folder above it, the top of a disk, a folder directly below the root, or ``site-packages``.
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
    """Yield ``folder`` and those above it, up to the first that may contain files of others."""
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
    """Finds the files that one model names. Mutable: records the files outside the model's folder.

    Args:
        file: The model.
        roots: Additional folders for its files; packages, or folders that contain packages.

    Attributes:
        folder: Folder of the model, to which relative names refer.
        tree: Tree of the model, see ``model_tree``.
    """

    def __init__(self, file: Path, roots: Sequence[Path] = ()) -> None:
        self.file = file
        self.roots = tuple(roots)
        self.folder = file.resolve().parent
        self.tree = model_tree(file)
        self._outside: dict[Path, None] = {}

    def place(self, path: Path, *, named: str) -> Path:
        """Return ``path``, relative to the model's folder, if the model may open it; the file need not exist.

        Args:
            path: The path.
            named: The name in the model, for errors.

        Raises:
            RobotError: The path is outside tree and roots, or outside the model's folder and not a model or mesh.
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
                problem = "only models and meshes are read from outside the robot's folder"
                raise RobotError(problem, file=self.file, value=named, remedy="Put the file inside the robot's folder")
            self._outside[found] = None
        return found

    def findings(self) -> list[Finding]:
        """Return the number of opened files of the tree outside the model's folder, without those in given roots."""
        opened = [
            path
            for path in self._outside
            if os.path.isfile(path) and not any(path.is_relative_to(root.resolve()) for root in self.roots)
        ]
        note = "models and meshes of this folder, the robot's package or repository, were opened"
        return [Finding("files-beside", str(self.tree), note, len(opened))] if opened else []

    def similar_meshes(self, missing: Sequence[Path]) -> dict[Path, list[str]]:
        """Return up to three likely mesh files for each missing file, the most likely first.

        These have the same name without its extension, in any folder of the tree or the roots and in any case of
        letters. Their paths are relative to the model's folder where they are below it.
        """
        stems = {path.stem.casefold() for path in missing}
        found: dict[str, list[Path]] = {}
        for path in _mesh_files([self.folder, self.tree, *self.roots]):
            if path.stem.casefold() in stems:
                found.setdefault(path.stem.casefold(), []).append(path)
        return {path: self._likeliest(path, found.get(path.stem.casefold(), [])) for path in missing}

    def _likeliest(self, missing: Path, found: Sequence[Path]) -> list[str]:
        def rank(path: Path) -> tuple[bool, bool, bool, int, str]:
            other_name = path.name.casefold() != missing.name.casefold()
            outside = not path.is_relative_to(self.folder)
            return other_name, path.parent != missing.parent, outside, len(path.parts), str(path)

        others = sorted((path for path in found if path != missing), key=rank)[:_SIMILAR]
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
    """Return the remedy for a file that is not a complete robot: the models in its folder that include it."""
    named = file.name.encode()
    found = list[str]()
    try:
        models = sorted(path for path in file.resolve().parent.iterdir() if path.suffix.lower() in MODEL_SUFFIXES)
    except OSError:
        models = []
    for path in models[:_LOOKED_INTO]:
        try:
            if path.name != file.name and _includes(read_bytes(path), named):
                found.append(path.name)
        except RobotError:
            continue
    if not found:
        return "Open the file that includes it, or one with a link or body"
    return f"It is part of other files: open {', '.join(found[:5])}{', …' if len(found) > 5 else ''}"


def _includes(text: bytes, named: bytes) -> bool:
    return re.search(rb"<(?:xacro:)?include\b[^>]*[\"'/\\]" + re.escape(named) + rb"[\"']", text) is not None


_LOOKED_INTO = 200
PACKAGE_ROOT_OPTION = "--package-root DIR"
PACKAGE_ROOT_REMEDY = "give its folder as a package root"


_FIND = re.compile(r"^(?:file://)?\$\(find(?:-pkg-share)? +([\w.-]+)\)/")
"""Expression that xacro replaces by the folder of a package."""


class PackageResolver:
    """Finds the files that one URDF file names.

    A package is searched in the given roots, in ``ROS_PACKAGE_PATH`` and ``AMENT_PREFIX_PATH``, in the folders above
    the file (their subfolders need a package.xml), in the model's tree and in the interpreter's ``share``. A relative
    path may not leave the model's tree or a given root.

    Args:
        file: The URDF file.
        roots: Packages, or folders that contain packages.

    Attributes:
        files: Files that may be opened.
    """

    def __init__(self, file: Path, roots: Sequence[Path] = ()) -> None:
        self.files = ModelFiles(file, roots)
        self._file = file
        self._known: dict[str, list[Path]] = {}

    def resolve(self, address: str) -> Path:
        """Return the path of ``address``; the file need not exist.

        Raises:
            RobotError: The path leaves its package or tree, or the scheme does not name a file.
        """
        text = _FIND.sub(r"package://\1/", unquote(address.strip()).replace("\\", "/"))
        scheme, found, rest = text.partition("://")
        if found and scheme in ("package", "model"):
            return self._in_package(rest, address)
        if found and scheme != "file":
            remedy = "Download it to the robot's folder and name it by its path"
            raise RobotError("meshes are read from files only", file=self._file, value=address, remedy=remedy)
        return self.files.place(Path(rest if found else text), named=address)

    def package(self, name: str) -> Path | None:
        """Return the folder of a package; None if it is unknown."""
        return next((home for home in self._homes_of(name) if os.path.isdir(home)), None)

    def _in_package(self, rest: str, address: str) -> Path:
        """Return the path in a package; with a third slash, as in Pinocchio, the package must exist."""
        parts = PurePosixPath(rest.lstrip("/")).parts
        homes = self._homes_of(parts[0]) if parts else []
        unsound = len(parts) < 2 or ".." in parts[:1]
        if unsound or (rest.startswith("/") and not any(os.path.isdir(home) for home in homes)):
            remedy = "Write package://name/path/to/file"
            raise RobotError("the package address is invalid", file=self._file, value=address, remedy=remedy)
        paths = [resolve_inside(home.joinpath(*parts[1:]), [home], file=self._file, named=address) for home in homes]
        return next((path for path in paths if os.path.isfile(path)), paths[0])

    def _homes_of(self, name: str) -> list[Path]:
        """Return possible folders of a package, the likeliest first; never a whole disk or all files of a user."""
        if name in self._known:
            return self._known[name]
        share = Path(sys.prefix, "share")
        ros = [Path(part) for part in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if part]
        ament = [Path(part, "share") for part in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if part]
        searched = [*self.files.roots, *ros, *ament]
        homes = [home for root in searched for home in _packages_under(root, name)]
        homes += [folder if folder.name == name else folder / name for folder in (self.files.folder, share)]
        for folder in (self.files.folder, *self.files.folder.parents):
            if folder.name == name and not _is_shared(folder):
                homes.append(folder)
            elif (folder / name / "package.xml").is_file():
                homes.append(folder / name)
            elif not _is_shared(folder) and _stated_name(folder) == name:
                homes.append(folder)
        self._known[name] = homes
        return homes


def _packages_under(root: Path, name: str) -> list[Path]:
    """Return possible folders of a package in a trusted folder: the folder itself, in it, or one level deeper."""
    if root.name == name or _stated_name(root) == name:
        return [root]
    try:
        deeper = sorted(folder / name for folder in root.iterdir() if (folder / name / "package.xml").is_file())
    except OSError:
        deeper = []
    return [root / name, *deeper]


def _stated_name(folder: Path) -> str | None:
    """Return the name in a folder's package.xml, which may differ from the folder's."""
    try:
        return (parse_xml(read_bytes(folder / "package.xml"), file=folder).findtext("name") or "").strip() or None
    except RobotError:
        return None
