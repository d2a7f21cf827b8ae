"""Two packages install MuJoCo into one folder, which pip does not notice."""

from __future__ import annotations

import importlib
import sys

import pytest

import tactile_maps.robots
from tactile_maps.core.errors import RobotError


@pytest.mark.parametrize(("installed", "rejected"), [("3.17.0", True), ("4.0.1", False)])
def test_mujoco_before_version_4_next_to_mujoco_core_is_rejected(tmp_path, monkeypatch, installed, rejected):
    folder = tmp_path / f"mujoco-{installed}.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text(f"Metadata-Version: 2.1\nName: mujoco\nVersion: {installed}\n")
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    if rejected:
        with pytest.raises(RobotError, match=rf"mujoco {installed}.*pip uninstall mujoco mujoco-core"):
            importlib.reload(tactile_maps.robots)
    else:
        importlib.reload(tactile_maps.robots)
