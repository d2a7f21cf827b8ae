"""MuJoCo specs from text and back, with errors of MuJoCo as errors for the user."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterator, Mapping, Sequence, Sized
from contextlib import contextmanager
from types import MappingProxyType
from typing import Any
from xml.etree.ElementTree import tostring

import mujoco
import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.caches import weak_cache
from tactile_maps.core.errors import Finding, RobotError
from tactile_maps.robots.files.model_limits import check_amounts, check_contents
from tactile_maps.robots.files.safe_files import parse_xml
from tactile_maps.robots.model.mujoco_warnings import collect_warnings, limit_findings, warning_findings
from tactile_maps.robots.model.robot import Robot

OWN_NAMES = "tactile-maps/"
"""Prefix of the names of elements that are added to a robot's model; the robot itself may not use it."""
_SHORTEST_AXIS = 1e-12
"""Length of a joint's axis below which MuJoCo does not normalise it."""
TOUCHING = f"{OWN_NAMES}touching "
"""Prefix of the exclusions that were found from the shapes of the robot when it was loaded."""
MESH_CACHE = 128 * 2**20
"""Bytes of compiled meshes that MuJoCo keeps, so that a robot compiles up to twice as fast again. By default it keeps
500 MB, which a window that opens many robots fills with those that were closed. Arms need 40 to 90 MB."""
mujoco.mj_setCacheCapacity(mujoco.mj_getCache(), MESH_CACHE)


def robot_spec(robot: Robot) -> mujoco.MjSpec:
    """Return a new, editable MuJoCo spec of ``robot`` alone, in radians; the caller owns it.

    Elements that are added to it inherit nothing: the defaults and the compiler settings are MuJoCo's own. The text of
    a robot states the masses and inertias of its links, so that these settings no longer concern them.

    Raises:
        RobotError: MuJoCo cannot read the robot's text, or it uses a reserved name.

    Cost: about 5 ms, later 0.1 ms; compiling is what takes time.
    """
    return _parsed_robot(robot).copy()


@weak_cache
def _parsed_robot(robot: Robot) -> mujoco.MjSpec:
    spec = parse_spec(robot.mjcf, robot.assets, source=robot.source)
    settings = spec.compiler
    settings.degree = False
    settings.alignfree = False
    settings.boundmass = settings.boundinertia = 0.0
    settings.inertiagrouprange = [0, mujoco.mjNGROUP - 1]
    check_names(spec, source=robot.source)
    return spec


def drop_found_exclusions(spec: mujoco.MjSpec) -> frozenset[frozenset[str]]:
    """Delete the contact exclusions found when the robot was loaded; return their pairs of links."""
    found = [exclude for exclude in spec.excludes if exclude.name.startswith(TOUCHING)]
    pairs = frozenset(frozenset((exclude.bodyname1, exclude.bodyname2)) for exclude in found)
    for exclude in found:
        spec.delete(exclude)
    return pairs


