"""Added plots that can be shown over a whole recording, and their units."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.recording.overview.curves import FrameQuantity, QuantityKind
from tactile_maps.skin.model.skin import Skin, taxels_with_axes
from tactile_widgets.plots.choice.plot_choice import OF_SHEAR, STANDARD, PlotKey, PlotKind, TaxelGroup
from tactile_widgets.plots.timeline.lanes import added_lanes

GROUP = TaxelGroup("palm", (3, 4, 5)).text


def test_added_plots_become_lanes_of_recorded_quantities(prepared):
    joint = prepared.robot.joints[2].name
    link = prepared.skin.patches[0].link
    keys = [
        PlotKey(PlotKind.JOINT, joint),
        PlotKey(PlotKind.JOINT_SPEED, joint),
        PlotKey(PlotKind.LINK, link),
        PlotKey(PlotKind.TAXEL, "7"),
        PlotKey(PlotKind.GROUP_FORCE, GROUP),
        PlotKey(PlotKind.GROUP_PRESSURE, GROUP),
    ]
    found = added_lanes(keys, prepared, ReadingUnits.CALIBRATED)
    assert [lane.key for lane in found] == keys
    assert [lane.unit for lane in found] == ["rad", "rad/s", "N", "kPa", "N", "kPa"]
    assert [lane.signed for lane in found] == [True, True, False, False, False, False]
    assert found[0].quantity == FrameQuantity(QuantityKind.JOINT_POSITION, (2,))
    assert found[4].quantity.areas == tuple(prepared.skin.areas[[3, 4, 5]])
    assert found[5].lane(9).title == "Pressure on palm (kPa)"


@pytest.mark.parametrize(
    "key",
    [
        *STANDARD,
        *OF_SHEAR,
        PlotKey(PlotKind.JOINT, "of another robot"),
        PlotKey(PlotKind.LINK, "of another robot"),
        PlotKey(PlotKind.TAXEL, "123456"),
        PlotKey(PlotKind.GROUP_FORCE, TaxelGroup("far", (1, 123456)).text),
        PlotKey(PlotKind.CONTACT, "1"),
        PlotKey(PlotKind.LIMIT, "joint-limit"),
    ],
    ids=lambda key: key.text,
)
def test_plots_missing_in_the_recording_are_omitted(prepared, key):
    assert added_lanes([key], prepared, ReadingUnits.CALIBRATED) == ()


def test_readings_in_counts_have_no_force_lane(prepared):
    keys = [PlotKey(PlotKind.GROUP_FORCE, GROUP), PlotKey(PlotKind.TAXEL, "7")]
    (taxel,) = added_lanes(keys, prepared, ReadingUnits.COUNTS)
    assert (taxel.key, taxel.unit) == (keys[1], "counts")


def test_shear_has_lanes_for_taxels_that_measure_it(prepared):
    (patch, *rest) = prepared.skin.patches
    skin = Skin((replace(patch, taxels=taxels_with_axes(patch.taxels, 3)), *rest))
    sheared = replace(prepared, skin=skin)
    force, friction = added_lanes(OF_SHEAR, sheared, ReadingUnits.CALIBRATED)
    assert (force.quantity.kind, force.unit) == (QuantityKind.SHEAR_FORCE, "N")
    assert (friction.quantity.kind, friction.unit, friction.factor) == (QuantityKind.FRICTION_IN_USE, "%", 100.0)
    (only,) = added_lanes(OF_SHEAR, sheared, ReadingUnits.COUNTS)
    assert only.key == OF_SHEAR[1]
