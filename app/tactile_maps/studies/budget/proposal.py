"""Settings within a budget: the most accurate that are fast enough, or the fastest that are accurate enough.

A tick must keep up with the robot: steps of the simulation, a reading of the skin, an image of the map. The stages that
run in each tick have been tried one by one on the user's own robot (``work_precision.run_trials``); here their trials
are combined. Times add. Errors of different stages have different causes, so their squares add; the effect of a stage
on the error of another is neglected. All combinations of settings that no other setting beats are compared, so the
result is optimal for these figures.

The choice of a controller costs the robot's time instead of the computer's, so it is independent: the fastest trial of
a path whose true errors, to which all stages contribute, are within the limits. Cutting and flattening cost time once
and not in each tick, and stay unchanged.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import astuple, dataclass
from functools import reduce

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import BudgetError
from tactile_maps.scene.effects import Override
from tactile_maps.studies.stages.simulation import BOUNCES
from tactile_maps.studies.study.work_precision import Trial
from tactile_maps.tactile.mechanics.half_space_stress import TAIL_SHARE

LIVE_STAGES = ("simulation", "touch", "image")
"""Names of the stages that run in each tick."""


@dataclass(frozen=True)
class Cost:
    """Time and errors of settings.

    Attributes:
        milliseconds: Time of a tick.
        millimetres: Error of the place of a contact.
        newtons: Error of its force.
        pressure: Error of the displayed pressure, as a share; no budget limits it.
    """

    milliseconds: float
    millimetres: float = 0.0
    newtons: float = 0.0
    pressure: float = 0.0


@dataclass(frozen=True)
class Budget:
    """Maximum time of a tick, or maximum errors of a contact; None for no limit.

    Attributes:
        milliseconds: Maximum time of a tick.
        millimetres: Maximum error of a contact's place.
        newtons: Maximum error of its force.

    Raises:
        BudgetError: A limit is not a positive number, or there is none.
    """

    milliseconds: float | None = None
    millimetres: float | None = None
    newtons: float | None = None

    def __post_init__(self) -> None:
        limits = {"milliseconds": self.milliseconds, "millimetres": self.millimetres, "newtons": self.newtons}
        for name, limit in limits.items():
            if limit is not None and not (math.isfinite(limit) and limit > 0):
                raise BudgetError("a limit must be a positive number", place=name, value=limit)
        if all(limit is None for limit in limits.values()):
            raise BudgetError("there is no limit", remedy="Give milliseconds, or millimetres and newtons")

    @property
    def of_error(self) -> bool:
        """Whether an error is limited, so that the time is minimised; otherwise the error is minimised."""
        return self.millimetres is not None or self.newtons is not None


@dataclass(frozen=True)
class Option:
    """A setting of one stage that can be chosen, and its cost."""

    trial: Trial
    cost: Cost


def options_of(stage: str, trials: Iterable[Trial], *, tick: float, force: float) -> tuple[Option, ...]:
    """Return the settings of a stage that can be chosen: those that worked.

    Args:
        stage: One of ``LIVE_STAGES``.
        trials: All of its trials.
        tick: Control period [s].
        force: Usual contact force [N]; errors of the force are measured as a share of it.
    """
    costs = ((trial, _cost(stage, trial, tick, force)) for trial in trials)
    return tuple(Option(trial, cost) for trial, cost in costs if cost is not None)


def unbeaten(options: Iterable[Option]) -> tuple[Option, ...]:
    """Return the options that no other option beats in time and every error (Pareto), the fastest first."""
    ordered = sorted(options, key=lambda option: option.cost.milliseconds)
    costs = _table([option.cost for option in ordered])
    return tuple(option for option, own in zip(ordered, costs, strict=True) if not _beaten(own, costs))


def _cost(stage: str, trial: Trial, tick: float, force: float) -> Cost | None:
    """Cost of a trial in a tick; None if it cannot be chosen or lost the contact."""
    took = trial.milliseconds
    errors = trial.errors
    if not trial.usable or took is None or trial.note == BOUNCES or errors.get("lost_percent"):
        return None
    if trial.setting.values.get("share", TAIL_SHARE) != TAIL_SHARE:
        return None  # a scene has the half-space with the widest fields only
    if stage == "simulation":
        if abs(tick / step_of(trial) - round(tick / step_of(trial))) > 1e-6:
            return None  # a tick is a whole number of steps
        took *= tick  # that was of a simulated second
    place = errors.get("place_mm", errors.get("place", 0.0))
    share = errors.get("force_percent", 0.0)
    pressure = errors.get("depth_percent", errors.get("press", 0.0))
    if place is None or share is None or pressure is None or not math.isfinite(place + share + pressure):
        return None
    return Cost(took, abs(place), 1e-2 * abs(share) * force, 1e-2 * abs(pressure))


def effects_of(trial: Trial) -> dict[str, Override]:
    """Return the effects of a scene for the setting of a trial, by key; empty for the image, a setting of the view."""
    method = trial.setting.method
    if trial.setting.stage == "simulation":
        return {"integrator": method, "timestep": step_of(trial)}
    return {"skin": method} if trial.setting.stage == "touch" else {}


def step_of(trial: Trial) -> float:
    """Return the time step of a trial of the simulation [s]."""
    return 1e-3 * float(trial.setting.values["timestep_ms"])


def _table(costs: Sequence[Cost]) -> FloatArray:
    return np.array([astuple(cost) for cost in costs], float).reshape(-1, 4)


def _beaten(own: FloatArray, others: FloatArray) -> bool:
    """Whether any other row is nowhere worse and somewhere better."""
    return bool(((others <= own).all(axis=1) & (others < own).any(axis=1)).any())


@dataclass(frozen=True)
class Proposal:
    """Settings of all stages that run in each tick.

    Attributes:
        chosen: One option for each stage, by name.
        cost: Total cost.
        finest: Cost of the most accurate settings.
    """

    chosen: Mapping[str, Option]
    cost: Cost
    finest: Cost

    @property
    def effects(self) -> dict[str, Override]:
        """Effects of a scene for these settings, by key; the image is a setting of the view."""
        return {key: value for option in self.chosen.values() for key, value in effects_of(option.trial).items()}


def propose(budget: Budget, options: Mapping[str, Sequence[Option]], *, pitch_mm: float, force: float) -> Proposal:
    """Return the best settings within a budget, of all combinations of settings that no other of their stage beats.

    Args:
        budget: Limits.
        options: Options of each stage, see ``measurement``.
        pitch_mm: Spacing of the taxels. An error of a whole pitch has the same weight as one of the whole force, or of
            all the pressure.
        force: Usual contact force [N].

    Raises:
        BudgetError: A stage has no setting, or no combination is within the budget; the nearest one is reported.

    Cost: 1 ms.
    """
    options = {stage: unbeaten(of_stage) for stage, of_stage in options.items()}
    empty = [stage for stage, of_stage in options.items() if not of_stage]
    if empty or not options:
        raise BudgetError("no setting could be tried", place=", ".join(empty), remedy="Measure these stages")
    names = tuple(options)
    tables = [_table([option.cost for option in options[name]]) for name in names]
    costs = reduce(_combined, tables)
    wrong = np.linalg.norm(costs[:, 1:] / [pitch_mm, force, 1.0], axis=1)
    within = np.ones(len(costs), bool)
    for column, limit in enumerate((budget.milliseconds, budget.millimetres, budget.newtons)):
        if limit is not None:
            within &= costs[:, column] <= limit
    if not within.any():
        raise _out_of_reach(budget, costs, wrong)
    goal, tie = (costs[:, 0], wrong) if budget.of_error else (wrong, costs[:, 0])
    best = min(np.flatnonzero(within).tolist(), key=lambda row: (goal[row], tie[row]))
    picks = np.unravel_index(best, [len(table) for table in tables])
    chosen = {name: options[name][int(pick)] for name, pick in zip(names, picks, strict=True)}
    return Proposal(chosen, Cost(*costs[best].tolist()), Cost(*costs[int(wrong.argmin())].tolist()))


def _combined(one: FloatArray, other: FloatArray) -> FloatArray:
    """(a b, 4) costs of each row of (a, 4) with each of (b, 4), the last index changing fastest."""
    milliseconds = np.add.outer(one[:, 0], other[:, 0])
    errors = [np.hypot.outer(one[:, k], other[:, k]) for k in (1, 2, 3)]
    return np.stack([milliseconds, *errors], axis=-1).reshape(-1, 4)


def fastest_path(budget: Budget, trials: Iterable[Trial]) -> Trial | None:
    """Return the fastest trial of the control stage that is within the errors of a budget and never loses contact.

    None if the budget limits no error, or if no trial is within it.
    """
    place, force = (math.inf if limit is None else limit for limit in (budget.millimetres, budget.newtons))
    kept = [
        (trial.milliseconds, number, trial)
        for number, trial in enumerate(trials)
        if trial.milliseconds is not None
        and not trial.errors["lost_percent"]
        and _at_most(trial.errors["body_mm"], place)
        and _at_most(trial.errors["force_n"], force)
    ]
    return min(kept)[2] if kept and budget.of_error else None


def _at_most(error: float | None, limit: float) -> bool:
    return error is not None and error <= limit


def _out_of_reach(budget: Budget, costs: FloatArray, wrong: FloatArray) -> BudgetError:
    """Error with the nearest settings: the necessary values of all limits."""
    limits = {"ms": budget.milliseconds, "mm": budget.millimetres, "N": budget.newtons}
    given = {unit: (column, limit) for column, (unit, limit) in enumerate(limits.items()) if limit is not None}
    over = np.stack([costs[:, column] / limit for column, limit in given.values()]).max(axis=0)
    near = costs[int(np.lexsort((wrong, over))[0])]
    limits_text = ", ".join(f"{limit:.3g} {unit}" for unit, (_, limit) in given.items())
    least = ", ".join(f"{near[column]:.3g} {unit}" for unit, (column, _) in given.items())
    return BudgetError("no settings within the budget", value=limits_text, remedy=f"The nearest settings need {least}")
