"""The comparison of what a scene simulates with everything switched the other way: changes, verdicts, scenes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import UsageError
from tactile_maps.scene.effects import EFFECTS
from tactile_maps.scene.tasks import OUTPUTS
from tactile_maps.studies.sweeps.needs import (
    STUDY,
    TOLERANCE,
    Verdict,
    change_of,
    measure,
    outputs_of,
    switched_to,
    verdict_of,
)
from tactile_maps.studies.testbeds.decision_scenes import decision_scenes
from tests.support.touch import prepared_bar


@pytest.fixture(scope="module")
def rows():
    case = {"scene": "poke", "seconds": 0.8, "seed": 0}
    return {row["effect"]: {**case, **row} for row in measure(case)}


@pytest.mark.long
def test_every_effect_is_toggled(rows):
    assert list(rows) == list(EFFECTS)
    for name, row in rows.items():
        assert row["switched"] != row["decided"].removesuffix(" s"), name


@pytest.mark.long
def test_required_effects_are_found(rows):
    for name in ("dynamics", "fingers", "skin"):
        assert rows[name]["verdict"] == Verdict.NEEDED.value
        assert rows[name]["change"] > 0.5
    assert 0 < rows["contact"]["change"] < TOLERANCE, "time averaging comes with it"
    assert rows["contact"]["verdict"] == Verdict.RIGHTLY_OFF.value
    assert rows["timestep"]["verdict"] == Verdict.FINE_ENOUGH.value
    assert rows["joint_limits"]["verdict"] == Verdict.SPARE.value
    assert {rows[name]["verdict"] for name in ("noise", "sampling")} == {Verdict.NO_OUTPUT.value}


@pytest.mark.long
@pytest.mark.parametrize("effect", ["skin", "timestep", "noise"])
def test_replay_applies_the_change_of_its_row(rows, effect):
    case = STUDY.replay(rows[effect])
    seen = []
    with case.session.watched(lambda frame: seen.append(frame.pressures)):
        case.play()
    scene = decision_scenes()["poke"]
    assert len(seen) == case.ticks == round(0.8 / scene.tick)
    assert case.session.prepared.scene.overrides == {**scene.overrides, effect: switched_to(row_of(scene, effect))}
    if rows[effect]["output"] == "pressure":
        decided = outputs_of(case.session.prepared, scene, 0.8)["pressure"]
        assert change_of("pressure", decided, np.array(seen)) == pytest.approx(rows[effect]["change"])


def row_of(scene, effect):
    return next(row for row in scene.unattended.rows if row.name == effect)


@pytest.fixture(scope="module")
def brief_row():
    case = {"scene": "poke", "seconds": 0.05, "seed": 0}
    return case | next(row for row in measure(case) if row["effect"] == "skin")


@pytest.mark.parametrize("change", [{"scene": "nowhere"}, {"effect": "gravitation"}])
def test_row_without_a_case_is_not_replayed(brief_row, change):
    with pytest.raises(UsageError, match="does not belong to a case of this study"):
        STUDY.replay(brief_row | change)


def test_change_is_relative_to_the_size_of_the_output():
    moved = np.array([[1.0, 5.0], [1.2, 5.0], [1.4, 5.0]])
    assert change_of("posture", moved, moved) == 0.0
    assert change_of("posture", moved, moved + [[0], [0.1], [0.2]]) == pytest.approx(0.5)
    assert change_of("pressure", 100 * moved, 100 * moved * 1.1) == pytest.approx(0.1)
    nothing = np.zeros((3, 2))
    assert change_of("force", nothing, nothing + 1e-4) == pytest.approx(1e-3)  # of the least that counts as a force
    assert change_of("pressure", np.zeros((3, 0)), np.zeros((3, 0))) == 0.0


def test_contact_that_begins_a_tick_later_does_not_count_as_a_jump_of_its_centre():
    decided = np.zeros((100, 3))
    decided[10:] = 0.1, 0.0, 0.2
    later = decided.copy()
    later[10] = 0.0
    assert change_of("centre_of_pressure", decided, later) == pytest.approx(0.01)
    assert change_of("centre_of_pressure", decided, np.zeros((100, 3))) == pytest.approx(0.9)
    assert change_of("centre_of_pressure", decided, decided * 1.1) == pytest.approx(0.1)


def test_every_output_has_a_signal():
    prepared = prepared_bar()
    scene = replace(prepared.scene, outputs=tuple(OUTPUTS))
    found = outputs_of(replace(prepared, scene=scene), scene, 0.05)
    assert list(found) == list(OUTPUTS)
    assert {len(values) for values in found.values()} == {10}


def test_falling_ball_starts_above_the_floor():
    floor, ball = decision_scenes()["arm under a falling ball"].objects
    assert ball.at[2] - ball.size[0] > floor.at[2]


def test_effects_with_more_than_two_choices_are_switched():
    decided = {row.name: row for row in decision_scenes()["view"].unattended.rows}
    assert switched_to(decided["skin"]) == "water-fill"
    assert switched_to(decided["integrator"]) == "implicit"
    assert switched_to(decided["timestep"]) == pytest.approx(0.0025)


@pytest.mark.parametrize(
    ("effect", "small", "large"),
    [
        ("skin", Verdict.SPARE, Verdict.NEEDED),
        ("friction", Verdict.RIGHTLY_OFF, Verdict.MISSING),
        ("timestep", Verdict.FINE_ENOUGH, Verdict.TOO_COARSE),
    ],
)
def test_change_above_the_tolerance_means_that_an_effect_matters(effect, small, large):
    row = row_of(decision_scenes()["poke"], effect)
    assert [verdict_of(row, factor * TOLERANCE) for factor in (0.9, 1.1)] == [small, large]


@pytest.mark.long
def test_physics_that_a_view_omits_would_change_its_postures():
    rows = {row["effect"]: row for row in measure({"scene": "view", "seconds": 0.5, "seed": 0})}
    assert rows["dynamics"]["verdict"] == Verdict.MISSING.value
    assert rows["friction"]["verdict"] == Verdict.RIGHTLY_OFF.value
