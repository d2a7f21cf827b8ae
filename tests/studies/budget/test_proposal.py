"""Settings within a budget: against every combination tried one by one."""

from __future__ import annotations

import itertools
import math
from dataclasses import astuple, replace

import numpy as np
import pytest

from tactile_maps.core.errors import BudgetError
from tactile_maps.studies.budget.proposal import (
    LIVE_STAGES,
    Budget,
    Cost,
    Option,
    fastest_path,
    options_of,
    propose,
    unbeaten,
)
from tactile_maps.studies.stages.simulation import BOUNCES
from tactile_maps.studies.study.work_precision import Setting, Trial

TICK = 0.005
FORCE = 3.0
PITCH = 8.0


def trial(stage, method="a", ms=1.0, *, errors=None, values=None, note="", usable=True):
    return Trial(Setting(stage, method, values or {}), "", ms, errors or {}, note, usable)


def random_options(seed, count=7):
    rng = np.random.default_rng(seed)
    return {
        stage: tuple(
            Option(trial(stage, f"{stage}-{number}"), Cost(*rng.lognormal(0, 1, 4).tolist())) for number in range(count)
        )
        for stage in LIVE_STAGES
    }


def wrong(cost):
    return math.hypot(cost.millimetres / PITCH, cost.newtons / FORCE, cost.pressure)


def total(options):
    ms, *errors = zip(*(astuple(option.cost) for option in options), strict=True)
    return Cost(sum(ms), *(math.hypot(*each) for each in errors))


@pytest.mark.parametrize("seed", range(8))
def test_no_combination_is_better_than_the_proposal(seed):
    options = random_options(seed)
    costs = [total(chosen) for chosen in itertools.product(*options.values())]
    middle = [float(np.median([getattr(cost, name) for cost in costs])) for name in ("milliseconds", "millimetres")]
    quick = propose(Budget(milliseconds=middle[0]), options, pitch_mm=PITCH, force=FORCE)
    assert wrong(quick.cost) == pytest.approx(min(wrong(cost) for cost in costs if cost.milliseconds <= middle[0]))
    fine = propose(Budget(millimetres=middle[1], newtons=9.0), options, pitch_mm=PITCH, force=FORCE)
    kept = [cost for cost in costs if cost.millimetres <= middle[1] and cost.newtons <= 9.0]
    assert fine.cost.milliseconds == pytest.approx(min(cost.milliseconds for cost in kept))
    assert astuple(fine.cost) == pytest.approx(astuple(total(fine.chosen.values())))
    assert wrong(fine.finest) == pytest.approx(min(map(wrong, costs)))
    both = propose(Budget(middle[0], middle[1]), options, pitch_mm=PITCH, force=FORCE)
    assert both.cost.milliseconds <= middle[0]
    assert both.cost.millimetres <= middle[1]


@pytest.mark.parametrize(
    ("limits", "problem"),
    [
        ((), "no limit"),
        ((0.0,), "positive"),
        ((math.nan,), "positive"),
        ((None, -1.0), "positive"),
        ((math.inf,), "positive"),
    ],
)
def test_meaningless_limits_are_rejected(limits, problem):
    with pytest.raises(BudgetError, match=problem):
        Budget(*limits)


def test_budget_out_of_reach_names_the_nearest_settings():
    options = {"touch": (Option(trial("touch"), Cost(2.0, 1.0, 0.1)), Option(trial("touch"), Cost(1.0, 3.0, 0.1)))}
    with pytest.raises(BudgetError, match=r"0\.5 ms.*nearest settings need 1 ms"):
        propose(Budget(milliseconds=0.5), options, pitch_mm=PITCH, force=FORCE)
    with pytest.raises(BudgetError, match=r"nearest settings need 1 mm, 0\.1 N"):
        propose(Budget(millimetres=0.9, newtons=0.09), options, pitch_mm=PITCH, force=FORCE)
    with pytest.raises(BudgetError, match="touch"):
        propose(Budget(milliseconds=5.0), {"touch": ()}, pitch_mm=PITCH, force=FORCE)


def test_only_settings_that_work_and_that_a_scene_can_have_are_options():
    step = {"timestep_ms": 1.0}
    good = trial("simulation", ms=20.0, errors={"force_percent": -2.0, "lost_percent": 0.0}, values=step)
    bad = [
        replace(good, note=BOUNCES),
        replace(good, errors={"force_percent": 0.0, "lost_percent": 3.0}),
        replace(good, usable=False),
        replace(good, milliseconds=None),
        replace(good, errors={"force_percent": math.nan, "lost_percent": 0.0}),
        replace(good, setting=Setting("simulation", "a", {"timestep_ms": 2.0})),  # 5 ms is no multiple
    ]
    (option,) = options_of("simulation", [*bad, good], tick=TICK, force=FORCE)
    assert option.cost == pytest.approx(Cost(0.1, 0.0, 0.06))
    narrow = trial("touch", "half-space", errors={"place_mm": 0.1, "force_percent": 0.0}, values={"share": 0.3})
    assert options_of("touch", [narrow], tick=TICK, force=FORCE) == ()


def test_dominated_settings_are_not_options():
    errors = {"place_mm": 1.0, "force_percent": 1.0, "depth_percent": 1.0}
    slow = trial("touch", "slow", 2.0, errors=errors)
    quick = trial("touch", "quick", 1.0, errors=errors)
    sharp = trial("touch", "sharp", 3.0, errors={**errors, "depth_percent": 0.5})
    found = unbeaten(options_of("touch", [slow, quick, sharp], tick=TICK, force=FORCE))
    assert [option.trial.setting.method for option in found] == ["quick", "sharp"]


def test_fastest_path_keeps_the_limits_and_the_contact():
    def round_in(seconds, mm, newtons, lost=0.0):
        return trial("control", ms=1e3 * seconds, errors={"body_mm": mm, "force_n": newtons, "lost_percent": lost})

    trials = [
        round_in(9.0, 1.0, 0.1),
        round_in(4.0, 2.0, 0.2),
        round_in(2.0, 2.0, 0.2, lost=1.0),
        round_in(1.0, 5.0, 0.1),
    ]
    assert fastest_path(Budget(millimetres=2.0, newtons=0.2), trials) is trials[1]
    assert fastest_path(Budget(newtons=0.1), trials) is trials[3]
    assert fastest_path(Budget(millimetres=0.5), trials) is None
    assert fastest_path(Budget(milliseconds=1.0), trials) is None, "the computer's time does not choose a controller"
