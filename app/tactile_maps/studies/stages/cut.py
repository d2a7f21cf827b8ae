"""How many seams: each lets the patch lie flatter, takes neighbours apart and costs time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from tactile_maps.flattening.methods import METHODS
from tactile_maps.studies.stages.timed_flattening import (
    ERRORS,
    chart_errors,
    chosen_patches,
    flatten_timed,
    seam_plan_fingerprint,
)
from tactile_maps.studies.study.work_precision import PatchRecipe, Setting, Stage, Subject, Trial

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
    """The patches, cut and flattened by the setting."""
    patches = chosen_patches(subject)
    laid = flatten_timed(patches, (recipe for _, recipe in recipes(subject, setting)))
    errors = chart_errors(patches, laid.charts, laid.rounds[-1])
    extra = setting.values["extra"]
    name = _NAMES.get(extra, f"{extra} extra cuts")
    joined = extra in range(_MOST + 1)
    yield Trial(setting, name, 1e3 * laid.seconds[-1], errors, laid.note, joined=joined)


def current_setting(subject: Subject) -> Setting | None:
    """That of the patches, if it is the same for all and can be tried."""
    ways = {(recipe.method, recipe.seams.extra) for recipe in map(subject.recipes.__getitem__, subject.patches)}
    if len(ways) != 1:
        return None
    ((method, extra),) = ways
    return _setting(subject, method, AUTOMATIC if extra is None else extra) if method in METHODS else None


def fingerprint(subject: Subject) -> str:
    """Drawn seams, areas of interest and the slider."""
    own = [subject.recipes[number] for number in subject.patches]
    return " ".join(f"{seam_plan_fingerprint(recipe.seams)}/{recipe.lengths:g}" for recipe in own)


def recipes(subject: Subject, setting: Setting) -> list[tuple[int, PatchRecipe]]:
    """The setting's patches with its method and number of cuts; the slider stays where the method has one."""
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
    """About how long all of it takes."""
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
    "Errors are those of the whole patch, not of a sample of it: there is no interval.",
    current_setting,
    recipes,
)
