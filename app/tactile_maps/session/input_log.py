"""Compact log of the inputs of a session, small enough to be kept for days.

A stroking finger moves at every frame, a scripted one at every tick. As objects, moves would take 0.5 kB each, a
gigabyte in an afternoon. They are stored in arrays, 56 bytes each, and recreated bit for bit when they are read.
"""

from __future__ import annotations

from array import array
from bisect import bisect_left
from collections.abc import Iterable, Sequence
from typing import overload

from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.session.inputs import SessionInput
from tactile_maps.tactile.poke import PokeMoved

TimedInput = tuple[int, SessionInput]
"""Tick at which an input took effect, and the input."""
_LARGEST = 2**63


class InputLog(Sequence[TimedInput]):
    """Append-only list of inputs. One thread may append while others read.

    Args:
        inputs: The first inputs.
    """

    def __init__(self, inputs: Iterable[TimedInput] = ()) -> None:
        self._ticks = array("q")
        # three integers each (finger, patch, face), and three weights
        self._moves = array("q")
        self._weights = array("d")
        self._others: list[SessionInput] = []
        self._places: list[int] = []  # indices of the others, ascending
        for tick, session_input in inputs:
            self.append(tick, session_input)

    def append(self, tick: int, session_input: SessionInput) -> None:
        """Append an input that is not earlier than the last one. Cost: 1 µs."""
        if isinstance(session_input, PokeMoved) and -_LARGEST <= session_input.id < _LARGEST:
            at = session_input.at
            self._weights.extend(at.weights)
            self._moves.extend((session_input.id, at.patch, at.face))
        else:
            self._others.append(session_input)
            self._places.append(len(self._ticks))
        self._ticks.append(tick)  # last, because it makes the input visible to readers

    def __len__(self) -> int:
        return len(self._ticks)

    @overload
    def __getitem__(self, index: int) -> TimedInput: ...
    @overload
    def __getitem__(self, index: slice) -> list[TimedInput]: ...
    def __getitem__(self, index: int | slice) -> TimedInput | list[TimedInput]:
        """Return one input or a list of several. Cost: 2 µs each."""
        if isinstance(index, slice):
            return [self._at(place) for place in range(*index.indices(len(self)))]
        place = index + len(self) if index < 0 else index
        if not 0 <= place < len(self):
            raise IndexError(f"index {index} is out of range for a log of {len(self)} inputs")
        return self._at(place)

    def __eq__(self, other: object) -> bool:
        return list(self) == list(other) if isinstance(other, Sequence) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"InputLog({list(self)!r})"

    def _at(self, place: int) -> TimedInput:
        number = bisect_left(self._places, place)
        if number < len(self._places) and self._places[number] == place:
            return self._ticks[place], self._others[number]
        move = 3 * (place - number)
        finger, patch, face = self._moves[move : move + 3]
        first, second, third = self._weights[move : move + 3]
        return self._ticks[place], PokeMoved(finger, SurfacePoint(patch, face, (first, second, third)))
