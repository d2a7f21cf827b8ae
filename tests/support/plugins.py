"""Example plug-ins, as if installed but without the time that pip takes."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[1] / "plugins" / "example"


def install_example(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Write to ``folder`` what ``pip install`` of the example package would, for this process and its children."""
    project = tomllib.loads((EXAMPLE / "pyproject.toml").read_text())["project"]
    info = folder / "tactile_maps_example-1.0.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n")
    groups = project["entry-points"].items()
    lines = [line for group, points in groups for line in (f"[{group}]", *(f"{n} = {v}" for n, v in points.items()))]
    (info / "entry_points.txt").write_text("\n".join(lines))
    (folder / "tactile_maps_example.py").write_bytes((EXAMPLE / "tactile_maps_example.py").read_bytes())
    monkeypatch.syspath_prepend(str(folder))
