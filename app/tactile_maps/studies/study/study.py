"""A study: a question, the cases to measure, the measurement of one case, and the figures of the answer.

Studies of a stage of the program (``map_cost``, ``image_cost``, ``touch_cost``, ``step_cost``) try the settings of the
stage on subjects with known truth. They use the trials of the stage, which become the rows of their tables.

``tactile_maps.studies.running`` measures the cases in one or several processes and collects their rows in one table.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.studies.base.figures import BarChart, Figure
from tactile_maps.studies.base.hypotheses import Hypothesis
from tactile_maps.studies.base.rows import Case, Measure, Row
from tactile_maps.studies.running.sequential import PairedEffect

if TYPE_CHECKING:
    from tactile_maps.session.inputs import SessionInput
    from tactile_maps.session.session import Session


@dataclass(frozen=True, eq=False)
class CaseReplay:
    """A case of a study that can be simulated again, tick by tick.

    Attributes:
        session: Session at its beginning; its prepared scene contains everything that it simulates.
        ticks: Number of ticks.
        inputs: Input to submit before a tick, by tick number from 0.
    """

    session: Session
    ticks: int
    inputs: Mapping[int, SessionInput]

    def play(self, progress: Progress = no_progress) -> None:
        """Simulate all ticks.

        Raises:
            SimulationError: The physics diverged, as it may have in the study.
        """
        for tick in range(self.ticks):
            if tick in self.inputs:
                self.session.submit(self.inputs[tick])
            self.session.tick()
            if tick % 50 == 0:
                progress("Simulating the case", tick / self.ticks)


@dataclass(frozen=True)
class Study:
    """A question and the method that answers it.

    Attributes:
        name: Name on the command line.
        question: The question, in one sentence.
        method: The method of measurement, in a few sentences for the report.
        cases: Cases to measure, for ``quick`` (about a minute, for trying out) and a seed.
        measure: Returns the rows of one case, in any process on any machine. A case contains numbers and words.
        figures: Diagrams of the rows, also of the rows of an unfinished run.
        hypotheses: Expectations from theory.
        effect: Effect that the seeds are to decide; None where every seed of every case is measured.
        replay: Returns the run behind a row, from the cells of the row; None where a row is not from one run.
    """

    name: str
    question: str
    method: str
    cases: Callable[[bool, int], Sequence[Case]]
    measure: Measure
    figures: Callable[[Sequence[Row]], Sequence[Figure | BarChart]]
    hypotheses: Sequence[Hypothesis] = ()
    effect: PairedEffect | None = None
    replay: Callable[[Row], CaseReplay] | None = None
