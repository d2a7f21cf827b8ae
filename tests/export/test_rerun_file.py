"""Rerun reads the file: an image, points, surfaces. Needs rerun-sdk (extra ``rerun``), 170 MB: skipped without."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tactile_maps.export.export import export_recording

pytest.importorskip("rerun", reason="rerun-sdk is not installed (extra rerun)")


def test_rerun_file_contains_all_components(player, tmp_path):
    target = tmp_path / "out.rrd"
    export_recording(player, target, to="rerun")
    command = [sys.executable, "-m", "rerun", "rrd", "print", "-vv", str(target)]
    printed = subprocess.run(command, check=True, capture_output=True, text=True, timeout=120).stdout
    for component in ("Image:", "Points3D:", "Mesh3D:", "Transform3D:", "Arrows3D:", "TextLog:", "Scalars:"):
        assert component in printed
    assert [path.name for path in tmp_path.iterdir()] == ["out.rrd"]
