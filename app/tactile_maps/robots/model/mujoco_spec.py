"""From text to MuJoCo and back: MuJoCo's complaints become one sentence a user can act on."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any
from xml.etree.ElementTree import tostring

import mujoco
import numpy as np

from tactile_maps.core.errors import Finding, RobotError
from tactile_maps.robots.files.model_limits import check_amounts, check_contents
from tactile_maps.robots.files.safe_files import parse_xml
from tactile_maps.robots.model.mujoco_warnings import collect_warnings, limit_findings, warning_findings
from tactile_maps.robots.model.robot import Robot

OWN_NAMES = "tactile-maps/"
"""What we add to a robot's model is called so first, and nothing of a robot is: nobody can be taken for another."""
TOUCHING = f"{OWN_NAMES}touching "
"""How the names of exclusions begin that were found when the robot was loaded, by the shapes of its model."""


def robot_spec(robot: Robot) -> mujoco.MjSpec:
    """Return a new, editable MuJoCo spec of ``robot`` alone, in radians; the caller owns it.

    Elements that are added to it inherit nothing: the defaults and the compiler settings are MuJoCo's own. The text of
    a robot states the masses and inertias of its links, so that these settings no longer concern them.

    Raises:
        RobotError: MuJoCo cannot read the robot's text, or a name in it is kept for us.

    Cost: about a millisecond; compiling is what takes time.
    """
    spec = parse_spec(robot.mjcf, robot.assets, source=robot.source)
    settings = spec.compiler
    settings.degree = False
    settings.alignfree = False
    settings.boundmass = settings.boundinertia = 0.0
    settings.inertiagrouprange = [0, mujoco.mjNGROUP - 1]
    check_names(spec, source=robot.source)
    return spec


def drop_found_exclusions(spec: mujoco.MjSpec) -> frozenset[frozenset[str]]:
    """Delete the exclusions that were found when the robot was loaded; return their pairs of links."""
    found = [exclude for exclude in spec.excludes if exclude.name.startswith(TOUCHING)]
    pairs = frozenset(frozenset((exclude.bodyname1, exclude.bodyname2)) for exclude in found)
    for exclude in found:
        spec.delete(exclude)
    return pairs


def check_names(spec: mujoco.MjSpec, *, source: str) -> None:
    """Refuse a robot that uses names kept for what is added to it.

    Raises:
        RobotError: With the element's name.
    """
    for kind in ("bodies", "joints", "geoms", "meshes"):
        for element in getattr(spec, kind):
            if element.name.startswith(OWN_NAMES):
                remedy = f"Give it a name that does not begin with {OWN_NAMES}"
                raise RobotError(
                    "this name is reserved for the program", file=source, value=element.name, remedy=remedy
                )


def parse_spec(
    text: str, assets: Mapping[str, bytes], *, source: str, findings: list[Finding] | None = None
) -> mujoco.MjSpec:
    """Parse MJCF or URDF text whose files are all in ``assets``.

    The text may be anyone's: MuJoCo gets what our own parser understood of it, once its amounts and files are checked.

    Args:
        text: The text.
        assets: File contents by name.
        source: Its name in errors and findings.
        findings: Receives the warnings of MuJoCo's parser, and joint limits that MuJoCo ignores.

    Raises:
        RobotError: The text asks for too much, names other files, or MuJoCo cannot read it.
    """
    root = parse_xml(text.encode(errors="replace"), file=source)
    check_contents(root, assets, source)
    check_amounts(root, source)
    try:
        with collect_warnings() as texts:
            spec = mujoco.MjSpec.from_string(tostring(root, encoding="unicode"), assets=dict(assets))
    except (ValueError, mujoco.FatalError) as error:
        raise RobotError("MuJoCo cannot read the robot", file=source, value=_mujoco_message(error)) from error
    if findings is not None:
        findings += limit_findings(spec, texts, urdf=root.tag == "robot")
        findings += warning_findings(texts, source=source)
    _reset_defaults(spec, {element.get("class", "") for element in root.iter("default")})
    return spec


_DEFAULT_KINDS = (
    "actuator", "camera", "equality", "flex", "geom", "joint", "light", "material", "mesh", "pair", "site", "tendon",
)  # fmt: skip
_NO_SETTINGS = ("classname", "compiler", "id", "info", "name", "plugin", "signature")
"""Properties of an element that are not settings; MuJoCo 4.0.0 crashes when some of them are read from a default."""


