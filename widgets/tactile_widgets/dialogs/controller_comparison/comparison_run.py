"""The comparison of controllers on one stimulus, as a function that runs in the background."""

from __future__ import annotations

from tactile_maps.studies.controller_comparison import Contender, ControllerTrace, compare_controllers
from tactile_widgets.jobs.executor import Report
from tactile_widgets.session.comparison_stimulus import ComparisonStimulus


def run_comparison(
    stimulus: ComparisonStimulus, contenders: tuple[Contender, ...], seconds: float, own_task: bool, report: Report
) -> tuple[ControllerTrace, ...]:
    """Return the trace of each contender; see ``compare_controllers``."""
    return compare_controllers(
        stimulus.prepared,
        contenders,
        inputs=stimulus.inputs,
        seconds=seconds,
        own_task=own_task,
        progress=report,
    )
