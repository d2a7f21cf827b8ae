"""The names stand for the experiments, without loading them."""

from __future__ import annotations

import subprocess
import sys

from app.experiments.names import NAMES


def test_names_are_their_own():
    assert len(set(NAMES)) == len(NAMES) >= 3
    assert "touch-cost" in NAMES


def test_the_command_line_knows_them_and_stays_light():
    code = "import sys; from app.cli.parser import build_parser; build_parser(); print(sorted(sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert "'app.experiments.names'" in loaded
    for heavy in ("numpy", "mujoco", "scipy", "app.experiments.table"):
        assert f"'{heavy}'" not in loaded
