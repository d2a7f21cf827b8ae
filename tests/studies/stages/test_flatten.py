"""The flattening stage: all methods on the same cut, rounds on the way."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tactile_maps.flattening.methods import METHODS
from tactile_maps.studies.stages.flatten import STAGE
from tactile_maps.studies.study.work_precision import Setting


def tried(subject, method, **values):
    return list(STAGE.trials(subject, Setting("flatten", method, values, subject.patches)))


def test_every_method_is_tried_with_its_slider(hemisphere):
    requested = STAGE.settings(hemisphere)
    assert {s.method for s in requested} == set(METHODS) == set(STAGE.methods)
    assert [s.values for s in requested if s.method == "symmetric-dirichlet"] == [
        {"lengths": value} for value in (1.0, 0.75, 0.5, 0.25, 0.0)
    ]
    assert [s.values for s in requested if s.method == "tutte"] == [{}]
    assert STAGE.current(hemisphere) == requested[0]
    other = replace(hemisphere, recipes=(hemisphere.recipes[0], replace(hemisphere.recipes[1], lengths=0.37)))
    assert STAGE.current(other) in STAGE.settings(other), "the present place of the slider too"


def test_iterative_methods_report_iterations(hemisphere):
    *rounds, last = tried(hemisphere, "symmetric-dirichlet", lengths=1.0)
    assert len(rounds) > 2
    assert not any(trial.usable for trial in rounds)
    assert last.usable
    assert set(last.errors) == {kind.key for kind in STAGE.errors}
    assert rounds[0].errors["distortion"] > 2 * last.errors["distortion"]
    assert last.errors["distortion"] <= min(trial.errors["distortion"] for trial in rounds) * (1 + 1e-9)
    assert len(tried(hemisphere, "tutte")) == 1


@pytest.mark.long
def test_balanced_map_distorts_least_and_the_slider_gains_angles(hemisphere):
    last = {name: tried(hemisphere, name)[-1].errors for name in METHODS}
    assert last["symmetric-dirichlet"]["distortion"] <= min(e["distortion"] for e in last.values()) * 1.0001
    (slid,) = tried(hemisphere, "symmetric-dirichlet", lengths=0.0)
    assert slid.errors["angles"] < 0.7 * last["symmetric-dirichlet"]["angles"]
    assert not slid.joined


def test_methods_are_compared_on_the_present_cut(hemisphere):
    setting = Setting("flatten", "lscm", {}, (1,))
    assert [way.seams.extra for _, way in STAGE.recipes(hemisphere, setting)] == [None], "none was added"
    seamed = replace(hemisphere, recipes=(hemisphere.recipes[0], replace(hemisphere.recipes[1], added=2)))
    ((number, way),) = STAGE.recipes(seamed, setting)
    assert (number, way.method, way.seams.extra) == (1, "lscm", 2)
    assert STAGE.fingerprint(seamed) != STAGE.fingerprint(hemisphere)
