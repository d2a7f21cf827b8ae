"""Experiments are found by the names they have."""

from __future__ import annotations

from app.experiments.names import NAMES
from app.experiments.table import EXPERIMENTS


def test_names_are_their_own():
    assert list(EXPERIMENTS) == list(NAMES)
    for name, experiment in EXPERIMENTS.items():
        assert experiment.name == name
        assert experiment.question.endswith("?")
        assert experiment.cases(True, 0)
        assert len(experiment.cases(True, 0)) < len(experiment.cases(False, 0))
