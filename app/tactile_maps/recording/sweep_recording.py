"""Recording of one case of a sweep: a scene with varied settings, simulated for a while and written to a file.

A case states the file and the settings. Cases can be recorded in one process or on many machines; robot, skin and map
are cached between cases that share them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from tactile_maps.core.errors import RecordingError
from tactile_maps.core.files import make_atomically
from tactile_maps.recording.recorder import Recorder
from tactile_maps.scene.object_meshes import make_objects
from tactile_maps.scene.scene import Scene
from tactile_maps.scene.scene_sweep import varied_scene
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.session.session import Session
from tactile_maps.skin.fitting.cover import CoverSpec
from tactile_maps.skin.fitting.grid import GridSpec

OWN = ("file", "seconds")
"""Keys of a case that are not settings of the scene."""
_KEPT = 4


@dataclass(frozen=True)
class SweepRecording:
    """Properties that all recordings of a sweep share.

    Attributes:
        scene: Scene that is varied.
        folder: Folder of the recordings.
        sweep: File of the sweep, for errors.
        viewers: Whether to write messages for viewers of other programs, see ``Recorder``.
    """

    scene: Scene
    folder: Path
    sweep: str
    viewers: bool = True


def record_case(case: Mapping[str, Any], *, common: SweepRecording) -> list[dict[str, str | float | int | bool | None]]:
    """Simulate and record one case; an existing file is replaced once the new one is complete.

    Args:
        case: ``file``, ``seconds``, and settings of the scene by their dotted keys.
        common: Properties shared by all cases.

    Returns:
        One row: frames, contacts, share of frames with a contact, and the largest contact force [N].

    Raises:
        TactileMapsError: The settings are invalid, the simulation stopped, or the file cannot be written; no file is
            left.

    Cost: the time of the simulation, and 0.1 to 1 s to write robot and map.
    """
    settings = {key: value for key, value in case.items() if key not in OWN}
    scene = varied_scene(common.scene, settings, file=common.sweep)
    session = Session(_prepared(scene), effects=scene.unattended.effects)
    contacts: set[int] = set()
    strongest = 0.0
    touched = 0
    count = max(1, round(case["seconds"] / scene.tick))
    target = common.folder / case["file"]
    with (
        make_atomically(target, error=RecordingError, overwrite=True) as part,
        Recorder(session.prepared, part, viewers=common.viewers) as recorder,
    ):
        for _ in range(count):
            frame = session.tick()
            recorder.write(frame, session.inputs)
            contacts |= {region.id for region in frame.regions}
            strongest = max(strongest, frame.strongest_force)
            touched += bool(frame.regions)
    return [{"frames": count, "contacts": len(contacts), "touched": touched / count, "max_force_N": strongest}]


def _prepared(scene: Scene) -> PreparedScene:
    base = _base(scene.robot, scene.taxel_files, scene.cover, scene.grids, scene.more_covers, scene.package_roots)
    return replace(base, scene=scene, objects=make_objects(scene))


@lru_cache(maxsize=_KEPT)
def _base(
    robot: str,
    taxel_files: tuple[str, ...],
    cover: CoverSpec,
    grids: tuple[GridSpec, ...],
    more_covers: tuple[CoverSpec, ...],
    roots: tuple[str, ...],
) -> PreparedScene:
    """Return robot, skin and map, which depend only on these parts of a scene."""
    return prepare_cached(
        Scene(
            "sweep",
            robot,
            taxel_files=taxel_files,
            cover=cover,
            grids=grids,
            more_covers=more_covers,
            package_roots=roots,
        )
    )
