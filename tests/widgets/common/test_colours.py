"""The palette and the pressure scale: readable text, and colours whose order every eye can see."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtGui import QColor

from tactile_widgets.common.colours import DEFAULT_MAXIMUM, THEMES, PressureScale, mixed, rgb

# Full dichromacies on linear RGB: Machado, Oliveira, Fernandes 2009, severity 1.
EYES = {
    "typical": np.eye(3),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "tritanopia": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    ),
}
_TO_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)


def linear(colours):
    share = np.asarray(colours, dtype=np.float64)
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


def lab(linear_rgb):
    """CIELAB (k, 3) under D65."""
    xyz = linear_rgb @ _TO_XYZ.T / _TO_XYZ.sum(axis=1)
    f = np.where(xyz > (6 / 29) ** 3, np.cbrt(xyz), xyz / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1)


def contrast(one, other):
    """Contrast ratio of two hex colours (WCAG 2)."""
    light = sorted(float(linear(rgb(colour)) @ _TO_XYZ[1]) for colour in (one, other))
    return (light[1] + 0.05) / (light[0] + 0.05)


def seen(eye):
    return np.clip(linear(PressureScale().table / 255.0) @ EYES[eye].T, 0, 1)


@pytest.mark.parametrize("eye", EYES)
def test_higher_pressure_is_darker_also_to_colour_blind_users(eye):
    lightness = lab(seen(eye))[:, 0]
    # Eight bits a channel round the table by up to half a unit; over sixteen entries the fall must be plain.
    assert (np.diff(lightness) < 0.35).all()
    assert (lightness[16:] < lightness[:-16] - 0.9).all()
    assert lightness[0] - lightness[-1] > 55


@pytest.mark.parametrize("eye", EYES)
def test_colour_difference_of_a_sixteenth_of_the_scale_is_visible(eye):
    colours = lab(seen(eye))[::16]
    assert np.linalg.norm(np.diff(colours, axis=0), axis=1).min() > 2.3  # one just noticeable difference


def test_scale_runs_from_light_neutral_to_deep_red():
    first, last = PressureScale().table[[0, -1]].astype(int)
    assert np.ptp(first) <= 8
    assert first.min() > 200
    assert last[0] > 2.5 * max(last[1:])


def test_pressures_have_the_colours_of_the_table():
    scale = PressureScale(20.0)
    assert scale.rgb(np.array([0.0, 20.0, 500.0])).tolist() == [scale.table[k].tolist() for k in (0, -1, -1)]
    middle = scale.rgb(np.array([10.0]))[0]
    assert middle.tolist() in scale.table[126:130].tolist()


def test_packed_qimage_pixels_contain_the_same_colours():
    scale = PressureScale()
    for entry in (0, 100, 255):
        colour = QColor.fromRgb(int(scale.lut[entry]))
        assert [colour.red(), colour.green(), colour.blue()] == scale.table[entry].tolist()


def test_pressures_above_the_maximum_have_the_last_colour():
    assert PressureScale().maximum == DEFAULT_MAXIMUM
    assert PressureScale(5.0).maximum == 5.0


@pytest.mark.parametrize("theme", THEMES.values(), ids=THEMES)
@pytest.mark.parametrize("ground", ["window", "panel"])
@pytest.mark.parametrize("ink", ["text", "quiet", "link"])
def test_text_has_enough_contrast(theme, ground, ink):
    assert contrast(getattr(theme, ground), getattr(theme, ink)) >= 4.5


@pytest.mark.parametrize("theme", THEMES.values(), ids=THEMES)
def test_links_without_skin_contrast_with_skin_and_background(theme):
    skin = "#" + "".join(f"{channel:02x}" for channel in PressureScale().table[0])
    assert contrast(skin, theme.body) > 1.8
    assert contrast(theme.window, theme.body) > 1.8


def test_mixed_colours_run_from_the_first_to_the_second():
    assert mixed("#000000", "#ff8000", 0.0) == "#000000"
    assert mixed("#000000", "#ff8000", 1.0) == "#ff8000"
    assert mixed("#000000", "#ffffff", 0.5) == "#808080"
