"""Takes a contact from one place of the skin to another that is far from it: lift, carry, press.

What is touched stays where it is in the world; the arm lets go of it, moves so that the other place comes over it, and
presses until it feels it there. Where that cannot be done it goes back to what it held, and says why.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypeAlias

import numpy as np

from app.arrays import FloatArray
from app.contacts.region import ContactRegion
from app.control.carry_plan import CarryPlan
from app.geometry.surface_point import SurfacePoint
from app.robots.configuration import Configuration
from app.skin.skin import Skin

State: TypeAlias = Literal["look", "lift", "carry", "press", "return", "arrived", "failed"]

JOINT_SPEED = 0.6
"""Of any joint on the way [rad/s]."""
SPEED, SLOW = 0.2, 0.02
"""Of either place, at most [m/s]; slow on the leg at whose end it will touch."""
LONGEST = 20.0
"""On the way there, or back [s]."""
BUMP = 1.0
"""Force of a contact on the way that turns the arm back [N]."""
PITCHES = 3.0
"""So near to the place that is wanted a contact on the same patch counts as the one."""
_ROUNDS = 5
"""Of the search for a way, each tick."""
_GENTLE = 0.1
"""Time constant of changes of speed [s]."""
_NEAR, _RATE = 0.01, 6.0


class Transfer:
    """One contact on its way. Mutable.

    Args:
        plan: Finds the way.
        skin: Of the arm.
        leaves: The place that touches now.
        enters: The place that is to touch.
        pitch: Of the taxels [m].
        known: Ids of the contacts there are at the start: they are in nobody's way.

    Attributes:
        state: ``look`` for a way, the contact still held; ``lift``, ``carry``, ``press``; ``return`` to the old place;
            ``arrived`` or ``failed`` at the end.
        reason: Why it turned back or failed; empty until then.
    """

    def __init__(
        self,
        plan: CarryPlan,
        skin: Skin,
        leaves: SurfacePoint,
        enters: SurfacePoint,
        pitch: float,
        known: frozenset[int],
    ) -> None:
        self._plan, self._skin, self._pitch, self._known = plan, skin, pitch, known
        self.leaves, self.enters = leaves, enters
        self.state: State = "look"
        self.reason = ""
        self._time = 0.0
        self._way: list[FloatArray] = []
        self._speed: FloatArray | None = None

    @property
    def moves(self) -> bool:
        """Whether the arm is on the way, without a task for any contact."""
        return self.state in ("lift", "carry", "press", "return")

    @property
    def says(self) -> str:
        """What it does, in words."""
        where = _where(self._skin, self.leaves, self.enters)
        if self.state == "return":
            return f"{self.reason}: going back"
        return f"looking for a way to {where}" if self.state == "look" else f"carrying the contact to {where}"

    def watch(self, regions: Sequence[ContactRegion], dt: float) -> ContactRegion | None:
        """Go on by what is felt; the contact in hand as soon as it has arrived, there or back.

        Args:
            regions: All contacts.
            dt: Since the last tick [s].
        """
        self._time += dt
        if self.state == "look":
            self._look()
        elif self.moves:
            return self._feel(regions)
        return None

    def speed(self, start: FloatArray, configuration: Configuration, dt: float) -> FloatArray:
        """(n,) joint velocity along the way, from the wanted posture ``start`` (n,); bounded, and without jumps."""
        while self._way and np.abs(self._way[0] - start).max(initial=0.0) < _NEAR:
            self._leg_done()
        wanted = self._towards(start, configuration) if self._way else np.zeros_like(start)
        before = np.zeros_like(start) if self._speed is None else self._speed
        self._speed = before + min(dt / _GENTLE, 1.0) * (wanted - before)
        return self._speed

    def _look(self) -> None:
        self._plan.look(_ROUNDS)
        if not self._plan.done:
            return
        if self._plan.route is None:
            where = _where(self._skin, self.leaves, self.enters)
            self.state, self.reason = "failed", f"{where} cannot come to what it touches"
            return
        self.state, self._time, self._way = "lift", 0.0, [self._plan.route.lifted]

    def _leg_done(self) -> None:
        """The next leg; at the end of the last one nothing was felt where it should be."""
        self._way.pop(0)
        route = self._plan.route
        if self._way or route is None:
            return
        if self.state == "lift":
            self.state, self._way = "carry", [route.over, route.above]
        elif self.state == "carry":
            self.state, self._way = "press", [route.pressed]
        elif self.state == "press":
            self._turn_back("nothing is there to touch")
        else:
            self.state = "failed"

    def _feel(self, regions: Sequence[ContactRegion]) -> ContactRegion | None:
        if self.state == "return":
            found = self._arrive(regions, self.leaves, "failed") if len(self._way) <= 1 else None
            self.state = "failed" if self._time > LONGEST else self.state
            return found
        if self._time > LONGEST:
            self._turn_back("it takes too long")
        elif self.state != "lift":
            arrived = self._arrive(regions, self.enters, "arrived")
            if arrived is not None:
                return arrived
            if any(region.force > BUMP and region.id not in self._known for region in regions):
                self._turn_back("something is in the way")
            elif self._at(regions, self.leaves) is not None:
                self._turn_back("what touches comes along")
        return None

    def _arrive(self, regions: Sequence[ContactRegion], at: SurfacePoint, state: State) -> ContactRegion | None:
        """The contact about a place, if there is one: then it is over."""
        region = self._at(regions, at)
        self.state = self.state if region is None else state
        return region

    def _at(self, regions: Sequence[ContactRegion], at: SurfacePoint) -> ContactRegion | None:
        place, near = self._skin.position(at), PITCHES * self._pitch
        return next((r for r in regions if r.at.patch == at.patch and np.linalg.norm(r.point - place) < near), None)

    def _turn_back(self, reason: str) -> None:
        route = self._plan.route
        assert route is not None
        lifted = [] if self.state == "lift" else [route.lifted]
        came_over = self.state == "press" or (self.state == "carry" and len(self._way) == 1)
        self.state, self.reason, self._time = "return", reason, 0.0
        self._way = [*([route.over] if came_over else []), *lifted, route.start]

    def _towards(self, start: FloatArray, configuration: Configuration) -> FloatArray:
        """Straight to the next posture, as fast as joints and places may move, slower near its end."""
        off = self._way[0] - start
        fastest = float(np.abs(off).max())
        moved = max(
            float(np.linalg.norm(configuration.jacobian(self._skin.link(at), self._skin.position(at)) @ off))
            for at in (self.leaves, self.enters)
        )
        touches = self.state == "press" or (self.state == "return" and len(self._way) == 1)
        pace = min(JOINT_SPEED / fastest, (SLOW if touches else SPEED) / max(moved, 1e-9), _RATE)
        return pace * off


def _where(skin: Skin, leaves: SurfacePoint, enters: SurfacePoint) -> str:
    link = skin.link(enters).replace("_", " ")
    return f"the {link}" if skin.link(leaves) != skin.link(enters) else f"another place of the {link}"
