"""Share of true forces and places within the stated uncertainties. The goal is 68 % within the standard uncertainty of
the force and 95 % within its interval, among the touches for which an error is stated. Of places, whose uncertainty is
radial, the goal is 63 % and 98 %, and 52 % where they may be anywhere in one taxel.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.coverage import BODIES, EFFECTS, MODELS, OTHER_SKINS, Coverage, coverage, coverage_of, touch_errors

SKIN = "arm-1000"
COUNT = 900
"""Touches of each case; with pads a third of them is felt."""
STANDARD = 0.63, 0.73
INTERVAL = 0.92, 0.98
RARE = 60
"""Shares of fewer touches than these are not compared."""
SPREADING = [name for name in MODELS if name not in ("point", "depth")]
QUICK = ("gain spread", "noise", "hysteresis", "quantisation", "threshold", "saturation", "area averaging")


def assert_forces_are_covered(
    found: Coverage, standard: tuple[float, float] = STANDARD, interval: tuple[float, float] = INTERVAL
) -> None:
    """Compare the shares of forces with the goal, or with the stated bounds where the goal cannot be met."""
    if found.stated[0] >= RARE:
        assert standard[0] <= found.force[0] <= standard[1]
    if found.stated[1] >= RARE and not found.exact:
        assert interval[0] <= found.force[1] <= interval[1]


def assert_places_are_covered(found: Coverage) -> None:
    assert 0.40 <= found.place[0] <= 0.95
    assert found.place[1] >= 0.94


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("effect", QUICK)
def test_force_is_within_its_uncertainty_and_its_interval_as_often_as_stated(effect):
    found = coverage(SKIN, effect=effect, count=COUNT)
    assert found.stated[0] >= 290
    assert_forces_are_covered(found)
    assert_places_are_covered(found)


@pytest.mark.long
@pytest.mark.parametrize(
    ("model", "effect"),
    [
        ("half-space", "threshold"),
        ("half-space", "quantisation"),
        ("foundation", "none"),
        ("foundation", "noise"),
        ("point", "quantisation"),
    ],
)
def test_intervals_include_force_omitted_by_the_contact_model(model, effect):
    found = coverage(SKIN, model, effect, count=COUNT)
    assert found.stated[0] >= 300
    assert_forces_are_covered(found)


@pytest.mark.long
@pytest.mark.parametrize("skin", [SKIN, "arm-10000"])
def test_tails_are_read_to_their_end_without_noise(skin):
    table = touch_errors(skin, "half-space")
    assert len(table) > 290
    assert (np.abs(table[:, 0]) < 1e-4 * table[:, 4]).all()


@pytest.mark.long
@pytest.mark.parametrize("effect", ["threshold", "quantisation"])
def test_tails_that_a_fine_skin_does_not_read_are_within_the_interval(effect):
    """Half-space stress reaches beyond the ring of a contact and below the threshold of its taxels, 5 mm apart."""
    found = coverage("arm-10000", "half-space", effect)
    assert found.stated[1] > 290
    assert found.force[1] >= 0.92


@pytest.mark.long
def test_forces_of_the_surface_model_are_exact_without_effects():
    found = coverage(SKIN, "water-fill", "none")
    assert found.exact
    assert found.stated[0] == 0, "no error is stated at 68 %"


@pytest.mark.long
@pytest.mark.parametrize("skin", [SKIN, "arm-300", "bar-1000"])
def test_crosstalk_does_not_make_the_force_uncertain(skin):
    """Except for the few contacts whose rim is beyond the ring."""
    table = touch_errors(skin, "water-fill", "crosstalk")
    off = np.abs(table[:, 0]) > 1e-9 * table[:, 4]
    assert off.mean() <= 0.01
    assert (table[off, 4] < table[off, 6]).all()
    assert (table[:, 1] < 1e-4 * table[:, 4]).all(), "no error is stated at 68 %"


@pytest.mark.long
@pytest.mark.parametrize(("skin", "highest"), [("arm-300", 0.73), ("arm-500", 0.73), ("bar-300", 0.77)])
def test_threshold_of_wide_taxels_is_covered(skin, highest):
    """Most contacts are on one taxel, with a pitch of 12 to 30 mm, and the others lose up to the threshold of one.

    A fifth of those on the bar touch three taxels, which may be a wider body than these balls.
    """
    found = coverage(skin, effect="threshold", count=3 * COUNT)
    assert found.stated[0] > 1000
    assert_forces_are_covered(found, (0.63, highest))


@pytest.mark.long
@pytest.mark.parametrize("model", ["water-fill", "half-space"])
def test_forces_with_all_effects_are_within_their_uncertainty(model):
    found = coverage(SKIN, model, effect="all", count=COUNT)
    assert found.stated[0] > 300, "two of three touches press between the pads"
    assert_forces_are_covered(found, (0.63, 0.82))
    assert_places_are_covered(found)


@pytest.mark.long
def test_position_from_displaced_pads_is_covered():
    """Pads of the bar are up to 3 mm from their taxels, on a pitch of 11 mm."""
    found = coverage("bar-400", "water-fill", "area averaging")
    assert 0.58 <= found.place[0] <= 0.73
    assert found.place[1] >= 0.92


def test_pads_below_the_edges_of_a_face_are_covered():
    """A face covers more or fewer pads by where its edges are, which the readings do not show."""
    found = coverage_of(touch_errors("strip-110", effect="area averaging", body="box", count=200))
    assert found.stated[0] > 150
    assert_forces_are_covered(found, (0.57, 0.73), INTERVAL)
    assert 0.50 <= found.place[0] <= 0.73
    assert found.place[1] >= 0.92


@pytest.mark.long
def test_uncertainty_of_a_time_average_covers_changing_forces():
    """The error of a force that swings is close to the stated uncertainty most of the time."""
    found = coverage(SKIN, effect="time averaging")
    assert found.found > 290
    assert_forces_are_covered(found)


@pytest.mark.long
def test_depth_model_gives_a_position_and_a_force_of_unknown_accuracy():
    found = coverage(SKIN, "depth")
    assert found.found > 0
    assert found.ratio[0] == math.inf
    assert found.force == (1.0, 1.0)
    assert found.place[1] >= 0.95


@pytest.mark.long
def test_no_single_width_covers_the_forces_at_all_depths():
    """The true force is several times the reading, and neither factor nor scatter is the same on two skins."""
    factors = []
    for skin in (SKIN, "bar-400"):
        table = touch_errors(skin, "depth", count=COUNT)
        assert 0.02 * COUNT < len(table) < 0.12 * COUNT, "taxels feel only what is above them"
        true = table[:, 4]
        factors.append(true / (true + table[:, 0]))
        assert np.isinf(table[:, 6]).all()
    assert min(each.min() for each in factors) > 2
    assert np.median(factors[1]) > 2 * np.median(factors[0])
    assert all(np.percentile(each, 97.5) > 5 * np.percentile(each, 2.5) for each in factors)


STATED = {
    ("foundation", "hysteresis"): ((0.60, 0.73), (0.92, 0.985)),
    ("foundation", "saturation"): ((0.63, 0.76), INTERVAL),
    ("foundation", "all"): ((0.63, 0.82), (0.92, 0.985)),
    ("half-space", "all"): ((0.63, 0.76), INTERVAL),
    ("punch", "all"): ((0.63, 0.82), INTERVAL),
    ("water-fill", "all"): ((0.63, 0.82), INTERVAL),
    ("point", "saturation"): (STANDARD, (0.92, 1.0)),
    ("point", "threshold"): ((1.0, 1.0), (1.0, 1.0)),
    **{
        (model, effect): (STANDARD, (1.0, 1.0)) for model in ("water-fill", "punch") for effect in ("none", "crosstalk")
    },
    **{("half-space", effect): (STANDARD, (0.92, 0.985)) for effect in ("none", "crosstalk")},
    **{(model, "dead taxels"): ((0.63, 0.81), INTERVAL) for model in SPREADING},
    ("point", "dead taxels"): ((0.63, 1.0), (0.92, 1.0)),
}
"""Bounds where the goal is not met; the guide states the reasons."""


@pytest.mark.long
@pytest.mark.parametrize("effect", EFFECTS)
@pytest.mark.parametrize("model", [*SPREADING, "point"])
def test_every_effect_is_covered_in_every_contact_model(model, effect):
    found = coverage(SKIN, model, effect, count=COUNT)
    assert_forces_are_covered(found, *STATED.get((model, effect), (STANDARD, INTERVAL)))
    if found.found >= RARE:
        assert_places_are_covered(found)


@pytest.mark.long
@pytest.mark.parametrize("effect", EFFECTS)
@pytest.mark.parametrize("estimator", ["local-nnls", "tikhonov"])
def test_every_effect_is_covered_with_every_estimator(estimator, effect):
    found = coverage(SKIN, "half-space", effect, estimator, count=COUNT)
    if effect in ("none", "crosstalk", "saturation", "dead taxels"):
        assert found.force[1] >= 0.95, "the difference of the two forces bounds the error"
    else:
        assert_forces_are_covered(found, *STATED.get(("half-space", effect), (STANDARD, INTERVAL)))


@pytest.mark.long
@pytest.mark.parametrize("effect", ["none", "gain spread", "noise", "hysteresis", "all"])
def test_force_torque_interval_does_not_depend_on_the_skin(effect):
    found = coverage(SKIN, effect=effect, estimator="lumped", count=COUNT)
    assert_forces_are_covered(found)
    assert 0.60 <= found.place[0] <= 0.80
    assert found.place[1] >= 0.95


@pytest.mark.long
@pytest.mark.parametrize("skin", ["bar-400", "arm-100", "arm-10000"])
@pytest.mark.parametrize("effect", ["gain spread", "noise", "hysteresis", "area averaging", "threshold"])
def test_coverage_does_not_depend_on_the_skin(skin, effect):
    found = coverage(skin, effect=effect)
    if effect in ("gain spread", "noise", "hysteresis"):
        assert 0.60 <= found.force[0] <= 0.80
    assert found.force[1] >= 0.88
    assert found.place[1] >= 0.88


OTHER_BODIES = {
    ("cylinder", "threshold"): ((0.50, 0.73), (0.80, 0.98)),
    ("box", "threshold"): ((0.45, 0.73), (0.78, 0.98)),
    ("cylinder", "saturation"): ((0.80, 1.0), (0.97, 1.0)),
    ("box", "saturation"): ((0.90, 1.0), (0.97, 1.0)),
    ("cylinder", "dead taxels"): ((0.40, 0.73), (0.90, 1.0)),
    ("box", "dead taxels"): ((0.40, 0.73), (0.90, 1.0)),
}
"""Bounds where the goal is not met for bodies other than balls; the guide states the reasons."""


@pytest.mark.long
@pytest.mark.parametrize("effect", EFFECTS)
@pytest.mark.parametrize("body", BODIES)
def test_intervals_hold_for_skins_and_bodies_not_used_to_fit_widths(body, effect):
    tables = [touch_errors(skin, effect=effect, body=body, count=100) for skin in OTHER_SKINS]
    found = coverage_of(np.concatenate(tables))
    standard, interval = OTHER_BODIES.get((body, effect), ((0.55, 0.78), (0.88, 1.0)))
    assert_forces_are_covered(found, standard, interval)
