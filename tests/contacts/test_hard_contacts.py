"""Contacts in difficult places, by every contact model: force is kept, nothing jumps, one contact stays one contact."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from tactile_maps.control.motion.joint_impedance import joint_impedance
from tactile_maps.core.errors import SimulationError
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.object_meshes import primitive_mesh
from tactile_maps.scene.objects import ObjectSpec, SceneObject
from tactile_maps.session.frame import Frame
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.studies.loop_laws.gantry import gantry
from tactile_maps.tactile.mechanics.contact_notes import NOTED_SHARE, ContactNoteKind
from tactile_maps.tactile.poke import Finger, PokeMoved, PokePressed
from tests.hard_cases.touch import EXACT, MODELS, PLACES, Place, with_scene
from tests.hard_cases.touch_checks import (
    Run,
    centres,
    check_numbers,
    check_repeats,
    largest_jump,
    play,
    spring_force,
)

ONE_PIECE = (
    "on a seam",
    "at a border",
    "half over a border",
    "in a corner",
    "one taxel",
    "below the pitch",
    "one tiny taxel",
)
"""Places at which one finger touches one patch."""
TWO_PATCHES = ("between two patches", "over a gap")
_LATER = 0.2
_HOPS = 2.0
"""The model ``point`` hops from taxel to taxel, this many pitches at most."""


@cache
def place(name: str) -> Place:
    return PLACES[name]()


@cache
def stroked(name: str, model: str) -> Run:
    """Fingers press for 0.2 s, then go their ways."""
    here = place(name)
    finger = Finger(radius=here.radius, max_force=3.0, speed=0.05)
    ticks = round(_LATER / here.prepared.scene.tick)
    ways = [here.points(way) for way in range(len(here.ways))]
    acts = {1: [PokePressed(number, points[0], finger) for number, points in enumerate(ways)]}
    for step in range(1, max(map(len, ways))):
        acts[ticks + step] = [
            PokeMoved(number, points[step]) for number, points in enumerate(ways) if step < len(points)
        ]
    prepared = with_scene(here.prepared, overrides={"skin": model})
    return play(prepared, (max(acts) + 5) * prepared.scene.tick, acts)


@cache
def probed(name: str, model: str) -> Run:
    """Probes come, go along and rest."""
    return play(place(name).probed(model), Place.resting())


def read_share(frame: Frame) -> float:
    """Return the share of a contact's force that taxels read, by the notes; less than 1 % outside is not noted."""
    if any(note.kind is ContactNoteKind.OUTSIDE_SKIN for note in frame.notes):
        return 0.0
    return 1 - sum(note.share for note in frame.notes if note.kind is ContactNoteKind.PARTLY_OUTSIDE)


def is_read(felt: float, force: float, frame: Frame, *, rel: float) -> bool:
    """Return whether taxels read the force [N], but for what the notes state or what is too little to be noted."""
    unnoted = NOTED_SHARE * force if read_share(frame) == 1 else 0.0
    expected = read_share(frame) * force
    return expected - unnoted - rel * force - 1e-12 <= felt <= expected + rel * force + 1e-12


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("model", EXACT)
@pytest.mark.parametrize("name", PLACES)
def test_full_force_of_a_finger_is_measured_along_the_stroke(name, model):
    run = stroked(name, model)
    check_numbers(run)
    assert run.failure is None
    pressed = np.array([sum(poke.force for poke in frame.pokes) for frame in run.frames])
    assert pressed[-1] == pytest.approx(3.0 * len(place(name).ways)), "it pressed as hard as it may"
    for frame, felt, force in zip(run.frames, run.forces, pressed, strict=True):
        reported = [
            note for note in frame.notes if note.kind in (ContactNoteKind.SKIN_EDGE, ContactNoteKind.MOMENT_IGNORED)
        ]
        assert is_read(felt, force, frame, rel=1e-9) or reported


@pytest.mark.long
@pytest.mark.rotating
@pytest.mark.parametrize("model", EXACT)
@pytest.mark.parametrize("name", PLACES)
def test_position_of_a_stroke_never_jumps(name, model):
    run = stroked(name, model)
    here = place(name)
    step = max(largest_jump(way) for way in here.ways)
    allowed = _HOPS if model == "point" else here.jump
    assert largest_jump(centres(run)) <= allowed * here.pitch + step + 1e-12


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", ONE_PIECE)
def test_finger_gives_one_contact_along_the_whole_stroke(name):
    """Across a seam as well: its identity stays, and its place on the body moves as the finger does."""
    run = stroked(name, "water-fill")
    here = place(name)
    touched = [frame.regions for frame in run.frames if frame.regions]
    assert len(touched) > len(here.ways[0])
    assert all(len(regions) == 1 for regions in touched)
    assert {regions[0].id for regions in touched} == {1}
    assert largest_jump(np.array([regions[0].link_position for regions in touched])) <= max(here.jump, 0.1) * here.pitch


@pytest.mark.long
def test_stroke_crosses_the_seam():
    """The contact is torn on the map while it is on the seam, and only then."""
    torn = [frame.regions[0].torn for frame in stroked("on a seam", "water-fill").frames if frame.regions]
    assert any(torn)
    assert not torn[0]


