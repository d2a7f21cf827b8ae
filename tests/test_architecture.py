"""The shape of the project is a promise: imports run one way, folders stay small, app starts without a screen."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("app", "widgets", "assets")
MOST_ENTRIES = {False: 15, True: 20}
"""Of a folder, and of a package's own, whose entries are folders."""
SOURCES = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))


def test_there_are_sources_to_check():
    assert len(SOURCES) > 50


def test_imports_run_one_way():
    done = subprocess.run(
        [Path(sys.executable).with_name("lint-imports"), "--no-cache"], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_file_says_what_it_is():
    assert not [path for path in SOURCES if not ast.get_docstring(ast.parse(path.read_text(encoding="utf8")))]


def test_a_folder_fits_on_one_screen():
    """About a dozen entries; an ``__init__`` is not counted."""
    folders = {
        path.parent for path in SOURCES if path.is_relative_to(ROOT / "app") or path.is_relative_to(ROOT / "widgets")
    }
    entries = {
        folder: {x for x in folder.iterdir() if x.suffix == ".py" or (x / "__init__.py").exists()} for folder in folders
    }
    full = {
        str(folder.relative_to(ROOT)): len(found)
        for folder, found in entries.items()
        if len(found - {folder / "__init__.py"}) > MOST_ENTRIES[len(folder.relative_to(ROOT).parts) == 1]
    }
    assert not full


def test_app_starts_without_a_screen():
    """No module of app pulls in Qt or VTK; checked in a fresh interpreter, since this one has both."""
    modules = [
        ".".join(path.relative_to(ROOT).with_suffix("").parts)
        for path in SOURCES
        if path.parts[len(ROOT.parts)] == "app"
    ]
    names = [name.removesuffix(".__init__") for name in modules if not name.endswith("__main__")]
    code = (
        f"import importlib, sys\nfor name in {names!r}: importlib.import_module(name)\n"
        "bad = [m for m in sys.modules if m.split('.')[0] in ('PySide6', 'pyvista', 'vtk', 'vtkmodules', 'widgets')]\n"
        "assert not bad, bad\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
