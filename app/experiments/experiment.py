"""An experiment: one question, the cases to ask it of, how to measure one, and how to draw the answer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from app.experiments.bars import Bars
from app.experiments.plot import Figure
from app.experiments.sweep import Case, Measure, Row


@dataclass(frozen=True)
class Experiment:
    """One question.

    Attributes:
        name: As the user writes it.
        question: What is asked, in one sentence.
        method: How it is measured, in a few sentences for the report.
        cases: What to measure, for ``quick`` (a minute's worth, for trying out) and a seed.
        measure: The rows of one case; in any process.
        figures: The diagrams of all rows.
    """

    name: str
    question: str
    method: str
    cases: Callable[[bool, int], Sequence[Case]]
    measure: Measure
    figures: Callable[[Sequence[Row]], Sequence[Figure | Bars]]
