"""Which method flattens the patches, with the cuts that they have now."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from tactile_maps.flattening.methods import METHODS
from tactile_maps.studies.stages.timed_flattening import (
    ERRORS,
    chart_errors,
    chosen_patches,
    distortion_percent,
    flatten_timed,
    seam_plan_fingerprint,
)
from tactile_maps.studies.study.work_precision import PatchRecipe, Setting, Stage, Subject, Trial

_LENGTHS = (0.75, 0.5, 0.25, 0.0)


def settings(subject: Subject) -> list[Setting]:
    """Every method, and where it has a slider between angles and lengths, places of it."""
    asked = []
    for name, method in METHODS.items():
        asked += [_setting(subject, name, lengths) for lengths in (1.0, *(_LENGTHS if method.slides else ()))]
    now = current_setting(subject)
    return asked if now is None or now in asked else [*asked, now]


def trials(subject: Subject, setting: Setting) -> Iterator[Trial]:
    """Rounds on the way, then the patches flattened by the setting."""
    patches = chosen_patches(subject)
    laid = flatten_timed(patches, (recipe for _, recipe in recipes(subject, setting)))
    lengths = setting.values.get("lengths", 1.0)
    if lengths == 1.0:
        for number in laid.shown[:-1]:
            off = {"distortion": distortion_percent(laid.rounds[number])}
            yield Trial(setting, f"after round {number + 1}", 1e3 * laid.seconds[number], off, usable=False)
    name = "" if lengths == 1.0 else f"{lengths:g} of the way from angles to lengths"
    errors = chart_errors(patches, laid.charts, laid.rounds[-1])
    yield Trial(setting, name, 1e3 * laid.seconds[-1], errors, laid.note, joined=lengths == 1.0)


def current_setting(subject: Subject) -> Setting | None:
    """That of the patches, if it is the same for all and can be tried."""
    ways = {(recipe.method, recipe.lengths) for recipe in map(subject.recipes.__getitem__, subject.patches)}
    if len(ways) != 1:
        return None
    ((method, lengths),) = ways
    return _setting(subject, method, lengths) if method in METHODS else None


def fingerprint(subject: Subject) -> str:
    """The cuts."""
    own = [subject.recipes[number] for number in subject.patches]
    return " ".join(f"{seam_plan_fingerprint(recipe.seams)}/{recipe.added}" for recipe in own)


def recipes(subject: Subject, setting: Setting) -> list[tuple[int, PatchRecipe]]:
    """The setting's patches by its method, with as many seams as there are: methods are compared on the same cut."""
    lengths = float(setting.values.get("lengths", 1.0))
    found = []
    for number in setting.patches:
        old = subject.recipes[number]
        plan = replace(old.seams, extra=old.added) if old.added else old.seams
        found.append((number, PatchRecipe(setting.method, lengths, plan)))
    return found


def _setting(subject: Subject, method: str, lengths: float) -> Setting:
    values = {"lengths": lengths} if METHODS[method].slides else {}
    return Setting("flatten", method, values, subject.patches)


def seconds(subject: Subject) -> float:
    """About how long all of it takes."""
    return 2 + 5e-4 * subject.faces


STAGE = Stage(
    "flatten",
    "Flatten",
    "Which flattening method distorts least, and how long does it take?",
    tuple(METHODS),
    ERRORS,
    settings,
    trials,
    fingerprint,
    seconds,
    "Errors are those of the whole patch, not of a sample of it: there is no interval.",
    current_setting,
    recipes,
)
