"""``study``: measure accuracy against time; the result is a table, figures and a page."""

from __future__ import annotations

import argparse
import time
from contextlib import closing
from pathlib import Path

from tactile_maps.cli.shared.output import print_fields, print_json, print_warning, progress_line
from tactile_maps.cli.shared.outputs import check_outputs_in
from tactile_maps.cli.shared.workers import workers_from_arguments
from tactile_maps.core.errors import counted
from tactile_maps.studies.catalogue import load_study
from tactile_maps.studies.running.case_log import CaseLog
from tactile_maps.studies.running.case_run import CaseRun, paced
from tactile_maps.studies.running.sequential import Outcome, run_within
from tactile_maps.studies.running.workers import Workers
from tactile_maps.studies.study.report import (
    RunState,
    StudyResult,
    describe_machine,
    report_files,
    write_page,
    write_parquet,
    write_report,
)
from tactile_maps.studies.study.study import Study

_PAGE_SECONDS = 30.0
"""Minimum time between two pages during the measurement [s]: sixteen diagrams take some seconds."""


def execute(arguments: argparse.Namespace) -> int:
    """Run the study and write its report; Ctrl-C keeps the finished cases."""
    study = load_study(arguments.name)
    jobs, workers = workers_from_arguments(arguments)
    log_path = Path(arguments.output) / f"{study.name}.cases.jsonl"
    with closing(CaseLog(log_path, resume=arguments.resume, overwrite=arguments.overwrite)) as log:
        if not (arguments.resume or arguments.overwrite):
            check_outputs_in(Path(arguments.output), report_files(study), overwrite=False)
        if log.torn:
            print_warning(f"{log_path}: {counted(log.torn, 'damaged line')}, whose cases are measured again")
        outcome, files = _run(study, log, jobs, workers, arguments)
    return _report(outcome, files, arguments)


def _run(
    study: Study, log: CaseLog, jobs: int | None, workers: Workers, arguments: argparse.Namespace
) -> tuple[StudyResult, tuple[Path, ...]]:
    """Measure the cases; write the page occasionally and the complete report at the end."""
    folder = Path(arguments.output)
    machine = describe_machine()
    start = time.perf_counter()

    def outcome(*, running: bool) -> StudyResult:
        left = run.remaining if running else None
        state = RunState(run.done, len(run.cases), run.known, left, ended.spared, ended.undecided)
        seconds = time.perf_counter() - start
        return StudyResult(study, run.rows, machine, seconds, arguments.seed, jobs, arguments.quick, state)

    run = CaseRun(
        study.name,
        study.measure,
        study.cases(arguments.quick, arguments.seed),
        workers=workers,
        log=log,
        progress=progress_line(),
        watch=paced(lambda: write_page(outcome(running=True), folder), least=_PAGE_SECONDS),
    )
    ended = Outcome(0, ())
    try:
        if arguments.budget is None:
            run.go_on()
        else:
            ended = run_within(run, until=time.monotonic() + arguments.budget, effect=study.effect)
    except KeyboardInterrupt:
        if run.done:
            write_page(outcome(running=False), folder)
            print_warning(f"{run.done} of {len(run.cases)} cases are kept; continue with the same command and --resume")
        raise
    if run.done + ended.spared == len(run.cases):
        log.end()
    found = outcome(running=False)
    return found, write_report(found, folder) + write_parquet(found, folder)


def _report(outcome: StudyResult, files: tuple[Path, ...], arguments: argparse.Namespace) -> int:
    study = outcome.study
    rows = outcome.rows
    state = outcome.state or RunState(0, 0)
    failed = sum("problem" in row for row in rows)
    if arguments.json:
        print_json(
            {
                "name": study.name,
                "rows": rows,
                "files": [str(file) for file in files],
                "seconds": outcome.seconds,
                "machine": outcome.machine,
                "seed": outcome.seed,
                "cases": state.total,
                "known": state.known,
                "spared": state.spared,
                "undecided": list(state.undecided),
            }
        )
    else:
        before = f", {state.known} of them before" if state.known else ""
        of = f" of {state.total}" if state.done < state.total else ""
        found = {
            "Question": study.question,
            "Cases": f"{state.done}{of} in {outcome.seconds:.1f} s{before}",
            "Failed": failed,
        }
        found |= {"Not needed": f"{state.spared}, already settled"} if state.spared else {}
        found |= {f"Undecided ({number})": text for number, text in enumerate(state.undecided, 1)}
        print_fields(found | {f"Written ({file.suffix[1:]})": file for file in files})
    if not rows:
        print_warning("the budget ended before the first case: choose a longer --budget")
    return 1 if failed == len(rows) else 0
