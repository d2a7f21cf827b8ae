"""The last stretch of every import: a spec of anything becomes a robot alone that is known to run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np

from app.arrays import FloatArray
from app.errors import Finding, RobotError
from app.robots.compile import compile_spec, parse_spec, spec_text
from app.robots.exclusions import pairs_to_exclude
from app.robots.prove import prove_alive, refuse_absurd_numbers
from app.robots.robot import Joint, Link, Robot
from app.robots.strip import home_of_keyframe, name_everything, strip_scene
from app.robots.tessellate import link_mesh
from app.robots.thin_meshes import keep_inertias_valid, settle_thin_meshes

MAX_BODIES = 2000


def build_robot(
    spec: mujoco.MjSpec,
    *,
    name: str,
    source: str,
    assets: Mapping[str, bytes],
    findings: Sequence[Finding] = (),
    home: Mapping[str, float] | None = None,
) -> Robot:
    """Strip, check, compile and try out a spec; it is used up.

    Args:
        spec: A parsed spec whose files are bare names in ``assets``.
        name: A short name for people.
        source: Path or library name, for errors.
        assets: File contents by bare name.
        findings: What the reader noticed already.
        home: Joint values by joint name [rad, m], before those of a keyframe; others rest at zero.

    Raises:
        RobotError: The robot has no links, joints that are not scalar, too many bodies, or does not simulate.
    """
    if len(spec.bodies) > MAX_BODIES:
        raise RobotError(f"the robot has more than {MAX_BODIES} bodies", file=source, value=len(spec.bodies))
    wished = {**home_of_keyframe(spec), **(home or {})}
    notes = [*findings, *strip_scene(spec, source), *name_everything(spec), *settle_thin_meshes(spec, assets)]
    used = {mesh.file for mesh in spec.meshes}
    files = {file: content for file, content in assets.items() if file in used}
    first = compile_spec(spec, source=source)
    refuse_absurd_numbers(first, source)
    keep_inertias_valid(spec, first)
    notes += _exclude_touching(spec, first, _home(first, wished)[0])
    text = spec_text(spec, source=source)
    model = compile_spec(parse_spec(text, files, source=source), source=source)
    rest, clipped = _home(model, wished)
    if clipped:
        notes.append(Finding("home-outside-limits", ", ".join(clipped), "moved inside the limits", len(clipped)))
    prove_alive(model, rest, source)
    links = tuple(Link(model.body(i).name, link_mesh(model, i)) for i in range(1, model.nbody))
    return Robot(name, source, text, files, links, _joints(model), rest, tuple(notes))


def _exclude_touching(spec: mujoco.MjSpec, model: mujoco.MjModel, home: FloatArray) -> list[Finding]:
    known = {frozenset((exclude.bodyname1, exclude.bodyname2)) for exclude in spec.excludes}
    pairs = [pair for pair in pairs_to_exclude(model, home) if frozenset(pair) not in known]
    for first, second in pairs:
        spec.add_exclude(bodyname1=first, bodyname2=second)
    if not pairs:
        return []
    named = ", ".join(f"{first}-{second}" for first, second in pairs[:5]) + (", …" if len(pairs) > 5 else "")
    return [Finding("touching-links", named, "these pairs of links will not collide", len(pairs))]


def _joints(model: mujoco.MjModel) -> tuple[Joint, ...]:
    slide = mujoco.mjtJoint.mjJNT_SLIDE
    lower, upper = _limits(model)
    return tuple(
        Joint(model.joint(i).name, float(lower[i]), float(upper[i]), bool(model.jnt_type[i] == slide))
        for i in range(model.njnt)
    )


def _limits(model: mujoco.MjModel) -> tuple[FloatArray, FloatArray]:
    limited = model.jnt_limited.astype(bool)
    return np.where(limited, model.jnt_range[:, 0], -np.inf), np.where(limited, model.jnt_range[:, 1], np.inf)


def _home(model: mujoco.MjModel, wished: Mapping[str, float]) -> tuple[FloatArray, list[str]]:
    """The posture at rest, and the joints whose wish lay outside their limits."""
    lower, upper = _limits(model)
    names = [model.joint(i).name for i in range(model.njnt)]
    home = model.qpos0.copy()
    outside = (home < lower) | (home > upper)
    home[outside] = 0.5 * (lower[outside] + upper[outside])
    wishes = np.array([wished.get(name, rest) for name, rest in zip(names, home, strict=True)])
    finite = np.isfinite(wishes)
    inside = np.where(finite, np.clip(wishes, lower, upper), home)
    moved = ~finite | ~np.isclose(inside, wishes, rtol=0, atol=1e-5)
    return inside, [names[i] for i in np.flatnonzero(moved)]
