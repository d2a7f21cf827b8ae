"""The tank counts what contacts are given, and slows what would give more than it holds."""

from __future__ import annotations

from itertools import pairwise

import pytest

from app.control.energy_tank import FULL, LOW, RECOVERED, EnergyTank


def test_what_is_given_leaves_the_tank_and_what_is_taken_fills_it():
    tank = EnergyTank()
    tank.flow(2.0, 0.0, 0.1)
    assert tank.level == pytest.approx(FULL - 0.2)
    tank.flow(-1.0, 0.0, 0.1)
    assert tank.level == pytest.approx(FULL - 0.1)
    tank.flow(-100.0, 0.0, 1.0)
    assert tank.level == FULL, "it holds no more"
    assert tank.given == pytest.approx(0.1 - 100.0)
    tank.reset()
    assert (tank.level, tank.given) == (FULL, 0.0)


def test_damping_gives_back_a_part():
    tank = EnergyTank()
    tank.flow(5.0, 0.0, 0.1)
    tank.flow(0.0, 1.0, 0.1)
    assert tank.level == pytest.approx(FULL - 0.5 + 0.1 * RECOVERED)


def test_the_share_falls_smoothly_and_never_lets_the_last_go():
    tank, shares = EnergyTank(), []
    while tank.level > 0:
        tank.flow(1.0, 0.0, 0.01)
        shares.append(tank.share)
    assert shares[0] == 1.0
    assert shares[-1] == 0.0
    assert all(0 <= before - after < 0.16 for before, after in pairwise(shares))
    again = EnergyTank()
    for _ in range(100_000):
        again.flow(10.0 * again.share, 0.0, 0.001)
    assert again.level >= LOW - 1e-2
    assert again.given <= FULL
