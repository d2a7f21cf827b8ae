"""Contacts of the skin as stiff as its cover, with Coulomb friction: from N/m to the numbers of MuJoCo's solver.

MuJoCo's solver gives a contact the acceleration a with  f = (a_ref - a) / R,  where  a_ref = -B v - K depth  and R is
the regularizer. With a direct ``solref = (-k, -b)`` and a constant impedance d, a contact has the stiffness
k / ((1 - d) w)  [N/m]. The inverse mass w of a pair is estimated as the sum of the bodies' ``body_invweight0``,
independent of the posture (verified to rounding for 0.1 to 5 kg).

Two shapes may meet in several points. Each has its own spring and damper, so that a pair with n points at equal depth
would be n times as stiff. ``ContactSharing`` therefore multiplies R of all points of a pair by

    n = (sum of depths) / (largest depth),

which is the number of points for equal depths, and changes continuously as points come and go. The force of all is then
what the deepest point alone would have, shared in proportion to the depths.

A link that collides in pieces meets a body in several pairs of geoms, which count as one pair. Their normals differ;
see ``shared_counts``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import mujoco
import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.simulation.model.contact_points import centre_on_cap, centre_on_side, correct_normal
from tactile_maps.simulation.model.model_names import is_hull, is_object, plain_name
from tactile_maps.simulation.model.piece_contacts import PieceContacts, piece_groups, shared_counts
from tactile_maps.skin.link_pieces import piece_number
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, ContactNoteKind
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer

SOLVER_IMPEDANCE = 0.5
"""MuJoCo's ``d`` of skin contacts, constant: with 0.9 the error of a held force is eight times as large (measured)."""
FRICTION_RATIO = 1000.0
"""MuJoCo's ``impratio``: how much harder friction is than the normal direction.

MuJoCo's friction is viscous up to Coulomb's force, so that bodies at rest creep. On a slope of 10 degrees a body creeps
by 8 mm/s with a ratio of 1, and by 3 um/s with 1,000 (0.5 kg, time step 1 ms).
"""
FRICTION_DAMPING = 0.5
"""Reference damping B of friction times the time step: sliding ends within a few steps."""
_DILATION = 0.8
"""Largest share of the normal reference acceleration that friction may add to it.

In MuJoCo's convex model sliding at speed v also pushes the bodies apart, with the acceleration  mu B v: without a limit
the contact hops, and a pressing force of 10 N varies by 13 N at 0.3 m/s. While bodies slide, friction is Coulomb's
force for any reference above their deceleration, so that the limit does not change it; where they are braked harder, or
friction itself stays below Coulomb's force, ``PassiveFriction`` repeats the step without it. What is left of the push
is subtracted from the normal reference, except with ``discrete``, which does not need it.
"""
_ROUND = {
    int(shape) for shape in (mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_CAPSULE)
}
"""Shapes for which MuJoCo always finds the direction of the contact exactly, as numbers: its enumerations are not equal
to NumPy's integers."""
_SEMI_IMPLICIT = 2 * math.sqrt(2) - 2
"""Largest  h sqrt(k)  of a critically damped spring under semi-implicit Euler.

Such a spring has the double pole  -sqrt(k).  Semi-implicit Euler, which all of MuJoCo's first-order integrators are for
a contact, is unstable from  h^2 k + 4 h sqrt(k) = 4  on. Measured on our arm, UR5e and iCub, pressed at 3 to 300 kN/m:
0.98 to 1.00 of it (Euler once 0.82, where a servo becomes unstable first).
"""

_NO_BOUNCE = math.sqrt(0.5)
"""Largest  h sqrt(k)  with which a free body leaves the cover no faster than it came: its mass is at least K h^2.

A contact is found up to a step too late, and its spring then has energy that nothing put into it.
"""


