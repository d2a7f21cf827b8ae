"""The cutting stage: what is measured is what a click puts in force, and more cuts bring what they must."""

from __future__ import annotations

from dataclasses import replace

import pytest

from app.editing.document import MapDocument
from app.editing.reflatten import apply_result, reflatten
from app.studies.stages.cut import AUTOMATIC, STAGE
from app.studies.work_precision import Setting, Subject


def tried(subject, method="symmetric-dirichlet", extra=0):
    (found,) = STAGE.trials(subject, Setting("cut", method, {"extra": extra}, subject.patches))
    return found


def test_a_cut_lowers_a_hemispheres_distortion_and_takes_neighbours_apart(hemisphere):
    none, two = tried(hemisphere), tried(hemisphere, extra=2)
    assert two.errors["distortion"] < 0.8 * none.errors["distortion"]
    assert two.errors["torn"] > none.errors["torn"] == 0
    assert (none.name, two.name) == ("no extra cut", "2 extra cuts")
    assert none.joined
    assert not tried(hemisphere, extra=AUTOMATIC).joined


def test_the_settings_hold_0_to_4_cuts_and_the_present_one(hemisphere):
    asked = STAGE.settings(hemisphere)
    assert {s.values["extra"] for s in asked} == {0, 1, 2, 3, 4, AUTOMATIC}
    assert STAGE.current(hemisphere) in asked
    assert len(asked) == len({(s.method, s.values["extra"]) for s in asked})
    edit = replace(hemisphere.document.patches[1], method="tutte")
    other = Subject(hemisphere.document.with_patch(1, edit), (1,))
    assert STAGE.current(other) == Setting("cut", "tutte", {"extra": AUTOMATIC}, (1,))
    assert STAGE.current(other) in STAGE.settings(other)


def test_patches_that_differ_have_no_present_setting(bodies):
    mixed = bodies.with_patch(0, replace(bodies.patches[0], method="tutte"))
    assert STAGE.current(Subject(mixed, (0, 1))) is None
    by_hand = bodies.with_patch(0, replace(bodies.patches[0], method="by hand"))
    assert STAGE.current(Subject(by_hand, (0,))) is None


def test_using_a_setting_gives_the_map_that_was_measured(bodies, hemisphere):
    setting = Setting("cut", "arap", {"extra": 2}, (1,))
    used = apply_result(bodies, reflatten(STAGE.reflatten(bodies, setting)))
    assert STAGE.current(Subject(used, (1,))) == setting
    assert used.charts[0] is bodies.charts[0], "only the patch that was meant"
    assert used.charts[1].energies[-1] == pytest.approx(
        2 * sum((1 + tried(hemisphere, "arap", 2).errors["distortion"] / 100) ** power for power in (2, -2))
    )
    back = apply_result(
        used, reflatten(STAGE.reflatten(used, Setting("cut", "symmetric-dirichlet", {"extra": AUTOMATIC}, (1,))))
    )
    assert back.patches[1].seams.extra is None


def test_trials_are_out_of_date_when_the_slider_moved_not_when_the_number_did(bodies):
    def basis(**changed) -> str:
        edit = replace(bodies.patches[1], **changed)
        return STAGE.fingerprint(Subject(MapDocument(bodies.map, (bodies.patches[0], edit), bodies.order), (1,)))

    assert basis(lengths=0.5) != basis()
    assert basis(method="tutte", seams=replace(bodies.patches[1].seams, extra=3)) == basis()
