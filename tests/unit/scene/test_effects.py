"""Effects: what a scene simulates unless it says otherwise."""

from __future__ import annotations

from dataclasses import FrozenInstanceError

import pytest

from app.scene.effects import Effects


def test_defaults_are_the_cheap_ones():
    effects = Effects()
    assert (effects.gravity, effects.contact, effects.joint_limits, effects.timestep) == (
        "compensated",
        "off",
        True,
        1e-3,
    )
    with pytest.raises(FrozenInstanceError):
        effects.contact = "self"