class ContactSharing:
    """Keeps every pair of skin and something else at the stiffness of the cover, in one compiled model.

    The model's pairs are set once. ``apply`` then works on the constraints of one step, between ``mj_step1`` and
    ``mj_step2``; it has no memory. Two skins in series have half the stiffness. A free object that is lighter than
    K h^2 touches with the stiffness at which it is not, so that the cover does not throw it out.

    The integrator ``discrete`` solves for the end of the step and builds its constraints again in ``mj_step2``, from
    the parameters of each contact. Its solver weighs bodies together with their servos and dampers, in contact with a
    very stiff joint up to seven times heavier; so there the numbers are those for the weight in this step.

    Args:
        model: Compiled; its contact pairs are set.
        layer: The skin's cover.
        pieces: Corrects the contacts of links that collide in pieces; without it their pairs are only set.
    """

    def __init__(self, model: mujoco.MjModel, layer: ElasticLayer, *, pieces: PieceContacts | None = None) -> None:
        self._model = model
        self._step = float(model.opt.timestep)
        self._discrete = model.opt.integrator == mujoco.mjtIntegrator.mjINT_DISCRETE
        self._pieces = pieces
        self._groups = piece_groups(model)
        self._divided = [
            any(piece_number(model.geom(geom).name) is not None for geom in geoms) for geoms in _geoms(model)
        ]
        self._pairs = {geoms: pair for pair, geoms in enumerate(_geoms(model))}
        self._pairs |= {geoms[::-1]: pair for geoms, pair in self._pairs.items()}
        self._stiffness = [_stiffness(model, layer, geoms) for geoms in _geoms(model)]
        self._exact = [any(int(model.geom_type[geom]) in _ROUND for geom in geoms) for geoms in _geoms(model)]
        self._cylinders = frozenset(np.flatnonzero(model.geom_type == int(mujoco.mjtGeom.mjGEOM_CYLINDER)).tolist())
        self._sizes: list[int] = model.pair_dim.tolist()
        for pair, geoms in enumerate(_geoms(model)):
            mobility = max(_mobility(model, geoms), 1e-9)
            k = self._stiffness[pair] * (1 - SOLVER_IMPEDANCE) * mobility
            model.pair_solref[pair] = -k, -2 * math.sqrt(k)
            if model.pair_dim[pair] > 1:
                model.pair_solreffriction[pair] = -1.0, -FRICTION_DAMPING * SOLVER_IMPEDANCE / self._step

    def apply(self, data: mujoco.MjData) -> None:
        """Share the stiffness among the points of each pair, and limit what friction adds to the normal force.

        Cost: 3 us and 2 us a contact, 5 us for each pair that is not round; with ``discrete`` also that of a solution.
        """
        contact = data.contact
        geoms = contact.geom.tolist()
        rows = contact.efc_address.tolist()
        points = self._points(geoms, rows)
        if self._correct(data, geoms, points):
            rows = data.contact.efc_address.tolist()
            points = self._points(geoms, rows)
        if self._discrete:
            self._set_parameters(data, points)
            return
        self._share(data, points, rows)
        contact = data.contact
        sizes = contact.dim.tolist()
        if max(sizes) > 1:
            reference = data.efc_aref
            values = reference.tolist()
            for row, size, friction in zip(rows, sizes, contact.friction[:, 0].tolist(), strict=True):
                if row >= 0 and size > 1:
                    _limit_dilation(reference, values, row, friction)

    def _share(self, data: mujoco.MjData, points: Mapping[int, list[int]], rows: list[int]) -> None:
        """Make each of several points of a pair softer than it would be alone."""
        softer: FloatArray | None = None
        for pair, numbers in points.items():
            if len(numbers) == 1:
                continue
            for number, count in zip(numbers, self._counts(data, pair, numbers), strict=True):
                if count > 1:
                    if softer is None:
                        softer = np.ones(data.nefc)
                    softer[rows[number] : rows[number] + self._sizes[pair]] = count
        if softer is not None:
            np.multiply(data.efc_R, softer, out=data.efc_R)
            np.divide(data.efc_D, softer, out=data.efc_D)

    def _counts(self, data: mujoco.MjData, pair: int, numbers: list[int]) -> list[float]:
        """Return by how much each point of a pair is softer than it would be alone."""
        contact = data.contact
        distances = contact.dist.tolist()
        depths = [-distances[number] for number in numbers]
        if not self._divided[pair]:
            return [effective_count(depths)] * len(depths)
        bodies = self._model.geom_bodyid[contact.geom[numbers, 0]]
        signs = np.where(bodies == bodies[0], 1.0, -1.0)
        counts: list[float] = shared_counts(depths, signs[:, None] * contact.frame[numbers, :3]).tolist()
        return counts

    def _points(self, geoms: list[list[int]], rows: list[int]) -> dict[int, list[int]]:
        """Return the numbers of the contacts of each pair that touches, from both geoms and the row of each contact."""
        points: dict[int, list[int]] = {}
        for number, (first, second) in enumerate(geoms):
            pair = self._pairs.get((self._groups[first], self._groups[second]))
            if pair is not None and rows[number] >= 0:
                points.setdefault(pair, []).append(number)
        return points

    def _correct(self, data: mujoco.MjData, geoms: list[list[int]], points: Mapping[int, list[int]]) -> bool:
        """Correct the points that MuJoCo finds between shapes with faces; return whether any changed."""
        changed = False
        for pair, numbers in points.items():
            if self._divided[pair] and self._pieces is not None:
                self._pieces.correct(data, pair, numbers)
                changed = True
            elif not self._exact[pair]:
                changed |= correct_normal(self._model, data, numbers)
                if geoms[numbers[0]][0] in self._cylinders:
                    changed |= centre_on_cap(self._model, data, numbers)
                    changed |= centre_on_side(self._model, data, numbers)
        if changed:
            mujoco.mj_makeConstraint(self._model, data)
            mujoco.mj_projectConstraint(self._model, data)
            mujoco.mj_fwdVelocity(self._model, data)
        return changed

    def _set_parameters(self, data: mujoco.MjData, points: Mapping[int, list[int]]) -> None:
        """Set each contact's own parameters, from which ``discrete`` builds its constraints again."""
        mujoco.mj_forwardSkip(self._model, data, mujoco.mjtStage.mjSTAGE_VEL, 1)  # computes R
        rows = data.contact.efc_address.tolist()
        depths = (-data.contact.dist).tolist()
        for pair, numbers in points.items():
            for number, count in zip(numbers, self._counts(data, pair, numbers), strict=True):
                self._set_contact(data, number, rows[number], pair, count, depths[number])

    def _set_contact(self, data: mujoco.MjData, number: int, row: int, pair: int, count: float, depth: float) -> None:
        step = self._step
        contact = data.contact
        k, b = (-self._model.pair_solref[pair]).tolist()
        # R of a row is  (1 - d) / d  times the inverse mass, divided by  1 + h b / d + h^2 k / d.
        implicit = 1 + step * (b + step * k) / SOLVER_IMPEDANCE
        mobility = float(data.efc_R[row]) * implicit * SOLVER_IMPEDANCE / (1 - SOLVER_IMPEDANCE)
        k = self._stiffness[pair] * (1 - SOLVER_IMPEDANCE) * mobility
        b = 2 * math.sqrt(k)
        # This impedance multiplies R by n; the scale keeps the reference unchanged.
        impedance = SOLVER_IMPEDANCE / (SOLVER_IMPEDANCE + count * (1 - SOLVER_IMPEDANCE))
        scale = impedance / SOLVER_IMPEDANCE
        contact.solimp[number, :2] = impedance
        contact.solref[number] = -k * scale, -b * scale
        if self._model.pair_dim[pair] > 1:
            damping = FRICTION_DAMPING / step
            speed = math.hypot(data.efc_vel[row + 1], data.efc_vel[row + 2])
            reference = max(k * depth - b * float(data.efc_vel[row]), 0.0) / SOLVER_IMPEDANCE
            # The reference of friction is  B v / (1 + h B).
            friction = float(self._model.pair_friction[pair, 0])
            allowed = _DILATION * reference / friction if friction > 0 else math.inf
            if speed * damping > allowed * (1 + step * damping):
                damping = allowed / (speed - step * allowed)
            contact.solreffriction[number, 1] = -damping * impedance


