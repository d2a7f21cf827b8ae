"""Print the results of the benchmarks in one table: median, 95th percentile and, if a test states one, a ratio.

    .venv/bin/python -m pytest tests/benchmarks --benchmark-enable

Without ``--benchmark-enable`` each benchmark runs once, to prove that it runs. No benchmark asserts a time.
"""

from __future__ import annotations

import numpy as np

from tests.benchmarks.flatten_table import FLATTENING, write


def pytest_terminal_summary(terminalreporter, config):
    """Print the table; ``extra_info['per']`` states what one round is, ``extra_info['ratio']`` a comparison."""
    session = getattr(config, "_benchmarksession", None)
    measured = [bench for bench in getattr(session, "benchmarks", []) if bench.stats.rounds > 1]
    if not measured:
        return
    terminalreporter.section("measured (milliseconds)")
    terminalreporter.write_line(f"{'what':<58}{'median':>10}{'p95':>10}{'rounds':>8}  remark")
    for bench in measured:
        median, p95 = 1e3 * np.percentile(bench.stats.data, [50, 95])
        name = bench.name.removeprefix("test_").replace("_", " ")
        remark = "; ".join(f"{key}: {value}" for key, value in bench.extra_info.items())
        terminalreporter.write_line(f"{name:<58}{median:>10.3f}{p95:>10.3f}{bench.stats.rounds:>8}  {remark}")
    if FLATTENING in config.stash:
        terminalreporter.section("flattening, against peers")
        write(config.stash[FLATTENING], terminalreporter.write_line)
