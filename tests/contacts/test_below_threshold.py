"""A lasting load that no taxel reports is noted with its values, and nothing else is."""

import numpy as np
import pytest

from tactile_maps.session.prepare import open_scene
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.session.session import Session
from tactile_maps.tactile.mechanics.contact_notes import ContactNoteKind, contact_note_text

SCENE = """robot = "none"
taxel_file = "flat.csv"
[[objects]]
name = "book"
kind = "box"
size = [0.06, 0.06, 0.04]
at = [0.0, 0.0, 0.06997]
mass = {mass}
[effects]
{effects}
"""


def notes(folder, *, mass, effects="", seconds=0.4):
    """Return the last note on a load below the threshold, and the frame, after a box was put down on a flat skin."""
    places = np.linspace(-0.05, 0.05, 14)
    rows = [f"{x:.6f},{y:.6f},0.05,0,0,1" for x in places for y in places]
    (folder / "flat.csv").write_text("\n".join(["x,y,z,nx,ny,nz", *rows]))
    (folder / "scene.toml").write_text(SCENE.format(mass=mass, effects=effects))
    session = Session(prepare_cached(open_scene(str(folder / "scene.toml"))))
    frame = session.run_for(seconds)
    return [note for note in frame.notes if note.kind is ContactNoteKind.BELOW_THRESHOLD], frame


@pytest.mark.sampled(1)
@pytest.mark.parametrize("skin", ["water-fill", "half-space", "foundation"])
def test_light_wide_body_is_noted_with_force_pressure_and_threshold(tmp_path, skin):
    (note,), frame = notes(tmp_path, mass=0.2, effects=f'skin = "{skin}"\ntimestep = 0.0005')
    assert not frame.regions
    assert note.bodies[-1] == "skin"
    assert skin == "foundation" or note.bodies == ("book", "skin")
    assert note.force == pytest.approx(0.2 * 9.81, rel=0.01)
    assert 400 < note.pressure < 1000
    assert note.threshold == 1000.0
    assert "below the threshold of 1 kPa, so no contact is reported" in contact_note_text(note)


@pytest.mark.long
def test_body_above_the_threshold_is_not_noted(tmp_path):
    found, frame = notes(tmp_path, mass=0.5)
    assert frame.regions
    assert found == []


@pytest.mark.long
def test_sensor_threshold_applies_if_it_is_higher(tmp_path):
    (note,), frame = notes(tmp_path, mass=0.5, effects="threshold = { at = 2500.0 }")
    assert not frame.regions
    assert not frame.pressures.any()
    assert note.threshold == 2500.0
    assert note.force == pytest.approx(0.5 * 9.81, rel=0.01)


def test_short_touch_below_the_threshold_is_not_noted(tmp_path):
    found, frame = notes(tmp_path, mass=0.2, seconds=0.05)
    assert frame.pressures.any()
    assert found == []


def test_part_of_a_body_below_the_threshold_of_the_sensor_is_noted_with_its_share(tmp_path):
    (note,), frame = notes(tmp_path, mass=0.7, effects="threshold = { at = 1900.0 }\ngain_spread = { sd = 0.1 }")
    weight = 0.7 * 9.81
    reported = sum(region.force for region in frame.regions)
    assert 0 < reported < 0.65 * weight
    assert note.force == pytest.approx(weight, rel=0.01)
    assert note.share == pytest.approx(1 - reported / weight, abs=0.1)
    assert "on taxels that read less than the threshold of 1.9 kPa: contacts lack this part" in contact_note_text(note)
