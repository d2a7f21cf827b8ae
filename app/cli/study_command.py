"""``study``: measure what accuracy costs in time, and tell it in a table, a plot and a page."""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path

from app.cli.output import print_fields, print_json, progress_line
from app.core.errors import UsageError
from app.studies.catalogue import STUDY_NAMES
from app.studies.report import StudyResult, describe_machine, write_report
from app.studies.study import Study, run_cases

STUDIES: Mapping[str, Study] = {
    name: import_module(f"app.studies.sweeps.{name.replace('-', '_')}").STUDY for name in STUDY_NAMES
}


def execute(arguments: argparse.Namespace) -> int:
    """Run the study and write its report; Ctrl-C stops it and writes nothing."""
    if arguments.name not in STUDIES:
        choice = f"Choose {' or '.join(STUDIES)}"
        raise UsageError("there is no such study", value=arguments.name, remedy=choice)
    jobs = arguments.jobs or os.cpu_count() or 1
    if jobs < 1:
        raise UsageError("the number of jobs is below one", place="--jobs", value=jobs)
    study = STUDIES[arguments.name]
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
        told = {"Question": study.question, "Cases": f"{len(cases)} in {seconds:.1f} s", "Failed": failed}
        print_fields(told | {f"Written ({file.suffix[1:]})": file for file in files})
    return 1 if failed == len(rows) else 0
