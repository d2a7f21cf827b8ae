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
"""Names of the edits in the history, by stage."""


def subject_of(
    document: MapDocument, patches: Iterable[int] | None = None, prepared: PreparedScene | None = None
) -> Subject:
    """Return the edited map with all or some patches, and the robot it covers. Pins are omitted."""
    numbers = range(len(document.patches))
    recipes = [
        PatchRecipe(edit.method, edit.lengths, edit.seams, extra_seams(document, number))
        for number, edit in enumerate(document.patches)
    ]
    names = tuple(edit.name for edit in document.patches)
    return Subject(document.map, tuple(numbers if patches is None else patches), tuple(recipes), names, prepared)


def reflatten_for(document: MapDocument, setting: Setting) -> ReflattenRequest:
    """Return the edit that applies ``setting``: exactly what was measured, except for pins.

    Raises:
        MapError: The setting does not belong to the map, or names patches that the map does not have.
    """
    stage = STAGES[setting.stage]
    if stage.recipes is None:
        raise MapError("not a setting of the map", place=setting.stage, value=setting.method)
    recipes = stage.recipes(subject_of(document), replace(setting, patches=tuple(document.chosen(setting.patches))))
    edits = [
        (number, replace(document.patches[number], method=way.method, lengths=way.lengths, seams=way.seams))
        for number, way in recipes
    ]
    return request_reflatten(document, _STEP_NAMES[setting.stage], edits)
