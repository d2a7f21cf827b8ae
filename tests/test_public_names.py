"""Names exported by the two facades, and the order of their arguments."""

from __future__ import annotations

import ast
import importlib
import inspect
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
STUBS = sorted(path for source in ("app", "widgets") for path in (ROOT / source).rglob("__init__.pyi"))
FACADES = ("tactile_maps", "tactile_maps.live")


def _package(stub: Path) -> str:
    return ".".join(stub.parent.relative_to(ROOT).parts[1:])


def test_every_public_name_is_found():
    assert tuple(map(_package, STUBS)) == FACADES
    for stub in STUBS:
        package = importlib.import_module(_package(stub))
        assert package.__all__
        for name in package.__all__:
            assert getattr(package, name) is not None, (stub, name)


def test_stub_imports_only_the_names_it_declares():
    for stub in STUBS:
        tree = ast.parse(stub.read_text(encoding="utf8"))
        imported = [alias.name for node in tree.body if isinstance(node, ast.ImportFrom) for alias in node.names]
        assert sorted(imported) == sorted(importlib.import_module(_package(stub)).__all__), stub


def test_no_public_name_equals_a_module_name():
    """A shared name would be the function or the module, depending on the order of imports."""
    for stub in STUBS:
        modules = {path.stem for path in stub.parent.iterdir()}
        assert not modules.intersection(importlib.import_module(_package(stub)).__all__), stub


def test_package_facade_imports_no_heavy_modules():
    packages = [_package(stub) for stub in STUBS]
    code = (
        f"import importlib, sys\nfor name in {packages!r}: importlib.import_module(name)\n"
        "heavy = {'numpy', 'scipy', 'mujoco', 'igl', 'matplotlib', 'PySide6', 'mcap'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


ORDER = ("robot", "skin", "map_", "settings", "effects", "options", "spec", "path")
"""Order of arguments: body, map, options, output file; a file to be read comes first."""


def test_public_functions_have_consistent_argument_order():
    checked = 0
    for package in map(importlib.import_module, FACADES):
        for name in package.__all__:
            public = getattr(package, name)
            if not callable(public):
                continue
            given = [argument for argument in inspect.signature(public).parameters if argument in ORDER]
            given = given[1:] if given[:1] == ["path"] else given
            assert given == sorted(given, key=ORDER.index), f"{name}({', '.join(given)})"
            checked += len(given) > 1
    assert checked > 2
