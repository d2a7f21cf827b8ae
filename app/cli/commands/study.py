"""``study``: measure what accuracy costs in time; the answer is a table, figures and a page."""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

from app.cli.output import print_fields, print_json, progress_line
from app.core.errors import UsageError
from app.studies.catalogue import load_study
from app.studies.report import StudyResult, describe_machine, write_report
from app.studies.study import run_cases


def execute(arguments: argparse.Namespace) -> int:
    """Run the study and write its report; Ctrl-C stops it and writes nothing."""
    study = load_study(arguments.name)
    jobs = arguments.jobs or os.cpu_count() or 1
    if jobs < 1:
        raise UsageError("the number of jobs is below one", place="--jobs", value=jobs)
    start = time.perf_counter()
    cases = study.cases(arguments.quick, arguments.seed)
    rows = run_cases(study.measure, cases, jobs=jobs, progress=progress_line())
    seconds = time.perf_counter() - start
    outcome = StudyResult(study, rows, describe_machine(), seconds, arguments.seed, jobs, arguments.quick)
    files = write_report(outcome, Path(arguments.output))
    failed = sum("problem" in row for row in rows)
    if arguments.json:
        print_json(
            {
                "name": study.name,
                "rows": rows,
                "files": [str(file) for file in files],
                "seconds": seconds,
                "machine": outcome.machine,
                "seed": arguments.seed,
            }
        )
    else:
        found = {"Question": study.question, "Cases": f"{len(cases)} in {seconds:.1f} s", "Failed": failed}
        print_fields(found | {f"Written ({file.suffix[1:]})": file for file in files})
    return 1 if failed == len(rows) else 0
