"""Notes on deviations of the physics or a contact model, as values; ``contact_note_text`` formats them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import assert_never

from tactile_maps.core.codec import LATER


class ContactNoteKind(Enum):
    """Kinds of deviations. In brackets: the names in ``ContactNote.bodies``."""

    CONVEX_HULL = "convex-hull"
    """A mesh collides as its convex hull, which is not its surface (the object)."""
    UNSTABLE = "unstable"
    """A contact is too stiff for the time step (both bodies)."""
    SOFTER = "softer"
    """A contact is softer than the cover, because the object is too light for the time step (both bodies)."""
    OUTSIDE_SKIN = "outside-skin"
    """A load outside its link's skin is not sensed (what presses, the link)."""
    PARTLY_OUTSIDE = "partly-outside"
    """More than 1 % of a load is on bare surface next to the skin and is not sensed (what presses, the link)."""
    BELOW_THRESHOLD = "below-threshold"
    """A lasting load, or a large part of it, is below the threshold of the taxels (what presses, the link)."""
    SKIN_EDGE = "skin-edge"
    """A single point at the skin's edge bears a whole load (what presses, the link)."""
    BENT_SKIN = "bent-skin"
    """The readings sum to more or less than the force, by geometry: the skin bends (what presses, the link)."""
    MOMENT_IGNORED = "moment-ignored"
    """Only the force of a load is kept, because it acts outside the points under it (what presses, the link)."""
    UNSTABLE_SERVO = "unstable-servo"
    """A joint's servo is too stiff for integrator and time step (the joint)."""
    DEEP = "deep"
    """A body has been deeper in another than any cover is thick since the last reading (both bodies)."""
    HARD = "hard"
    """A contact force is larger than any skin bears, since the last reading (both bodies)."""
    FAST = "fast"
    """A body has been faster than any robot moves things, since the last reading (the body)."""
    BRIEF = "brief"
    """A contact came and went between two readings (both bodies)."""
    FRICTION_EXCEEDED = "friction-exceeded"
    """The friction of a load is larger than the skin under it can transfer (what presses, the link)."""
    BLIND_AREA = "blind-area"
    """Broken taxels with too few working neighbours to be estimated (the taxels, the link)."""


@dataclass(frozen=True)
class ContactNote:
    """Deviation of the physics or the contact model.

    Attributes:
        kind: Kind of the deviation.
        bodies: Names as stated by ``kind``, without a pressing body that has no name.
        stiffness: Stated stiffness of a contact that may be unstable or is softer [N/m]; None for other kinds, as the
            next two.
        max_stiffness: Largest stable stiffness at the time step [N/m]; of a softer contact that of the simulation.
        max_timestep: Largest stable time step at the stiffness [s].
        depth: Depth of one body in the other, or of a mesh's surface in its convex hull [m]; None for other kinds.
        force: Normal force of a contact that presses too hard, or that taxels do not report [N]; None for others.
        share: Share of the load that is not sensed, of a contact partly outside the skin or partly below the threshold,
            0 to 1; None for others.
        ratio: Sum of pressure times area over the force, of a contact on bent skin; None for others.
        pressure: Highest pressure on a taxel, of a contact that no taxel reports [Pa]; None for others.
        threshold: Pressure from which a taxel reports it [Pa]; None for others.
        area: Area of blind taxels [m²]; None for others.
        speed: Highest speed of a body that is too fast [m/s]; None for others.
    """

    kind: ContactNoteKind
    bodies: tuple[str, ...]
    stiffness: float | None = None
    max_stiffness: float | None = None
    max_timestep: float | None = None
    depth: float | None = None
    force: float | None = None
    share: float | None = None
    ratio: float | None = None
    pressure: float | None = field(default=None, metadata=LATER)
    threshold: float | None = field(default=None, metadata=LATER)
    area: float | None = field(default=None, metadata=LATER)
    speed: float | None = field(default=None, metadata=LATER)


def load_note(kind: ContactNoteKind, by: str, link: str) -> ContactNote:
    """Return the note about a load on ``link`` by a body that may have no name."""
    return ContactNote(kind, (by, link) if by else (link,))


NOTED_SHARE = 0.01
"""Share of a load outside the skin above which it is noted."""


def border_notes(share: float, by: str, link: str) -> tuple[ContactNote, ...]:
    """Return the note about a load on ``link`` of which bare surface bears ``share``; empty where that is little."""
    if share == 1:
        return (load_note(ContactNoteKind.OUTSIDE_SKIN, by, link),)
    if share > NOTED_SHARE:
        return (replace(load_note(ContactNoteKind.PARTLY_OUTSIDE, by, link), share=share),)
    return ()


NOTED_BIAS = 0.005
"""Share by which readings differ in sum from the force before a note states it."""


def bent_skin_notes(felt: float, force: float, by: str, link: str) -> tuple[ContactNote, ...]:
    """Return the note about a contact whose readings sum to ``felt`` under ``force`` [N]; empty where they agree."""
    if abs(felt - force) <= NOTED_BIAS * force:
        return ()
    return (replace(load_note(ContactNoteKind.BENT_SKIN, by, link), ratio=felt / force if force > 0 else math.inf),)


