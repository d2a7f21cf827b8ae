"""Growth, settling and lag of loops; test benches settle first."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.studies.loop_laws.closed_loop import Loop
from tactile_maps.studies.loop_laws.step_trials import (
    FORCE_STEP,
    PLACE_STEP,
    LoopTest,
    diverges,
    proportional_settings,
    settling_samples,
)

LOOP = Loop(period=0.1, stiffness=1000.0)


def test_growth_is_detected_in_the_last_quarter_or_immediately_above_a_bound():
    k = np.arange(80)
    assert not diverges(0.99**k, 2.0)
    assert diverges(1.01**k, 9.0)
    assert diverges(np.where(k == 3, 5.0, 0.1 * 0.9**k), 2.0)


def test_settling_counts_from_the_step_and_the_delay_on_top():
    errors = np.outer(0.5 ** np.arange(20), [3.0, 4.0])
    assert settling_samples(errors, 0) == 6
    assert settling_samples(errors + [1.0, 2.0], 3) == 9, "from where it ends"


def test_bench_starts_at_rest():
    bench = LoopTest(LOOP)
    settings = proportional_settings("hybrid", 0.5 / (1000.0 * 0.1))
    assert bench.force_step(settings, 10)[0] == pytest.approx(-FORCE_STEP, abs=1e-6)
    assert bench.place_step(2.0, 10)[0] == pytest.approx([-PLACE_STEP, 0.0], abs=1e-6)
    assert LoopTest(LOOP, axis=1).place_step(2.0, 10)[0] == pytest.approx([0.0, -PLACE_STEP], abs=1e-6)
