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
def test_cut_lowers_distortion_of_a_hemisphere_and_separates_neighbours(hemisphere):
    none = tried(hemisphere)
    two = tried(hemisphere, extra=2)
    assert two.errors["distortion"] < 0.8 * none.errors["distortion"]
    assert two.errors["torn"] > none.errors["torn"] == 0
    assert (none.name, two.name) == ("no extra cut", "2 extra cuts")
    assert none.joined
    assert not tried(hemisphere, extra=AUTOMATIC).joined


def test_settings_contain_0_to_4_cuts_and_the_current_one(hemisphere):
    requested = STAGE.settings(hemisphere)
    assert {s.values["extra"] for s in requested} == {0, 1, 2, 3, 4, AUTOMATIC}
    assert STAGE.current(hemisphere) in requested
    assert len(requested) == len({(s.method, s.values["extra"]) for s in requested})
    other = changed(hemisphere, 1, method="tutte")
    assert STAGE.current(other) == Setting("cut", "tutte", {"extra": AUTOMATIC}, (1,))
    assert STAGE.current(other) in STAGE.settings(other)


def test_different_patches_have_no_current_setting(tube):
    assert STAGE.current(changed(replace(tube, patches=(0, 1)), 0, method="tutte")) is None
    assert STAGE.current(changed(tube, 0, method="by hand")) is None


def test_slider_is_kept_if_the_method_has_one(hemisphere):
    slid = changed(hemisphere, 1, lengths=0.25)
    ways = [STAGE.recipes(slid, Setting("cut", name, {"extra": 1}, (1,))) for name in ("symmetric-dirichlet", "lscm")]
    assert [(number, way.lengths, way.seams.extra) for ((number, way),) in ways] == [(1, 0.25, 1), (1, 1.0, 1)]


def test_trials_become_outdated_when_the_slider_changes_but_not_the_number(hemisphere):
    now = hemisphere.recipes[1]
    basis = STAGE.fingerprint(hemisphere)
    assert STAGE.fingerprint(changed(hemisphere, 1, lengths=0.5)) != basis
    assert STAGE.fingerprint(changed(hemisphere, 1, method="tutte", seams=replace(now.seams, extra=3))) == basis
