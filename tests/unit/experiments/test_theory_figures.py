"""Figures of control against theory: theory and measured in one diagram, and a line that says why they part."""

from __future__ import annotations

from app.experiments.theory_figures import FIGURES, figures
from app.experiments.theory_rows import IDEAL_JOINTS, OURS


def row(figure, plant, measured, theory, explained, **said):
    off, left = (100 * (measured / each - 1) if each else None for each in (theory, explained))
    case = {"figure": figure, "what": "force", "law": "hybrid", "plant": plant, "x": 0.5}
    told = {"measured": measured, "theory": theory, "explained": explained}
    return case | told | {"off_percent": off, "explained_off_percent": left} | said


def test_a_figure_has_theory_each_plant_and_the_theory_of_ours():
    rows = [row("onset", IDEAL_JOINTS, 4120.0, 4000.0, 4000.0), row("onset", OURS, 9800.0, 4000.0, 10000.0)]
    (figure,) = figures(rows)
    (panel,) = figure.panels
    assert figure.title == FIGURES["onset"].title
    assert panel.curves["theory"] == [(0.5, 4000.0)]
    assert panel.curves[IDEAL_JOINTS] == [(0.5, 4120.0)]
    assert panel.curves[OURS] == [(0.5, 9800.0)]
    assert panel.curves["theory with that loop"] == [(0.5, 10000.0)]


def test_its_note_says_why_and_how_far():
    rows = [row("onset", IDEAL_JOINTS, 4120.0, 4000.0, 4000.0), row("onset", OURS, 9800.0, 4000.0, 10000.0)]
    note = figures(rows)[0].note
    assert note.startswith(FIGURES["onset"].why)
    assert "ideal joints 3 %;" in note
    assert f"{OURS} 145 %, 2 % of the theory with it" in note


def test_whole_arms_have_a_panel_a_robot_and_a_curve_a_law():
    rows = [row("arms", robot, 0.01, 0.07, 0.011, what=robot, law=law) for robot in ("arm", "ur5e")
            for law in ("hybrid", "qp")]  # fmt: skip
    (figure,) = figures(rows)
    assert [panel.title for panel in figure.panels] == ["arm", "ur5e"]
    assert list(figure.panels[0].curves) == ["theory with all joints", "hybrid", "qp"]


def test_what_the_theory_has_as_nothing_is_no_departure():
    (figure,) = figures([row("behind", OURS, 0.5, 0.0, 0.5)])
    assert "Farthest off" not in figure.note