def _limit_dilation(reference: FloatArray, values: list[float], row: int, friction: float) -> None:
    """Limit what friction adds to the normal force of the contact at ``row``, also between bodies without skin.

    Args:
        reference: Reference accelerations of all rows, changed.
        values: The same before the change.
        row: Row of the contact's normal.
        friction: Its friction coefficient.
    """
    normal, first, second = values[row : row + 3]
    dilation = friction * math.hypot(first, second)
    allowed = _DILATION * max(normal, 0.0)
    if dilation > allowed:
        reference[row + 1 : row + 3] *= allowed / dilation
    reference[row] = normal - min(dilation, allowed)


def effective_count(depths: list[float]) -> float:
    """Return how many points as deep as the deepest are as stiff as these together; 1 to ``len(depths)``."""
    largest = max(depths)
    if largest <= 0:
        return float(len(depths))
    return sum(max(depth, 0.0) / largest for depth in depths)


def stable_timesteps(model: mujoco.MjModel, layer: ElasticLayer) -> Mapping[tuple[str, str], float]:
    """Return the longest stable time step of each contact of the skin [s], by the names of both sides.

    It is that of the pair alone, at the bodies' nominal weights: servos, fingers and the rest of the arm are left out.

    Args:
        model: The compiled model.
        layer: The skin's cover.

    Returns:
        Time steps by pair of names; empty with the integrator ``discrete``, which is implicit in the contact as well.
    """
    if model.opt.integrator == mujoco.mjtIntegrator.mjINT_DISCRETE:
        return {}
    found = {}
    for geoms in _geoms(model):
        k = layer.stiffness / _skins(model, geoms) * (1 - SOLVER_IMPEDANCE) * _mobility(model, geoms)
        names = _names(model, geoms)
        found[names] = _SEMI_IMPLICIT / math.sqrt(k) if k > 0 else math.inf
    return found


