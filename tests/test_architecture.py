"""Structure of the project: imports run one way, folders stay small, the library starts without a display."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from functools import cache
from graphlib import CycleError, TopologicalSorter
from importlib.metadata import packages_distributions
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = {"tactile_maps": ROOT / "app", "tactile_widgets": ROOT / "widgets"}
"""Packages with their folders."""
MOST_ENTRIES = {False: 15, True: 22}
"""Maximum number of entries of a folder, and of a package's root, whose entries are folders."""
SOURCES = sorted(path for package, folder in PACKAGES.items() for path in (folder / package).rglob("*.py"))


def test_sources_are_found():
    assert len(SOURCES) > 50


@pytest.mark.long  # tests/run.sh has just run it
def test_imports_between_layers_have_one_direction():
    done = subprocess.run(
        [Path(sys.executable).with_name("lint-imports"), "--no-cache"], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr


@cache
def imports_of_packages():
    return grimp.build_graph(*PACKAGES, cache_dir=None)


def test_no_modules_import_each_other():
    """Imports form no cycle, including those for type checking and those inside functions."""
    graph = imports_of_packages()
    imports = {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    assert len(imports) > 50
    try:
        TopologicalSorter(imports).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(reversed(error.args[1])))


def folder_of(module, packages):
    """Return the folder of a module, which is itself for a package."""
    return module if module in packages else module.rpartition(".")[0]


def branches(first, second):
    """Return the two folders at the level where the paths to two folders part; equal if one contains the other."""
    first = first.split(".")
    second = second.split(".")
    common = next(
        (level for level, (a, b) in enumerate(zip(first, second, strict=False)) if a != b), min(len(first), len(second))
    )
    return ".".join(first[: common + 1]), ".".join(second[: common + 1])


def test_imports_between_folders_have_one_direction():
    """A folder may import its subfolders, not the reverse, and of two sibling folders only one imports the other."""
    graph = imports_of_packages()
    packages = {module for module in graph.modules if graph.find_children(module)}
    directions = {}
    upward = []
    for module in graph.modules:
        for imported in graph.find_modules_directly_imported_by(module):
            here = folder_of(module, packages)
            there = folder_of(imported, packages)
            if here.startswith(f"{there}."):
                upward.append(f"{module} -> {imported}")
            elif here != there:
                directions.setdefault(branches(here, there), f"{module} -> {imported}")
    assert not upward
    mutual = [
        (found, directions[pair[::-1]])
        for pair, found in directions.items()
        if pair[0] < pair[1] and pair[::-1] in directions
    ]
    assert not mutual


def test_every_file_has_a_docstring():
    assert not [path for path in SOURCES if not re.match(r'r?"""\S', path.read_text(encoding="utf8"))]


def test_folders_have_few_entries():
    """A folder has at most ``MOST_ENTRIES`` entries, not counting ``__init__``."""
    folders = {path.parent for path in SOURCES}
    entries = {
        folder: {x for x in folder.iterdir() if x.suffix == ".py" or (x / "__init__.py").exists()} for folder in folders
    }
    full = {
        str(folder.relative_to(ROOT)): len(found)
        for folder, found in entries.items()
        if len(found - {folder / "__init__.py"}) > MOST_ENTRIES[folder.name in PACKAGES]
    }
    assert not full


@pytest.mark.long
def test_library_starts_without_a_display():
    """Importing the library loads neither Qt nor VTK; checked in a new interpreter, because this one has both."""
    modules = [
        ".".join(path.relative_to(ROOT / "app").with_suffix("").parts)
        for path in SOURCES
        if path.is_relative_to(ROOT / "app")
    ]
    names = [name.removesuffix(".__init__") for name in modules if not name.endswith("__main__")]
    code = (
        f"import importlib, sys\nfor name in {names!r}: importlib.import_module(name)\n"
        "qt = ('PySide6', 'pyvista', 'vtk', 'vtkmodules', 'tactile_widgets')\n"
        "bad = [m for m in sys.modules if m.split('.')[0] in qt]\n"
        "assert not bad, bad\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def imported_packages(path):
    """Return the top-level names of third-party packages that a file imports, also inside functions."""
    names = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf8"))):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and not node.level:
            names.append(node.module)
    return {name.split(".")[0] for name in names} - set(sys.stdlib_module_names) - set(PACKAGES)


def normalized(name):
    """Return a package name in normalized form (PEP 503)."""
    return re.sub(r"[-_.]+", "-", name).lower()


@pytest.mark.long
def test_imported_and_declared_packages_are_the_same():
    """Every imported package is declared, because a transitive dependency may disappear."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf8"))["project"]
    extras = project["optional-dependencies"]
    required = [*project["dependencies"], *(line for name, lines in extras.items() if name != "dev" for line in lines)]
    declared = {normalized(re.match(r"[\w.-]+", line)[0]) for line in required}
    providers = {"rerun": ["rerun-sdk"], **packages_distributions()}  # too large to be always installed
    imported = {name for path in SOURCES for name in imported_packages(path)}
    undeclared = {
        name for name in imported if not declared & {normalized(each) for each in providers.get(name, [name])}
    } - {"rclpy", "rosidl_runtime_py"}  # part of ROS 2, which is not on PyPI
    assert not undeclared
    used = {normalized(each) for name in imported for each in providers.get(name, [name])}
    # pyvistaqt imports qtpy; the wheel of iCub's models is located by its files.
    assert declared - used == {"qtpy", "icub-models"}


def test_frozen_classes_are_written_only_by_the_array_fields_module():
    """Frozen dataclasses are written only by ``ArrayFields`` and ``set_fields``."""
    around = [
        str(path.relative_to(ROOT)) for path in SOURCES if "object.__setattr__" in path.read_text(encoding="utf8")
    ]
    assert around == ["app/tactile_maps/core/arrays.py"]
