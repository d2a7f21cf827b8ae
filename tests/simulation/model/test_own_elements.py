"""Elements that the program adds to a robot's model take nothing of the robot's defaults and compiler settings."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tactile_maps.control.path_following.clearance import collision_model
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.load import load_robot_file
from tactile_maps.robots.model.mujoco_spec import compile_spec, robot_spec
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.effects import Effects, Integrator
from tactile_maps.scene.objects import SceneObject
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.skin.fitting.cover import CoverSpec, cover_robot
from tactile_maps.skin.formats.mujoco_touch import write_touch_sensors
from tactile_maps.tactile.mechanics.loads import Box, Cylinder, Plane, Sphere
from tests.support.scene_objects import every_kind, thing
from tests.support.touch import bar, bar_skin, pair

WEDGE = Mesh(
    np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.03, 0.05, 0.0], [0.02, 0.01, 0.2]]),
    np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]),
)
"""A body whose axes of inertia are not those of its frame."""
OWN_PREFIXES = ("tactile-maps/", "impedance ")
DERIVED = ("adr", "id", "num", "bvh", "0", "plugin", "lengthrange", "treeid", "Jnum", "actadr")
"""Endings of model fields that depend on the whole robot, or are positions in other fields."""
KINDS = {
    "body": "body",
    "jnt": "joint",
    "geom": "geom",
    "site": "site",
    "pair": "pair",
    "actuator": "actuator",
    "mesh": "mesh",
    "sensor": "sensor",
}


def hostile_defaults(*, seed: int = 0) -> str:
    """A ``<default>`` section in which no attribute has MuJoCo's own value, and a class with other values."""
    one = iter(np.random.default_rng(seed).uniform(0.1, 0.9, 400).round(3).tolist())

    def some(count: int) -> str:
        return " ".join(str(next(one)) for _ in range(count))

    def limits() -> str:
        return f"-{next(one)} {next(one)}"

    def solver(suffix: str = "") -> str:
        return f'solref{suffix}="{some(2)}" solimp{suffix}="0.1 0.2 {some(2)} 3"'

    def settings() -> str:
        return f"""
          <joint type="slide" axis="{some(3)}" pos="{some(3)}" group="3" limited="true" range="{limits()}"
            actuatorfrclimited="true" actuatorfrcrange="{limits()}" actuatorgravcomp="true" margin="{some(1)}"
            ref="{some(1)}" springref="{some(1)}" stiffness="{some(3)}" damping="{some(3)}" armature="{some(1)}"
            frictionloss="{some(1)}" {solver("limit")} {solver("friction")}/>
          <geom type="cylinder" contype="7" conaffinity="7" condim="6" group="5" priority="3" size="{some(3)}"
            friction="{some(3)}" density="{some(1)}" solmix="{some(1)}" margin="{some(1)}" gap="{some(1)}"
            fitscale="{some(1)}" rgba="{some(4)}" euler="{some(3)}" pos="{some(3)}" shellinertia="true"
            fluidshape="ellipsoid" fluidcoef="{some(5)}" {solver()}/>
          <site type="cylinder" group="5" size="{some(3)}" pos="{some(3)}" euler="{some(3)}" rgba="{some(4)}"/>
          <mesh scale="{some(3)}" inertia="legacy" maxhullvert="7"/>
          <pair condim="6" friction="{some(5)}" margin="{some(1)}" gap="{some(1)}" solreffriction="{some(2)}"
            {solver()}/>
          <equality active="false" {solver()}/>
          <tendon group="5" limited="true" range="{limits()}" width="{some(1)}" {solver("limit")}/>
          <general ctrllimited="true" forcelimited="true" actlimited="true" ctrlrange="{limits()}" group="5"
            forcerange="{limits()}" actrange="{limits()}" gear="{some(6)}" cranklength="{some(1)}" dyntype="filter"
            dynprm="{some(3)}" gaintype="affine" gainprm="{some(3)}" biastype="affine" biasprm="{some(3)}"
            actearly="true"/>"""

    return f'<default>{settings()}<default class="other">{settings()}</default></default>'


def wedge() -> SceneObject:
    return thing("mesh", mesh=WEDGE, name="wedge", at=(7.0, 0.0, 5.0), mass=0.2)


COMPILER = '<compiler angle="radian" alignfree="true" boundmass="5" boundinertia="5" inertiagrouprange="4 5"/>'


def hostile(robot: Robot, *, seed: int = 0) -> Robot:
    """The robot with hostile defaults and settings in its text; what its joints weigh is stated."""
    text = robot.mjcf.replace('<compiler angle="radian"/>', COMPILER + hostile_defaults(seed=seed))
    text = text.replace('<joint name="hinge"', '<joint name="hinge" type="hinge"')
    text = text.replace("<joint name=", '<joint armature="0" pos="0 0 0" ref="0" name=')
    for link in robot.links:
        text = text.replace(f'<body name="{link.name}"', f'<body name="{link.name}" childclass="other"')
    assert text.count("childclass") == len(robot.links)
    return replace(robot, mjcf=text)


def own_elements(model: mujoco.MjModel) -> dict[str, np.ndarray]:
    """Compiled values of the elements that the program added, by field and name."""
    found = {}
    for prefix, kind in KINDS.items():
        accessor = getattr(model, kind)
        count = int(getattr(model, f"n{'u' if kind == 'actuator' else prefix}"))
        fields = [name for name in dir(model) if name.startswith(f"{prefix}_") and not name.endswith(DERIVED)]
        for number in range(count):
            name = accessor(number).name
            if not name.startswith(OWN_PREFIXES) and kind != "pair":
                continue
            for field in fields:
                values = np.atleast_1d(getattr(model, field))
                if len(values) == count:
                    found[f"{field} of {name}"] = np.array(values[number])
    return found


