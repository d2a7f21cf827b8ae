"""``package://`` addresses and relative paths of URDF files, resolved to places a robot may read."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

from app.errors import RobotError
from app.robots.safe_files import contained


class Packages:
    """Finds the files that one URDF file names.

    A package is looked for in the given roots, in ``ROS_PACKAGE_PATH``, in the folders above the file and in the
    interpreter's ``share``. A relative path may not leave the file's folder, the package around it (the nearest folder
    above with a package.xml), or a given root.

    Args:
        file: The URDF file.
        roots: Folders that hold packages, or are packages themselves.
    """

    def __init__(self, file: Path, roots: Sequence[Path] = ()) -> None:
        self._file = file
        self._folder = file.resolve().parent
        above = (self._folder, *self._folder.parents)
        around = next((folder for folder in above if (folder / "package.xml").is_file()), self._folder)
        self._allowed = (self._folder, around, *roots)
        ros = [Path(part) for part in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if part]
        self._search = (*roots, *ros, *above, Path(sys.prefix, "share"))

    def resolve(self, address: str) -> Path:
        """Where ``address`` points; the file need not exist.

        Raises:
            RobotError: It climbs out of its package or folder, or uses a scheme that is not a file.
        """
        text = unquote(address.strip()).replace("\\", "/")
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
        path = self._folder / (rest if found else text)
        return contained(path, self._allowed, file=self._file, named=address)

    def _in_package(self, rest: str, address: str) -> Path:
        parts = PurePosixPath(rest).parts
        if len(parts) < 2 or parts[0] in ("..", "/"):
            raise RobotError(
                "this is not a package address",
                file=self._file,
                value=address,
                remedy="It reads package://name/path/to/file",
            )
        homes = [root if root.name == parts[0] else root / parts[0] for root in self._search]
        paths = [contained(home.joinpath(*parts[1:]), [home], file=self._file, named=address) for home in homes]
        return next((path for path in paths if path.is_file()), paths[0])
