"""Start-up against the bare imports it cannot do without, all in fresh interpreters of the same run."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CODES = {
    "bare import PySide6, pyvista, mujoco": "import PySide6.QtWidgets, pyvista, mujoco",
    "tactile-maps --help": "from app.__main__ import main; main(['--help'])",
    "window shown": """
from pathlib import Path
import os, tempfile
from widgets.window.application import make_application, picture_window
if __name__ == "__main__":
    app = make_application()
    window = picture_window("dark", (1400, 900))
    app.processEvents()
    window.close()
""",
    "window alive with the arm": """
from app.session.prepare import prepare
from app.scene.scene_file import load_scene
from widgets.window.application import make_application, picture_window
if __name__ == "__main__":
    app = make_application()
    window = picture_window("dark", (1400, 900))
    window.live.show_prepared(prepare(load_scene("arm")))
    app.processEvents()
    window.robot_view.display.draw_now()
    window.close()
""",
}


def _run(code: str) -> None:
    environment = {**os.environ, "QT_QPA_PLATFORM": "offscreen"}
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("what", CODES)
def test_start_up(benchmark, what):
    benchmark.pedantic(_run, args=(CODES[what],), rounds=5, warmup_rounds=1)
