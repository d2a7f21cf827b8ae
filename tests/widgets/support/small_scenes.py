"""All that ships, to be opened often: each scene in few taxels, prepared once."""

from __future__ import annotations

import pickle
from dataclasses import replace

from tactile_maps.core.arrays import refreeze
from tactile_maps.robots.library import list_robots
from tactile_maps.scene.scene import Scene
from tactile_maps.scene.scene_file import load_scene, scene_for, scene_names, scene_to_toml
from tactile_maps.session.prepare import PreparedScene, prepare


class SmallScenes:
    """Prepares scenes like ``prepare`` but with fewer taxels, and caches them.

    Each call returns a new copy, as a worker process would send it.

    Args:
        taxels: Maximum number of taxels of a scene.
        most: Size of the cache, which keeps the most recent scenes; effects of the user make ever new ones.
    """

    def __init__(self, taxels: int, *, most: int = 24) -> None:
        self._taxels = taxels
        self._most = most
        self._made: dict[str, bytes] = {}

    def prepare(self, scene: Scene, **how: object) -> PreparedScene:
        """Prepare a scene, see ``tactile_maps.session.prepare.prepare``."""
        small = replace(scene, cover=replace(scene.cover, taxels=min(scene.cover.taxels, self._taxels)))
        key = scene_to_toml(small)
        if key not in self._made:
            self._made[key] = pickle.dumps(prepare(small, **how))
            if len(self._made) > self._most:
                del self._made[next(iter(self._made))]
        prepared: PreparedScene = pickle.loads(self._made[key])
        refreeze(prepared)
        return prepared


def everything_that_opens() -> list[str]:
    """``scene NAME`` and ``robot NAME`` of all that ships and can be opened here."""
    robots = [entry.name for entry in list_robots() if entry.available]
    return [*(f"scene {name}" for name in scene_names()), *(f"robot {name}" for name in robots)]


def open_named(window, what: str) -> None:
    """Open one of ``everything_that_opens``, as the File menu does."""
    kind, name = what.split()
    window.presenters.files.open_scene(load_scene(name) if kind == "scene" else scene_for(name))
