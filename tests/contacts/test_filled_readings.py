"""Estimates of the readings of broken taxels from their neighbours, and the areas that stay blind."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.contacts.detection.filled_readings import LIMIT, TaxelFill
from tactile_maps.contacts.pipeline import ContactPipeline, ReadingSettings, read_contacts
from tactile_maps.core.errors import MapError, SceneError
from tactile_maps.scene.effects import Effects
from tactile_maps.session.session import Session
from tactile_maps.skin.model.skin import merge_skins
from tactile_maps.tactile.mechanics.contact_notes import ContactNoteKind, contact_note_text
from tactile_maps.tactile.press import press_skin
from tactile_maps.tactile.sensors.sensor_effects import DeadTaxels, SensorEffects
from tests.support.touch import bar, bar_map, prepared_bar

MAP = bar_map(400, finer=3)
SKIN = MAP.skin
HOLE = int(np.linalg.norm(SKIN.patches[0].taxels.positions - [0.2, 0.0, 0.02], axis=1).argmin())
"""A taxel in the middle of the skin."""
THRESHOLD = 1000.0


def broken(*taxels: int) -> np.ndarray:
    mask = np.zeros(len(SKIN), dtype=bool)
    mask[list(taxels)] = True
    return mask


def neighbours(*taxels: int) -> set[int]:
    pairs = SKIN.neighbours
    near = pairs[np.isin(pairs[:, 0], taxels) | np.isin(pairs[:, 1], taxels)]
    return set(near.ravel().tolist()) - set(taxels)


def without(pressures: np.ndarray, *taxels: int, value: float = 0.0) -> np.ndarray:
    read = pressures.copy()
    read[list(taxels)] = value
    return read


def test_missing_taxels_under_uniform_pressure_are_estimated():
    even = np.full(len(SKIN), 5e3)
    filled = TaxelFill(SKIN, broken(HOLE)).fill(without(even, HOLE), threshold=THRESHOLD)
    assert filled.pressures[HOLE] == pytest.approx(5e3)
    assert np.array_equal(without(filled.pressures, HOLE), without(even, HOLE)), "working taxels keep their readings"


def test_contacts_on_a_hole_are_within_the_stated_interval():
    fill = TaxelFill(SKIN, broken(HOLE))
    off = []
    stated = []
    for taxel in (HOLE, *sorted(neighbours(HOLE))):
        for force in (3.0, 10.0):
            true = press_skin(SKIN, SKIN.taxel_point(taxel), force=force, radius=0.03)
            filled = fill.fill(without(true, HOLE), threshold=THRESHOLD)
            off.append(abs(float((filled.pressures - true) @ SKIN.areas)))
            stated.append(float(filled.sd @ SKIN.areas))
    assert np.mean(np.array(off) <= LIMIT * np.array(stated) + 1e-9) >= 0.85


def test_stuck_taxel_is_replaced_by_its_neighbours():
    fill = TaxelFill(SKIN, broken(HOLE))
    filled = fill.fill(without(np.zeros(len(SKIN)), HOLE, value=20e3), threshold=THRESHOLD)
    assert not filled.pressures.any()
    assert not filled.sd.any()


def test_noise_of_the_neighbours_is_not_a_contact():
    read = np.abs(np.random.default_rng(3).normal(0, 400.0, len(SKIN)))
    filled = TaxelFill(SKIN, broken(HOLE)).fill(without(read, HOLE), threshold=1200.0, noise=400.0)
    assert filled.pressures[HOLE] == 0


def test_nothing_is_estimated_across_patches():
    pair = merge_skins([SKIN, SKIN])
    mask = np.concatenate([broken(HOLE), np.zeros(len(SKIN), dtype=bool)])
    read = np.concatenate([np.zeros(len(SKIN)), np.full(len(SKIN), 5e3)])
    assert np.array_equal(TaxelFill(pair, mask).fill(read, threshold=THRESHOLD).pressures, read)


def test_broken_taxels_surrounded_by_broken_ones_are_blind():
    ring = neighbours(HOLE)
    fill = TaxelFill(SKIN, broken(HOLE, *ring))
    (area,) = fill.blind
    assert (area.link, area.taxels.tolist()) == ("bar", [HOLE])
    assert area.area == SKIN.areas[HOLE]
    even = np.full(len(SKIN), 5e3)
    filled = fill.fill(without(even, HOLE, *ring), threshold=THRESHOLD).pressures
    assert filled[HOLE] == 0
    assert (filled[list(ring)] > 2e3).all()
    assert contact_note_text(area.note) == (
        f"bar is blind at taxel {HOLE}, {1e4 * SKIN.areas[HOLE]:.3g} cm²: it is broken and has too few working "
        "neighbours"
    )


def test_blind_areas_are_connected_and_include_a_whole_dead_skin():
    (area,) = TaxelFill(SKIN, np.ones(len(SKIN), dtype=bool)).blind
    assert len(area.taxels) == len(SKIN)
    far = int(np.linalg.norm(SKIN.patches[0].taxels.positions - [0.3, 0.0, 0.02], axis=1).argmin())
    both = TaxelFill(SKIN, broken(HOLE, far, *neighbours(HOLE), *neighbours(far))).blind
    assert sorted(area.taxels.tolist() for area in both) == sorted([[HOLE], [far]])


def test_pipeline_reads_contacts_from_estimates_and_states_their_uncertainty():
    sensor = SensorEffects(dead_taxels=DeadTaxels(0.1))
    sense = ContactPipeline(bar(), MAP, sensor)
    sense.set_broken_taxels(broken(HOLE))
    true = press_skin(SKIN, SKIN.taxel_point(min(neighbours(HOLE))), force=10.0, radius=0.03)
    (region,) = sense.read(1, 0.0, np.zeros(1), without(true, HOLE))
    assert HOLE in region.taxels
    assert region.force_interval[0] <= 10.0 <= region.force_interval[1]
    sense.settings = ReadingSettings(broken_taxels="as-read")
    (unfilled,) = sense.read(2, 0.005, np.zeros(1), without(true, HOLE))
    assert unfilled.force == pytest.approx(without(true, HOLE)[unfilled.taxels] @ SKIN.areas[unfilled.taxels])
    assert region.force > unfilled.force
    with pytest.raises(SceneError, match="broken taxels"):
        ReadingSettings(broken_taxels="guessed")


def test_session_keeps_raw_readings_and_names_blind_areas():
    effects = Effects(sensor=SensorEffects(dead_taxels=DeadTaxels(dead=1.0)))
    frame = Session(prepared_bar(), effects=effects).tick()
    (note,) = [note for note in frame.notes if note.kind is ContactNoteKind.BLIND_AREA]
    assert note.bodies == ("taxels 0-59", "bar")
    assert note.area == pytest.approx(prepared_bar().skin.areas.sum())
    assert not frame.pressures.any()


def test_reading_that_is_missing_at_the_peak_is_estimated_as_that_of_a_broken_taxel():
    read = without(press_skin(SKIN, SKIN.taxel_point(HOLE), force=10.0, radius=0.03), HOLE, value=np.nan)
    (contact,) = read_contacts(MAP, read)
    pipeline = ContactPipeline(bar(), MAP, SensorEffects())
    pipeline.set_broken_taxels(broken(HOLE))
    (known,) = pipeline.read(1, 0.01, bar().home, read)
    assert contact.force == known.force > np.nansum(read * SKIN.areas) > 0
    assert contact.force_parts["dead_taxels"] == known.force_parts["dead_taxels"] > 0
    (found,) = ContactPipeline(bar(), MAP, SensorEffects()).read(1, 0.01, bar().home, read)
    assert (found.force, found.force_parts) == (known.force, known.force_parts)


def test_pipeline_follows_which_taxels_did_not_report():
    even = np.full(len(SKIN), 5e3)
    (other, *ring) = neighbours(HOLE)
    pipeline = ContactPipeline(bar(), MAP, SensorEffects())
    pipeline.set_broken_taxels(broken(other))
    frames = (
        without(even, other),
        without(even, HOLE, value=np.nan),
        without(even, HOLE, *ring, value=np.nan),
        without(even, other),
    )
    found = []
    for tick, read in enumerate(frames):
        (region,) = pipeline.read(tick, 0.01 * tick, bar().home, read)
        blind = [area.taxels.tolist() for area in pipeline.blind]
        found.append((region.force, region.force_parts["dead_taxels"], blind))
    assert found[3] == found[0]
    assert found[0][0] == found[1][0] == pytest.approx(even @ SKIN.areas)
    assert found[1][1] > found[0][1] > 0, "a broken taxel and a missing one"
    assert found[2][0] == pytest.approx(even @ SKIN.areas - 5e3 * SKIN.areas[HOLE])
    assert [blind for _, _, blind in found] == [[], [], [[HOLE]], []], "without a working neighbour"


def test_readings_that_cannot_be_estimated_are_rejected_with_the_taxel_and_the_remedy():
    pressures = np.zeros(len(SKIN))
    with pytest.raises(MapError, match=f"taxel {HOLE}: a pressure is infinite.*Use NaN"):
        read_contacts(MAP, without(pressures, HOLE, value=-np.inf))
    with pytest.raises(MapError, match=f"too few neighbours.*taxels 0.{len(SKIN) - 1}.*Read the skin again"):
        read_contacts(MAP, np.full(len(SKIN), np.nan))
