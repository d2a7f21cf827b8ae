"""Method that flattens the patches, with their current seams."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from tactile_maps.flattening.methods import METHODS
from tactile_maps.studies.stages.timed_flattening import (
    ERRORS,
    chart_errors,
    chosen_patches,
    common_recipe,
    distortion_percent,
    flatten_timed,
    seam_plan_fingerprint,
)
from tactile_maps.studies.study.work_precision import PatchRecipe, Setting, Stage, Subject, Trial

_LENGTHS = (0.75, 0.5, 0.25, 0.0)


def settings(subject: Subject) -> list[Setting]:
    """Return every method, and several values of the lengths parameter for methods that have one."""
    found = []
    for name, method in METHODS.items():
        found += [_setting(subject, name, lengths) for lengths in (1.0, *(_LENGTHS if method.slides else ()))]
    now = current_setting(subject)
    return found if now is None or now in found else [*found, now]


def trials(subject: Subject, setting: Setting) -> Iterator[Trial]:
    """Yield intermediate rounds, then the patches flattened with the setting."""
    patches = chosen_patches(subject)
    flattened = flatten_timed(patches, (recipe for _, recipe in recipes(subject, setting)))
    lengths = setting.values.get("lengths", 1.0)
    if lengths == 1.0:
        for number in flattened.shown[:-1]:
            errors = {"distortion": distortion_percent(flattened.rounds[number])}
            yield Trial(setting, f"after round {number + 1}", 1e3 * flattened.seconds[number], errors, usable=False)
    name = "" if lengths == 1.0 else f"{lengths:g} of the way from angles to lengths"
    final = chart_errors(patches, flattened.charts, flattened.rounds[-1])
    yield Trial(setting, name, 1e3 * flattened.seconds[-1], final, flattened.note, joined=lengths == 1.0)


def current_setting(subject: Subject) -> Setting | None:
    """Return the setting of the patches if it is the same for all and can be tried."""
    recipe = common_recipe(subject, lambda recipe: recipe.lengths)
    return None if recipe is None else _setting(subject, recipe.method, recipe.lengths)


def fingerprint(subject: Subject) -> str:
    """Return the seams."""
    own = [subject.recipes[number] for number in subject.patches]
    return " ".join(f"{seam_plan_fingerprint(recipe.seams)}/{recipe.added}" for recipe in own)


def recipes(subject: Subject, setting: Setting) -> list[tuple[int, PatchRecipe]]:
    """Return the patches with the method of the setting and their current number of seams, so that methods compare."""
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
    """Return the approximate duration of all trials [s]."""
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
    "Errors are those of the whole patch, not of a sample: there is no interval.",
    current_setting,
    recipes,
)
