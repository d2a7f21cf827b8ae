"""The studies by name, for those who need not load them; each is a file of that name in ``sweeps``."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from app.core.errors import UsageError

if TYPE_CHECKING:
    from app.studies.study import Study

STUDY_NAMES = (
    "map-cost",
    "image-cost",
    "touch-cost",
    "step-cost",
    "effect-cost",
    "needs",
    "control-cost",
    "controller-accuracy",
)


def load_study(name: str) -> Study:
    """The study of a name. Cost: up to 2 s for the modules that it needs.

    Raises:
        UsageError: There is no such study.
    """
    if name not in STUDY_NAMES:
        raise UsageError("there is no such study", value=name, remedy=f"Choose {' or '.join(STUDY_NAMES)}")
    study: Study = import_module(f"app.studies.sweeps.{name.replace('-', '_')}").STUDY
    return study
