"""The stages by name: those that make the map, then its image and its readings, and how all of it moves."""

from __future__ import annotations

from collections.abc import Mapping

from app.core.errors import MapError
from app.editing.document import MapDocument
from app.editing.reflatten import ReflattenRequest
from app.studies.stages import control, cut, flatten, image, simulation, touch
from app.studies.work_precision import Setting, Stage

_STAGES = (cut.STAGE, flatten.STAGE, image.STAGE, touch.STAGE, simulation.STAGE, control.STAGE)
STAGES: Mapping[str, Stage] = {stage.name: stage for stage in _STAGES}


def edits_map(setting: Setting) -> bool:
    """Whether a setting is put in force by an edit of the map."""
    return STAGES[setting.stage].reflatten is not None


def reflatten_for(document: MapDocument, setting: Setting) -> ReflattenRequest:
    """What the editor must compute for ``setting`` to be in force: exactly what was measured, but for pins.

    Raises:
        MapError: It is no edit of the map, or for patches that the map does not have.
    """
    make = STAGES[setting.stage].reflatten
    if make is None:
        raise MapError("this setting is none of the map's", place=setting.stage, value=setting.method)
    return make(document, setting)
