"""Option ``--all`` and the marks ``long``, ``rotating`` and ``sampled``; see ``tests/conftest.py``."""

from __future__ import annotations

import gc
from collections import Counter, defaultdict
from collections.abc import Hashable, Sequence
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

APART = tuple(Path(__file__).resolve().parents[1] / folder for folder in ("benchmarks", "x11"))
"""Folders that run only with ``--all`` or if they are named."""


def pytest_addoption(parser):
    """Add ``--all``."""
    parser.addoption("--all", action="store_true", help="every case, not only those of the default")


def pytest_configure(config):
    """Declare the marks and Hypothesis' settings; see ``tests.support.examples``."""
    config.addinivalue_line("markers", "long: only with --all")
    config.addinivalue_line("markers", "rotating: by default each value of each parameter, the others taking turns")
    config.addinivalue_line("markers", "sampled(n): by default n of its cases that are not long, spread evenly")
    count = 100 if everything(config) else 20
    # No time limits for running or generating examples, because both depend on the load of the machine.
    untimed = {"deadline": None, "suppress_health_check": [HealthCheck.too_slow]}
    settings.register_profile("tests", max_examples=count, derandomize=True, **untimed)
    settings.load_profile("tests")


def everything(config) -> bool:
    """Whether all cases run, because of ``--all`` or because a test is named."""
    return config.getoption("--all") or any("::" in str(arg) for arg in config.args)


def pytest_ignore_collect(collection_path, config):
    """Do not import folders that are omitted: some prepare their measurements at import, for seconds."""
    if collection_path in APART and not everything(config):
        named = [Path(str(arg)).resolve() for arg in config.args]
        return not any(path.is_relative_to(collection_path) for path in named) or None
    return None


def pytest_collection():
    """Collect no garbage while tests are collected: nearly all objects that are made then are kept."""
    gc.disable()


def pytest_pycollect_makeitem(collector, obj):
    """Make no cases of functions of which all are long."""
    marks = getattr(obj, "pytestmark", ())
    if not everything(collector.config) and any(mark.name == "long" for mark in marks) and not isinstance(obj, type):
        return []
    return None


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    """Deselect the cases that the default run omits, before other plugins visit each case."""
    if everything(config):
        return
    cases = defaultdict(list)
    for item in items:
        cases[item.nodeid.split("[")[0]].append(item)
    kept = set()
    for name, group in cases.items():
        short = [item for item in group if not item.get_closest_marker("long")]
        chosen = _default(short) if short else []
        if short and not chosen:
            raise pytest.UsageError(f"{name}: no case was chosen for the default run")
        kept |= {item.nodeid for item in chosen}
    config.hook.pytest_deselected(items=[item for item in items if item.nodeid not in kept])
    items[:] = [item for item in items if item.nodeid in kept]


def pytest_collection_finish():
    """Exclude the objects made so far from garbage collection, which shortens its passes.

    A tenth of them is garbage; to collect it first would take 0.6 s in each process and free no memory.
    """
    gc.freeze()
    gc.enable()


def _default(cases: list) -> list:
    """Return those of the short cases of one test that run by default."""
    mark = cases[0].get_closest_marker("sampled")
    if mark and len(cases) > mark.args[0]:
        count = mark.args[0]
        return [cases[(2 * k + 1) * len(cases) // (2 * count)] for k in range(count)]
    if not cases[0].get_closest_marker("rotating"):
        return cases
    # By identity: values need not be hashable, and all cases share the objects of ``parametrize``.
    chosen = covering([{(name, id(value)) for name, value in case.callspec.params.items()} for case in cases])
    return [cases[number] for number in chosen]


def covering(cases: Sequence[set[Hashable]]) -> list[int]:
    """Return indices of a few cases that together contain every value, each value about equally often."""
    used = Counter({value: 0 for case in cases for value in case})
    chosen = []
    while not all(used.values()):
        best = min(
            range(len(cases)),
            key=lambda number: (
                -sum(not used[value] for value in cases[number]),
                sum(used[value] for value in cases[number]),
            ),
        )
        chosen.append(best)
        used.update(cases[best])
    return sorted(chosen)
