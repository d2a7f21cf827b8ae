"""Small sheet of skin, touched."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.tactile.babbling import BabbleSpec, babble
from tests.support.surfaces import sheet, skin_of


@pytest.fixture(scope="session")
def touched_sheet():
    """A flat skin of 60 taxels and the readings of 1500 touches."""
    skin = skin_of(sheet(30, 20), taxels=60)
    return skin, babble(skin, BabbleSpec(touches=1500))


@pytest.fixture(scope="session")
def true_places(touched_sheet):
    """Positions (60, 2) of the taxels of the sheet [m]."""
    return touched_sheet[0].patches[0].taxels.positions[:, :2]


@pytest.fixture(scope="session")
def misfit(true_places):
    """Return a function for the root mean square error of places [pitches] after the best similarity transform."""

    def of(points):
        truth = true_places - true_places.mean(axis=0)
        flat = points - points.mean(axis=0)
        u, values, vt = np.linalg.svd(flat.T @ truth)
        fitted = flat @ u @ vt * values.sum() / (flat**2).sum()
        pitch = np.sqrt(2 / np.sqrt(3) * 0.12 * 0.08 / len(truth))
        return float(np.sqrt(((fitted - truth) ** 2).sum(axis=1).mean()) / pitch)

    return of
