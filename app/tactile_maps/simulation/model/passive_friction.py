"""Steps in which friction never adds energy, and brakes as Coulomb's law says.

MuJoCo turns friction against the difference between a contact's acceleration and its reference acceleration. That is
the direction of sliding only while the reference exceeds every other deceleration. Where the reference is limited (see
``contact_stiffness``) and a servo brakes the bodies harder, friction pushes them along. It also does where joints are
strongly damped: the integrators ``implicitfast``, ``implicit`` and ``euler`` apply damping after the solver, which
computes friction for bodies that it takes for too light.

``PassiveFriction`` measures the work of friction on the way of each step, force times the slip velocity at its end. The
mechanical energy changes by this work and that of the other dissipative forces, less the kinetic energy of the change
of velocity, which is never negative. A step in which a contact gains energy is repeated; with ``discrete`` also one in
which friction with a limited reference brakes by less than Coulomb's force, from a coefficient of 0.7 on. It has then

* the reference  -v / h,  so that friction is opposite to the velocity at the end of the step, or stops the bodies;
* the normal reference less  mu |a + v / h|,  by which friction pushes the bodies apart in MuJoCo's convex model, with
  the acceleration a of the previous step;
* the bodies as heavy as the integrator takes them, with the time step times the damping added to the inertia.

All other steps are unchanged.
"""

from __future__ import annotations

import mujoco
import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.simulation.model.contact_stiffness import FRICTION_DAMPING

LEAST_GAIN = 1e-10
"""Work of friction on a contact in one step from which on the step is repeated [J]."""
_COULOMB_SHARE = 0.99
"""Share of Coulomb's force below which sliding friction counts as too weak: the solver's own error is below 0.1 %."""
_STOPS = 1e5
"""Damping of friction times the time step with which ``discrete`` stops sliding within a step. With 1e4 a repeated step
of 8 ms between heavy bodies still gained 1e-6 J."""
_NUDGE = 1e-6
"""Change of a contact's depth for the derivative of its reference [m]."""


class PassiveFriction:
    """Second half of the steps of one compiled model, see the module.

    It has no memory. Cost: 20 us a step with contacts, and the time of a step for each repetition.

    Args:
        model: The compiled model; without MuJoCo's islands.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self._model = model
        self._discrete = model.opt.integrator == mujoco.mjtIntegrator.mjINT_DISCRETE
        self._inertia = model.M_rowadr + model.M_rownnz - 1
        self._damping = model.D_rowadr + model.D_diag
        self._posture = np.zeros(model.nq)
        self._velocity = np.zeros(model.nv)
        self._acceleration = np.zeros(model.nv)

    def finish_step(self, data: mujoco.MjData) -> None:
        """Do what ``mj_step2`` does, without energy from friction.

        Args:
            data: State after ``mj_step1``, with its contacts set.
        """
        model = self._model
        rows = _rough_rows(data)
        if not rows:
            mujoco.mj_step2(model, data)
            return
        time = data.time
        self._posture[:] = data.qpos
        self._velocity[:] = data.qvel
        self._acceleration[:] = data.qacc_warmstart
        mujoco.mj_step2(model, data)
        if max(_works(model, data, rows)) > LEAST_GAIN or (self._discrete and _is_weak(model, data)):
            data.time = time
            data.qpos[:] = self._posture
            data.qvel[:] = self._velocity
            data.qacc_warmstart[:] = self._acceleration
            rough = np.flatnonzero((data.contact.dim > 1) & (data.contact.efc_address >= 0))
            if self._discrete:
                self._repeat_discrete(data, rough)
            else:
                self._repeat(data, rough)

    def _repeat(self, data: mujoco.MjData, rough: IntArray) -> None:
        model = self._model
        option = model.opt
        mujoco.mj_referenceConstraint(model, data)
        rows = data.contact.efc_address[rough]
        stop, push = self._references(data, rough)
        data.efc_aref[rows + 1] = stop[:, 0]
        data.efc_aref[rows + 2] = stop[:, 1]
        data.efc_aref[rows] -= push
        inertia = data.M[self._inertia]
        integrator = option.integrator
        flags = option.disableflags
        data.M[self._inertia] += option.timestep * self._implicit_damping(data)
        mujoco.mj_factorM(model, data)
        option.integrator = mujoco.mjtIntegrator.mjINT_EULER
        option.disableflags = flags | mujoco.mjtDisableBit.mjDSBL_EULERDAMP
        mujoco.mj_step2(model, data)
        option.integrator = integrator
        option.disableflags = flags
        data.M[self._inertia] = inertia
        mujoco.mj_factorM(model, data)

    def _repeat_discrete(self, data: mujoco.MjData, rough: IntArray) -> None:
        """Repeat a step of ``discrete``, which knows the damping, and computes the references from depths."""
        model = self._model
        data.contact.solreffriction[rough, 1] = -_STOPS / model.opt.timestep
        mujoco.mj_forwardSkip(model, data, mujoco.mjtStage.mjSTAGE_VEL, 1)
        rows = data.contact.efc_address[rough]
        normal = data.efc_aref[rows]
        data.efc_pos[rows] += _NUDGE
        mujoco.mj_forwardSkip(model, data, mujoco.mjtStage.mjSTAGE_VEL, 1)
        stiffness = (normal - data.efc_aref[rows]) / _NUDGE
        _, push = self._references(data, rough)
        data.efc_pos[rows] += push / np.maximum(stiffness, 1.0) - _NUDGE
        mujoco.mj_step2(model, data)

    def _references(self, data: mujoco.MjData, rough: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return the accelerations that stop sliding (k, 2), and those by which they push apart (k,) [m/s^2]."""
        rows = data.contact.efc_address[rough]
        slip = _along(self._model, data, rows, data.qvel) / self._model.opt.timestep
        before = _along(self._model, data, rows, data.qacc_warmstart)
        speed = np.linalg.norm(slip, axis=1)
        rising = np.einsum("ij,ij->i", slip, before) / np.maximum(speed, 1e-12)
        return -slip, data.contact.friction[rough, 0] * np.clip(speed + rising, 0.0, 2 * speed)

    def _implicit_damping(self, data: mujoco.MjData) -> FloatArray:
        """Return the damping of each degree of freedom (nv,) that the integrator evaluates at the end of the step."""
        if self._model.opt.integrator == mujoco.mjtIntegrator.mjINT_EULER:
            return np.array(self._model.dof_damping)
        return np.maximum(-data.qDeriv[self._damping], 0.0)


