"""Friction in use at each taxel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tactile_maps.contacts.detection.contact_shear import ContactShear, Slip
from tactile_maps.contacts.detection.shear_estimation import friction_in_use
from tests.widgets.support.samples import leaf_map, touched


def test_friction_in_use_is_traction_over_coefficient_times_pressure_on_contacts_only():
    map_ = leaf_map()
    frame = touched(map_, [10, 300])
    first, second = frame.regions
    shear = ContactShear((1.0, 0.0, 0.0), 0.0, 0.5, 1.0, Slip.STICKING, 0.5, estimated=False)
    tractions = np.zeros((len(map_.skin), 2))
    pressed = first.taxels[frame.pressures[first.taxels] > 0]
    tractions[pressed] = 0.3 * 0.5 * frame.pressures[pressed, None] * [0.6, -0.8]
    used = friction_in_use([replace(first, shear=shear), second], frame.pressures, tractions)
    np.testing.assert_allclose(used[pressed], 0.3)
    assert np.isnan(np.delete(used, pressed)).all(), "neither off the contacts nor on one without shear"
