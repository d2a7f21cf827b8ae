"""The study in time steps: verdicts that are right, errors that shrink with the step, a table that is whole."""

from __future__ import annotations

import pytest

from tactile_maps.studies.sweeps.step_cost import STUDY, figures, measure


def row(integrator, timestep_ms, stiffness):
    case = {"integrator": integrator, "timestep_ms": timestep_ms, "stiffness": stiffness, "seed": 0}
    (found,) = measure(case)
    return {**case, **found}


@pytest.fixture(scope="module")
def rows():
    requested = [("discrete", 1.0, 1e4), ("discrete", 8.0, 1e4), ("euler", 8.0, 1e4), ("implicitfast", 4.0, 1e4)]
    return [row(*each) for each in requested]


@pytest.mark.long
def test_rows_have_the_expected_verdicts(rows):
    assert [found["verdict"] for found in rows] == ["steady", "steady", "diverges", "bounces"]


@pytest.mark.long
def test_steady_contact_keeps_its_force(rows):
    for found in rows[:2]:
        assert found["force_percent"] < 0.1
        assert found["ripple_percent"] < 0.1
        assert found["lost_percent"] == 0


@pytest.mark.long
def test_bouncing_contact_is_lost_between_steps(rows):
    """The contact seems constant when sampled at every other step, so every step is checked."""
    assert rows[3]["lost_percent"] > 5
    assert rows[3]["ripple_percent"] > 50


@pytest.mark.long
def test_divergence_has_a_reason_and_no_numbers(rows):
    assert "time step" in rows[2]["note"]
    assert all(
        rows[2][key] is None for key in ("force_percent", "ripple_percent", "lost_percent", "posture_mrad", "ms")
    )
    assert rows[0]["note"] == ""


@pytest.mark.long
def test_shorter_step_is_more_accurate_and_slower(rows):
    assert rows[0]["posture_mrad"] < rows[1]["posture_mrad"] < 1
    assert rows[0]["ms"] > 3 * rows[1]["ms"]


@pytest.mark.long
def test_figures_have_a_panel_per_stiffness_and_a_curve_per_integrator(rows):
    posture, ripple = figures(rows)
    for figure in (posture, ripple):
        (panel,) = figure.panels
        assert set(panel.curves) == {"discrete", "euler", "implicitfast"}
        assert len(panel.curves["discrete"]) == 2
        assert panel.curves["euler"] == [], "what diverged is not drawn"
    assert STUDY.name == "step-cost"
