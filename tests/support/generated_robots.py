"""Robots as MJCF text: arms of any size, a hand and a leg, all straight if every joint is at zero."""

from __future__ import annotations

from pathlib import Path

from tactile_maps.robots.library import load_robot
from tactile_maps.robots.model.robot import Robot


def chain(axes: str, length: float, *, name: str = "", ranges: str = "-2 2", inner: str = "") -> str:
    """Return capsules of ``length`` [m] in a row along z, each rotating about the axis given by its letter."""
    text = inner
    for number in range(len(axes), 0, -1):
        axis = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}[axes[number - 1]]
        ends = f"0 0 {0.15 * length:.6g} 0 0 {0.85 * length:.6g}"
        text = (
            f'<body name="{name}link{number}" pos="0 0 {length if number > 1 else 0:.6g}">'
            f'<joint name="{name}joint{number}" axis="{axis}" range="{ranges}" damping="{5 * length**3:.6g}"/>'
            f'<geom type="capsule" size="{0.1 * length:.6g}" fromto="{ends}" density="500"/>{text}</body>'
        )
    return text


def model(bodies: str, *, height: float = 2.0, extra: str = "") -> str:
    """Return a robot whose base is a sphere at a height [m]."""
    base = f'<body name="base" pos="0 0 {height:g}"><geom size="0.01" contype="0" conaffinity="0"/>{bodies}</body>'
    return f'<mujoco><compiler angle="radian"/><worldbody>{base}</worldbody>{extra}</mujoco>'


def arm(size: float, *, extra: str = "") -> str:
    """Return a straight arm with six joints, 1.2 m long at scale 1."""
    return model(chain("zyyzyz", 0.2 * size), extra=extra)


def hand() -> str:
    """Return a palm with three fingers of four joints each, of which the last three are at a limit at zero."""
    fingers = ""
    for number in range(3):
        finger = chain("xyyy", 0.03, name=f"finger{number}_", ranges="0 1.6")
        fingers += f'<body name="mount{number}" pos="{0.04 * number - 0.04:g} 0 0.02">{finger}</body>'
    return model(fingers)


def leg() -> str:
    """Return a straight leg that hangs from a base."""
    return model(f'<body name="hip" euler="3.14159265 0 0">{chain("xyy", 0.3)}</body>')


ROBOTS = {"small arm": arm(0.2), "arm": arm(1.0), "large arm": arm(4.0), "hand": hand(), "leg": leg()}


def load(text: str, folder: Path, **options: object) -> Robot:
    """Write a model to a folder and load it."""
    path = folder / "generated.xml"
    path.write_text(text)
    return load_robot(path, **options)  # type: ignore[arg-type]
