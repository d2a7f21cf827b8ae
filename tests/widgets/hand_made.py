"""Frames made by hand: a smooth touch at a taxel, as the session would report it, without simulating."""

from __future__ import annotations

import numpy as np

from app.contacts.region import ContactRegion
from app.control.command import JointCommand
from app.session.frame import Frame
from app.simulation.poke import PokeState
from app.timing import Timings


def touched(tactile_map, taxels=(), *, tick=1, time=0.0, kilopascals=12.0, radius=0.02) -> Frame:
    """A frame with a round touch on the map around each of ``taxels``."""
    pressures, regions, pokes = np.zeros(len(tactile_map.skin)), [], []
    for number, taxel in enumerate(taxels):
        at, centre = tactile_map.skin.taxel_point(taxel), tactile_map.taxel_points[taxel]
        share = 1 - (np.linalg.norm(tactile_map.taxel_points - centre, axis=1) / radius) ** 2
        pressures += 1e3 * kilopascals * np.clip(share, 0, None)
        felt, skin = np.flatnonzero(share > 0), tactile_map.skin
        point, normal = skin.position(at), skin.normal(at)
        force, area = float(pressures[felt] @ skin.areas[felt]), float(skin.areas[felt].sum())
        regions.append(
            ContactRegion(
                number, felt, force, area, float(pressures[felt].max()), centre, at, skin.link(at), point, normal
            )
        )
        pokes.append(PokeState(number, at, force, point, normal, 0.008))
    none = np.zeros(0)
    command = JointCommand(none, none, none, none)
    timings = Timings({"physics": 1.1, "sensing": 0.5, "contacts": 0.3, "control": 0.2})
    return Frame(tick, time, none, none, pressures, tuple(regions), tuple(pokes), command, (), timings)


def middle_taxel(tactile_map, patch) -> int:
    """The taxel nearest to the middle of a patch on the map."""
    first, last = tactile_map.skin.first[patch], tactile_map.skin.first[patch + 1]
    points = tactile_map.taxel_points[first:last]
    return int(first + np.linalg.norm(points - points.mean(axis=0), axis=1).argmin())
