"""Published robots: every model of unpacked wheels opens within bounds or is rejected with a named error.

``TACTILE_MAPS_ROBOTS`` names a folder in which wheels were unpacked (``pip download --no-deps``, ``unzip``), each into
a folder of any name: dm_control, example-robot-data, gymnasium-robotics, mani_skill, metaworld, pybullet, robosuite.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.files import hostile_files

FOLDER = Path(os.environ.get("TACTILE_MAPS_ROBOTS", "nowhere"))
LOADED = (
    "dm_control/suite/*.xml",
    "dm_control/locomotion/walkers/assets/humanoid_CMU*.xml",
    "dm_control/third_party/kinova/jaco_*.xml",
    "example-robot-data/robots/*/urdf/*.urdf",
    "example-robot-data/robots/*/robots/*.urdf",
    "gymnasium_robotics/envs/assets/fetch/*.xml",
    "gymnasium_robotics/envs/assets/hand/*.xml",
    "gymnasium_robotics/envs/assets/adroit_hand/adroit_*.xml",
    "mani_skill/assets/robots/**/*.urdf",
    "metaworld/assets/sawyer_xyz/*.xml",
    "pybullet_data/*/*.urdf",
    "robosuite/models/assets/robots/*/robot.xml",
    "robosuite/models/assets/grippers/*.xml",
    "robosuite/models/assets/bullet_data/**/*.urdf*",
)
REFUSED = (
    "no robot: it has no",
    "is a part of an MJCF file",
    "no longer supported",
    "MuJoCo cannot read the robot",
    "there is no such file",
    "leaves the robot's folder",
    "unknown macro",
    "not MJCF",
    "names a file that is not its own",
    "the parent of a joint is not a link of this file",
)
"""Expected errors of files that are not robots or are published broken."""


@pytest.mark.long
@pytest.mark.skipif(not FOLDER.is_dir(), reason="TACTILE_MAPS_ROBOTS names no folder of unpacked wheels")
def test_published_robots_open_or_are_rejected_by_name(call_all):
    models = sorted({path for pattern in LOADED for path in FOLDER.glob(f"*/**/{pattern}")})
    models = [path for path in models if "objects" not in path.parts]
    assert len(models) > 100
    outcomes = call_all(hostile_files.robot, [(str(path),) for path in models])
    found = dict(zip(models, outcomes, strict=True))
    unexpected = {path: text for path, text in found.items() if text != "ok" and not any(w in text for w in REFUSED)}
    assert not unexpected
    assert outcomes.count("ok") > 0.9 * len(models)
