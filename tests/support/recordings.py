"""A short session and its recording, for tests of recording and command line."""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import cache

from mcap.opcode import Opcode

from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.files import cache_folder
from tactile_maps.editing.arrange import move
from tactile_maps.editing.document import MapDocument
from tactile_maps.recording.recorder import Recorder
from tactile_maps.scene.scene import Scene
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.inputs import ControlChanged, EffectsChanged, MapEdited, ReadingChanged
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import PokeMoved, PokePressed, PokeReleased
from tactile_maps.tactile.sensors.sensor_effects import Hysteresis, Noise, SensorEffects

NOISY = SensorEffects(noise=Noise(), hysteresis=Hysteresis())


def prepare_once(scene: Scene) -> PreparedScene:
    """Prepare a scene, or wait until another process of the run, which needs it at the same time, has prepared it."""
    folder = cache_folder()
    if folder is None or sys.platform == "win32":
        return prepare_cached(scene)
    import fcntl

    with (folder / "preparing").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        return prepare_cached(scene)


@cache
def small_arm(taxels: int = 120, thickness: float = 0.01) -> PreparedScene:
    """Return the arm with few taxels; cached. A thicker skin [m] has larger triangles and is prepared faster."""
    scene = load_scene("arm")
    return prepare_once(replace(scene, cover=replace(scene.cover, taxels=taxels, thickness=thickness)))


def record(prepared: PreparedScene, path, *, ticks: int = 200, start: int = 0) -> Session:
    """Record a poke, a stroke, an edit, another controller, estimator and effects, and a release, after ``start``
    ticks.
    """
    session = Session(prepared)
    skin = prepared.skin
    acts = {
        start + 20: PokePressed(1, skin.taxel_point(30)),
        start + 60: PokeMoved(1, skin.taxel_point(31)),
        start + 70: MapEdited("Move", move(MapDocument.of(prepared.map), [0], (0.2, 0.1)).map),
        start + 80: ControlChanged(ControlSettings(controller="hold_force", force_goal=2.0)),
        start + 100: ReadingChanged(ReadingSettings("tikhonov")),
        start + 110: EffectsChanged(replace(prepared.scene.effects, friction=True, sensor=NOISY)),
        start + 150: PokeReleased(1),
    }
    for _ in range(start):
        session.tick()
    with Recorder(prepared, path) as recorder:
        for tick in range(start, start + ticks):
            if tick in acts:
                session.submit(acts[tick])
            recorder.write(session.tick(), session.inputs)
    return session


def with_checksum_damage(data: bytes) -> bytes:
    """Return a recording with another checksum of its data section: each chunk and attachment still matches its own."""
    footer = data.rfind(bytes([Opcode.FOOTER]) + (20).to_bytes(8, "little"))
    summary = int.from_bytes(data[footer + 9 : footer + 17], "little")
    return data[: summary - 1] + bytes([data[summary - 1] ^ 1]) + data[summary:]
