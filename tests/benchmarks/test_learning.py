"""Steps of a learning environment with 1,000 taxels in contact, and the shares of a step's time."""

import time
from collections import defaultdict

import numpy as np
import pytest

from tactile_maps.learning.environment import TICKS_PER_STEP
from tactile_maps.learning.tasks import FollowEnvironment

STEPS = 200


@pytest.mark.parametrize("action", ["joint_velocity", "map_target"])
def test_learning_step(benchmark, action):
    environment = FollowEnvironment(taxels=1000, action=action)
    rng = np.random.default_rng(0)

    def episode():
        seen, _ = environment.reset(seed=1)
        began = time.process_time()
        spent = defaultdict(float)
        with environment.session.watched(lambda frame: _add(spent, frame.timings.ms)):
            for _ in range(STEPS):
                seen, *_ = environment.step(rng.uniform(-0.02, 0.02, environment.action_space.shape))
        assert seen["contact_mask"][0], "it must be measured in contact"
        return (time.process_time() - began) / STEPS, spent

    seconds, spent = benchmark.pedantic(episode, rounds=3, warmup_rounds=1)
    benchmark.extra_info["steps_per_cpu_second"] = round(1 / seconds)
    benchmark.extra_info["ticks_per_cpu_second"] = round(TICKS_PER_STEP / seconds)
    benchmark.extra_info["ms_a_step"] = {name: round(ms / STEPS, 3) for name, ms in spent.items()}


def _add(spent, stages):
    for name, ms in stages.items():
        spent[name] += ms