def check_names(spec: mujoco.MjSpec, *, source: str) -> None:
    """Raise an error for a robot that uses reserved names.

    Raises:
        RobotError: It names the element.
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

    The text may be untrusted: MuJoCo receives the parsed and checked tree, not the text itself.

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
    with mujoco_errors("read", source=source), collect_warnings() as texts:
        spec = mujoco.MjSpec.from_string(tostring(root, encoding="unicode"), assets=dict(assets))
    if findings is not None:
        findings += limit_findings(spec, texts, urdf=root.tag == "robot")
        findings += warning_findings(texts, source=source)
    _reset_defaults(spec, {element.get("class", "") for element in root.iter("default")})
    return spec


_DEFAULT_KINDS = (
    "actuator",
    "camera",
    "equality",
    "flex",
    "geom",
    "joint",
    "light",
    "material",
    "mesh",
    "pair",
    "site",
    "tendon",
)
_NO_SETTINGS = ("classname", "compiler", "id", "info", "name", "plugin", "signature")
"""Properties of an element that are not settings; reading some of them from a default crashes MuJoCo 4.0.0."""


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
        elif not isinstance(value, str) and isinstance(value, Sized) and len(value) == len(getattr(element, name)) == 0:
            pass  # MuJoCo's vectors are empty in nearly all defaults, and to set one takes 0.5 ms
        else:
            setattr(element, name, value)


def compile_spec(spec: mujoco.MjSpec, *, source: str, findings: list[Finding] | None = None) -> mujoco.MjModel:
    """Compile ``spec``; convex hulls of the colliding meshes take most of the time.

    Args:
        spec: Specification to compile.
        source: Its name in errors.
        findings: Receives warnings about deprecated features of MuJoCo.

    Raises:
        RobotError: MuJoCo rejects the model, or warns that its numbers are invalid.
    """
    _check_axes(spec, source)
    _check_sizes(spec, source)
    with mujoco_errors("build", source=source), warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        model = spec.compile()
    for text in dict.fromkeys(str(warning.message) for warning in found):
        if "deprecated" not in text:  # for example of an inertia that is not invertible
            raise RobotError("MuJoCo cannot build the robot", file=source, value=_mujoco_message(text))
        if findings is not None:
            findings.append(Finding("deprecated", source, f"MuJoCo: {_mujoco_message(text)}"))
    return model


def _check_axes(spec: mujoco.MjSpec, source: str) -> None:
    turning = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
    for joint in spec.joints:
        if joint.type in turning and not np.linalg.norm(joint.axis) > _SHORTEST_AXIS:
            raise RobotError(
                "the axis of a joint has no direction",
                file=source,
                place=f"joint {joint.name}, axis",
                value=" ".join(f"{value:g}" for value in joint.axis),
                remedy="Write a unit vector, such as 0 0 1",
            )


_SIZES: Mapping[mujoco.mjtGeom, tuple[int, str]] = MappingProxyType(
    {
        mujoco.mjtGeom.mjGEOM_SPHERE: (1, "its radius"),
        mujoco.mjtGeom.mjGEOM_CAPSULE: (2, "its radius and half its length"),
        mujoco.mjtGeom.mjGEOM_CYLINDER: (2, "its radius and half its length"),
        mujoco.mjtGeom.mjGEOM_ELLIPSOID: (3, "its radii along x, y and z"),
        mujoco.mjtGeom.mjGEOM_BOX: (3, "half its lengths along x, y and z"),
    }
)
"""Number and meaning of the sizes of shapes."""


def _check_sizes(spec: mujoco.MjSpec, source: str) -> None:
    """Raise RobotError for a shape with missing, zero or negative sizes, whose body MuJoCo does not name."""
    for geom in spec.geoms:
        if geom.type not in _SIZES or geom.meshname or not np.isnan(geom.fromto[0]):
            continue  # such sizes follow from a mesh or from two points
        count, words = _SIZES[geom.type]
        sizes = geom.size[:count]
        if (sizes <= 0).any():
            shape = geom.type.name.removeprefix("mjGEOM_").lower()
            raise RobotError(
                f"a {shape} needs {count} positive {'size' if count == 1 else 'sizes'}",
                file=source,
                place=f"body {geom.parent.name or '(unnamed)'}, geom {geom.name or '(unnamed)'}, size",
                value=" ".join(f"{value:g}" for value in sizes),
                remedy=f"Write {words} [m]",
            )


def spec_text(spec: mujoco.MjSpec, *, source: str) -> str:
    """Return a compiled ``spec`` as MJCF text in radians.

    Raises:
        RobotError: MuJoCo cannot write it.
    """
    with mujoco_errors("write", source=source), warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*deprecated", UserWarning)  # reported when it was compiled
        return spec.to_xml()


@contextmanager
def mujoco_errors(verb: str, *, source: str) -> Iterator[None]:
    """Raise errors of MuJoCo inside the block as errors of the robot.

    Args:
        verb: What is done in the block: ``read``, ``build`` or ``write``. MuJoCo checks some properties, such as
            repeated names, only when a spec is changed.
        source: Path or name of the robot.

    Raises:
        RobotError: MuJoCo raised an error.
    """
    try:
        yield
    except (ValueError, mujoco.FatalError) as error:
        raise RobotError(f"MuJoCo cannot {verb} the robot", file=source, value=_mujoco_message(error)) from error


def _mujoco_message(error: Exception | str) -> str:
    """Return MuJoCo's message on one line, without its prefix."""
    return " ".join(str(error).split()).removeprefix("Error: ").removeprefix("XML Error: ")


def remove_geoms(spec: mujoco.MjSpec) -> None:
    """Delete the geometry of bodies whose inertia is stated, and the meshes that are then unused.

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


def joints_before(model: mujoco.MjModel, body: int) -> tuple[int, ...]:
    """Return the numbers of the joints that move a body, from the base on."""
    found: tuple[int, ...] = ()
    while body:
        first = int(model.body_jntadr[body])
        found = (*range(first, first + int(model.body_jntnum[body])), *found)
        body = int(model.body_parentid[body])
    return found


def rotation_of(quaternion: FloatArray) -> FloatArray:
    """Return the rotation matrix (3, 3) of a unit quaternion (w, x, y, z)."""
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix.reshape(3, 3)
