"""Random scenes within the limits of scene files, and independent measurements of their simulation.

``random_scene(seed)`` is the text of a scene: the arm with objects of 1e-6 to 1e3 kg, covers and springs of 10 to
1e8 N/m, steps of 0.1 to 10 ms, every integrator, contact model and controller, gains at the ends of their ranges,
fingers, probes that jump, and motions that are too fast. Robot, skin and map are those of ``covered_arm``.

``play`` runs a scene and measures the state of MuJoCo at every step: penetration depths, speeds, forces between bodies,
and their energy if nothing adds to it; with shear also the friction in use of taxels and contacts. ``unreported``
returns the values that exceed their bound without a report.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, get_args

import mujoco
import numpy as np

from tactile_maps.contacts.force_estimation.estimate import ESTIMATORS
from tactile_maps.control.motion.command import CHOICES, RANGES
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import SimulationError, TactileMapsError
from tactile_maps.core.toml import toml_lines
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.scene.effects import Integrator, SkinModel
from tactile_maps.scene.object_meshes import make_objects
from tactile_maps.scene.scene_file import load_scene, scene_from_toml
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.session.session import Session
from tactile_maps.simulation.model.model_names import is_hull, is_object
from tactile_maps.tactile.models.contact_model import WITH_SHEAR

SECONDS = 0.3
_ROUNDING = 1e-3
_GAIN = 0.05
"""[J], and share of what was stored or moved, that energy may come out wrong by: a tick is many steps."""
MOST_FORCE = 1e4
MOST_SPEED = 100.0
MOST_DEPTH = 0.010
"""[N], [m/s], [m] that nothing may pass unreported."""
_FRICTION_GAIN = 1e-9
"""Share of the friction force times the way that may come out as a gain, by the solver's tolerance."""
MOST_GAIN = 1e-6
"""[J] that friction may add to the bodies in a scene: 1e-10 J a contact and step, at most."""
MOST_FRICTION = 1 + 1e-9
"""Share of Coulomb's limit that no taxel and no contact may pass."""
STEPS = (0.0001, 0.0002, 0.0005, 0.001, 0.002, 0.004, 0.005, 0.008, 0.01)
_GAINS = (
    "stiffness",
    "damping_ratio",
    "force_gain",
    "integral_time",
    "position_gain",
    "inertia_time",
    "path_speed",
    "force_goal",
    "max_force",
)


@cache
def covered_arm() -> PreparedScene:
    """Our arm with 60 taxels on forearm and hand."""
    scene = load_scene("arm")
    return prepare_cached(replace(scene, cover=replace(scene.cover, links=("forearm", "hand"), taxels=60), stimuli=()))


def random_scene(seed: int, *, shear: bool = False) -> str:
    """The text of a scene; every fifth has the same integrator.

    With ``shear`` the same scene has friction and shear, and a contact model that supports it.
    """
    rng = np.random.default_rng((41, seed))
    step = float(rng.choice(STEPS))
    tick = step * max(round(float(rng.choice([0.005, 0.01, 0.02])) / step), 1)
    scene: dict[str, Any] = {
        "robot": "arm",
        "task": str(rng.choice(["touch", "slide", "push", "crowd", "self-touch"])),
        "tick": tick,
        "seed": seed,
    }
    tables: dict[str, dict[str, Any]] = {
        "layer": _layer(rng),
        "effects": _effects(rng, step, get_args(Integrator)[seed % len(get_args(Integrator))]),
        "control": _control(rng),
        "contacts": {"estimator": str(rng.choice(ESTIMATORS))},
    }
    alone = rng.random() < 0.35  # nothing adds to the energy
    if alone:
        tables["control"] |= {"controller": "impedance"}
    lists = {
        "objects": [_object(rng, number, still=alone) for number in range(int(rng.integers(0, 5)))],
        "stimuli": [_hand(rng) for _ in range(0 if alone else int(rng.integers(0, 3)))],
        "motion": [_waypoint(rng) for _ in range(int(rng.integers(1, 3)))] if rng.random() < 0.3 and not alone else [],
    }
    if shear:
        model = str(np.random.default_rng((43, seed)).choice(WITH_SHEAR))
        tables["effects"] |= {"skin": model, "friction": True, "shear": True}
    parts = [toml_lines(scene)]
    for key, table in tables.items():
        parts += [f"[{key}]", toml_lines(table)]
    for key, rows in lists.items():
        for row in rows:
            parts += [f"[[{key}]]", toml_lines(row)]
    return "\n".join(parts) + "\n"