def differences(one: mujoco.MjModel, other: mujoco.MjModel) -> list[str]:
    first = own_elements(one)
    second = own_elements(other)
    assert first.keys() == second.keys()
    return [
        f"{name}: {first[name]} and {second[name]}"
        for name in first
        if not np.allclose(first[name], second[name], atol=1e-9, rtol=1e-9, equal_nan=True)
    ]


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("skin", ["water-fill", "depth"])
@pytest.mark.parametrize("integrator", ["implicitfast", "discrete"])
def test_added_elements_are_the_same_with_hostile_defaults(skin: str, integrator: Integrator) -> None:
    effects = Effects(contact="all", skin=skin, integrator=integrator)
    guided = thing("box", name="lift", at=(6.0, 0.0, 5.0), mass=0.2, guided=True)
    objects = (*every_kind(), guided, wedge())
    plain = assemble(bar(), bar_skin(), effects, objects=objects)
    found = assemble(hostile(bar()), bar_skin(), effects, objects=objects)
    assert len(own_elements(plain)) > 500
    assert {len(values) for values in (plain.actuator_gear, found.actuator_gear)} == {4}
    assert differences(plain, found) == []


def test_hulls_in_self_contact_are_the_same_with_hostile_defaults() -> None:
    robot, skin = pair()
    effects = Effects(contact="self")
    plain, found = (assemble(one, skin, effects) for one in (robot, hostile(robot)))
    assert plain.npair == 1
    assert differences(plain, found) == []


def test_obstacles_of_the_planner_are_the_same_with_hostile_defaults() -> None:
    mesh = thing("mesh").mesh
    shapes = (Sphere(0.1), Box((0.1, 0.2, 0.3)), Cylinder(0.1, 0.2), Plane(), mesh)
    plain, found = (collision_model(robot, bar_skin(), shapes) for robot in (bar(), hostile(bar())))
    assert sum("obstacle" in plain.geom(number).name for number in range(plain.ngeom)) == len(shapes)
    assert differences(plain, found) == []


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_random_defaults_do_not_change_added_elements(seed: int) -> None:
    effects = Effects(contact="all")
    objects = (*every_kind(), wedge())
    plain, found = (
        assemble(robot, bar_skin(), effects, objects=objects) for robot in (bar(), hostile(bar(), seed=seed))
    )
    assert differences(plain, found) == []


def test_hinges_in_place_of_a_ball_joint_are_the_same_with_hostile_defaults(tmp_path: Path) -> None:
    body = """<mujoco><compiler angle="radian"/>{}<worldbody><body name="ball"><inertial pos="0 0 0" mass="1"
      diaginertia="1 1 1"/>
      <joint name="turn" type="ball" pos="0 0 0" limited="true" range="0 1" damping="0.1" frictionloss="0.2"
        armature="0.3" group="2"/></body></worldbody></mujoco>"""
    joints = []
    for number, defaults in enumerate(("", hostile_defaults())):
        path = tmp_path / f"ball{number}.xml"
        path.write_text(body.format(defaults))
        model = compile_spec(robot_spec(load_robot_file(path)), source="ball")
        fields = [name for name in dir(model) if name.startswith("jnt_") and not name.endswith(DERIVED)]
        joints.append({name: np.array(getattr(model, name)) for name in fields})
        joints[-1]["dof"] = np.stack([model.dof_damping, model.dof_frictionloss, model.dof_armature])
    assert all(np.array_equal(joints[0][name], joints[1][name]) for name in joints[0])


def test_written_touch_sensors_are_the_same_with_hostile_defaults(tmp_path: Path) -> None:
    sites = []
    for number, robot in enumerate((bar(), hostile(bar()))):
        write_touch_sensors(bar_skin(), robot, tmp_path / f"skin{number}.xml")
        model = mujoco.MjModel.from_xml_path(str(tmp_path / f"skin{number}.xml"))
        sites.append((model.site_pos, model.site_size, model.site_type, model.site_quat))
    assert all(np.allclose(one, other, atol=1e-6) for one, other in zip(*sites, strict=True))


@pytest.mark.long
def test_arm_reaches_its_target_with_any_actuator_defaults(tmp_path: Path) -> None:
    path = tmp_path / "finger.xml"
    path.write_text(FINGER)
    robot = load_robot_file(path)
    skin = cover_robot(robot, CoverSpec(links=("finger",), taxels=20))
    model = assemble(robot, skin, Effects(gravity="off", contact="off"))
    data = mujoco.MjData(model)
    model.actuator_gainprm[0, 0] = 100.0
    model.actuator_biasprm[0, 1:3] = -100.0, -10.0
    data.ctrl[0] = 1.0
    mujoco.mj_step(model, data, 3000)
    assert data.qpos[0] == pytest.approx(1.0, abs=1e-3)


FINGER = """<mujoco model="finger">
  <default><position kp="10" ctrlrange="-0.2 0.2" forcerange="-1 1" gear="3" dampratio="1"/></default>
  <worldbody><body name="base"><geom type="box" size=".05 .05 .05"/>
    <body name="finger" pos="0 0 .12"><joint name="bend" axis="0 1 0" range="-90 90" armature="0.01"/>
      <geom type="capsule" size=".03 .06" pos="0 0 .1"/></body></body></worldbody></mujoco>"""
