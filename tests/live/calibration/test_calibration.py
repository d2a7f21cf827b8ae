"""Values become pressure by gain, offset and baseline, from a file, a tare or a known weight."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import LiveError
from tactile_maps.live.calibration.calibration import (
    GRAVITY,
    Calibration,
    ValueMode,
    load_calibration,
    save_calibration,
)
from tactile_maps.live.readings.readings import Unit
from tactile_maps.skin.model.skin import Patch, Skin, TaxelIdentity, taxels_with_axes
from tests.support.touch import bar_skin


def test_pressure_is_gain_times_the_reading_minus_offset_and_baseline():
    calibration = Calibration([2.0, -3.0], [10.0, 20.0])
    pressures = calibration.values(np.array([15.0, 15.0]), np.array([1.0, 0.0]), ValueMode.PRESSURE)
    assert pressures.tolist() == [8.0, 15.0]


def test_known_quantities_follow_from_the_unit():
    assert not Calibration.plain(3, Unit.COUNTS).known
    assert Calibration.plain(3, Unit.KILOPASCAL).gain.tolist() == [1000.0] * 3


@pytest.mark.parametrize("gain", [0.0, np.nan, np.inf, 1e12])
def test_invalid_gain_is_rejected(gain):
    with pytest.raises(LiveError, match="gain, taxel 1"):
        Calibration([1.0, gain], [0.0, 0.0])


def test_weight_sets_the_scale():
    areas = np.full(4, 1e-4)
    change = np.array([0.0, 5.0, 10.0, 0.0])
    calibration = Calibration.plain(4, Unit.COUNTS).with_weight(change, areas, 0.2)
    assert np.isclose((calibration.gain * change * areas).sum(), 0.2 * GRAVITY)
    assert calibration.known
    with pytest.raises(LiveError, match="readings fall under the weight"):
        calibration.with_weight(-change, areas, 0.2)
    with pytest.raises(LiveError, match="out of range"):
        calibration.with_weight(change, areas, np.nan)


def test_saved_calibration_is_read_back_unchanged(tmp_path):
    random = np.random.default_rng(0)
    path = tmp_path / "gains.csv"
    saved = Calibration(random.uniform(1, 5, 60), random.normal(size=60))
    save_calibration(saved, path)
    back = load_calibration(path, bar_skin())
    assert np.array_equal(back.gain, saved.gain)
    assert np.array_equal(back.offset, saved.offset)


CURVE = np.array([[[0.0, 10.0, 30.0], [0.0, 200.0, 1200.0]]])


def test_curve_is_interpolated_and_continued_with_the_sign_of_the_gain():
    for sign in (1.0, -1.0):
        calibration = Calibration([sign], [100.0], curve=CURVE)
        found = [calibration.pressures(sign * np.array([change]))[0] for change in (-1.0, 0.0, 5.0, 20.0, 40.0)]
        assert found == [-20.0, 0.0, 100.0, 700.0, 1700.0]
        assert calibration.slope.tolist() == [sign * 20.0]


def test_weight_scales_the_curve():
    areas = np.array([1e-4])
    scaled = Calibration([1.0], [0.0], curve=CURVE).with_weight(np.array([20.0]), areas, 0.1)
    assert np.isclose(scaled.pressures(np.array([20.0]))[0] * 1e-4, 0.1 * GRAVITY)
    assert np.isclose(scaled.gain[0], 0.1 * GRAVITY / 0.07)


@pytest.mark.parametrize("points", [[[0, 1, 1], [0, 1, 2]], [[0, 1, 2], [0, 2, 1]], [[1, 2, 3], [0, 1, 2]]])
def test_curve_that_does_not_increase_from_zero_is_rejected(points):
    with pytest.raises(LiveError, match="points, taxel 0: a curve does not increase from 0"):
        Calibration([1.0], [0.0], curve=[points])


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("1 0 0 0 1 0 0 0", "matrix of taxel 3: expected a matrix .*nine numbers"),
        ("1 0 0 0 1 0 0 0 x", "matrix of taxel 3: expected a matrix"),
        ("1 0 0 0 1 0 1 1 0", "matrix, taxel 3: a matrix is singular .*nine finite numbers"),
        ("1 0 0 0 1 0 0 0 nan", "matrix, taxel 3: invalid number"),
    ],
)
def test_unusable_matrix_is_named_with_its_taxel(tmp_path, text, found):
    (patch,) = bar_skin().patches
    skin = Skin((replace(patch, taxels=taxels_with_axes(patch.taxels, 3)),))
    path = tmp_path / "gains.toml"
    path.write_text(f"gain = 1.0\n[[taxel]]\ntaxel = 3\nmatrix = '{text}'\n")
    with pytest.raises(LiveError, match=found):
        load_calibration(path, skin)


def test_matrix_of_a_taxel_with_one_axis_is_rejected(tmp_path):
    path = tmp_path / "gains.toml"
    path.write_text("gain = 1.0\n[[taxel]]\ntaxel = 3\nmatrix = '1 1 0 0 1 0 0 0 1'\n")
    with pytest.raises(LiveError, match="taxel 3: a taxel with one axis has no matrix"):
        load_calibration(path, bar_skin())


def test_curves_and_deviations_read_back_from_the_file(tmp_path):
    path = tmp_path / "curves.csv"
    points = ["0:0 10:200 30:1200", "", "0:0 7:70"]
    rows = [f"{taxel},{2.0 if taxel == 1 else 1.0},{points[taxel % 3]},{taxel or ''}" for taxel in range(60)]
    path.write_text("\n".join(["taxel,gain,points,deviation", *rows]))
    first = load_calibration(path, bar_skin())
    assert first.pressures(np.full(60, 20.0))[:4].tolist() == [700.0, 40.0, 200.0, 700.0]
    assert np.isnan(first.deviation[0])
    assert first.deviation[7] == 7.0
    save_calibration(first, path)
    again = load_calibration(path, bar_skin())
    for name in ("gain", "offset", "curve", "deviation"):
        assert np.array_equal(getattr(again, name), getattr(first, name), equal_nan=True), name


def test_toml_may_contain_one_gain_for_all_and_others_for_some_taxels(tmp_path):
    path = tmp_path / "gains.toml"
    path.write_text("gain = 12.5\noffset = 3\n[[taxel]]\ntaxel = 7\ngain = 11.0\n")
    calibration = load_calibration(path, bar_skin())
    assert (calibration.gain[6], calibration.gain[7], calibration.offset[7]) == (12.5, 11.0, 3.0)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.csv", "taxel,gain\n0,1\n", "some taxels have no gain .found: 1 of 60"),
        ("a.csv", "taxel,gain\n0,zero\n", "line 2, gain: expected a number"),
        ("a.csv", "taxel,gain,colour\n0,1,2\n", "line 2: unknown column .found: colour"),
        ("a.csv", "taxel,gain\n60,1\n", "line 2: unknown taxel"),
        ("a.csv", "id,gain\n60,1\n", "line 2: unknown taxel"),
        ("a.csv", "gain\n60\n", "line 2: the row names no taxel"),
        ("a.csv", "taxel,gain\n1,1\n1,1\n", "line 3: a taxel is calibrated twice"),
        ("a.csv", "taxel,gain,points\n0,1,0:0 much\n", "line 2, points: expected the points of a curve"),
        ("a.toml", "gain = 1\n[[taxel]]\ntaxel = 4\npoints = '0:0 2:1 1:2'", "points, taxel 4: a curve does not"),
        ("a.toml", "gain = 'much'", "gain: expected a number"),
        ("a.toml", "gains = 1", "unknown key"),
        ("a.toml", "gain = 0", "gain, taxel 0: invalid number in a calibration"),
        ("a.toml", "gain =", "not TOML"),
        ("a.toml", "taxel = 3", "expected tables"),
    ],
)
def test_invalid_file_entry_is_reported(tmp_path, name, text, said):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(LiveError, match=said) as caught:
        load_calibration(path, bar_skin())
    assert str(caught.value.file) == str(path)


def test_id_on_two_links_is_calibrated_with_its_link(tmp_path):
    (patch,) = bar_skin().patches
    taxels = replace(patch.taxels, identity=TaxelIdentity(ids=np.arange(60)))
    both = Skin((Patch("a", "left", patch.surface, taxels), Patch("b", "right", patch.surface, taxels)))
    path = tmp_path / "gains.csv"
    labels = [f"{link}:{number}" for number in range(60) for link in ("left", "right")]
    path.write_text("id,gain\n" + "".join(f"{label},{gain}\n" for gain, label in enumerate(labels, start=1)))
    assert load_calibration(path, both).gain[[0, 60, 61]].tolist() == [1, 2, 4]
    path.write_text("id,gain\n5,1\n")
    with pytest.raises(LiveError, match="several taxels have that id .found: 5.. Give its link too: left:5 or right:5"):
        load_calibration(path, both)
    toml = tmp_path / "gains.toml"
    toml.write_text('gain = 2\n[[taxel]]\nid = "right:5"\ngain = 3\n')
    assert load_calibration(toml, both).gain[[5, 65]].tolist() == [2, 3]


def test_readings_that_decrease_under_a_weight_are_reported_with_the_negative_gain():
    with pytest.raises(LiveError, match="fall under the weight .*-1 N.* gain is negative: add --inverted"):
        Calibration.plain(2, Unit.PASCAL).with_weight(np.array([-1.0, 0.0]), np.ones(2), 0.5)
