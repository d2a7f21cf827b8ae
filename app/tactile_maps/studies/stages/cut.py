"""Number of seams: each seam reduces distortion, separates neighbours and costs time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from tactile_maps.flattening.methods import METHODS
from tactile_maps.studies.stages.timed_flattening import (
    ERRORS,
    chart_errors,
    chosen_patches,
    common_recipe,
    flatten_timed,
    seam_plan_fingerprint,
)
from tactile_maps.studies.study.work_precision import PatchRecipe, Setting, Stage, Subject, Trial

AUTOMATIC = "automatic"
"""Smallest number of seams that reduces distortion enough."""
_MOST = 4
_NAMES = {AUTOMATIC: "automatic cuts", 0: "no extra cut", 1: "1 extra cut"}
_METHODS = ("symmetric-dirichlet", "arap", "lscm")


def settings(subject: Subject) -> list[Setting]:
    """Return 0 to 4 additional seams with three methods and the current one, and the automatic number of seams."""
    now = current_setting(subject)
    methods = dict.fromkeys((*_METHODS, *([now.method] if now else [])))
    found = [_setting(subject, method, extra) for method in methods for extra in range(_MOST + 1)]
    found.append(_setting(subject, "symmetric-dirichlet", AUTOMATIC))
    return found if now is None or now in found else [*found, now]


def trials(subject: Subject, setting: Setting) -> Iterator[Trial]:
    """Yield the patches cut and flattened with the setting."""
    patches = chosen_patches(subject)
    flattened = flatten_timed(patches, (recipe for _, recipe in recipes(subject, setting)))
    errors = chart_errors(patches, flattened.charts, flattened.rounds[-1])
    extra = setting.values["extra"]
    name = _NAMES.get(extra, f"{extra} extra cuts")
    joined = extra in range(_MOST + 1)
    yield Trial(setting, name, 1e3 * flattened.seconds[-1], errors, flattened.note, joined=joined)


def current_setting(subject: Subject) -> Setting | None:
    """Return the setting of the patches if it is the same for all and can be tried."""
    recipe = common_recipe(subject, lambda recipe: recipe.seams.extra)
    if recipe is None:
        return None
    return _setting(subject, recipe.method, AUTOMATIC if recipe.seams.extra is None else recipe.seams.extra)


def fingerprint(subject: Subject) -> str:
    """Return drawn seams, areas of interest and the lengths parameter."""
    own = [subject.recipes[number] for number in subject.patches]
    return " ".join(f"{seam_plan_fingerprint(recipe.seams)}/{recipe.lengths:g}" for recipe in own)


def recipes(subject: Subject, setting: Setting) -> list[tuple[int, PatchRecipe]]:
    """Return the patches with the method and number of seams of the setting, and the lengths parameter where used."""
    extra = setting.values["extra"]
    found = []
    for number in setting.patches:
        old = subject.recipes[number]
        plan = replace(old.seams, extra=None if extra == AUTOMATIC else int(extra))
        lengths = old.lengths if METHODS[setting.method].slides else 1.0
        found.append((number, PatchRecipe(setting.method, lengths, plan)))
    return found


def _setting(subject: Subject, method: str, extra: str | int) -> Setting:
    return Setting("cut", method, {"extra": extra}, subject.patches)


def seconds(subject: Subject) -> float:
    """Return the approximate duration of all trials [s]."""
    return 2 + 8e-4 * subject.faces


STAGE = Stage(
    "cut",
    "Cut",
    "How much does each additional seam reduce distortion, and what does it cost?",
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
