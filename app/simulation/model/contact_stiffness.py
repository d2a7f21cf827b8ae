"""Contacts of the skin as stiff as its cover is: from N/m to the numbers of MuJoCo's solver.

A direct ``solref = (-k, -b)`` with constant impedance d makes a contact of  K = k / ((1 - d) w)  [N/m], where w is the
solver's estimate of the pair's inverse mass: the sum of the bodies' ``body_invweight0``, whatever the posture. In the
same way friction's b makes  b / ((1 - d) w)  [N s/m]. (Measured to the digit for 0.1 to 5 kg.)
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import mujoco
import numpy as np

from app.core.arrays import FloatArray
from app.simulation.model.model_names import is_hull, plain_name
from app.tactile.contact_notes import ContactNote, ContactNoteKind
from app.tactile.elastic_layer import ElasticLayer

SOLVER_IMPEDANCE = 0.5
"""MuJoCo's ``d`` of skin contacts, constant: with 0.9 a held force wavers eight times as much (measured)."""
FRICTION_DAMPING = 100.0
"""Friction of skin contacts below the speed at which they slide [N s/m].

MuJoCo's friction creeps: it is viscous up to Coulomb's force, and what viscosity would bring beyond that also pushes
the bodies apart. A contact held with force N creeps up to  mu N / GRIP  and hops from  N (1 / mu + 2 mu) / GRIP  on.
With 10 N and mu = 0.5 that is 0.05 and 0.3 m/s. MuJoCo's own value makes it hop at 0.03 m/s (10 N waver by 9.5 N); the
known cure of ``solreffriction = 0.2 1`` is worth 4 N s/m, with which nothing rubs below 1 m/s (measured).
"""
_SEMI_IMPLICIT, _RUNGE_KUTTA = 2 * math.sqrt(2) - 2, 2.785
"""Largest  h √k  of a critically damped spring, by integrator.

Such a spring has the double pole -√k. Semi-implicit Euler, which all of MuJoCo's first-order integrators are of a
contact, makes it grow from  h² k + 4 h √k = 4  on; fourth-order Runge-Kutta has 2.785 on the negative real axis.
Measured on our arm, UR5e and iCub, pressed at 3 to 300 kN/m: 0.98 to 1.00 of it (Euler once 0.82, where a servo is the
first to grow), Runge-Kutta 0.88 to 0.97, and 0.65 once.
"""


class ContactStiffness:
    """Keeps every pair of skin and something at the layer's stiffness, in one compiled model, which it changes.

    Two skins in series have half the stiffness. The integrator ``discrete`` is implicit: its solver weighs bodies with
    their servos and dampers, in contact with a very stiff joint up to seven times heavier. So there the numbers follow
    the weight that the solver used last.

    Args:
        model: Compiled.
        layer: Of the skin.
    """

    def __init__(self, model: mujoco.MjModel, layer: ElasticLayer) -> None:
        self._model = model
        self._stiffness = [layer.stiffness / _skins(model, geoms) for geoms in _geoms(model)]
        self._follows = model.opt.integrator == mujoco.mjtIntegrator.mjINT_DISCRETE
        self._pairs = {geoms: pair for pair, geoms in enumerate(_geoms(model))}
        self.reset()

    def reset(self) -> None:
        """Back to the bodies' own weights."""
        weight = self._model.body_invweight0[:, 0]
        for pair, geoms in enumerate(_geoms(self._model)):
            self._set(pair, max(sum(float(weight[self._model.geom_bodyid[geom]]) for geom in geoms), 1e-9))

    def follow(self, data: mujoco.MjData) -> None:
        """Take the solver's last estimate of each pair in contact. Cost: 5 µs; nothing with other integrators."""
        if not (self._follows and data.ncon):
            return
        # The regulariser of a row is (1 - d) / d times the estimate, over  1 + h b / d + h² k / d.
        step, estimate = self._model.opt.timestep, data.efc_R * (SOLVER_IMPEDANCE / (1 - SOLVER_IMPEDANCE))
        for row, (first, second) in zip(data.contact.efc_address.tolist(), data.contact.geom.tolist(), strict=True):
            pair = self._pairs.get((first, second), self._pairs.get((second, first)))
            if row >= 0 and pair is not None:
                k, b = -self._model.pair_solref[pair]
                implicit = float(1 + step * (b + step * k) / SOLVER_IMPEDANCE)
                self._set(pair, float(estimate[row]) * implicit, implicit=implicit)

    def numbers(self) -> FloatArray:
        """(k,) what ``follow`` remembers, for comparing runs; empty with other integrators."""
        return np.array(self._model.pair_solref[:, 0]) if self._follows else np.zeros(0)

    def _set(self, pair: int, mobility: float, *, implicit: float = 1.0) -> None:
        scale = (1 - SOLVER_IMPEDANCE) * mobility
        k = self._stiffness[pair] * scale
        self._model.pair_solref[pair] = -k, -2 * np.sqrt(k)
        if self._model.pair_dim[pair] > 1:  # no stiffness: friction has nowhere to return
            # Friction shares the normal's regulariser, and with it what makes the normal implicit.
            self._model.pair_solreffriction[pair] = -1.0, -FRICTION_DAMPING * scale / implicit


def stable_timesteps(model: mujoco.MjModel, layer: ElasticLayer) -> Mapping[tuple[str, str], float]:
    """The longest time step that each contact of the skin bears [s], by the names of both sides.

    It is that of the pair alone, at the bodies' nominal weights: servos, fingers and the rest of the arm are left out.

    Args:
        model: Compiled.
        layer: Of the skin.

    Returns:
        Nothing with the integrator ``discrete``, which is implicit in the contact as well: none was found too stiff.
    """
    if model.opt.integrator == mujoco.mjtIntegrator.mjINT_DISCRETE:
        return {}
    runge_kutta = model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4
    limit, found = _RUNGE_KUTTA if runge_kutta else _SEMI_IMPLICIT, {}
    for geoms in _geoms(model):
        first, second = geoms
        mobility = sum(float(model.body_invweight0[model.geom_bodyid[geom], 0]) for geom in geoms)
        k = layer.stiffness / _skins(model, geoms) * (1 - SOLVER_IMPEDANCE) * mobility
        names = plain_name(model.geom(first).name), plain_name(model.geom(second).name)
        found[names] = limit / math.sqrt(k) if k > 0 else math.inf
    return found


def unstable_contacts(model: mujoco.MjModel, layer: ElasticLayer) -> tuple[ContactNote, ...]:
    """Contacts of the skin that are stiffer than the time step bears, with what each bears.

    Args:
        model: Compiled.
        layer: Of the skin.
    """
    step = model.opt.timestep
    return tuple(
        ContactNote(ContactNoteKind.UNSTABLE, names, layer.stiffness, layer.stiffness * (longest / step) ** 2, longest)
        for names, longest in stable_timesteps(model, layer).items()
        if step > longest
    )


def _skins(model: mujoco.MjModel, geoms: tuple[int, int]) -> int:
    return sum(is_hull(model.geom(geom).name) for geom in geoms)


def _geoms(model: mujoco.MjModel) -> list[tuple[int, int]]:
    """Both geoms of each pair."""
    return list(zip(model.pair_geom1.tolist(), model.pair_geom2.tolist(), strict=True))