@pytest.mark.long
@pytest.mark.parametrize("name", TWO_PATCHES)
def test_contact_on_two_patches_is_two_regions_with_one_force(name):
    run = stroked(name, "water-fill")
    count = np.array([len(frame.regions) for frame in run.frames])
    assert count.max() == 2
    shared = [frame for frame in run.frames if len(frame.regions) == 2]
    for frame in shared:
        assert len({run.prepared.skin.patch_of[region.taxels[0]] for region in frame.regions}) == 2
        assert sum(region.force for region in frame.regions) <= 3.0 * (1 + 1e-9)


@pytest.mark.long
def test_merged_contacts_keep_the_id_of_one():
    run = stroked("two that merge", "water-fill")
    count = [len(frame.regions) for frame in run.frames if frame.regions]
    assert count[0] == 2
    assert count[-1] == 1
    assert np.abs(np.diff(count)).sum() == 1, "they merge once"
    assert run.frames[-1].regions[0].id in {1, 2}
    assert run.frames[-1].regions[0].force == pytest.approx(6.0, rel=0.02)


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("name", PLACES)
def test_measured_force_of_a_probe_equals_its_spring_force(name, model):
    """The contact at rest carries the force of the motors, by Hooke's law, on every kind of skin."""
    run = probed(name, model)
    check_numbers(run)
    assert run.failure is None
    pushed = spring_force(run.prepared, run.frames[-1])
    assert pushed > 0.05, "it presses"
    if model == "foundation":  # what acts across the skin; at a border the ball is pushed aside as well
        across = spring_force(run.prepared, run.frames[-1], along=(1.0, 0.0, 0.0) if name == "on a seam" else (0, 0, 1))
        nearby = name == "on a seam" or read_share(run.frames[-1]) < 1
        assert is_read(run.forces[-1], across, run.frames[-1], rel=0.02 if nearby else 1e-3)
    elif model != "depth":  # which promises no force
        assert is_read(run.forces[-1], pushed, run.frames[-1], rel=1e-3)


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("model", EXACT)
@pytest.mark.parametrize("name", PLACES)
def test_contact_is_never_lost_along_the_stroke(name, model):
    run = probed(name, model)
    here = place(name)
    if model == "point" and any(read_share(frame) == 0 for frame in run.frames[run.at(0.2) :]):
        assert name in ("half over a border", "over a gap"), "all of the force is on the nearest point, skin or bare"
        return
    held = run.forces[run.at(0.2) :]
    assert held.min() > 0.5 * held.max()
    along = centres(run)[run.at(0.2) - len(run.frames) :]
    step = max(largest_jump(way) for way in here.ways)
    assert largest_jump(along) <= (_HOPS if model == "point" else here.jump) * here.pitch + step


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", PLACES)
def test_pressure_is_located_under_the_probe(name):
    """No taxel farther away than the ball and a cell reads anything."""
    run = probed(name, "water-fill")
    here = place(name)
    away = np.linalg.norm(run.prepared.skin.positions[:, None] - run.frames[-1].objects[:, :3, 3], axis=2)
    felt = run.frames[-1].pressures > 0
    assert felt.any()
    assert (away.min(axis=1)[felt] < 2 * here.radius + 2.5 * here.pitch).all()


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", ["on a seam", "two that merge"])
def test_repeated_run_gives_the_same_numbers(name):
    check_repeats(play(place(name).probed("punch"), 0.2), play(place(name).probed("punch"), 0.2))


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("moves", "speed", "step"),
    [
        ("ball", 5.0, 1e-3),
        ("ball", 20.0, 1e-3),
        ("ball", 60.0, 1e-3),
        ("ball", 20.0, 5e-4),
        ("skin", 20.0, 1e-3),
        ("skin", 60.0, 1e-3),
        ("skin", 20.0, 5e-4),
    ],
)
def test_body_that_passes_through_the_foundation_stops_the_run(speed, step, moves):
    """A ball of 6 mm that motors drive through a plate of skin faster than the layer can stop it, or the plate past it.

    Half of these fly over the layer between two steps: nothing would be felt.
    """
    made = gantry()
    still = ((0.0, 0.0, 0.0, 0.05), (60.0, 0.0, 0.0, 0.05))
    path = ((0.0, 0.0, 0.0, 0.05), (0.15 / speed, 0.0, 0.0, -0.1), (60.0, 0.0, 0.0, -0.1))
    spec = ObjectSpec(
        "ball", "probe", (0.006,), mass=0.01, friction=0.0, max_force=1e4, path=path if moves == "ball" else still
    )
    effects = Effects(gravity="off", contact="probe", fingers=False, timestep=step, skin="foundation")
    objects = (SceneObject(spec, primitive_mesh(spec)),)
    simulation = Simulation(made.robot, made.skin, effects, objects=objects)
    hold = joint_impedance(np.full(3, 4.0), np.zeros(3), frequency=40.0, damping_ratio=1.0)
    if moves == "skin":
        simulation._data.qvel[2] = speed
    with pytest.raises(SimulationError, match="pressed through"):
        simulation.step(round(0.2 / step), hold)
