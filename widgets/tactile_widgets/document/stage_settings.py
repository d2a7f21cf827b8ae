"""Settings of ``tactile_maps.studies`` stages read from a map document, and the edit that applies one."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from tactile_maps.core.errors import MapError
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.reflatten import ReflattenRequest, request_reflatten
from tactile_maps.editing.seams import extra_seams
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.studies.stages.registry import STAGES
from tactile_maps.studies.study.work_precision import PatchRecipe, Setting, Subject

_STEP_NAMES = {"cut": "Number of cuts", "flatten": "Method"}
"""Of the edits, as the history shows them."""


def subject_of(
    document: MapDocument, patches: Iterable[int] | None = None, prepared: PreparedScene | None = None
) -> Subject:
    """The map as it is edited, all its patches or those named, and the robot that it covers. Pins are left out."""
    numbers = range(len(document.patches))
    recipes = [
        PatchRecipe(edit.method, edit.lengths, edit.seams, extra_seams(document, number))
        for number, edit in enumerate(document.patches)
    ]
    names = tuple(edit.name for edit in document.patches)
    return Subject(document.map, tuple(numbers if patches is None else patches), tuple(recipes), names, prepared)


def reflatten_for(document: MapDocument, setting: Setting) -> ReflattenRequest:
    """What the editor must compute for ``setting`` to be in force: exactly what was measured, but for pins.

    Raises:
        MapError: It is no edit of the map, or for patches that the map does not have.
    """
    stage = STAGES[setting.stage]
    if stage.recipes is None:
        raise MapError("this setting is none of the map's", place=setting.stage, value=setting.method)
    wanted = stage.recipes(subject_of(document), replace(setting, patches=tuple(document.chosen(setting.patches))))
    edits = [
        (number, replace(document.patches[number], method=way.method, lengths=way.lengths, seams=way.seams))
        for number, way in wanted
    ]
    return request_reflatten(document, _STEP_NAMES[setting.stage], edits)