def _power(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a power of ten with a uniform exponent."""
    return float(10 ** rng.uniform(low, high))


def _layer(rng: np.random.Generator) -> dict[str, Any]:
    return {
        "stiffness": _power(rng, 1, 8),
        "modulus": _power(rng, 3, 9),
        "poisson": float(rng.uniform(0, 0.49)),
        "thickness": _power(rng, -3.5, -1.5),
        "friction": float(rng.uniform(0, 2)),
    }


def _effects(rng: np.random.Generator, step: float, integrator: str) -> dict[str, Any]:
    return {
        "timestep": step,
        "integrator": integrator,
        "skin": str(rng.choice([model for model in get_args(SkinModel) if model != "off"])),
        "contact": str(rng.choice(["environment", "environment", "all", "probe", "auto"])),
        "gravity": str(rng.choice(["on", "compensated", "off"])),
        "friction": bool(rng.random() < 0.5),
        "joint_limits": bool(rng.random() < 0.8),
    }


def _control(rng: np.random.Generator) -> dict[str, Any]:
    chosen: dict[str, Any] = {
        name: str(rng.choice(CHOICES[name])) for name in ("controller", "task", "gains", "jacobian", "path_kind")
    }
    for name in _GAINS:
        if rng.random() < 0.5:
            low, high = RANGES[name]
            chosen[name] = (
                float(rng.choice([low, min(high, 1e3)])) if rng.random() < 0.7 else low + 0.1 * (min(high, 1e3) - low)
            )
    return chosen


def _object(rng: np.random.Generator, number: int, *, still: bool) -> dict[str, Any]:
    """Return an object near the skin, from 4 mm deep in it to 30 mm away, or above it."""
    kind = str(rng.choice(["sphere", "box", "cylinder", "probe", "plate"]))
    size = _power(rng, -3, -0.5)
    sizes = {
        "sphere": [size],
        "probe": [min(size, 0.05)],
        "cylinder": [size, size * _power(rng, -1, 1)],
        "box": [size, size * _power(rng, -1, 0.5), size],
        "plate": [size, size, size * _power(rng, -1, 0)],
    }
    extents = [min(max(edge, 1e-3), 1.0) for edge in sizes[kind]]
    reach = extents[0] if kind in ("sphere", "probe") else 0.5 * max(extents)
    point, normal = _place(rng)
    gap = float(rng.choice([-0.004, 0.0005, 0.002, 0.03]))
    away = np.array([0.0, 0.0, 1.0]) if rng.random() < 0.3 else normal
    at = point + (reach + gap) * away + (_power(rng, -3, 0) * np.array([0, 0, 1]) if rng.random() < 0.3 else 0)
    made: dict[str, Any] = {
        "name": f"thing {number}",
        "kind": kind,
        "size": extents,
        "at": _rounded(at),
        "turn": _rounded(rng.uniform(-180, 180, 3)),
        "mass": 0.0 if rng.random() < 0.15 and kind not in ("probe", "plate") else _power(rng, -6, 3),
        "friction": float(rng.uniform(0, 2)),
    }
    if kind == "plate":
        made |= {"stiffness": _power(rng, 1, 8), "damping": float(rng.uniform(0, 2))}
    elif kind == "probe":
        made["max_force"] = _power(rng, 0, 4)
        if rng.random() < 0.7 and not still:
            made["path"] = _path(rng, point, normal, reach)
    elif made["mass"] and rng.random() < 0.3:
        made["guided"] = True
    return made


def _path(rng: np.random.Generator, point: np.ndarray, normal: np.ndarray, reach: float) -> list[list[float]]:
    """Return the path of a probe to depths that it cannot reach, slow or immediate."""
    times = np.cumsum([0.0, *(_power(rng, -3.5, -0.7) for _ in range(int(rng.integers(1, 4))))])
    heights = [0.005, *(rng.uniform(-0.06, 0.01, len(times) - 1))]
    return [_rounded([time, *(point + (reach + high) * normal)]) for time, high in zip(times, heights, strict=True)]


def _place(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return the position and the outward normal (3,) of a taxel in the world, at home."""
    prepared = covered_arm()
    at = prepared.skin.taxel_point(int(rng.integers(len(prepared.skin))))
    pose = Configuration(prepared.robot).pose(prepared.skin.link(at))
    return pose.points(prepared.skin.position(at)), pose.directions(prepared.skin.normal(at))


def _hand(rng: np.random.Generator) -> dict[str, Any]:
    kind = str(rng.choice(["poke", "stroke", "tap", "roll", "grasp"]))
    made: dict[str, Any] = {
        "kind": kind,
        "patch": str(rng.choice([patch.name for patch in covered_arm().skin.patches])),
        "force": _power(rng, -1, 2),
        "press": _power(rng, -3, 0),
        "radius": _power(rng, -3, -1.3),
        "stiffness": _power(rng, 1, 6),
        "begin": float(rng.uniform(0, 0.1)),
    }
    return made | ({"at": _rounded(rng.uniform(0, 1, 2))} if kind != "stroke" else {"speed": _power(rng, -2, 1)})


def _waypoint(rng: np.random.Generator) -> dict[str, Any]:
    """Return a posture within the joint limits that is reached quickly."""
    joints = covered_arm().robot.joints
    home = covered_arm().robot.home
    chosen = rng.choice(len(joints), size=2, replace=False)
    posture = {
        joints[k].name: round(float(np.clip(home[k] + rng.normal(), joints[k].lower, joints[k].upper)), 4)
        for k in chosen
    }
    return {"posture": posture, "seconds": max(_power(rng, -2, 0.3), 0.01)}


def _rounded(values: Any) -> list[float]:
    return [round(float(value), 5) for value in values]


@dataclass
class Outcome:
    """Measurements of a scene from the state of MuJoCo, and the reports of the program.

    Attributes:
        force: Greatest between two bodies, or on a free one [N].
        speed: Greatest of a body's centre of mass [m/s].
        depth: Greatest of one body in another [m].
        gained: Greatest mechanical energy over that at the start, where nothing adds to it [J]; None where something
            may.
        stored: What gained energy is held against [J]: what the skin stored at the start, and the most motion since.
        taxel_friction: Greatest shear of a taxel over friction times its pressure; 0 without shear.
        contact_friction: Greatest friction of a contact over its limit; 0 without shear.
        friction_work: Work of friction on the way of all steps [J]; a loss is negative.
        friction_gain: Sum of the works that are positive, over contacts and steps [J].
        refused: The error that rejected the scene; "" for none.
        failure: The error that stopped the run; "" for none.
        remedied: Whether this error states a remedy.
        reported: Kinds of everything that was reported: findings, notes, limits, refused inputs.
    """

    force: float = 0.0
    speed: float = 0.0
    depth: float = 0.0
    gained: float | None = None
    stored: float = 0.0
    taxel_friction: float = 0.0
    contact_friction: float = 0.0
    friction_work: float = 0.0
    friction_gain: float = 0.0
    refused: str = ""
    failure: str = ""
    remedied: bool = True
    reported: set[str] = field(default_factory=set)


def play(text: str, *, seconds: float = SECONDS) -> Outcome:
    """Run a scene's text for some simulated seconds, or until it stops."""
    outcome = Outcome()
    try:
        scene = scene_from_toml(text, name="random")
        prepared = replace(covered_arm(), scene=scene, objects=make_objects(scene))
        session = Session(prepared)
    except TactileMapsError as error:
        outcome.refused = str(error)
        outcome.remedied = bool(error.remedy)
        return outcome
    outcome.reported |= {f"finding {finding.kind}" for finding in scene.decision.warnings}
    judge = _Judge(session, outcome)
    with judge.watching():
        for _ in range(round(seconds / scene.tick)):
            try:
                frame = session.tick()
            except SimulationError as error:
                if session.failure is not None:
                    outcome.failure = str(error)
                    outcome.remedied = bool(error.remedy)
                    break
                outcome.reported.add(f"refused {error.problem}")
                continue
            except TactileMapsError as error:
                outcome.reported.add(f"refused {error.problem}")
                continue
            outcome.reported |= {f"note {note.kind.value}" for note in frame.notes}
            outcome.reported |= {f"limit {limit.kind.value}" for limit in frame.why_limited}
            for values in (frame.posture, frame.velocity, frame.pressures, frame.objects):
                assert np.isfinite(values).all(), "everything that is shown is a number"
            judge.look(frame.pressures)
    return outcome


class _Judge:
    """Measures a session by MuJoCo's state. It sees every step through MuJoCo's callback, and the forces every tick."""

    def __init__(self, session: Session, outcome: Outcome) -> None:
        self._simulation = session._simulation
        physics = session._simulation._physics
        self._model = physics.model
        self._data = physics.data
        self._outcome = outcome
        scene = session.prepared.scene
        self._alone = not scene.stimuli and not scene.motion and not any(thing.path for thing in scene.objects)
        self._alone = self._alone and scene.control["controller"] == "impedance" and scene.effects.skin != "foundation"
        self._layer = scene.layer.stiffness
        self._free = [
            slice(int(adr), int(adr) + (3 if num >= 3 else 1))
            for adr, num, body in zip(
                self._model.body_dofadr, self._model.body_dofnum, range(self._model.nbody), strict=True
            )
            if num and is_object(self._model.body(body).name)
        ]
        self._time = -1.0
        self._alone = self._alone and self._skin_alone()
        self._start = sum(self._energy())
        self._fastest = 0.0
        # Of the skin that is pressed in; later its springs give back what they took.
        self._stored = 0.5 * self._layer * float(np.square(self._data.contact.dist).sum())

    @contextmanager
    def watching(self) -> Iterator[None]:
        physics = self._simulation._physics
        after = physics._look

        def look() -> None:
            self._add_friction_work()
            after()

        mujoco.set_mjcb_control(self._step)
        physics._look = look
        try:
            yield
        finally:
            mujoco.set_mjcb_control(None)
            physics._look = after

    def _step(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        if data.time < self._time + 0.99 * model.opt.timestep:
            return  # within a step of Runge-Kutta
        self._time = data.time
        outcome = self._outcome
        if data.ncon:
            outcome.depth = max(outcome.depth, -float(data.contact.dist.min()))
        spin = data.cvel[:, :3]
        motion = data.cvel[:, 3:]
        arms = data.xipos - data.subtree_com[model.body_rootid]
        speed = float(np.linalg.norm(motion + np.cross(spin, arms), axis=1).max())
        if np.isfinite(speed):
            outcome.speed = max(outcome.speed, speed)
        for dofs in self._free:  # of the step before
            force = float(np.linalg.norm(data.qfrc_constraint[dofs]))
            if np.isfinite(force):
                outcome.force = max(outcome.force, force)

    def look(self, pressures: FloatArray) -> None:
        """After a tick, whose readings have no effects of the sensor."""
        own = np.zeros(6)
        for number in range(self._data.ncon):
            mujoco.mj_contactForce(self._model, self._data, number, own)
            self._outcome.force = max(self._outcome.force, float(np.linalg.norm(own[:3])))
        self._look_at_friction(pressures)
        if self._alone:
            moving, still = self._energy()
            self._fastest = max(self._fastest, moving)
            gained = moving + still - self._start - self._stored
            self._outcome.gained = max(self._outcome.gained or 0.0, gained)
            self._outcome.stored = self._stored + self._fastest

    def _look_at_friction(self, pressures: FloatArray) -> None:
        """Compare the shear of the last reading with Coulomb's limits, of taxels and of contacts."""
        simulation = self._simulation
        shear = simulation.shear
        if shear is None:
            return
        outcome = self._outcome
        skin = simulation._skin
        links = np.array([patch.link for patch in skin.patches])[skin.patch_of]
        friction = np.zeros(len(skin))
        for one in simulation.sheared:
            own = links == one.load.link
            friction[own] = np.maximum(friction[own], one.load.friction)
            outcome.contact_friction = max(outcome.contact_friction, one.usage)
        lengths = np.linalg.norm(shear, axis=1)
        limits = friction * pressures
        used = np.divide(lengths, limits, out=np.where(lengths > 0, np.inf, 0.0), where=limits > 0)
        outcome.taxel_friction = max(outcome.taxel_friction, float(used.max()))

    def _add_friction_work(self) -> None:
        """Add the work of friction in the last step: force times the way to the end of the step.

        The way is that of the velocity at the end. With it the mechanical energy of a step changes by the work of all
        forces without potential, less the kinetic energy of the change of velocity.
        """
        model = self._model
        data = self._data
        rows = data.contact.efc_address
        rows = rows[(rows >= 0) & (data.contact.dim > 1)]
        if not rows.size or not np.isfinite(data.qvel).all():
            return
        along = np.stack([rows + 1, rows + 2])
        way = model.opt.timestep * (data.efc_J.reshape(-1, model.nv)[along] @ data.qvel)
        force = data.efc_force[along]
        work = (force * way).sum(axis=0)
        rounding = _FRICTION_GAIN * np.linalg.norm(force, axis=0) * np.linalg.norm(way, axis=0)
        self._outcome.friction_work += float(work.sum())
        self._outcome.friction_gain += float(np.maximum(work - rounding, 0.0).sum())

    def _skin_alone(self) -> bool:
        """Whether only skin, whose stiffness the scene states, is pressed in at the start."""
        return all(
            {is_hull(self._model.geom(geom).name) for geom in pair} == {True, False}
            for pair in self._data.contact.geom.tolist()
        )

    def _energy(self) -> tuple[float, float]:
        """Return the kinetic energy, and the potential energy of height and of springs of joints and servos [J]."""
        model = self._model
        data = self._data
        mujoco.mj_energyVel(model, data)
        carried = model.body_mass * (1 - model.body_gravcomp)
        energy = -float(carried @ (data.xipos @ model.opt.gravity))
        energy += float(
            sum(0.5 * model.jnt_stiffness[j] * data.qpos[model.jnt_qposadr[j]] ** 2 for j in range(model.njnt))
        )
        stretched = np.abs(data.ctrl - data.actuator_length)
        gains = model.actuator_gainprm[:, 0]
        most = np.where(model.actuator_forcelimited, model.actuator_forcerange[:, 1], np.inf)
        soft = np.minimum(stretched, most / np.maximum(gains, 1e-12))  # beyond that a servo pulls with all it has
        energy += float(gains @ (soft * (stretched - 0.5 * soft)))
        return float(data.energy[1]), energy


_PREDICTED = {"finding unstable-time-step", "note unstable", "note unstable-servo"}
"""Reports that contacts or servos of the scene are known to gain energy."""


def unreported(outcome: Outcome) -> list[str]:
    """Return what exceeded its bound without a report.

    A scene that was stopped with a reason is judged by the energy of friction up to there.
    """
    of_friction = f"{outcome.friction_gain:.3g} J of friction"
    gained = [of_friction] if outcome.friction_gain > MOST_GAIN else []
    if outcome.refused or outcome.failure:
        return gained if outcome.remedied else [*gained, "what to do about its end"]
    reported = outcome.reported
    gain = outcome.gained or 0.0
    # A body that starts deep in skin too stiff for the time step is thrown out; both are reported.
    released = "note hard" in reported and bool(reported & _PREDICTED)
    beyond = {
        f"{outcome.force:.3g} N": outcome.force > MOST_FORCE and not reported & {"note hard", "note deep"},
        f"{outcome.speed:.3g} m/s": outcome.speed > MOST_SPEED
        and "note unstable-servo" not in reported
        and "note fast" not in reported
        and not released,
        f"{1e3 * outcome.depth:.3g} mm deep": outcome.depth > MOST_DEPTH and "note deep" not in reported,
        f"shear of a taxel {outcome.taxel_friction:.9g} times its limit": outcome.taxel_friction > MOST_FRICTION,
        f"friction {outcome.contact_friction:.9g} times its limit": outcome.contact_friction > MOST_FRICTION,
        of_friction: bool(gained),
        f"{gain:.3g} J of nothing": gain > _ROUNDING + _GAIN * outcome.stored and not reported & _PREDICTED,
    }
    return [what for what, is_so in beyond.items() if is_so]
