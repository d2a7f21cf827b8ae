"""Start-up time compared with the imports that it requires, in new interpreters of the same run."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CODES = {
    "bare import PySide6, pyvista, mujoco": "import PySide6.QtWidgets, pyvista, mujoco",
    "tactile-maps --help": "from tactile_widgets.__main__ import main; main(['--help'])",
    "window shown": """
from pathlib import Path
import os, tempfile
from tactile_widgets.window.application import make_application, picture_window
if __name__ == "__main__":
    app = make_application()
    window = picture_window("dark", (1400, 900))
    app.processEvents()
    window.close()
""",
    "imports of the window": "import tactile_widgets.window.application",
    **{
        f"window alive with {scene}, kept on disk": f"""
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.scene.scene_file import load_scene
from tactile_widgets.window.application import make_application, picture_window
if __name__ == "__main__":
    app = make_application()
    window = picture_window("dark", (1400, 900))
    window.live.show_prepared(prepare_cached(load_scene("{scene}")))
    app.processEvents()
    window.robot_view.display.draw_now()
    window.close()
"""
        for scene in ("arm", "ur5e", "icub_whole")
    },
}


def _run(code: str, kept: Path) -> None:
    environment = {**os.environ, "QT_QPA_PLATFORM": "offscreen", "TACTILE_MAPS_CACHE": str(kept)}
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("what", CODES)
def test_startup_time(benchmark, what, tmp_path):
    benchmark.pedantic(_run, args=(CODES[what], tmp_path), rounds=5, warmup_rounds=1)
