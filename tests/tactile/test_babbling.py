"""Babbling: what is touched, how, and how often."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import SimulationError
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.babbling import KINDS, BabbleSpec, babble
from tests.support.surfaces import frustum, sheet, skin_of


@pytest.fixture(scope="module")
def skin():
    return skin_of(sheet(40, 30), taxels=100)


@pytest.fixture(scope="module")
def two_patches():
    return skin_of(sheet(40, 30), frustum(along=30), taxels=60)


def _still(kind="unbiased", **spec):
    return BabbleSpec(kind, touches=spec.pop("touches", 300), noise=0.0, **spec)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("kind", KINDS)
def test_same_seed_gives_the_same_readings_bit_for_bit(skin, kind):
    spec = BabbleSpec(kind, touches=20, samples=3, rest=1)
    first = babble(skin, spec)
    assert first.shape == (80, 100)
    assert first.tobytes() == babble(skin, spec).tobytes()
    assert first.tobytes() != babble(skin, BabbleSpec(kind, touches=20, samples=3, rest=1, seed=1)).tobytes()


@pytest.mark.long
def test_each_touch_is_one_contact_with_radius_of_two_spacings_and_its_force(skin):
    readings = babble(skin, _still(force=10.0, radius=0.05))
    forces = readings @ skin.areas
    assert 5 <= forces.min() < 6
    assert 14 < forces.max() <= 15
    footprints = babble(skin, _still())
    positions = skin.patches[0].taxels.positions
    pitch = np.sqrt(2 / np.sqrt(3) * np.median(skin.areas))
    for row in footprints:
        touched = positions[row > 0]
        assert np.linalg.norm(touched - touched.mean(axis=0), axis=1).max() < 4 * pitch
    assert 8 < (footprints > 0).sum(axis=1).mean() < 24


@pytest.mark.long
def test_fine_parts_of_a_surface_are_not_touched_more_often():
    even = sheet(60, 40)
    x, y, z = even.vertices.T
    crowded = Mesh(np.stack([x**2 / 0.12, y, z], axis=1), even.faces)
    skin = skin_of(crowded, taxels=40)
    readings = babble(skin, _still(touches=1500, radius=0.01))
    middle = readings @ skin.patches[0].taxels.positions[:, 0] / readings.sum(axis=1)
    assert (middle < 0.06).mean() == pytest.approx(0.5, abs=0.05), "though most of the faces are there"
    assert (crowded.vertices[:, 0] < 0.06).mean() > 0.6


@pytest.mark.long
def test_noise_has_the_requested_deviation(skin):
    still, noisy = (babble(skin, BabbleSpec(touches=300, noise=noise)) for noise in (0.0, 0.05))
    noise = noisy - still
    assert noise.std() / still.max(axis=1).mean() == pytest.approx(0.05, rel=0.02)
    assert abs(noise.mean()) < 0.02 * noise.std()


@pytest.mark.long
def test_self_touch_presses_two_patches_with_the_same_force(two_patches):
    readings = babble(two_patches, _still("self-touch"))
    forces = [(readings * two_patches.areas)[:, two_patches.patch_of == patch].sum(axis=1) for patch in (0, 1)]
    assert forces[0] == pytest.approx(forces[1])
    assert forces[0].min() > 0


@pytest.mark.long
def test_multi_touch_has_three_simultaneous_touches(skin):
    assert (babble(skin, _still("multi-touch", force=1.0)) @ skin.areas).mean() == pytest.approx(3, rel=0.05)


@pytest.mark.long
def test_biased_touch_always_has_its_far_partner(skin):
    positions = skin.patches[0].taxels.positions
    pitch = np.sqrt(2 / np.sqrt(3) * np.median(skin.areas))
    here = 3
    there = 70
    assert np.linalg.norm(positions[here] - positions[there]) > 5 * pitch
    around = np.linalg.norm(positions - positions[there], axis=1) < 3 * pitch
    biased = babble(skin, _still("biased", together=(here, there), touches=1500))
    plain = babble(skin, _still("unbiased", touches=1500))
    for readings, expected in ((biased, 1.0), (plain, 0.0)):
        touched_here = readings[:, here] > 0.8 * readings.max(axis=1)
        assert touched_here.sum() > 10
        assert (readings[touched_here][:, around] > 0).any(axis=1).mean() == expected


@pytest.mark.long
def test_biased_touch_defaults_to_the_two_farthest_taxels(skin):
    positions = skin.patches[0].taxels.positions
    apart = np.linalg.norm(positions[:, None] - positions[None], axis=-1)
    a, b = np.unravel_index(apart.argmax(), apart.shape)
    chosen = babble(skin, _still("biased", together=(int(a), int(b))))
    assert chosen.tobytes() == babble(skin, _still("biased")).tobytes()


@pytest.mark.long
def test_stroke_wanders_over_the_skin_and_then_rests(skin):
    readings = babble(skin, _still(touches=40, samples=8, rest=3)).reshape(40, 11, 100)
    assert not readings[:, 8:].any()
    pressed = readings[:, :8] / readings[:, :8].sum(axis=2, keepdims=True)
    middle = pressed @ skin.patches[0].taxels.positions
    pitch = np.sqrt(2 / np.sqrt(3) * np.median(skin.areas))
    steps = np.linalg.norm(np.diff(middle, axis=1), axis=2) / pitch
    assert steps.max() < 1.5
    assert 0.4 < np.median(steps) < 0.8
    assert np.median(np.linalg.norm(middle[:, 7] - middle[:, 0], axis=1)) > 2 * pitch


@pytest.mark.parametrize(
    "wrong",
    [
        {"kind": "wild"},
        {"touches": 0},
        {"samples": 0},
        {"rest": -1},
        {"radius": 0.0},
        {"force": -1.0},
        {"noise": np.nan},
    ],
)
def test_invalid_setting_is_rejected(wrong):
    with pytest.raises(SimulationError):
        BabbleSpec(**wrong)


def test_invalid_skin_is_rejected(skin):
    with pytest.raises(SimulationError, match="no taxels"):
        babble(Skin(()), BabbleSpec())
    with pytest.raises(SimulationError, match="press together"):
        babble(skin, BabbleSpec("biased", touches=3, together=(0, 100)))
