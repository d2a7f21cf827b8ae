"""How many seams: each lets the patch lie flatter, takes neighbours apart and costs time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from app.editing.document import MapDocument, PatchEdit
from app.editing.reflatten import ReflattenRequest, request_reflatten
from app.flattening.methods import METHODS
from app.studies.stages.timed_flattening import (
    ERRORS,
    chart_errors,
    chosen_patches,
    flatten_timed,
    seam_plan_fingerprint,
)
from app.studies.work_precision import Setting, Stage, Subject, Trial

AUTOMATIC = "automatic"
"""As many seams as are worth it."""
_MOST = 4
_NAMES = {AUTOMATIC: "automatic cuts", 0: "no extra cut", 1: "1 extra cut"}
_METHODS = ("symmetric-dirichlet", "arap", "lscm")


def settings(subject: Subject) -> list[Setting]:
    """0 to 4 seams more than drawn ones and the topology's, by three methods and the present one; and automatic."""
    now = current_setting(subject)
    methods = dict.fromkeys((*_METHODS, *([now.method] if now else [])))
    asked = [_setting(subject, method, extra) for method in methods for extra in range(_MOST + 1)]
    asked.append(_setting(subject, "symmetric-dirichlet", AUTOMATIC))
    return asked if now is None or now in asked else [*asked, now]


def trials(subject: Subject, setting: Setting) -> Iterator[Trial]:
    """The patches cut and laid flat so."""
    patches = chosen_patches(subject)
    laid = flatten_timed(patches, (edit for _, edit in _patch_edits(subject.document, setting)))
    errors = chart_errors(patches, laid.charts, laid.rounds[-1])
    extra = setting.values["extra"]
    name = _NAMES.get(extra, f"{extra} extra cuts")
    joined = extra in range(_MOST + 1)
    yield Trial(setting, name, 1e3 * laid.seconds[-1], errors, laid.note, joined=joined)


def current_setting(subject: Subject) -> Setting | None:
    """That of the patches, if it is the same for all and can be tried."""
    edits = [subject.document.patches[number] for number in subject.patches]
    ways = {(edit.method, edit.seams.extra) for edit in edits}
    if len(ways) != 1:
        return None
    ((method, extra),) = ways
    return _setting(subject, method, AUTOMATIC if extra is None else extra) if method in METHODS else None


def fingerprint(subject: Subject) -> str:
    """Drawn seams, areas of interest and the slider."""
    edits = [subject.document.patches[number] for number in subject.patches]
    return " ".join(f"{seam_plan_fingerprint(edit.seams)}/{edit.lengths:g}" for edit in edits)


def reflatten_for(document: MapDocument, setting: Setting) -> ReflattenRequest:
    """The edit that puts a setting in force."""
    return request_reflatten(document, "Number of cuts", _patch_edits(document, setting))


def _setting(subject: Subject, method: str, extra: str | int) -> Setting:
    return Setting("cut", method, {"extra": extra}, subject.patches)


def _patch_edits(document: MapDocument, setting: Setting) -> list[tuple[int, PatchEdit]]:
    extra = setting.values["extra"]
    edits = []
    for number in document.chosen(setting.patches):
        old = document.patches[number]
        plan = replace(old.seams, extra=None if extra == AUTOMATIC else int(extra))
        lengths = old.lengths if METHODS[setting.method].slides else 1.0
        edits.append((number, replace(old, method=setting.method, lengths=lengths, seams=plan)))
    return edits


def seconds(subject: Subject) -> float:
    """About how long all of it takes."""
    return 2 + 8e-4 * subject.faces


STAGE = Stage(
    "cut",
    "Cut",
    "What does each further cut gain, and what does it cost?",
    tuple(METHODS),
    ERRORS,
    settings,
    trials,
    fingerprint,
    seconds,
    current_setting,
    reflatten_for,
)
