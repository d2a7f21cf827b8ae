"""Which taxels are marked: broken by what the sensor drew, saturated by what it reads, never both."""

from __future__ import annotations

import numpy as np

from app.skin.skin import TaxelIdentity
from widgets.map_view.taxel_faults import NO_FAULTS, STROKES, Fault, TaxelFaults, broken_channels, fault_legend

PRESSURES = np.array([0.0, 5e3, 180e3, 179e3, 200e3, 180e3])
FAULTS = TaxelFaults(np.array([1, 0, 0, 0, 0, 2], np.int8), 180e3)


def test_each_taxel_has_one_fault_at_most():
    found = FAULTS.of(PRESSURES)
    assert np.flatnonzero(found[Fault.DEAD]).tolist() == [0]
    assert np.flatnonzero(found[Fault.STUCK]).tolist() == [5]
    assert np.flatnonzero(found[Fault.SATURATED]).tolist() == [2, 4]


def test_a_perfect_sensor_has_none():
    assert not NO_FAULTS.any
    assert not any(those.any() for those in NO_FAULTS.of(PRESSURES).values())
    assert not TaxelFaults(np.zeros(6, np.int8)).any
    assert TaxelFaults(most=1.0).any


def test_the_key_names_only_what_there_is():
    assert fault_legend(FAULTS.of(PRESSURES)) == (
        (Fault.DEAD, "1 taxel dead"),
        (Fault.STUCK, "1 taxel stuck"),
        (Fault.SATURATED, "2 taxels saturated"),
    )
    assert fault_legend(NO_FAULTS.of(PRESSURES)) == ()


def test_marks_differ_in_shape_not_only_in_colour():
    assert set(STROKES) == set(Fault)
    assert len({strokes.tobytes() for strokes in STROKES.values()}) == len(Fault)
    assert all(np.abs(strokes).max() == 1 for strokes in STROKES.values())


def test_broken_channels_are_named_by_module_and_saturated_ones_counted():
    modules, channels = [14, 0, 0, 0, 0, 15], [3, 0, 1, 2, 3, 0]
    legend = fault_legend(FAULTS.of(PRESSURES), TaxelIdentity(None, modules, channels))
    assert [text for _, text in legend] == [
        "1 taxel dead: module 14 (channel 3)",
        "1 taxel stuck: module 15 (channel 0)",
        "2 taxels saturated",
    ]
    assert fault_legend(FAULTS.of(PRESSURES), TaxelIdentity(None, modules))[0][1] == "1 taxel dead: module 14"


def test_many_broken_channels_stay_few_words():
    identity = TaxelIdentity(None, np.repeat([7, 2, 5, 9], 12), np.tile(np.arange(12), 4))
    those = np.ones(48, bool)
    those[[1, 13, 15]] = False
    assert (
        broken_channels(those, identity) == "module 2 (channels 0, 2, 4-11), module 5 (channels 0-11), 2 more modules"
    )
    assert broken_channels(those, TaxelIdentity()) == ""
