"""Names of the studies, available without loading them."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from tactile_maps.core.errors import UsageError

if TYPE_CHECKING:
    from tactile_maps.studies.study.study import Study

_MODULES = {
    "map-cost": "sweeps.map_cost",
    "image-cost": "sweeps.image_cost",
    "touch-cost": "sweeps.touch_cost",
    "shear-cost": "sweeps.shear_cost",
    "shear-benefit": "sweeps.shear_benefit",
    "force-estimators": "sweeps.force_estimators",
    "step-cost": "sweeps.step_cost",
    "contact": "sweeps.contact",
    "effect-cost": "sweeps.effect_cost",
    "needs": "sweeps.needs",
    "representation": "path_time.representation",
    "force-feedback": "path_time.force_feedback",
    "loop-laws": "loop_laws.loop_laws",
    "controller-accuracy": "sweeps.controller_accuracy",
}
STUDY_NAMES = tuple(_MODULES)


def load_study(name: str) -> Study:
    """Return a study by name. Cost: up to 2 s to import its modules.

    Raises:
        UsageError: The study is unknown.
    """
    if name not in STUDY_NAMES:
        raise UsageError("unknown study", value=name, remedy=f"Choose {' or '.join(STUDY_NAMES)}")
    study: Study = import_module(f"tactile_maps.studies.{_MODULES[name]}").STUDY
    return study
