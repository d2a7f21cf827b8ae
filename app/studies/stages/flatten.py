"""Which method flattens the patches, with the cuts that they have now."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from app.editing.document import MapDocument, PatchEdit
from app.editing.reflatten import ReflattenRequest, request_reflatten
from app.editing.seams import extra_seams
from app.flattening.methods import METHODS
from app.studies.stages.timed_flattening import (
    ERRORS,
    chart_errors,
    chosen_patches,
    distortion_percent,
    flatten_timed,
    seam_plan_fingerprint,
)
from app.studies.work_precision import Setting, Stage, Subject, Trial

_LENGTHS = (0.75, 0.5, 0.25, 0.0)


def settings(subject: Subject) -> list[Setting]:
    """Every method, and where it has a slider between angles and lengths, places of it."""
    asked = []
    for name, method in METHODS.items():
        asked += [_setting(subject, name, lengths) for lengths in (1.0, *(_LENGTHS if method.slides else ()))]
    now = current_setting(subject)
    return asked if now is None or now in asked else [*asked, now]


def trials(subject: Subject, setting: Setting) -> Iterator[Trial]:
    """Rounds on the way, then the patches laid flat so."""
    patches = chosen_patches(subject)
    laid = flatten_timed(patches, (edit for _, edit in _patch_edits(subject.document, setting)))
    lengths = setting.values.get("lengths", 1.0)
    if lengths == 1.0:
        for number in laid.shown[:-1]:
            errors = {"distortion": distortion_percent(laid.rounds[number])}
            yield Trial(setting, f"after round {number + 1}", 1e3 * laid.seconds[number], errors, usable=False)
    name = "" if lengths == 1.0 else f"{lengths:g} of the way from angles to lengths"
    errors = chart_errors(patches, laid.charts, laid.rounds[-1])
    yield Trial(setting, name, 1e3 * laid.seconds[-1], errors, laid.note, joined=lengths == 1.0)


def current_setting(subject: Subject) -> Setting | None:
    """That of the patches, if it is the same for all and can be tried."""
    ways = {(edit.method, edit.lengths) for edit in map(subject.document.patches.__getitem__, subject.patches)}
    if len(ways) != 1:
        return None
    ((method, lengths),) = ways
    return _setting(subject, method, lengths) if method in METHODS else None


def fingerprint(subject: Subject) -> str:
    """The cuts."""
    document = subject.document
    return " ".join(
        f"{seam_plan_fingerprint(document.patches[k].seams)}/{extra_seams(document, k)}" for k in subject.patches
    )


def reflatten_for(document: MapDocument, setting: Setting) -> ReflattenRequest:
    """The edit that puts a setting in force."""
    return request_reflatten(document, "Method", _patch_edits(document, setting))


def _setting(subject: Subject, method: str, lengths: float) -> Setting:
    values = {"lengths": lengths} if METHODS[method].slides else {}
    return Setting("flatten", method, values, subject.patches)


def _patch_edits(document: MapDocument, setting: Setting) -> list[tuple[int, PatchEdit]]:
    """The method, with as many seams as there are: methods are compared on the same cut."""
    edits = []
    for number in document.chosen(setting.patches):
        old, extra = document.patches[number], extra_seams(document, number)
        plan = replace(old.seams, extra=extra) if extra else old.seams
        lengths = float(setting.values.get("lengths", 1.0))
        edits.append((number, replace(old, method=setting.method, lengths=lengths, seams=plan)))
    return edits


def seconds(subject: Subject) -> float:
    """About how long all of it takes."""
    return 2 + 5e-4 * subject.faces


STAGE = Stage(
    "flatten",
    "Flatten",
    "Which way of laying flat distorts least, and how long does it take?",
    tuple(METHODS),
    ERRORS,
    settings,
    trials,
    fingerprint,
    seconds,
    current_setting,
    reflatten_for,
)