def _reset_defaults(spec: mujoco.MjSpec, classes: Collection[str]) -> None:
    """Give every default of ``spec`` MuJoCo's own values: an element added later must not inherit the file's.

    The elements of the file are unaffected: they got their values when the file was read.
    """
    fresh = mujoco.MjSpec()  # its defaults live only as long as it does
    settings = {kind: list(_settings(getattr(fresh.default, kind))) for kind in _DEFAULT_KINDS}
    for default in (spec.default, *(found for name in classes if (found := spec.find_default(name)) is not None)):
        for kind, values in settings.items():
            _apply(values, getattr(default, kind))


def _settings(element: object) -> Iterator[tuple[str, Any]]:
    """Names and values of an element's settings; the value of an orientation is a tuple of its own settings."""
    for name, described in vars(type(element)).items():
        if isinstance(described, property) and described.fset is not None and name not in _NO_SETTINGS:
            value = getattr(element, name)
            yield name, tuple(_settings(value)) if isinstance(value, mujoco.MjsOrientation) else value


def _apply(settings: Sequence[tuple[str, Any]], element: object) -> None:
    for name, value in settings:
        if isinstance(value, np.ndarray):
            getattr(element, name)[...] = value
        elif isinstance(value, tuple):
            _apply(value, getattr(element, name))
        else:
            setattr(element, name, value)


def compile_spec(spec: mujoco.MjSpec, *, source: str, findings: list[Finding] | None = None) -> mujoco.MjModel:
    """Compile ``spec``; convex hulls of the colliding meshes take most of the time.

    Args:
        spec: What to compile.
        source: Its name in errors.
        findings: Where warnings of what MuJoCo will give up one day are told.

    Raises:
        RobotError: MuJoCo refuses the model, or warns that its numbers are not sound.
    """
    try:
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            model = spec.compile()
    except (ValueError, mujoco.FatalError) as error:
        raise RobotError("MuJoCo cannot build the robot", file=source, value=_mujoco_message(error)) from error
    for text in dict.fromkeys(str(warning.message) for warning in told):
        if "deprecated" not in text:  # of inertias it cannot invert, for one
            raise RobotError("MuJoCo cannot build the robot", file=source, value=_mujoco_message(text))
        if findings is not None:
            findings.append(Finding("deprecated", source, f"MuJoCo: {_mujoco_message(text)}"))
    return model


def spec_text(spec: mujoco.MjSpec, *, source: str) -> str:
    """``spec`` as MJCF text in radians; it must have been compiled.

    Raises:
        RobotError: MuJoCo cannot write it.
    """
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", ".*deprecated", UserWarning)  # compiling it has told
            return spec.to_xml()
    except (ValueError, mujoco.FatalError) as error:
        raise RobotError("MuJoCo cannot write the robot", file=source, value=_mujoco_message(error)) from error


@contextmanager
def editing_spec(*, source: str) -> Iterator[None]:
    """Around changes to a spec, which MuJoCo checks only then: repeated names, for one.

    Raises:
        RobotError: MuJoCo refuses one.
    """
    try:
        yield
    except (ValueError, mujoco.FatalError) as error:
        raise RobotError("MuJoCo cannot build the robot", file=source, value=_mujoco_message(error)) from error


def _mujoco_message(error: Exception | str) -> str:
    """MuJoCo's message on one line, without its prefix."""
    return " ".join(str(error).split()).removeprefix("Error: ").removeprefix("XML Error: ")


def remove_geoms(spec: mujoco.MjSpec) -> None:
    """Delete the geometry of bodies whose inertia is stated, and the meshes nobody uses then.

    Bodies whose inertia comes from their shapes keep them, but collide with nothing.
    """
    for body in spec.bodies:
        for geom in list(body.geoms):
            if body.explicitinertial:
                spec.delete(geom)
            else:
                geom.contype = geom.conaffinity = 0
    used = {geom.meshname for geom in spec.geoms}
    for mesh in [mesh for mesh in spec.meshes if mesh.name not in used]:
        spec.delete(mesh)
    for pair in list(spec.pairs):
        spec.delete(pair)
