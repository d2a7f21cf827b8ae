"""The mesh files a robot names, gathered under bare names in a form MuJoCo can be trusted with."""

from __future__ import annotations

from pathlib import Path

from app.errors import Finding, RobotError
from app.robots.mesh_file import MAX_FACES, box_mesh, parse_mesh, to_msh
from app.robots.safe_files import read_bytes

PLACEHOLDER_SIZE = 0.02  # m


class AssetStore:
    """Collects meshes while a robot is read. Mutable.

    Attributes:
        files: Mesh bytes by bare file name, all in MuJoCo's own format.
        findings: Meshes that were missing.
    """

    def __init__(self) -> None:
        self.files: dict[str, bytes] = {}
        self.findings: list[Finding] = []
        self._names: dict[tuple[Path, str], str] = {}
        self._faces = 0

    def add(self, path: Path, *, variant: str = "") -> str:
        """Take in a mesh file and return its bare name; a missing file becomes a small box and a Finding.

        Args:
            path: The file.
            variant: Uses of one file that must keep different names, such as two scales.

        Raises:
            MeshError: The file exists but is no usable mesh.
            RobotError: All meshes together have more than 5 million triangles.
        """
        key = (path, variant)
        if key not in self._names:
            self._names[key] = self._free_name(path.stem)
            self.files[self._names[key]] = self._load(path)
        return self._names[key]

    def _load(self, path: Path) -> bytes:
        if not path.exists():
            self.findings.append(Finding("missing-mesh", str(path), "a small box stands in for it"))
            return to_msh(box_mesh(PLACEHOLDER_SIZE))
        mesh = parse_mesh(read_bytes(path), path)
        self._faces += len(mesh.faces)
        if self._faces > MAX_FACES:
            raise RobotError(
                "its meshes have more than 5 million triangles together",
                file=path,
                value=self._faces,
                remedy="Simplify them first",
            )
        return to_msh(mesh)

    def _free_name(self, stem: str) -> str:
        name, count = f"{stem}.msh", 1
        while name in self.files:
            count += 1
            name = f"{stem}_{count}.msh"
        return name