def unstable_contacts(model: mujoco.MjModel, layer: ElasticLayer) -> tuple[ContactNote, ...]:
    """Return notes on contacts of the skin that are too stiff for the time step, and on those made softer for it.

    Args:
        model: The compiled model.
        layer: The skin's cover.
    """
    step = model.opt.timestep
    notes = {}
    for geoms in _geoms(model):
        stated = layer.stiffness / _skins(model, geoms)
        used = _stiffness(model, layer, geoms)
        if used < stated:
            names = _names(model, geoms)
            longest = step * math.sqrt(used / stated)
            notes[names] = ContactNote(ContactNoteKind.SOFTER, names, stated, used, longest)
    for names, longest in stable_timesteps(model, layer).items():
        if step > longest and names not in notes:
            most = layer.stiffness * (longest / step) ** 2
            notes[names] = ContactNote(ContactNoteKind.UNSTABLE, names, layer.stiffness, most, longest)
    return tuple(notes.values())


def _stiffness(model: mujoco.MjModel, layer: ElasticLayer, geoms: tuple[int, int]) -> float:
    """Return the stiffness of a contact [N/m]: that of the cover, or less for a free object lighter than K h^2."""
    stated = layer.stiffness / _skins(model, geoms)
    if model.opt.integrator == mujoco.mjtIntegrator.mjINT_DISCRETE or not any(_is_free(model, geom) for geom in geoms):
        return stated
    k = (_NO_BOUNCE / model.opt.timestep) ** 2
    return float(min(stated, k / ((1 - SOLVER_IMPEDANCE) * max(_mobility(model, geoms), 1e-9))))


def _mobility(model: mujoco.MjModel, geoms: tuple[int, int]) -> float:
    """Return the nominal inverse mass of a pair [1/kg]."""
    return sum(float(model.body_invweight0[model.geom_bodyid[geom], 0]) for geom in geoms)


def _is_free(model: mujoco.MjModel, geom: int) -> bool:
    """Whether a geom belongs to an object that moves without motor and spring."""
    body = int(model.geom_bodyid[geom])
    joints = np.flatnonzero(model.jnt_bodyid == body)
    held = model.jnt_stiffness[joints].any() or np.isin(joints, model.actuator_trnid[:, 0]).any()
    return is_object(model.geom(geom).name) and joints.size > 0 and not held


def _names(model: mujoco.MjModel, geoms: tuple[int, int]) -> tuple[str, str]:
    first, second = geoms
    return plain_name(model.geom(first).name), plain_name(model.geom(second).name)


def _skins(model: mujoco.MjModel, geoms: tuple[int, int]) -> int:
    return sum(is_hull(model.geom(geom).name) for geom in geoms)


def _geoms(model: mujoco.MjModel) -> list[tuple[int, int]]:
    """Return both geoms of each pair."""
    return list(zip(model.pair_geom1.tolist(), model.pair_geom2.tolist(), strict=True))
