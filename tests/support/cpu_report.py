"""Options ``--cpu`` and ``--cpu-table FILE``: CPU time by folder, file and test, including finished child processes."""

from __future__ import annotations

import os
from collections import defaultdict
from pathlib import Path

import pytest

DEAREST = 40


def pytest_addoption(parser):
    """Add ``--cpu`` and ``--cpu-table``."""
    parser.addoption("--cpu", action="store_true", help="report CPU seconds by folder, file and test")
    parser.addoption("--cpu-table", type=Path, metavar="FILE", help="write the CPU seconds of all tests to FILE")


def _cpu_s() -> float:
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    """Give each report the CPU seconds of its phase."""
    report = yield
    report.cpu_s = item.stash.get(PHASE_CPU_S, 0.0)
    return report


PHASE_CPU_S = pytest.StashKey[float]()


def _measured(item):
    before = _cpu_s()
    try:
        return (yield)
    finally:
        item.stash[PHASE_CPU_S] = _cpu_s() - before


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_setup(item):
    """Measure the set-up of fixtures."""
    return (yield from _measured(item))


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_call(item):
    """Measure the test."""
    return (yield from _measured(item))


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_teardown(item):
    """Measure the tear-down of fixtures."""
    return (yield from _measured(item))


def pytest_terminal_summary(terminalreporter, config):
    """Print the table."""
    table_file = config.getoption("--cpu-table")
    if not (config.getoption("--cpu") or table_file):
        return
    phases = defaultdict(lambda: defaultdict(float))
    for reports in terminalreporter.stats.values():
        for report in reports:
            if hasattr(report, "cpu_s"):
                phases[report.nodeid][report.when] += report.cpu_s
    totals = {test: sum(by_phase.values()) for test, by_phase in phases.items()}
    folders = defaultdict(float)
    files = defaultdict(float)
    counts = defaultdict(int)
    for test, seconds in totals.items():
        path = test.split("::")[0]
        parts = Path(path).parts
        folder = "/".join(parts[1:-1][:2]) or parts[-1]
        folders[folder] += seconds
        files[path] += seconds
        counts[folder] += 1
        counts[path] += 1
    write = terminalreporter.write_line
    terminalreporter.section(f"CPU seconds: {sum(totals.values()):.0f} in {len(totals)} tests")
    for table, most in ((folders, None), (files, DEAREST)):
        for name, seconds in sorted(table.items(), key=lambda row: -row[1])[:most]:
            write(f"{seconds:9.1f}  {counts[name]:5}  {name}")
        write("")
    lines = []
    for test, seconds in sorted(totals.items(), key=lambda row: -row[1]):
        setup, call, teardown = (phases[test][phase] for phase in ("setup", "call", "teardown"))
        lines.append(f"{seconds:9.2f} {setup:8.2f} {call:8.2f} {teardown:8.2f}  {test}")
    write(f"{'all':>9} {'setup':>8} {'call':>8} {'teardown':>8}")
    for line in lines[:DEAREST]:
        write(line)
    if table_file:
        table_file.write_text("\n".join(lines) + "\n", encoding="utf-8")
