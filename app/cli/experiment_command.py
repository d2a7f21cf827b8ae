"""``experiment``: measure what accuracy costs in time, and tell it in a table, a plot and a page."""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

from app.cli.output import answer, facts, progress_line
from app.errors import UsageError
from app.experiments.machine import describe
from app.experiments.report import Outcome, write_report
from app.experiments.sweep import run_cases
from app.experiments.table import EXPERIMENTS


def execute(arguments: argparse.Namespace) -> int:
    """Run the experiment and write its report; Ctrl-C stops it and writes nothing."""
    if arguments.name not in EXPERIMENTS:
        choice = f"Choose {' or '.join(EXPERIMENTS)}"
        raise UsageError("there is no such experiment", value=arguments.name, remedy=choice)
    jobs = arguments.jobs or os.cpu_count() or 1
    if jobs < 1:
        raise UsageError("the number of jobs is below one", place="--jobs", value=jobs)
    experiment = EXPERIMENTS[arguments.name]
    start = time.perf_counter()
    cases = experiment.cases(arguments.quick, arguments.seed)
    rows = run_cases(experiment.measure, cases, jobs=jobs, progress=progress_line())
    seconds = time.perf_counter() - start
    outcome = Outcome(experiment, rows, describe(), seconds, arguments.seed, jobs, arguments.quick)
    files = write_report(outcome, Path(arguments.output))
    failed = sum("problem" in row for row in rows)
    if arguments.json:
        answer(
            {
                "name": experiment.name,
                "rows": rows,
                "files": [str(file) for file in files],
                "seconds": seconds,
                "machine": outcome.machine,
                "seed": arguments.seed,
            }
        )
    else:
        told = {"Question": experiment.question, "Cases": f"{len(cases)} in {seconds:.1f} s", "Failed": failed}
        facts(told | {f"Written ({file.suffix[1:]})": file for file in files})
    return 1 if failed == len(rows) else 0
