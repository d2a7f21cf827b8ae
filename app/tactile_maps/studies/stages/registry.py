"""Stages by name, in processing order: map, image, touch, simulation, control."""

from __future__ import annotations

from collections.abc import Mapping

from tactile_maps.studies.stages import control, cut, flatten, image, simulation, touch
from tactile_maps.studies.study.work_precision import Setting, Stage

_STAGES = (cut.STAGE, flatten.STAGE, image.STAGE, touch.STAGE, simulation.STAGE, control.STAGE)
STAGES: Mapping[str, Stage] = {stage.name: stage for stage in _STAGES}


def edits_map(setting: Setting) -> bool:
    """Return whether a setting is applied by an edit of the map."""
    return STAGES[setting.stage].recipes is not None
