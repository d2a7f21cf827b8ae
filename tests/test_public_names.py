"""What the packages offer by name: it is there, it is lazy, and it travels with the wheel."""

from __future__ import annotations

import ast
import importlib
import inspect
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
STUBS = sorted(path for package in ("app", "widgets") for path in (ROOT / package).rglob("__init__.pyi"))


def _package(stub: Path) -> str:
    return ".".join(stub.parent.relative_to(ROOT).parts)


def test_every_public_name_can_be_had():
    assert len(STUBS) > 15
    for stub in STUBS:
        package = importlib.import_module(_package(stub))
        assert package.__all__
        for name in package.__all__:
            assert getattr(package, name) is not None, (stub, name)


def test_a_stub_imports_what_it_names_and_nothing_else():
    for stub in STUBS:
        tree = ast.parse(stub.read_text(encoding="utf8"))
        imported = [alias.name for node in tree.body if isinstance(node, ast.ImportFrom) for alias in node.names]
        assert sorted(imported) == sorted(importlib.import_module(_package(stub)).__all__), stub


def test_no_public_name_is_that_of_a_module_beside_it():
    """It would be the function or the module, depending on who imported what first."""
    for stub in STUBS:
        beside = {path.stem for path in stub.parent.iterdir()}
        assert not beside.intersection(importlib.import_module(_package(stub)).__all__), stub


def test_a_package_loads_nothing_until_it_is_asked():
    packages = [_package(stub) for stub in STUBS]
    code = (
        f"import importlib, sys\nfor name in {packages!r}: importlib.import_module(name)\n"
        "heavy = {'numpy', 'scipy', 'mujoco', 'igl', 'matplotlib', 'PySide6', 'mcap'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


ORDER = ("robot", "skin", "map_", "settings", "effects", "options", "spec", "path")
"""First what there is, from body to map; then how it is wanted; then the file, which leads where it is read."""


def test_constructors_agree_in_the_order_of_their_arguments():
    checked = 0
    for stub in STUBS:
        package = importlib.import_module(_package(stub))
        for name in package.__all__:
            made = getattr(package, name)
            if not (callable(made) and getattr(made, "__module__", "").startswith("app")):
                continue
            given = [word for word in inspect.signature(made).parameters if word in ORDER]
            given = given[1:] if given[:1] == ["path"] else given
            assert given == sorted(given, key=ORDER.index), f"{stub}: {name}({', '.join(given)})"
            checked += len(given) > 1
    assert checked > 15
