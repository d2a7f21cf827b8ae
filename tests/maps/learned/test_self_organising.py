"""The sheet that organises itself."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from tactile_maps.maps.learned.self_organising import build, train_batch_som


@pytest.mark.long
def test_taxels_of_a_sheet_are_learned_at_their_positions(touched_sheet, misfit):
    """The square sheet stretches over the oblong skin, so places are less true than those from distances."""
    learned = build(touched_sheet[1])
    assert learned.method == "self-organising"
    assert learned.stress is None
    assert misfit(learned.points) < 1.5


def test_adjacent_units_have_similar_prototypes():
    places = np.linspace(0, 1, 400)[:, None]
    contacts = np.exp(-0.5 * ((places - np.linspace(0, 1, 9)) / 0.1) ** 2)
    contacts /= np.linalg.norm(contacts, axis=1, keepdims=True)
    units = train_batch_som(csr_matrix(contacts), side=6)
    units /= np.linalg.norm(units, axis=1, keepdims=True)
    grid = units.reshape(6, 6, 9)
    nearby = (grid[1:] * grid[:-1]).sum(axis=-1).mean()
    across = (grid[0] * grid[-1]).sum(axis=-1).mean()
    assert nearby > across + 0.05
    assert (units >= 0).all()
