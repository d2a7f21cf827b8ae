"""The wheel holds what the app needs, no more, and runs from a clean folder."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

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


def test_the_wheel_holds_the_three_packages_and_no_tests(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    tops = {name.split("/")[0] for name in names if ".dist-info" not in name}
    assert tops == {"app", "widgets", "assets"}
    assert "assets/robots/arm/arm.xml" in names
    assert "assets/scenes/arm.toml" in names
    assert {"app/py.typed", "widgets/py.typed", "assets/py.typed"} <= set(names)
    stubs = {str(path.relative_to(ROOT)) for package in tops for path in (ROOT / package).rglob("*.pyi")}
    assert len(stubs) > 15
    assert stubs <= set(names)
    guide = {str(path.relative_to(ROOT)) for path in (ROOT / "assets/guide").iterdir()}
    assert len(guide) > 12
    assert guide | {"assets/tour.gif", "assets/scenes/README.md"} <= set(names), "the guide's links lead somewhere"
    assert [name for name in names if name.endswith(".dist-info/licenses/LICENSE")]
    assert not [name for name in names if name.startswith("assets/install") or name.endswith(".pyc")]


def test_the_wheel_runs_from_elsewhere(wheel, tmp_path):
    """``-I`` ignores the checkout; only the unpacked wheel and the installed dependencies are on the path."""
    site = tmp_path / "site"
    zipfile.ZipFile(wheel).extractall(site)
    code = (
        f"import sys; sys.path.insert(0, {str(site)!r}); from app.__main__ import main; "
        "import app; assert app.__file__.startswith(sys.path[0]), app.__file__; "
        "sys.exit(main(['inspect', 'arm', '--json']))"
    )
    done = subprocess.run([sys.executable, "-I", "-c", code], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert '"taxels"' in done.stdout.splitlines()[-1]


def test_qt_survives_twenty_thousand_calls():
    """PySide6 6.12.0 aborts Python < 3.12 after about 5,000 void calls; the pin in pyproject keeps it out."""
    code = (
        "from PySide6.QtWidgets import QApplication, QWidget\n"
        "app = QApplication([]); widget = QWidget()\n"
        "for _ in range(20_000): widget.update()\n"
    )
    environment = {**os.environ, "QT_QPA_PLATFORM": "offscreen"}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