def friction_work(model: mujoco.MjModel, data: mujoco.MjData) -> list[float]:
    """Return the work of friction in the last step on each contact that has friction [J].

    It is the friction force times the way that its contact slides in the step, negative for a loss. Cost: 10 us; lists
    are faster than arrays for a few contacts.

    Args:
        model: The compiled model.
        data: Its state after a step, with the contacts of the start of the step.
    """
    return _works(model, data, _rough_rows(data))


def _works(model: mujoco.MjModel, data: mujoco.MjData, rows: list[int]) -> list[float]:
    """Return the work of friction of the contacts whose normals are at ``rows``."""
    slip = np.zeros(data.nefc)
    mujoco.mj_mulJacVec(model, data, slip, data.qvel)
    slip *= data.efc_force
    power = slip.tolist()
    step = float(model.opt.timestep)
    return [step * (power[row + 1] + power[row + 2]) for row in rows]


def _rough_rows(data: mujoco.MjData) -> list[int]:
    """Return the rows of the normals of all contacts with friction."""
    contact = data.contact
    return [
        row
        for row, size in zip(contact.efc_address.tolist(), contact.dim.tolist(), strict=True)
        if size > 1 and row >= 0
    ]


def _is_weak(model: mujoco.MjModel, data: mujoco.MjData) -> bool:
    """Return whether friction with a limited reference is below Coulomb's force on any contact, after ``discrete``."""
    contact = data.contact
    unlimited = FRICTION_DAMPING / float(model.opt.timestep) * contact.solimp[:, 0]
    damping = -contact.solreffriction[:, 1]
    limited = (damping > 0) & (damping < (1 - 1e-9) * unlimited)
    chosen = np.flatnonzero(limited & (contact.dim > 1) & (contact.efc_address >= 0))
    rows = contact.efc_address[chosen]
    tangential = np.hypot(data.efc_force[rows + 1], data.efc_force[rows + 2])
    return bool((tangential < _COULOMB_SHARE * contact.friction[chosen, 0] * data.efc_force[rows]).any())


def _along(model: mujoco.MjModel, data: mujoco.MjData, rows: IntArray, motion: FloatArray) -> FloatArray:
    """Return ``motion`` (nv,) along both tangents of the contacts whose normals are at ``rows``, (k, 2)."""
    along = np.zeros(data.nefc)
    mujoco.mj_mulJacVec(model, data, along, motion)
    return np.column_stack([along[rows + 1], along[rows + 2]])
