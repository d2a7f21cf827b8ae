"""Babbling by hand: pokes and strokes at random places, seeded."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from app.errors import SceneError
from app.skin.skin import Skin
from app.stimuli.place import Ground
from app.stimuli.stimulus import Stimulus
from app.stimuli.stroke import lengths
from app.stimuli.track import Track
from app.touch.babbling import KINDS, BabbleSpec, Kind, pitch, touched_places

_SAMPLE = 0.7
"""Pitches between two places of a random way; see ``app.touch.babbling``."""


@dataclass(frozen=True, kw_only=True)
class Babble(Stimulus):
    """Pokes and short strokes at random, equally likely by area, at the places that ``babbling`` would touch.

    Attributes:
        patch: Where; empty for the whole skin.
        way: Which places at once: one (``unbiased``), two of different patches (``self-touch``), three
            (``multi-touch``), or one, but two far places always together (``biased``).
        touches: How many.
        strokes: Share of the touches that move.
        length: Of a stroke, at least [m].
        speed: Of a stroke, along the skin [m/s].
        hold: Time to press in [s]; a poke ends then.
        pause: Between two touches [s].
        force: Mean; each touch has from half to one and a half of it [N].
        seed: Chooses places, ways and forces.
    """

    kind: ClassVar[str] = "babble"
    ranges: ClassVar[Mapping[str, tuple[float, float]]] = {
        "touches": (1, 10_000),
        "strokes": (0.0, 1.0),
        "length": (0.0, 1.0),
        "speed": (1e-3, 10.0),
        "hold": (0.001, 3600.0),
        "pause": (0.001, 3600.0),
        "seed": (0, 2**31),
    }

    way: Kind = "unbiased"
    touches: int = 20
    strokes: float = 0.5
    length: float = 0.04
    speed: float = 0.06
    hold: float = 0.5
    pause: float = 0.2
    force: float = 3.0
    press: float = 0.03
    seed: int = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.way not in KINDS:
            raise self.refusal("way", self.way, f"Choose one of: {', '.join(KINDS)}")

    def tracks(self, ground: Ground) -> tuple[Track, ...]:
        """All touches, one after the other."""
        first, skin = self._skin(ground)
        samples = math.ceil(self.length / (_SAMPLE * pitch(skin))) + 1
        spec = BabbleSpec(self.way, self.touches, samples, seed=self.seed)
        places, patches = touched_places(skin, spec)
        # Its own stream, so that more strokes do not move the touches.
        generator = np.random.default_rng([self.seed, 1])
        forces, moves = generator.uniform(0.5, 1.5, self.touches), generator.random(self.touches) < self.strokes
        found, begin = [], 0.0
        for touch in range(self.touches):
            tip = replace(self.tip, max_force=self.force * float(forces[touch]))
            end = begin + self.hold
            for finger in range(places.shape[2]):
                patch = int(patches[touch, 0, finger])
                if patch >= 0:
                    way = places[touch, : samples if moves[touch] else 1, finger]
                    line = ground.lay(first + patch, way)
                    times = begin + self.hold + lengths(line) / self.speed
                    times, line = np.concatenate([[begin], times]), np.concatenate([line[:1], line])
                    found.append(Track(finger, tip, times, np.full(len(times), first + patch), line))
                    end = max(end, float(times[-1]))
            begin = end + self.pause
        return tuple(found)

    def _skin(self, ground: Ground) -> tuple[int, Skin]:
        """The skin to touch, and the index of its first patch in the whole."""
        if not len(ground.skin):
            raise SceneError("the skin has no taxels to touch", place="stimuli", remedy="Cover at least one link")
        if not self.patch:
            return 0, ground.skin
        first = ground.patch(self.patch)
        return first, Skin(ground.skin.patches[first : first + 1])
