"""The study of what measured shear buys: the same physics with a controller that uses it and one that does not."""

from __future__ import annotations

import pytest

from tactile_maps.studies.sweeps.shear_benefit import SHEAR, TASKS, cases, figures, measure


@pytest.fixture(scope="module")
def rows():
    return [{**case, **row} for case in cases(True, 0) for row in measure(case)]


def by_shear(rows, task):
    return [next(row for row in rows if (row["task"], row["shear"]) == (task, shear)) for shear in SHEAR]


@pytest.mark.long
def test_block_slips_where_shear_is_ignored(rows):
    used, ignored = by_shear(rows, "carry")
    assert abs(used["slip_mm"]) < 1.0
    assert ignored["slip_mm"] == pytest.approx(ignored["way_mm"], abs=1.0)
    assert min(used["way_mm"], ignored["way_mm"]) > 30
    assert used["force_n"] > ignored["force_n"]


@pytest.mark.long
def test_arm_follows_a_hand_farther_where_shear_is_used(rows):
    used, ignored = by_shear(rows, "guided_by_hand")
    assert used["way_mm"] == pytest.approx(60, abs=3)
    assert used["way_mm"] > ignored["way_mm"] + 3
    assert used["pull_n"] == pytest.approx(used["effort_mj"] / used["way_mm"])
    assert used["pull_n"] < ignored["pull_n"]


def test_figures_show_the_median_of_each_condition():
    made = [
        {"task": "carry", "friction": 0.8, "shear": "used", "seed": seed, "slip_mm": slip, "force_n": 5.0}
        for seed, slip in enumerate((0.1, 0.3, 0.2))
    ]
    slip = next(chart for chart in figures(made) if chart.title == "Slip of a lifted block")
    assert slip.amounts == {"friction 0.8, shear used": 0.2}


def test_every_friction_is_measured_with_and_without_shear():
    found = {(case["task"], case["friction"], case["shear"]) for case in cases(False, 0)}
    assert found == {(name, mu, shear) for name, task in TASKS.items() for mu in task.levels for shear in SHEAR}
