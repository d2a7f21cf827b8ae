"""Parts of a skin that repeat their values: found after a part has varied, never while it is only quiet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tactile_maps.live.channels.last_heard import FROZEN_FACTOR, FROZEN_SECONDS, LEARN_SECONDS, LastHeard
from tactile_maps.skin.model.skin import Skin, TaxelIdentity
from tests.support.touch import bar_skin

PERIOD = 0.01


def modules_of_ten() -> Skin:
    """The bar's 60 taxels on modules 100 to 105."""
    skin = bar_skin()
    patch = skin.patches[0]
    identity = TaxelIdentity(modules=np.repeat(np.arange(100, 106), 10), channels=np.tile(np.arange(10), 6))
    return Skin((replace(patch, taxels=replace(patch.taxels, identity=identity)),))


class Stream:
    """Readings of all taxels, of which some modules change."""

    def __init__(self) -> None:
        self.heard = LastHeard(modules_of_ten(), 1)
        self.now = 50.0

    def read(self, seconds, *, changing, every=1, gap=PERIOD):
        for number in range(round(seconds / PERIOD)):
            self.now += gap
            changed = np.repeat(np.isin(np.arange(6), changing), 10) & (number % every == 0)
            self.heard.add(np.arange(60), [0], changed, self.now, self.now)

    @property
    def frozen(self) -> list[int]:
        return np.flatnonzero(self.heard.frozen).tolist()


def test_noisy_module_that_freezes_is_detected_and_named():
    stream = Stream()
    stream.read(LEARN_SECONDS + 0.1, changing=[0, 1, 2, 3, 4, 5])
    stream.read(FROZEN_SECONDS, changing=[0, 1, 3, 4, 5])
    assert stream.frozen == []
    stream.read(0.02, changing=[0, 1, 3, 4, 5])
    assert stream.frozen == [2]
    assert stream.heard.frozen_text() == "module 102 for 0.52 s"
    stream.read(0.01, changing=[2])
    assert stream.frozen == []


def test_quantised_module_may_be_quiet_for_as_long_as_its_pauses_suggest():
    stream = Stream()
    stream.read(60.0, changing=[0], every=50)  # a change each half second, the last one half a second ago
    stream.read(0.9 * FROZEN_FACTOR * 0.5 - 0.5, changing=[])
    assert stream.frozen == []
    stream.read(0.2 * FROZEN_FACTOR * 0.5, changing=[])
    assert stream.frozen == [0]
    rare = Stream()
    rare.read(60.0, changing=[0], every=100)  # 60 changes teach too little
    rare.read(60.0, changing=[])
    assert rare.frozen == []


def test_module_that_never_varied_or_varied_briefly_is_not_frozen():
    stream = Stream()
    stream.read(5.0, changing=[])
    stream.read(LEARN_SECONDS - 0.1, changing=[1])  # a touch of a skin without noise
    stream.read(100.0, changing=[])
    assert stream.frozen == []


def test_duration_of_a_freeze_does_not_count_as_a_usual_pause():
    stream = Stream()
    stream.read(3.0, changing=[0])
    stream.read(5.0, changing=[])
    assert stream.frozen == [0]
    stream.read(1.0, changing=[0])
    stream.read(FROZEN_SECONDS + 0.02, changing=[])
    assert stream.frozen == [0]


def test_pause_of_the_stream_does_not_count_as_a_frozen_module():
    stream = Stream()
    stream.read(11.0, changing=[0])
    stream.read(0.05, changing=[0], gap=20.0)  # five readings in 100 s
    stream.read(FROZEN_FACTOR * 0.1 + 0.1, changing=[])
    assert stream.frozen == [0]


def test_names_combine_whole_modules_and_single_taxels():
    heard = LastHeard(modules_of_ten(), 0)
    chosen = np.zeros(60, dtype=bool)
    chosen[10:20] = chosen[33] = True
    assert heard.taxel_names(chosen) == ["module 101", "module 103, channel 3"]
