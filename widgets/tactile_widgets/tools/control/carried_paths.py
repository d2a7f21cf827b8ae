"""Paths that keep their place on the body when map or skin change; without Qt."""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from tactile_maps.editing.layout_import import points_on_other_map
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.maps.path_on_body import PathOnBody, Points
from tactile_maps.maps.paths import PathKind

_MOST_PATHS = 500


def path_on_skin(path: Points, before: TactileMap, after: TactileMap) -> Points:
    """Return the points of a path on the map of another skin; none if one of them is not on that skin."""
    found = points_on_other_map(np.array(path), before, after) if path else None
    return () if found is None else tuple((x, y) for x, y in found.tolist())


@dataclass(frozen=True, eq=False)
class _CarriedPath:
    place: PathOnBody
    on_maps: WeakKeyDictionary[TactileMap, tuple[PathKind, Points]]


class CarriedPaths:
    """Paths with their points on each map on which they were. Mutable.

    A path that returns to an earlier map, for example by an undo, has exactly the same points there again. Its places
    on the body are looked up once, on the map on which it was drawn: neither rounding nor patches that overlap in the
    meantime change them.
    """

    def __init__(self) -> None:
        self._paths: list[_CarriedPath] = []

    def carry(self, kind: PathKind, path: Points, before: TactileMap, after: TactileMap) -> tuple[PathKind, Points]:
        """Return kind and points of a path on another map of the same skin; an empty path remains empty."""
        if not path or before is after:
            return kind, path
        self._paths = [one for one in self._paths if one.on_maps][-_MOST_PATHS:]
        for known in self._paths:
            if known.on_maps.get(before) == (kind, path):
                break
        else:
            known = _CarriedPath(PathOnBody.of(kind, path, before), WeakKeyDictionary({before: (kind, path)}))
            self._paths.append(known)
        if after not in known.on_maps:
            known.on_maps[after] = known.place.on_map(after)
        return known.on_maps[after]
