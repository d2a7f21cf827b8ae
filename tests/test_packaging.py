"""The wheel contains what the program needs and nothing else, and runs in a separate environment."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import pytest

pytestmark = pytest.mark.long

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """The wheel, built from the checkout with the tools already installed (no network)."""
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", folder, ROOT]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    (built,) = folder.glob("*.whl")
    return built


def test_wheel_contains_both_packages_with_assets_and_no_tests(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    tops = {name.split("/")[0] for name in names if ".dist-info" not in name}
    assert tops == {"tactile_maps", "tactile_widgets"}
    assert "tactile_maps/assets/robots/arm/arm.xml" in names
    assert "tactile_maps/assets/scenes/arm.toml" in names
    assert {"tactile_maps/py.typed", "tactile_widgets/py.typed"} <= set(names)
    assert {"tactile_maps/__init__.pyi", "tactile_maps/live/__init__.pyi"} <= set(names)
    guide = {f"tactile_maps/{path.relative_to(ROOT)}" for path in (ROOT / "assets/guide").iterdir()}
    assert len(guide) > 12
    assert guide | {"tactile_maps/assets/tour.gif", "tactile_maps/assets/scenes/README.md"} <= set(names), (
        "targets of links in the guide"
    )
    assert [name for name in names if name.endswith(".dist-info/licenses/LICENSE")]
    assert not [name for name in names if "assets/install" in name or name.endswith(".pyc")]


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory) -> tuple[Path, dict[str, str]]:
    """Executables of an environment with the wheel and the dependencies, and environment variables for them."""
    folder = tmp_path_factory.mktemp("environment")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder], check=True)
    paths = sysconfig.get_paths("venv", vars={"base": str(folder), "platbase": str(folder)})
    executables = Path(paths["scripts"])
    install = ["install", "--quiet", "--no-deps", "--no-index", "--no-compile", wheel]
    subprocess.run([sys.executable, "-m", "pip", "--python", executables / "python", *install], check=True)
    # Adds only this folder: .pth files inside it, such as the checkout's, are not read.
    (Path(paths["purelib"]) / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    variables = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return executables, variables | {"QT_QPA_PLATFORM": "offscreen"}


@pytest.fixture
def foreign_folder(tmp_path):
    """Folder with an unrelated ``app.py``, ``widgets`` and ``assets``."""
    for name in ("app.py", "widgets/__init__.py", "assets/__init__.py", "assets/scenes/arm.toml"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("raise ImportError('not of tactile maps')\n")
    return tmp_path


SCENE = """
robot = "arm"
[cover]
links = ["hand"]
taxels = 30
"""
SWEEP = """
seconds = 0.02
[vary]
seed = [0]
"""
SCREENSHOT = ["python", "-m", "tactile_maps", "screenshot", "--scene", "scene.toml", "-o", "window.png"]
ENVIRONMENT = """
import gymnasium, tactile_maps
environment = gymnasium.make("tactile_maps.learning:TactileMaps-Follow-v0", taxels=60)
environment.reset(seed=1)
environment.step(environment.action_space.sample())
print(tactile_maps.__file__)
"""


@pytest.mark.parametrize(
    ("arguments", "shown"),
    [
        pytest.param(SCREENSHOT, "window.png", marks=pytest.mark.long),
        # With two jobs, the case runs in a separate process.
        (["tactile-maps", "run", "scene.toml", "--sweep", "sweep.toml", "-o", "out", "--jobs", "2"], "Recorded  1"),
        pytest.param(["python", "-c", ENVIRONMENT], "site-packages", marks=pytest.mark.long),
    ],
    ids=["window", "command line and worker process", "Gymnasium environment"],
)
def test_wheel_runs_next_to_packages_named_app_widgets_and_assets(installed, foreign_folder, arguments, shown):
    executables, variables = installed
    (foreign_folder / "scene.toml").write_text(SCENE)
    (foreign_folder / "sweep.toml").write_text(SWEEP)
    command = [executables / arguments[0], *arguments[1:]]
    done = subprocess.run(command, cwd=foreign_folder, env=variables, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert shown in done.stdout, done.stdout


def test_qt_handles_twenty_thousand_calls():
    """PySide6 6.12.0 aborts Python < 3.12 after about 5,000 void calls; the pin in pyproject keeps it out."""
    code = (
        "from PySide6.QtWidgets import QApplication, QWidget\n"
        "app = QApplication([]); widget = QWidget()\n"
        "for _ in range(20_000): widget.update()\n"
    )
    environment = {**os.environ, "QT_QPA_PLATFORM": "offscreen"}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
