"""Faults of taxels: broken by the sensor, saturated by its readings, never both; blind areas."""

from __future__ import annotations

import numpy as np

from tactile_maps.contacts.detection.filled_readings import TaxelFill
from tactile_maps.skin.model.skin import TaxelIdentity
from tactile_maps.tactile.sensors.sensor_effects import DEAD, STUCK
from tactile_widgets.overlays.taxel_faults import (
    NO_FAULTS,
    STROKES,
    Fault,
    TaxelFaults,
    broken_channels,
    fault_legend,
)
from tactile_widgets.panels.touch.contacts_panel import faults_text, faults_tip
from tests.support.touch import bar_skin

PRESSURES = np.array([0.0, 5e3, 180e3, 179e3, 200e3, 180e3])
FAULTS = TaxelFaults(np.array([1, 0, 0, 0, 0, 2], np.int8), 180e3)


def test_taxel_has_at_most_one_fault():
    found = FAULTS.of(PRESSURES)
    assert np.flatnonzero(found[Fault.DEAD]).tolist() == [0]
    assert np.flatnonzero(found[Fault.STUCK]).tolist() == [5]
    assert np.flatnonzero(found[Fault.SATURATED]).tolist() == [2, 4]


def test_perfect_sensor_has_no_faults():
    assert not NO_FAULTS.any
    assert not any(mask.any() for mask in NO_FAULTS.of(PRESSURES).values())
    assert not TaxelFaults(np.zeros(6, np.int8)).any
    assert TaxelFaults(most=1.0).any


def test_legend_lists_only_existing_faults():
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
    modules = [14, 0, 0, 0, 0, 15]
    channels = [3, 0, 1, 2, 3, 0]
    legend = fault_legend(FAULTS.of(PRESSURES), TaxelIdentity(None, modules, channels))
    assert [text for _, text in legend] == [
        "1 taxel dead: module 14 (channel 3)",
        "1 taxel stuck: module 15 (channel 0)",
        "2 taxels saturated",
    ]
    assert fault_legend(FAULTS.of(PRESSURES), TaxelIdentity(None, modules))[0][1] == "1 taxel dead: module 14"


def test_many_broken_channels_are_abbreviated():
    identity = TaxelIdentity(None, np.repeat([7, 2, 5, 9], 12), np.tile(np.arange(12), 4))
    mask = np.ones(48, bool)
    mask[[1, 13, 15]] = False
    assert broken_channels(mask, identity) == "module 2 (channels 0, 2, 4-11), module 5 (channels 0-11), 2 more modules"
    assert broken_channels(mask, TaxelIdentity()) == ""


def blind_bar(*, estimated=True):
    """A bar with a single dead taxel, and a stuck one whose neighbours are stuck too."""
    skin = bar_skin()
    around = np.unique(skin.neighbours[(skin.neighbours == 30).any(axis=1)])
    broken = np.zeros(len(skin), np.int8)
    broken[around] = STUCK
    others = np.setdiff1d(np.arange(len(skin)), around)
    alone = next(int(taxel) for taxel in others if not broken[neighbours(skin, taxel)].any())
    broken[alone] = DEAD
    return skin, alone, TaxelFaults(broken).with_areas(skin, estimated=estimated)


def neighbours(skin, taxel):
    pairs = skin.neighbours[(skin.neighbours == taxel).any(axis=1)]
    return pairs[pairs != taxel]


def test_blind_areas_are_the_broken_taxels_that_are_not_estimated():
    skin, alone, faults = blind_bar()
    found = faults.of(np.zeros(len(skin)))
    fill = TaxelFill(skin, faults.broken != 0)
    assert np.flatnonzero(found[Fault.BLIND]).tolist() == sorted(t for area in fill.blind for t in area.taxels.tolist())
    assert found[Fault.BLIND][30]
    assert not found[Fault.BLIND][alone]
    assert [fault for fault, _ in fault_legend(found)] == [Fault.DEAD, Fault.STUCK, Fault.BLIND]
    assert faults.words(found, 30) == "stuck, blind: too few working neighbours"
    assert faults.words(found, alone) == "dead, estimated from its neighbours"
    working = int(np.flatnonzero(faults.broken == 0)[0])
    assert faults.words(found, working) == ""


def test_no_taxel_is_blind_without_estimation():
    skin, alone, faults = blind_bar(estimated=False)
    found = faults.of(np.zeros(len(skin)))
    assert not found[Fault.BLIND].any()
    assert faults.words(found, alone) == "dead"


def test_blind_areas_of_another_skin_are_not_marked():
    _, _, faults = blind_bar()
    assert not any(mask.any() for mask in faults.of(np.zeros(7)).values())


def test_contacts_panel_counts_broken_taxels_and_names_blind_areas():
    _, _, faults = blind_bar()
    blind = sum(len(area.taxels) for area in faults.blind)
    area = 1e4 * sum(area.area for area in faults.blind)
    broken = int((faults.broken != 0).sum())
    assert faults_text(faults) == (
        f"{broken} broken taxels: {broken - blind} estimated from neighbours, {blind} blind ({area:.3g}\u202fcm²)"
    )
    assert faults_tip(faults).startswith("Bar is blind at taxel")
    assert "mean pressure of its working neighbours" in faults_tip(faults)
    assert faults_text(TaxelFaults(np.array([1, 0], np.int8))) == "1 broken taxel, used as read"
    assert faults_text(NO_FAULTS) == faults_text(TaxelFaults(most=1.0)) == ""
