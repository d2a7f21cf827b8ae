"""The touch stage: the user's own skin, touches that are known, and models ordered by what they know."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.studies.stages.touch import SHARES, STAGE, dense_around
from tactile_maps.tactile.models.contact_model import CONTACT_MODELS


@pytest.fixture(scope="module")
def found(tube):
    """Trials by model and share."""
    trials = [trial for setting in STAGE.settings(tube) for trial in STAGE.trials(tube, setting)]
    return {(trial.setting.method, trial.setting.values.get("share")): trial for trial in trials}


def test_every_model_is_tried_and_the_half_space_with_every_share(found, tube):
    others = {(name, None) for name in CONTACT_MODELS if name != "half-space"}
    assert set(found) == others | {("half-space", share) for share in SHARES}
    assert STAGE.current(tube) is None
    assert STAGE.recipes is None
    assert all(trial.milliseconds > 0 for trial in found.values())


def test_more_detailed_models_have_smaller_errors(found):
    assert found["point", None].errors["surface_percent"] > found["water-fill", None].errors["surface_percent"]
    felt = [found["half-space", share].errors["depth_percent"] for share in SHARES]
    assert felt == sorted(felt, reverse=True), "wider receptive fields read more"
    assert felt[-1] < found["water-fill", None].errors["depth_percent"]


def test_errors_are_within_their_intervals(found):
    widths = []
    for trial in found.values():
        assert set(trial.intervals) >= {"depth_percent", "surface_percent", "force_percent"}
        for key, (low, high) in trial.intervals.items():
            assert low <= trial.errors[key] <= high
        low, high = trial.intervals["depth_percent"]
        widths.append((high - low) / trial.errors["depth_percent"])
    assert max(widths) > 0.02


def test_dense_points_cover_the_skin_around(bodies):
    skin = bodies.skin
    at = skin.patches[1].taxels.positions[0]
    dense = dense_around(skin, "hemisphere", at, 0.02)
    assert 1000 < len(dense.areas) < 10_000
    assert dense.areas.sum() == pytest.approx(np.pi * 0.02**2, rel=0.3)
    assert set(dense.taxel) <= set(range(60, 120)), "taxels of the other patch are on another link"
    np.testing.assert_allclose(np.linalg.norm(dense.positions, axis=1), 0.05, rtol=0.02)
