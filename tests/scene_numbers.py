"""Numerical results of every shipped scene, for comparing two states of the code.

    python -m tests.scene_numbers write FOLDER        run every scene and save its results, one NPZ for each scene
    python -m tests.scene_numbers compare OLD NEW     print the largest difference of every array; exit code 1 if any

Each scene runs unchanged for 300 ticks, with its scripted stimuli, controller and behaviours, and then for 200 ticks
with user input: a press, a change of the controller and of the estimator, and a release.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.core.errors import TactileMapsError
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.frame import Frame
from tactile_maps.session.inputs import ControlChanged, ReadingChanged
from tactile_maps.session.prepare import prepare
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import PokePressed, PokeReleased

SCENES = Path(__file__).resolve().parents[1] / "assets" / "scenes"
CONTACTS = 4
"""Maximum number of contacts saved for each frame, in the order of their ids."""


def numbers(scene_name: str) -> dict[str, np.ndarray]:
    """Return the results of a scene by name, as (ticks, ...) arrays."""
    prepared = prepare(load_scene(scene_name))
    session = Session(prepared)
    person = {
        310: PokePressed(1, prepared.skin.taxel_point(len(prepared.skin) // 3)),
        360: ControlChanged(replace(session.settings, controller="hold_force", force_goal=2.0)),
        400: ReadingChanged(ReadingSettings("tikhonov")),
        440: ControlChanged(replace(session.settings, controller="hybrid", task="keep_force")),
        470: PokeReleased(1),
    }
    frames = []
    for tick in range(500):
        if tick in person:
            session.submit(person[tick])
        try:
            frames.append(session.tick())
        except TactileMapsError as error:
            print(f"{scene_name}: tick {tick}: {error}")
            if session.failure is not None:
                break
    rows = [_row(frame) for frame in frames]
    made = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    made["taxel_map_points"] = prepared.map.taxel_points
    made["taxel_body_points"] = np.concatenate([patch.taxels.positions for patch in prepared.skin.patches])
    return made


def _row(frame: Frame) -> dict[str, object]:
    regions = sorted(frame.regions, key=lambda region: region.id)[:CONTACTS]
    contacts = np.zeros((CONTACTS, 12))
    for row, region in zip(contacts, regions, strict=False):
        row[:] = (
            region.id,
            region.force,
            region.area,
            region.peak,
            *region.map_point,
            *region.link_position,
            *region.link_normal,
        )
    command = frame.command
    return {
        "tick": frame.tick,
        "posture": frame.posture,
        "velocity": frame.velocity,
        "pressures": frame.pressures,
        "objects": frame.objects,
        "contacts": contacts,
        "command": np.array([command.posture, command.stiffness, command.damping, command.torque]),
        "events": len(frame.events),
        "limits": len(frame.why_limited),
    }


def main(words: list[str]) -> int:
    """Run the command; return its exit code."""
    if len(words) == 2 and words[0] == "write":
        folder = Path(words[1])
        folder.mkdir(parents=True, exist_ok=True)
        for scene in sorted(SCENES.glob("*.toml")):
            np.savez_compressed(folder / f"{scene.stem}.npz", **numbers(scene.stem))
            print(scene.stem)
        return 0
    if len(words) == 3 and words[0] == "compare":
        return max([_compare(old, Path(words[2]) / old.name) for old in sorted(Path(words[1]).glob("*.npz"))])
    print(__doc__)
    return 2


def _compare(old_file: Path, new_file: Path) -> int:
    old = np.load(old_file)
    new = np.load(new_file)
    worst = 0
    for name in old.files:
        if old[name].shape != new[name].shape:
            print(f"{old_file.stem} {name}: shape {old[name].shape} became {new[name].shape}")
            worst = 1
        elif not np.array_equal(old[name], new[name], equal_nan=True):
            difference = np.abs(old[name] - new[name])
            first = int(np.argmax(difference.reshape(len(difference), -1).max(axis=1) > 0))
            print(f"{old_file.stem} {name}: differs by {difference.max():.3g}, first in row {first}")
            worst = 1
    if not worst:
        print(f"{old_file.stem}: the same in {', '.join(old.files)}")
    return worst


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
