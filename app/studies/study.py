"""A study: one question, the cases to ask it of, how to measure one, and how to draw the answer.

Studies of a stage of the program (``map_cost``, ``image_cost``, ``touch_cost``, ``step_cost``) try the stage's settings
on subjects whose truth is known; what they measure by are the stage's own trials, and their rows are those.

``app.studies.running`` measures the cases, in one process or many, and puts their rows in one table.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from app.studies.figures import BarChart, Figure
from app.studies.hypotheses import Hypothesis
from app.studies.rows import Case, Measure, Row
from app.studies.running.sequential import PairedEffect


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
    """

    name: str
    question: str
    method: str
    cases: Callable[[bool, int], Sequence[Case]]
    measure: Measure
    figures: Callable[[Sequence[Row]], Sequence[Figure | BarChart]]
    hypotheses: Sequence[Hypothesis] = ()
    effect: PairedEffect | None = None
