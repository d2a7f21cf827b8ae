"""Fingers: springs whose forces are known by hand on a bar."""

from __future__ import annotations

import pytest

from tactile_maps.core.errors import SimulationError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.tactile.poke import Finger, PokeMoved, PokePressed, PokeReleased
from tests.support.touch import BAR_INERTIA, bar, bar_skin, hold, no_command, taxel_near

SKIN = bar_skin()
AT = SKIN.taxel_point(taxel_near(SKIN, 0, (0.3, 0, 0.02)))
LEVER = float(SKIN.position(AT)[0])


def fixed() -> Simulation:
    return Simulation(bar(hinged=False), SKIN, Effects())


def test_force_on_a_rigid_robot_is_stiffness_times_depth():
    simulation = fixed()
    finger = Finger(stiffness=800.0, speed=0.01, max_force=5.0)
    simulation.apply(PokePressed(1, AT, finger))
    for steps in range(1, 900):
        simulation.step(1, no_command(bar(hinged=False)))
        depth = 0.01 * 0.001 * (steps - 1)  # the tip advances after it has pushed
        assert simulation.pokes[0].force == pytest.approx(min(800 * depth, 5.0), abs=1e-2 * 0.8)
    assert simulation.pokes[0].force == 5.0


def test_force_on_a_compliant_arm_is_that_of_springs_in_series():
    robot = bar()
    finger = Finger(stiffness=1000.0, speed=0.005, max_force=50.0)
    simulation = Simulation(robot, SKIN, Effects())
    rigid = fixed()
    for run, body in ((simulation, robot), (rigid, bar(hinged=False))):
        run.apply(PokePressed(1, AT, finger))
        run.step(2000, hold(body, 40.0, 6.0))
    series = 1 / (1 / 1000.0 + LEVER**2 / 40.0)
    before = simulation.pokes[0].force
    simulation.step(400, hold(robot, 40.0, 6.0))
    slope = (simulation.pokes[0].force - before) / 0.4
    assert slope == pytest.approx(0.005 * series, rel=0.01)
    assert simulation.pokes[0].force < 0.5 * rigid.pokes[0].force


def test_moving_keeps_the_force_and_releasing_ends_it():
    simulation = fixed()
    simulation.apply(PokePressed(1, AT, Finger(speed=0.01)))
    simulation.step(300, no_command(bar(hinged=False)))
    force = simulation.pokes[0].force
    there = SKIN.taxel_point(taxel_near(SKIN, 0, (0.1, 0, 0.02)))
    simulation.apply(PokeMoved(1, there))
    assert simulation.pokes[0].force == force
    simulation.step(1, no_command(bar(hinged=False)))
    assert simulation.pokes[0].force == pytest.approx(force + 0.01, abs=1e-9)
    assert simulation.pokes[0].at == there
    simulation.apply(PokeReleased(1))
    assert simulation.pokes == ()
    assert not simulation.sense().any()


def test_finger_whose_force_is_edited_presses_on_from_its_depth():
    simulation = fixed()
    simulation.apply(PokePressed(1, AT, Finger(speed=0.01, max_force=2.0)))
    simulation.step(300, no_command(bar(hinged=False)))
    assert simulation.pokes[0].force == 2.0
    simulation.apply(PokePressed(1, AT, Finger(speed=0.01, max_force=4.0)))
    assert simulation.pokes[0].force == 2.0
    simulation.step(2, no_command(bar(hinged=False)))
    assert simulation.pokes[0].force == pytest.approx(2.01, abs=0.01)
    simulation.apply(PokePressed(1, AT, Finger(speed=0.01, max_force=1.0)))
    assert simulation.pokes[0].force == 1.0


def test_unknown_fingers_are_ignored_and_a_second_press_starts_again():
    simulation = fixed()
    simulation.apply(PokeReleased(7))
    simulation.apply(PokeMoved(7, AT))
    assert simulation.pokes == ()
    simulation.apply(PokePressed(1, AT))
    simulation.step(100, no_command(bar(hinged=False)))
    assert simulation.pokes[0].force > 0
    simulation.apply(PokePressed(1, AT))
    assert len(simulation.pokes) == 1
    assert simulation.pokes[0].force == 0


@pytest.mark.parametrize(
    "at",
    [
        SurfacePoint(9, 0, (1.0, 0.0, 0.0)),
        SurfacePoint(0, 10**9, (1.0, 0.0, 0.0)),
        SurfacePoint(-1, 0, (1.0, 0.0, 0.0)),
        SurfacePoint(0, 0, (float("nan"), 0.0, 1.0)),
        SurfacePoint(0, 0, (2.0, -1.0, 0.0)),
    ],
)
def test_place_outside_the_skin_is_rejected(at):
    simulation = fixed()
    simulation.apply(PokePressed(1, AT))
    for poke in (PokePressed(2, at), PokeMoved(1, at)):
        with pytest.raises(SimulationError, match="not on the skin"):
            simulation.apply(poke)
    assert [poke.at for poke in simulation.pokes] == [AT], "fingers are unchanged"


def test_stiffness_limit_follows_from_the_effective_mass_at_the_point():
    limit = BAR_INERTIA / LEVER**2 * (0.6 / 0.001) ** 2
    simulation = Simulation(bar(), SKIN, Effects())
    simulation.apply(PokePressed(1, AT, Finger(stiffness=0.999 * limit)))
    with pytest.raises(SimulationError, match="too stiff") as caught:
        simulation.apply(PokePressed(2, AT, Finger(stiffness=1.001 * limit)))
    assert f"{limit:.3g} N/m" in caught.value.remedy
    nearer_the_hinge = SKIN.taxel_point(taxel_near(SKIN, 0, (0.02, 0, 0.02)))
    simulation.apply(PokePressed(2, nearer_the_hinge, Finger(stiffness=1.001 * limit)))
    with pytest.raises(SimulationError, match="too stiff"):
        simulation.apply(PokeMoved(2, AT))


def test_moving_a_finger_to_its_current_place_has_no_effect_on_a_yielding_arm():
    """The skin yields between the last step and the move; that counts."""
    still = Simulation(bar(), SKIN, Effects())
    moved = Simulation(bar(), SKIN, Effects())
    for simulation in (still, moved):
        simulation.apply(PokePressed(1, AT, Finger(max_force=3.0)))
    for _ in range(100):
        moved.apply(PokeMoved(1, AT))
        for simulation in (still, moved):
            simulation.step(2, hold(bar(), 5.0, 0.5))
    assert abs(still.posture[0]) > 0.005
    assert moved.posture == pytest.approx(still.posture, abs=1e-9)