def lacking_shares(notes: Iterable[ContactNote]) -> dict[str, float]:
    """Return the share of the force that contacts lack, because it is below the threshold, by link."""
    below = (note for note in notes if note.kind is ContactNoteKind.BELOW_THRESHOLD)
    return {note.bodies[-1]: note.share for note in below if note.share is not None}


def contact_note_text(note: ContactNote) -> str:
    """Return the displayed text of a note, with the remedy if there is one."""
    link = note.bodies[-1] if note.bodies else "something"
    by = note.bodies[0] if len(note.bodies) > 1 else "something"
    match note.kind:
        case ContactNoteKind.CONVEX_HULL:
            away = "" if note.depth is None else f", up to {1e3 * note.depth:.2g} mm from its surface"
            return f"{link} collides as its convex hull{away}"
        case ContactNoteKind.UNSTABLE:
            return f"{' and '.join(note.bodies)} may be unstable{_stiffness_advice(note)}"
        case ContactNoteKind.SOFTER:
            return f"{' and '.join(note.bodies)} touch {_softer_text(note)}"
        case ContactNoteKind.OUTSIDE_SKIN:
            return f"{by} presses {link} outside its skin: no reading"
        case ContactNoteKind.PARTLY_OUTSIDE:
            share = "part" if note.share is None else f"{100 * note.share:.0f} %"
            return f"{by} presses {link} across the edge of its skin: {share} of the force is not read"
        case ContactNoteKind.BELOW_THRESHOLD:
            return _below_threshold_text(note, " and ".join(note.bodies[:-1]) or "something", link)
        case ContactNoteKind.SKIN_EDGE:
            return f"{by} presses the edge of the skin on {link}: one point bears all of it"
        case ContactNoteKind.BENT_SKIN:
            ratio = "another sum than" if note.ratio is None else f"{note.ratio:.3f} of"
            return f"{by} presses {link} where the skin bends: the readings sum to {ratio} the force"
        case ContactNoteKind.MOMENT_IGNORED:
            return f"{by} presses {link} outside the points under it: only its force is kept"
        case ContactNoteKind.FRICTION_EXCEEDED:
            return f"{by} drags or twists {link} more than friction allows: its shear is not exact"
        case ContactNoteKind.UNSTABLE_SERVO:
            most = "" if note.max_timestep is None else f" at most {1e3 * note.max_timestep:.2g} ms, or"
            return f"the servo of {link} may be unstable: use{most} the integrator implicitfast or discrete"
        case ContactNoteKind.DEEP:
            depth = "" if note.depth is None else f": {1e3 * note.depth:.3g} mm"
            return f"{by} is deep in {link}{depth}; use a stiffer cover, a lighter body or a smaller force"
        case ContactNoteKind.HARD:
            force = "" if note.force is None else f" with {1e-3 * note.force:.3g} kN"
            return f"{by} presses {link} very hard{force}; use a softer cover, a lighter body or a smaller force"
        case ContactNoteKind.FAST:
            speed = "very fast" if note.speed is None else f"at {note.speed:.3g} m/s"
            return f"{link} moves {speed}; use a heavier body, a softer cover or a shorter time step"
        case ContactNoteKind.BRIEF:
            return f"{by} touched {link} for less than a tick: no reading; use a shorter tick"
        case ContactNoteKind.BLIND_AREA:
            area = "" if note.area is None else f", {1e4 * note.area:.3g} cm²"
            state = "they are broken and have" if by.startswith("taxels ") else "it is broken and has"
            return f"{link} is blind at {by}{area}: {state} too few working neighbours"
        case _:
            assert_never(note.kind)


def _below_threshold_text(note: ContactNote, by: str, link: str) -> str:
    if note.force is None or note.pressure is None or note.threshold is None:
        return f"{by} presses {link} below the threshold of its taxels: no contact is reported"
    if note.share is not None:
        return (
            f"{by} presses {link} with {note.force:.3g} N, {100 * note.share:.0f} % of it on taxels that read less "
            f"than the threshold of {1e-3 * note.threshold:.3g} kPa: contacts lack this part"
        )
    return (
        f"{by} presses {link} with {note.force:.3g} N, but with at most {1e-3 * note.pressure:.2g} kPa: below the "
        f"threshold of {1e-3 * note.threshold:.3g} kPa, so no contact is reported"
    )


def _stiffness_advice(note: ContactNote) -> str:
    if note.stiffness is None or note.max_stiffness is None or note.max_timestep is None:
        return ""
    return (
        f": {note.stiffness:.3g} N/m is too stiff for the time step; use at most {note.max_stiffness:.2g} N/m or "
        f"{1e3 * note.max_timestep:.2g} ms, or the integrator discrete"
    )


def _softer_text(note: ContactNote) -> str:
    if note.stiffness is None or note.max_stiffness is None or note.max_timestep is None:
        return "with less than the stated stiffness"
    return (
        f"with {note.max_stiffness:.2g} N/m instead of {note.stiffness:.3g} N/m, as much as the time step allows for "
        f"so light a body; use at most {1e3 * note.max_timestep:.2g} ms, or the integrator discrete"
    )
