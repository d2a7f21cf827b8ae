"""Share of true forces and places within the stated uncertainties: 68 % and 95 % are the goal, 63 % and 98 % of places,
whose uncertainty is radial.
"""

from __future__ import annotations

import pytest

from tests.support.coverage import coverage

SKIN = "arm-1000"


@pytest.mark.parametrize("effect", ["gain spread", "noise", "offset drift", "hysteresis", "quantisation", "sampling"])
def test_stated_uncertainty_of_one_effect_holds_as_often_as_it_should(effect):
    found = coverage(SKIN, effect=effect)
    assert found.found > 290
    assert 0.62 <= found.force[0] <= 0.74
    assert 0.90 <= found.force[1] <= 0.98
    assert 0.60 <= found.place[0] <= 0.78
    assert found.place[1] >= 0.95
