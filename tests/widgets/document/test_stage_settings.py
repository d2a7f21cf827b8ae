"""A measured setting and the edit that applies it give the same flattening."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.editing.reflatten import apply_result, reflatten
from tactile_maps.editing.seams import extra_seams
from tactile_maps.studies.stages.registry import STAGES
from tactile_maps.studies.study.work_precision import Setting
from tactile_widgets.document.stage_settings import reflatten_for, subject_of
from tests.widgets.support.samples import tube_and_hemisphere


@pytest.fixture(scope="module")
def bodies():
    return tube_and_hemisphere(600)


def used(document, *setting):
    """Return the document after applying a setting."""
    return apply_result(document, reflatten(reflatten_for(document, Setting(*setting))))


@pytest.mark.long
def test_applied_setting_gives_the_measured_map(bodies):
    setting = Setting("cut", "arap", {"extra": 2}, (1,))
    (trial,) = STAGES["cut"].trials(subject_of(bodies, (1,)), setting)
    after = used(bodies, "cut", "arap", {"extra": 2}, (1,))
    assert STAGES["cut"].current(subject_of(after, (1,))) == setting
    assert after.charts[0] is bodies.charts[0], "only the patch that was meant"
    stretch = 1 + trial.errors["distortion"] / 100
    assert after.charts[1].energies[-1] == pytest.approx(2 * (stretch**2 + stretch**-2))
    back = used(after, "cut", "symmetric-dirichlet", {"extra": "automatic"}, (1,))
    assert back.patches[1].seams.extra is None


def test_methods_apply_to_the_current_cut(bodies):
    seamed = used(bodies, "cut", "symmetric-dirichlet", {"extra": 2}, (1,))
    after = used(seamed, "flatten", "lscm", {}, (1,))
    assert STAGES["flatten"].current(subject_of(after, (1,))) == Setting("flatten", "lscm", {}, (1,))
    assert extra_seams(after, 1) == extra_seams(seamed, 1) == 2
    basis = [STAGES["flatten"].fingerprint(subject_of(each, (1,))) for each in (bodies, seamed, after)]
    assert basis[0] != basis[1] == basis[2]


def test_subject_equals_the_document(bodies):
    edited = bodies.with_patch(1, replace(bodies.patches[1], name="cap", lengths=0.5))
    subject = subject_of(edited)
    assert subject.map is bodies.map
    assert subject.patches == (0, 1)
    assert subject.names == ("tube", "cap")
    assert [recipe.lengths for recipe in subject.recipes] == [1.0, 0.5]
    assert subject_of(edited, (1,)).title == "cap"


def test_setting_that_is_not_of_the_map_is_rejected(bodies):
    assert reflatten_for(bodies, Setting("flatten", "tutte", {}, (0,))).name == "Method"
    with pytest.raises(MapError, match="not a setting of the map"):
        reflatten_for(bodies, Setting("image", "nearest", {"pixels": 64}))
    with pytest.raises(MapError, match="unknown patch number"):
        reflatten_for(bodies, Setting("flatten", "tutte", {}, (9,)))
