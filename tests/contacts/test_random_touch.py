"""Random hands and random effects: force is conserved, frames mean something and can be repeated bit for bit."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.object_meshes import make_objects
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.session.frame import Frame
from tactile_maps.session.inputs import ControlChanged, EffectsChanged
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.session import Session
from tactile_maps.skin.model.skin import Patch, Quadrature, Skin, Taxels
from tactile_maps.tactile.mechanics.contact_notes import ContactNoteKind
from tactile_maps.tactile.mechanics.loads import Box, Cylinder, Load, MeshShape, Plane, Sphere
from tactile_maps.tactile.mechanics.winkler import winkler_level
from tactile_maps.tactile.models.point import PointModel
from tactile_maps.tactile.models.water_fill import WaterFillModel
from tactile_maps.tactile.poke import Finger, PokeMoved, PokePressed, PokeReleased
from tactile_maps.tactile.sensors.sensor_effects import (
    Crosstalk,
    DeadTaxels,
    GainSpread,
    Hysteresis,
    Noise,
    OffsetDrift,
    Sampling,
    SensorEffects,
)
from tests.support.examples import examples
from tests.support.touch import arm, prepared_bar

SKIN = arm().skin
forces = st.one_of(st.just(0.0), st.just(5e-324), st.floats(1e-300, 1e-6), st.floats(1e-6, 1e3), st.floats(1e3, 1e290))
sizes = st.floats(1e-3, 0.1)


def _solids() -> list[Mesh]:
    """A ring, a box, and a link of the arm that its other links may touch."""
    solids = [
        trimesh.creation.torus(0.03, 0.01, major_sections=16, minor_sections=8),
        trimesh.creation.box((0.05, 0.02, 0.03)),
    ]
    link = next(link for link in arm().robot.links if link.name == SKIN.patches[0].link)
    return [*(Mesh(solid.vertices, solid.faces) for solid in solids), link.mesh]


@pytest.fixture(scope="module")
def models():
    """Both models, each used for all examples: what they remember must not matter."""
    return WaterFillModel(SKIN), PointModel(SKIN)


shapes = st.one_of(
    st.builds(Sphere, st.floats(1e-4, 0.1)),
    st.builds(lambda x, y, z: Box((x, y, z)), sizes, sizes, sizes),
    st.builds(Cylinder, sizes, sizes),
    st.just(Plane()),
    st.builds(MeshShape, st.sampled_from(_solids())),
)


@st.composite
def loads(draw, forces=forces):
    """A body of any kind, turned any way, that touches the skin somewhere."""
    at = SKIN.taxel_point(draw(st.integers(0, len(SKIN) - 1)))
    point = SKIN.position(at)
    normal = SKIN.normal(at)
    shape = draw(shapes)
    turn = Rotation.random(random_state=draw(st.integers(0, 1000)))
    if isinstance(shape, Plane):
        turn = Rotation.align_vectors([-normal], [[0, 0, 1]])[0]
    elif not isinstance(shape, MeshShape):  # from its middle against the normal to its surface
        inward = turn.inv().apply(-normal)
        point = point - turn.apply(_surface_along(shape, inward))
    else:
        vertices = shape.mesh.vertices @ turn.as_matrix().T
        point = point - vertices[(vertices @ normal).argmin()]
    return Load(SKIN.link(at), SKIN.position(at), normal, draw(forces), shape, Pose(turn.as_matrix(), point))


def _surface_along(shape, direction):
    """The point at which a ray from the middle of a body leaves it."""
    low = 0.0
    high = 2 * shape.reach
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if shape.distance(middle * direction[None])[0] < 0 else (low, middle)
    return low * direction


@pytest.mark.long
@given(load=loads(), which=st.integers(0, 1))
@examples(300)
def test_sum_of_pressure_times_area_is_the_force(models, load, which):
    model = models[which]
    pressures = model.pressures([load])
    assert model.notes == ()
    assert np.isfinite(pressures).all()
    assert (pressures >= 0).all()
    if load.force > 1e-290:  # below, rounding is no longer relative
        assert abs(pressures @ SKIN.areas / load.force - 1) < 1e-12


@pytest.mark.long
@given(several=st.lists(loads(st.floats(1e-3, 1e3)), min_size=1, max_size=5), which=st.integers(0, 1))
@examples(60)
def test_several_loads_add_up(models, several, which):
    model = models[which]
    together = model.pressures(several)
    apart = sum(model.pressures([load]) for load in several)
    np.testing.assert_allclose(together, apart, rtol=1e-12)
    assert abs(together @ SKIN.areas / sum(load.force for load in several) - 1) < 1e-12


@pytest.mark.long
@given(load=loads(st.floats(1e-3, 1e3)), seed=st.integers(0, 50), away=st.floats(0, 2.0))
@examples(60)
def test_moving_a_link_with_its_loads_does_not_change_readings(load, seed, away):
    motion = Pose(Rotation.random(random_state=seed).as_matrix(), np.array([away, -0.3, 0.1]))
    patches = tuple(_moved(patch, motion) for patch in SKIN.patches if patch.link == load.link)
    moved = Load(
        load.link, motion.points(load.point), motion.directions(load.normal), load.force, load.shape, motion @ load.pose
    )
    still = Skin(tuple(patch for patch in SKIN.patches if patch.link == load.link))
    expected = WaterFillModel(still).pressures([load])
    assert expected.max() > 0
    # Rounding in metres, times the stiffness of the bed and what a level is off by that wets one point more.
    np.testing.assert_allclose(WaterFillModel(Skin(patches)).pressures([moved]), expected, rtol=1e-7, atol=1e-4)


def _moved(patch: Patch, motion: Pose) -> Patch:
    taxels = patch.taxels
    points = patch.taxels.quadrature
    quadrature = Quadrature(
        motion.points(points.positions), motion.directions(points.normals), points.areas, points.taxel
    )
    surface = Mesh(motion.points(patch.surface.vertices), patch.surface.faces)
    moved = Taxels(
        motion.points(taxels.positions),
        motion.directions(taxels.normals),
        taxels.faces,
        taxels.weights,
        taxels.areas,
        taxels.neighbours,
        quadrature,
    )
    return Patch(patch.name, patch.link, surface, moved)


@given(
    floors=st.lists(st.tuples(st.floats(0, 0.1), st.floats(1e-9, 1e-3)), min_size=1, max_size=60),
    volume=st.floats(1e-12, 1.0),
)
@examples(300)
def test_water_level_matches_bisection(floors, volume):
    gaps, areas = np.array(floors).T
    low = gaps.min()
    high = gaps.max() + volume / areas.min() + 1.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if areas @ np.maximum(middle - gaps, 0) < volume else (low, middle)
    level = winkler_level(gaps, areas, volume).level
    assert abs(level - high) <= 1e-9 * max(abs(high), 1.0)
    assert abs(areas @ np.maximum(level - gaps, 0) - volume) <= 1e-9 * max(volume, areas.sum())


fingers = st.builds(Finger, stiffness=st.floats(1, 2e3), max_force=st.floats(0, 50), speed=st.floats(0, 0.2))
places = st.integers(0, 299).map(lambda taxel: arm().skin.taxel_point(taxel))
ids = st.integers(0, 2)
changes = st.builds(
    ControlSettings,
    controller=st.sampled_from(["impedance", "hold_force"]),
    stiffness=st.floats(0.5, 40),
    damping_ratio=st.floats(0.1, 3),
    force_goal=st.floats(0, 20),
    force_gain=st.floats(0, 0.05),
    integral_time=st.one_of(st.floats(0.05, 10), st.just(float("inf"))),
)
acts = st.one_of(
    st.builds(PokePressed, ids, places, fingers),
    st.builds(PokeMoved, ids, places),
    st.builds(PokeReleased, ids),
    st.builds(ControlChanged, changes),
    st.none(),
)


def play(script) -> list:
    session = Session(replace(arm()), scripted=False)
    frames = []
    for act in script:
        if act is not None:
            session.submit(act)
        frames += [session.tick() for _ in range(4)]
    return frames


@pytest.mark.long
@given(script=st.lists(acts, min_size=1, max_size=25))
@examples(25)
def test_random_touches_give_valid_reproducible_frames(script):
    frames = play(script)
    areas = arm().skin.areas
    for frame in frames:
        for values in (frame.posture, frame.velocity, frame.pressures, frame.command.posture):
            assert np.isfinite(values).all()
        force = sum(poke.force for poke in frame.pokes)
        # Bare parts bear the rest of what is pressed at a border; a note says so above 1 %.
        least = 0.0 if any(note.kind is ContactNoteKind.PARTLY_OUTSIDE for note in frame.notes) else 0.99 * force
        assert least - 1e-12 <= frame.pressures @ areas <= (1 + 1e-9) * force + 1e-12
        assert all(0 <= poke.force <= 50 for poke in frame.pokes)
        assert len({region.id for region in frame.regions}) == len(frame.regions)
    for one, other in zip(frames, play(script), strict=True):
        assert np.array_equal(one.posture, other.posture)
        assert np.array_equal(one.pressures, other.pressures)


TICKS = 4


BALL = ObjectSpec("ball", "sphere", size=(0.03,), at=(0.3, 0.0, 0.051), mass=0.2)


@cache
def bar() -> PreparedScene:
    """A ball 1 mm above the bar, which it falls on where there are gravity and contact."""
    prepared = prepared_bar(objects=(BALL,), overrides={"fingers": "on"})
    return replace(prepared, objects=make_objects(prepared.scene))


sensors = st.builds(
    SensorEffects,
    noise=st.sampled_from([None, Noise(), Noise(sd=5.0)]),
    crosstalk=st.sampled_from([None, Crosstalk()]),
    hysteresis=st.sampled_from([None, Hysteresis()]),
    gain_spread=st.sampled_from([None, GainSpread()]),
    offset_drift=st.sampled_from([None, OffsetDrift()]),
    sampling=st.sampled_from([None, Sampling()]),
    dead_taxels=st.sampled_from([None, DeadTaxels(dead=0.3)]),
)
effects = st.builds(
    Effects,
    gravity=st.sampled_from(["off", "on", "compensated"]),
    contact=st.sampled_from(["off", "self", "all"]),
    joint_limits=st.booleans(),
    timestep=st.sampled_from([0.0005, 0.001]),
    dynamics=st.booleans(),
    fingers=st.booleans(),
    friction=st.booleans(),
    joint_friction=st.booleans(),
    skin=st.sampled_from(["off", "point", "water-fill", "punch", "foundation", "depth"]),
    integrator=st.sampled_from(["implicitfast", "discrete", "implicit"]),
    sensor=sensors,
)
switches = st.lists(effects, min_size=1, max_size=6)


def play_toggles(script: list[Effects], *, press: int) -> tuple[Session, list[Frame]]:
    """Four ticks under each of the effects, a finger down from ``press`` on wherever fingers can be."""
    session = Session(bar(), scripted=False, settings=ControlSettings(stiffness=20.0))
    frames = [session.tick() for _ in range(TICKS)]
    for number, chosen in enumerate(script):
        session.submit(EffectsChanged(chosen))
        if chosen.fingers and number >= press:
            session.submit(PokePressed(1, bar().skin.taxel_point(30)))
        frames += [session.tick() for _ in range(TICKS)]
        assert session.effects == chosen
    return session, frames


def repeat(played: Session) -> list[Frame]:
    """A fresh session given what the other one did at its ticks."""
    session = Session(bar(), scripted=False)
    frames = []
    waiting = list(played.inputs)
    while session.frame.tick < played.frame.tick:
        while waiting and waiting[0][0] <= session.frame.tick + 1:
            session.submit(waiting.pop(0)[1])
        frames.append(session.tick())
    assert not waiting
    return frames


@pytest.mark.long
@given(script=switches, press=st.integers(0, 3))
@examples(20)
def test_any_effect_switches_give_valid_frames_that_repeat_bit_for_bit(script, press):
    session, frames = play_toggles(script, press=press)
    assert sum(isinstance(act, EffectsChanged) for _, act in session.inputs) == len(script)
    for frame, other in zip(frames, repeat(session), strict=True):
        for name in ("posture", "velocity", "pressures", "objects"):
            assert np.isfinite(getattr(frame, name)).all()
            assert getattr(frame, name).tobytes() == getattr(other, name).tobytes()


@pytest.mark.long
@given(script=switches, press=st.integers(0, 3))
@examples(12)
def test_switching_effects_does_not_move_the_robot(script, press):
    """The robot continues from its posture at the switch, within the motion of one tick."""
    session, _ = play_toggles(script[:-1] or script, press=press)
    session.submit(PokeReleased(1))
    before = session.tick()
    session.submit(EffectsChanged(script[-1]))
    after = session.tick()
    most = (np.abs(before.velocity).max() + 1.0) * bar().scene.tick
    assert not script[-1].dynamics or np.abs(after.posture - before.posture).max() <= most
