"""Maps learned from touch, for ``map --learn``: from babbling on a skin, or from what a recording felt."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from app.arrays import FloatArray
from app.cli.output import Progress
from app.errors import RecordingError, UsageError
from app.maps.learned.as_map import learned_tactile_map
from app.maps.learned.table import LEARNED
from app.maps.tactile_map import TactileMap
from app.recording.player import Player
from app.skin.skin import Skin
from app.touch.babbling import BabbleSpec, babble


def recorded_touch(path: str | Path) -> tuple[Skin, FloatArray]:
    """The skin of a recording, and what its taxels read (frames, taxels) [Pa].

    Raises:
        RecordingError: It cannot be read, or nothing was touched in it.
    """
    player = Player(path)
    readings = np.stack([player.frame(number).pressures for number in range(len(player))])
    if not readings.any():
        raise RecordingError("nothing is touched in the recording", file=path, remedy="Record strokes over the skin")
    return player.prepared.skin, readings


def learned_map(arguments: argparse.Namespace, skin: Skin, readings: FloatArray | None, report: Progress) -> TactileMap:
    """The map of ``skin`` by the builder asked for, from ``readings`` or from babbling.

    Raises:
        UsageError: There is no such builder.
    """
    if arguments.learn not in LEARNED:
        raise UsageError(
            "there is no such builder", value=arguments.learn, remedy=f"Choose one of: {', '.join(LEARNED)}"
        )
    if readings is None:
        report("Babbling", 0.0)
        strokes = arguments.learn in ("temporal-correlation", "human-touch")
        spec = BabbleSpec(
            arguments.babble,
            arguments.touches,
            samples=8 if strokes else 1,
            rest=2 if strokes else 0,
            seed=arguments.seed,
        )
        readings = babble(skin, spec)
    learned = LEARNED[arguments.learn](readings, seed=arguments.seed, progress=report)
    return learned_tactile_map(skin, learned)
