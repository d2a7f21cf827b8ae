from __future__ import annotations

import numpy as np
import pytest

from app.errors import SimulationError
from app.touch.sensor.ranges import check_range


@pytest.mark.parametrize("value", [0, 0.0, 1, 0.5, 1.0, np.float32(0.5), np.int64(1)])
def test_both_ends_and_any_real_number_between_are_in_range(value):
    check_range("noise.sd", value, 0.0, 1.0)


@pytest.mark.parametrize("value", [-1e-9, 1.0001, float("nan"), float("inf"), "0.5", None, True, 1j, [0.5]])
def test_all_else_is_refused_with_its_place_and_what_to_choose(value):
    with pytest.raises(SimulationError, match=r"sensor\.noise\.sd: .*Choose 0 to 1") as error:
        check_range("noise.sd", value, 0.0, 1.0)
    assert error.value.value is value
