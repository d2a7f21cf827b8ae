"""Start-up against the bare imports it cannot do without, both in fresh interpreters of the same run."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

BARE = "import PySide6.QtWidgets, pyvista, mujoco"
HELP = "import sys; from app.__main__ import main; sys.argv = ['tactile-maps', '--help']; main(['--help'])"
WINDOW = "from widgets.launch import time_to_first_frame; print(time_to_first_frame('arm'))"


def _run(code: str) -> str:
    environment = {**os.environ, "QT_QPA_PLATFORM": "offscreen"}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("code", [BARE, HELP], ids=["bare imports", "tactile-maps --help"])
def test_start_up(benchmark, code):
    benchmark.pedantic(_run, args=(code,), rounds=7, warmup_rounds=1)
