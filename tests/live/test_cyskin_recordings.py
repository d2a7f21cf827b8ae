"""Fingers counted on recordings of a real CySkin, which cannot be included because they have no licence.

Set ``CYSKIN_SOURCES`` to the folder ``src`` of ladylou899/ros2_ws_cyskin_project on GitHub to run the test.
"""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from tactile_maps.cli.commands.listen import ContactSummary
from tactile_maps.cli.parser import build_parser
from tactile_maps.cli.shared.scenes import scene_from_arguments
from tactile_maps.live.prepare import prepare_measured
from tactile_maps.live.readings.arrival import Arrived
from tactile_maps.live.session.measured_session import MeasuredSession
from tactile_maps.live.sources.files import read_text

_SOURCES = Path(os.environ.get("CYSKIN_SOURCES", "no such folder"))
_RECORDINGS = _SOURCES / "cyskin_acquisition" / "data"
_SKIN = _SOURCES / "uc1_tactile_images" / "calibration_files" / "curved_gesture_patch_full_isomap.json"


def count(prepared, path: Path) -> int:
    """Return the number of contacts that ``listen --tare 5`` reports as present at once for most of the time."""
    session = MeasuredSession(prepared, finite=True)
    session.tare(5)
    summary = ContactSummary()
    for reading in read_text(path):
        summary.add(session.show(Arrived(reading, reading.time, 0.0)))
    return summary.at_once


@pytest.mark.skipif(not _RECORDINGS.is_dir(), reason="CYSKIN_SOURCES does not name the sources of the CySkin project")
@pytest.mark.parametrize(
    ("first", "exact", "within_one", "touched"), [(1, 0.43, 0.84, 0.98), (0, 0.41, 0.86, 0.99)], ids=["even", "odd"]
)
def test_numbers_of_fingers_match_the_page_of_real_skins(first, exact, within_one, touched):
    """The detection was developed on the recordings with even numbers; those with odd numbers were left out."""
    arguments = build_parser().parse_args(["listen", "recording.txt", "--skin", str(_SKIN)])
    prepared = prepare_measured(scene_from_arguments(arguments))
    found = Counter[tuple[int, int]]()
    for fingers in range(6):
        for path in sorted((_RECORDINGS / f"{fingers}_finger").glob("*.txt"))[first::2]:
            found[fingers, count(prepared, path)] += 1
    pairs = np.array(list(found.elements()))
    off = np.abs(pairs[:, 0] - pairs[:, 1])
    assert np.mean(off == 0) > exact
    assert np.mean(off <= 1) > within_one
    assert np.mean((pairs[:, 0] > 0) == (pairs[:, 1] > 0)) > touched
