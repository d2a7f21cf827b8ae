"""A study: one question, the cases to ask it of, how to measure one, and how to draw the answer.

Studies of a stage of the program (``map_cost``, ``image_cost``, ``touch_cost``, ``step_cost``) try the stage's settings
on subjects whose truth is known; what they measure by are the stage's own trials, and their rows are those.

``tactile_maps.studies.running`` measures the cases, in one process or many, and puts their rows in one table.
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
    """A case of a study, to be simulated anew tick by tick.

    Attributes:
        session: At its beginning; what it is prepared from holds all that it simulates.
        ticks: How many there are.
        inputs: What is submitted before a tick, by its number from 0.
    """

    session: Session
    ticks: int
    inputs: Mapping[int, SessionInput]

    def play(self, progress: Progress = no_progress) -> None:
        """Simulate all of it.

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
    """One question.

    Attributes:
        name: As the user writes it.
        question: What is asked, in one sentence.
        method: How it is measured, in a few sentences for the report.
        cases: What to measure, for ``quick`` (a minute's worth, for trying out) and a seed.
        measure: The rows of one case; in any process, on any machine. A case is made of numbers and words.
        figures: The diagrams of all rows, or of those there are while others are still measured.
        hypotheses: What theory expects of them.
        effect: What its seeds are to decide; None where every seed of every case is wanted.
        replay: The run behind a row, by the row's own cells; None where a row is not of one run.
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
