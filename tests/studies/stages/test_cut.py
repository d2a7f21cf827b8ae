"""The cutting stage: tested settings, the current setting, and the expected effect of more cuts."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tactile_maps.studies.stages.cut import AUTOMATIC, STAGE
from tactile_maps.studies.study.work_precision import Setting


def changed(subject, number, **how):
    """The subject with another recipe for one of its patches."""
    recipes = list(subject.recipes)
    recipes[number] = replace(recipes[number], **how)
    return replace(subject, recipes=tuple(recipes))


def tried(subject, method="symmetric-dirichlet", extra=0):
    (found,) = STAGE.trials(subject, Setting("cut", method, {"extra": extra}, subject.patches))
    return found


@pytest.mark.long
def test_cut_lowers_a_hemispheres_distortion_and_takes_neighbours_apart(hemisphere):
    none = tried(hemisphere)
    two = tried(hemisphere, extra=2)
    assert two.errors["distortion"] < 0.8 * none.errors["distortion"]
    assert two.errors["torn"] > none.errors["torn"] == 0
    assert (none.name, two.name) == ("no extra cut", "2 extra cuts")
    assert none.joined
    assert not tried(hemisphere, extra=AUTOMATIC).joined


def test_settings_hold_0_to_4_cuts_and_the_present_one(hemisphere):
    requested = STAGE.settings(hemisphere)
    assert {s.values["extra"] for s in requested} == {0, 1, 2, 3, 4, AUTOMATIC}
    assert STAGE.current(hemisphere) in requested
    assert len(requested) == len({(s.method, s.values["extra"]) for s in requested})
    other = changed(hemisphere, 1, method="tutte")
    assert STAGE.current(other) == Setting("cut", "tutte", {"extra": AUTOMATIC}, (1,))
    assert STAGE.current(other) in STAGE.settings(other)


def test_patches_that_differ_have_no_present_setting(tube):
    assert STAGE.current(changed(replace(tube, patches=(0, 1)), 0, method="tutte")) is None
    assert STAGE.current(changed(tube, 0, method="by hand")) is None


def test_slider_stays_where_the_method_has_one(hemisphere):
    slid = changed(hemisphere, 1, lengths=0.25)
    ways = [STAGE.recipes(slid, Setting("cut", name, {"extra": 1}, (1,))) for name in ("symmetric-dirichlet", "lscm")]
    assert [(number, way.lengths, way.seams.extra) for ((number, way),) in ways] == [(1, 0.25, 1), (1, 1.0, 1)]


def test_trials_are_out_of_date_when_the_slider_moved_not_when_the_number_did(hemisphere):
    now = hemisphere.recipes[1]
    basis = STAGE.fingerprint(hemisphere)
    assert STAGE.fingerprint(changed(hemisphere, 1, lengths=0.5)) != basis
    assert STAGE.fingerprint(changed(hemisphere, 1, method="tutte", seams=replace(now.seams, extra=3))) == basis
