"""Settings proposed for a budget, compared with all combinations measured in the running scene, on three robots.

``over_best`` is the measured time of the proposal over that of the fastest combination within the limits,
``error_over_best`` its error over that of the most accurate combination that is fast enough, and ``additive`` the
measured time of a combination over the sum of its stages' times.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import astuple

import numpy as np
import pytest

from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepare import prepare
from tactile_maps.studies.budget.measurement import TIMED_STAGES, effects_of, measure_for_budget, tick_ms
from tactile_maps.studies.budget.proposal import Budget, Cost, propose
from tactile_maps.studies.study.work_precision import Subject

FORCE = 3.0


@pytest.mark.parametrize("name", ["arm", "ur5e", "icub"])
def test_proposal_compared_with_all_combinations(benchmark, name):
    prepared = prepare(load_scene(name))
    subject = Subject.of(prepared.map, prepared=prepared)
    how = {"paths": False, "progress": lambda *_: None}
    measured = benchmark.pedantic(measure_for_budget, (subject,), how, rounds=1)
    tried = [_tried(prepared, chosen, measured.pitch_mm) for chosen in itertools.product(*measured.options.values())]
    ms, mm, wrong, sums = (np.array(column) for column in zip(*tried, strict=True))
    over = []
    error_over = []
    for share in (0.1, 0.3, 0.5, 0.8):
        # The limit is one that both measurements can keep even if another program slows one of them.
        quick = Budget(milliseconds=float(np.quantile(np.maximum(ms, sums), share)))
        found = propose(quick, measured.options, pitch_mm=measured.pitch_mm, force=FORCE)
        error_over.append(_wrong(found.cost, measured.pitch_mm) / wrong[ms <= quick.milliseconds].min())
        fine = Budget(millimetres=float(np.quantile(mm, share)) * (1 + 1e-9))
        found = propose(fine, measured.options, pitch_mm=measured.pitch_mm, force=FORCE)
        real = _tried(prepared, tuple(found.chosen.values()), measured.pitch_mm)[0]
        over.append(real / ms[mm <= fine.millimetres].min())
    benchmark.extra_info["combinations"] = len(tried)
    benchmark.extra_info["over_best"] = [round(ratio, 3) for ratio in over]
    benchmark.extra_info["error_over_best"] = [round(ratio, 3) for ratio in error_over]
    benchmark.extra_info["additive"] = [round(float(q), 3) for q in np.quantile(ms / sums, [0.05, 0.5, 0.95])]


_KNOWN: dict[tuple[str, ...], float] = {}


def _tried(prepared, chosen, pitch_mm):
    """Return the time of a running combination [ms], its place and total errors, and the sum of its stages' times."""
    ms, *errors = zip(*(astuple(option.cost) for option in chosen), strict=True)
    first = Cost(sum(ms), *(math.hypot(*each) for each in errors))
    simulation, touch, image = chosen
    key = (prepared.scene.name, *(str(option.trial.setting) for option in (simulation, touch)))
    if key not in _KNOWN:
        spent = tick_ms(prepared, {**effects_of(simulation.trial), **effects_of(touch.trial)})
        _KNOWN[key] = sum(spent[name] for name in TIMED_STAGES.values())
    return _KNOWN[key] + image.cost.milliseconds, first.millimetres, _wrong(first, pitch_mm), first.milliseconds


def _wrong(cost, pitch_mm):
    return float(np.linalg.norm([cost.millimetres / pitch_mm, cost.newtons / FORCE, cost.pressure]))
