"""Hard cases of control: postures and limits that leave the arm too little freedom."""

from __future__ import annotations

import numpy as np

from tactile_maps.control.controllers import CONTROL_SCHEMES
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import LimitKind
from tactile_maps.scene.object_meshes import make_objects
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.session.session import Session
from tests.control.hard_cases.case import (
    SOME,
    HardCase,
    arrives,
    both,
    bounded_only,
    kept,
    narrowed,
    next_to_taxel,
    rests,
    stretched,
)
from tests.support.pressed_arm import Course, pressed_by_ball
from tests.support.touch import prepared_bar

UNABLE = (LimitKind.WEAK_DIRECTION, LimitKind.JOINT_ACCELERATION)


def stretched_arm(settings: ControlSettings, taxel: int = 150) -> Session:
    return pressed_by_ball(settings, prepared=stretched(), taxel=taxel, depth=0.0002)


def one_joint(settings: ControlSettings) -> Session:
    """The bar with its one hinge, touched by a fixed ball from above."""
    ball = ObjectSpec("ball", "sphere", (0.02,), at=(0.3, 0.0, 0.0395))
    prepared = prepared_bar(objects=(ball,), task="slide", outputs=("force", "pressure"))
    return Session(
        type(prepared)(prepared.scene, prepared.robot, prepared.skin, prepared.map, make_objects(prepared.scene)),
        settings=settings,
    )


def stays_within(most: float):
    """No joint is led farther from home than it was limited, but for what the contact bends it by."""

    def check(course: Course) -> None:
        home = course.session.prepared.robot.home
        limits = course.session.prepared.robot.joints
        limited = np.array([joint.upper - at < 2 * most for joint, at in zip(limits, home, strict=True)])
        assert np.abs(course.posture - home)[:, limited].max() < most + 0.03

    return check


CASES: dict[str, HardCase] = {
    "straight elbow, across": HardCase(
        "where one side can be moved to, the place is reached and the force kept, slowly",
        stretched_arm,
        both(kept(within=0.3, ripple=0.3), arrives(0.004)),
        {"task": "hold_point", "path": next_to_taxel(150, 0.02, 0.0)},
        seconds=5.0,
        says=(UNABLE,),
        controllers=tuple(name for name in CONTROL_SCHEMES if name != "hybrid"),  # which sticks half-way, and says so
    ),
    "straight elbow, along": HardCase(
        "where the arm is at a stationary point the force is kept, the error stays what it is, and it is said",
        stretched_arm,
        both(kept(within=0.3, ripple=0.3), rests(0.1)),
        {"task": "hold_point", "path": next_to_taxel(150, 0.0, 0.02), "force_gain": 0.008},
        seconds=5.0,
        says=((LimitKind.NO_APPROACH,),),
    ),
    "straight elbow, pressed sideways": HardCase(
        "pressed where the arm can hardly yield it is ten times as stiff: with a gain for that the force is kept",
        lambda settings: stretched_arm(settings, 300),
        kept(within=0.3, ripple=0.3),
        {"force_gain": 0.004},
        seconds=4.0,
    ),
    "straight elbow, pressed sideways, high gain": HardCase(
        "with a high gain the force may swing, but not without bounds",
        lambda settings: stretched_arm(settings, 300),
        bounded_only,
        {"task": "hold_point", "path": next_to_taxel(300, 0.02, 0.0)},
        seconds=3.0,
        force=60.0,
        controllers=SOME,
    ),
    "target out of reach": HardCase(
        "joints stop before the place is reached: the arm stays, keeps the force and says so",
        lambda settings: pressed_by_ball(settings, prepared=narrowed(0.06)),
        both(kept(), rests(), stays_within(0.06)),
        {"task": "hold_point", "path": next_to_taxel(150, 0.035, 0.03)},
        seconds=6.0,
        says=((LimitKind.OUT_OF_REACH,), (LimitKind.JOINT_LIMIT,)),
    ),
    "joint limits on the path": HardCase(
        "two joints stop on the way: the others do what they can, within the limits and near the force",
        lambda settings: pressed_by_ball(settings, prepared=narrowed(0.01, "elbow_pitch", "shoulder_pitch")),
        stays_within(0.01),
        {"task": "follow_path"},
        seconds=5.0,
        says=((LimitKind.JOINT_LIMIT,),),
    ),
    "one joint for three tasks": HardCase(
        "a place that only sliding sideways could reach: force first, in the end by all controllers",
        one_joint,
        both(kept(within=0.3, ripple=0.3), rests()),
        {"task": "hold_point", "path": ((0.005, 0.005),)},
        seconds=5.0,
        says=((LimitKind.OUT_OF_REACH,),),
    ),
}
