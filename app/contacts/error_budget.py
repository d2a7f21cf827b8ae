"""Standard uncertainties of a contact's force and place, with the named parts that they are made of.

Independent errors of the taxels propagate by the first derivatives (JCGM 100:2008, Guide to the Expression of
Uncertainty in Measurement, 5.1.2). Systematic errors of the whole contact are added in quadrature, a known bias with
its full size (F.2.4.5 there), because the force stays the plain sum of pressure times area. With pressures p_i, areas
a_i, forces f_i = p_i a_i, F = sum f_i, shares w_i = f_i / F, distances d_i from the centre, mean area a,
effective number of taxels n = F² / sum f_i² and n_t touched taxels with the area A, the parts of the force are:

    noise, quantisation, offset drift    sd² sum a_i², with step / sqrt(12) and (sd² + walk² t)^½
    gain spread                          gain² sum f_i²
    hysteresis                           about 0.43 share F: a load held for any time up to three time constants
    area averaging                       F (0.29² n^-2.5 exp(-3.6 u) + 0.24² n^-2)^½ with the pad's share u of the area,
                                         at least 0.3 F for n < 2 and min(1 - u, k) F for n < 1.1
    crosstalk                            0.4 share (r² + (0.1 g)²)^½: what the ring's own force r gives to taxels beyond
    threshold                            (m² / 9 + m / 5)^½ at a, m = 2 pi (n_t / pi)^¾ (at / peak)^½ taxels of the rim
    saturation                           at A_s s / (1 - s) / sqrt(2), s = 2 n_s / (n_t + n_s + 1); A_s, n_s: saturated
    dead taxels                          (dead sum f_i² + dead² F²)^½, for stuck ones the same with their own force
    sampling                             lag |dF / dt|
    ring                                 r³ / F²: the force beyond the ring
    contact model                        0.018 F for foundation, whose taxels read along their own normals; infinite for
                                         depth, whose readings are penetration: their sum is not a force

Pressure falls to zero at the rim of a contact with a slope of 2 peak / radius (a ball on springs). A taxel of pitch h
that reaches x < h into the contact reads slope x² / 2 h, so those with x < (2 h at / slope)^½ are below the threshold
and lose a third of it in the mean, a fifth of its square. Above the limit of saturation, pressures are spread evenly
up to the peak: a share s above it means a peak of at / (1 - s). Saturated taxels only bound the force from below.

The ring's own force r is what the touched taxels do not give to it by crosstalk. One touched taxel gives
g = share F / (1 - share) for a reading F, all of it to the ring; n_t of them give g / n_t^½, known to a tenth of g. Of
the neighbours of a ring taxel, a third are beyond the ring where it borders two touched taxels, half where it borders
one: 0.4. The ring is reached by the rim of a contact rather than by a tail, so that beyond it is less than the ratio
q = r / F again: F q q². With half-space, less than twice as much is beyond for 98 % of touches on the arm and for 93 %
on a flat irregular skin.

Pads sample the pressure on a lattice. By Poisson's summation formula the error of the sum is the spectrum of the
pressure at the reciprocal lattice, 4 pi / (3^½ h) for six vectors of a hexagonal one (Petersen and Middleton 1962),
times that of the pad, 2 J_1(x) / x ≈ exp(-x² / 8). A paraboloid of radius R has F 8 J_2(x) / x², x = G R, whose root
mean square over places is 11 x^-2.5 F, and n a = 3/4 pi R²: 0.27 n^-1.25, with the next vectors 0.29. A pad that is
displaced by s from the centroid of its cell adds s times the gradient, (9 pi / 4)^½ s / (a^½ n) in all; s is 0.09 a^½:
cells of three skins have 0.04 to 0.06, and a pad of few quadrature points as much again. One pad alone says little: of
contacts anywhere within its reach, whose radius is anything up to half of min(h, 16 mm), 68 % have F between 1 - k and
1 + k times the reading, with a long tail of larger ones: k = 1 - 0.42 v + 0.17 v², v = min((16 mm / h)², 1), a fit
within 0.01 to P(F / reading < x) = 1 - 0.27 v / x, or 0.4 (x / 0.45 v)^1.5 where x < 0.45 v. A pad that holds the whole
contact, and so any load of ``point``, reads 1 / u times too much. Two pads alone were 0.24 to 0.41 F off in 68 % of
simulated cases.

The place has the independent errors with d_i² / F² in every term, 2 calibration² sum w_i² for misplaced taxels, the
speed of the contact times the lag, and the position within a taxel's area:

    cells    a / 6 (0.8 exp(-1.5 (n - 1)) + 0.15 n^-3): a lump anywhere in one square is a / 6, a wide contact less
    pads     0.09 n^-1.5 a

These two are root mean squares over round contacts of all sizes (paraboloids of pressure with radii of
0.03 to 2.5 pitches) on a hexagonal lattice whose taxels are displaced by 0 to 15 % of the pitch.

``place`` is radial, the root of the two variances' sum. 63 % of normally distributed centres are within it and 98 %
within twice as much; of lumps anywhere in a taxel 52 % and 100 %.

Not included: errors that all taxels of a module share (a patch put on askew), and curvature.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from app.contacts.centre_of_pressure import SensorUncertainty
from app.core.arrays import FloatArray, IntArray, dot
from app.tactile.sensor_effects import DeadTaxels

INDEPENDENT = ("noise", "quantisation", "offset_drift", "gain_spread")
"""Parts that are independent between taxels, so that an estimator propagates them."""
_WHITE = ("noise", "quantisation")
_SMOOTHING = 0.6
"""Weight of the newest sample in the rates of change."""
_WIDEST = 0.016
"""Diameter of the widest contact that a single pad is expected to feel [m], as of a fingertip or a ball on a cover."""
_OF_NOISE = 2 * _SMOOTHING**2 / (2 - _SMOOTHING)
"""Variance of a rate that is due to noise, per variance of the noise over the squared period."""


class Uncertainty(NamedTuple):
    """Standard uncertainties of one contact.

    Attributes:
        place: Of the centre, radial [m].
        force: Of the force [N].
        parts: Parts of ``force`` [N] by effect of the sensor, ``ring`` or ``contact_model``.
    """

    place: float
    force: float
    parts: Mapping[str, float]


class Readings(NamedTuple):
    """Readings of the taxels of one contact.

    Attributes:
        forces: (k,) [N], of sum > 0.
        areas: (k,) [m²].
        taxels: (k,) their numbers.
        inside: (c,) indices of the touched ones.
    """

    forces: FloatArray
    areas: FloatArray
    taxels: IntArray
    inside: IntArray


class Motion(NamedTuple):
    """How force and place of a contact change from sample to sample, for the age of a reading.

    Attributes:
        time: Of the last sample [s].
        samples: Number of samples.
        period: Since the sample before [s].
        force: At the last sample [N].
        position: (3,) at the last sample, link frame [m].
        rate: Change of the force [N/s].
        velocity: (3,) [m/s], link frame.
    """

    time: float
    samples: int
    period: float
    force: float
    position: FloatArray
    rate: float
    velocity: FloatArray

    @classmethod
    def begin(cls, time: float, force: float, position: FloatArray, lag: float) -> Motion:
        """Return the motion of a contact that began within the last ``lag`` [s]."""
        return cls(time, 1, lag, force, position, force / lag, np.zeros(3))

    def next(self, time: float, force: float, position: FloatArray) -> Motion:
        """Return the motion with one more sample."""
        weight = max(_SMOOTHING, 1 / self.samples)
        period = time - self.time
        rate = self.rate + weight * ((force - self.force) / period - self.rate)
        velocity = self.velocity + weight * ((position - self.position) / period - self.velocity)
        return Motion(time, self.samples + 1, period, force, position, rate, velocity)


def reading_variances(errors: SensorUncertainty, pressures: FloatArray, taxels: IntArray) -> dict[str, FloatArray]:
    """Return the variances (k,) of the readings ``pressures`` (k,) [Pa²] by part, for the independent parts that exist.

    A sensor with a threshold reads exactly zero below it, whatever the noise. A converter reads a taxel that nothing
    presses exactly, unless noise or offsets reach it.
    """
    effects, count = errors.effects, len(pressures)
    step = effects.quantisation.step**2 / 12 if effects.quantisation else 0.0
    found: dict[str, FloatArray] = {}
    if errors.taxels is not None:
        found["noise"] = np.square(errors.taxels.sd.take(taxels))
    elif errors.noise**2 > (1 + 1e-9) * step:
        found["noise"] = np.full(count, errors.noise**2 - step)
    drift = effects.offset_drift
    if drift is not None:
        found["offset_drift"] = np.full(count, drift.sd**2 + drift.walk**2 * errors.elapsed)
    if effects.threshold is not None:
        felt = pressures != 0
        found = {name: variances * felt for name, variances in found.items()}
    if step:
        reached = bool(found) and effects.threshold is None
        found["quantisation"] = np.full(count, step) if reached else step * (pressures != 0)
    if errors.gain:
        found["gain_spread"] = errors.gain**2 * np.square(pressures)
    return found


def propagate_uncertainty(
    errors: SensorUncertainty,
    readings: Readings,
    squared: FloatArray,
    *,
    motion: Motion | None = None,
) -> Uncertainty:
    """Return the standard uncertainties; see the module.

    Args:
        errors: Uncertainty of the readings.
        readings: Readings of the contact.
        squared: (k,) squared distances from the centre [m²].
        motion: Change of the contact, where readings are old enough for it to count.

    Cost: 15 µs, and 5 µs for each effect.
    """
    forces, areas, effects = readings.forces, readings.areas, errors.effects
    total, square = float(forces.sum()), dot(forces, forces)
    effective = max(total * total / square, 1.0)
    parts: dict[str, float] = {}
    white = 0.0
    place = 2 * errors.calibration**2 * square
    for name, variances in reading_variances(errors, forces / areas, readings.taxels).items():
        loads = variances * areas * areas
        parts[name] = math.sqrt(float(loads.sum()))
        place += dot(loads, squared)
        if name in _WHITE:
            white += dot(loads, squared) / total**2
    shared, shift = _systematic(errors, readings, squared, effective)
    parts |= shared
    if errors.model:
        parts["contact_model"] = errors.model * total
    place += shift
    moved = 0.0
    if motion is not None:
        noise = sum(parts.get(name, 0.0) ** 2 for name in _WHITE)
        parts["sampling"] = errors.lag * math.sqrt(max(motion.rate**2 - _OF_NOISE * noise / motion.period**2, 0.0))
        moved = errors.lag**2 * max(dot(motion.velocity, motion.velocity) - _OF_NOISE * white / motion.period**2, 0.0)
    area = dot(forces, areas) / total
    if effects.area_averaging is not None:
        inner = 0.09 * effective**-1.5 * area
    else:
        spread = effective * (1 - effects.crosstalk.share) ** 2 if effects.crosstalk else effective
        inner = area / 6 * (0.7 * math.exp(-1.5 * (spread - 1)) + 0.15 * spread**-3 + 0.045 / spread)
    place = place / total**2 + max(inner, 0.0) + moved
    return Uncertainty(math.sqrt(place), math.hypot(*parts.values()), parts)


def _systematic(
    errors: SensorUncertainty, readings: Readings, squared: FloatArray, effective: float
) -> tuple[dict[str, float], float]:
    """Return the parts [N] that the taxels of a contact share, and their variance of force times place [N² m²]."""
    effects = errors.effects
    forces, areas, inside = readings.forces, readings.areas, readings.inside
    touched, count, total = forces.take(inside), len(inside), float(forces.sum())
    place = 0.0
    parts: dict[str, float] = {}
    ring = total - float(touched.sum())
    if effects.area_averaging is not None:
        radius = effects.area_averaging.radius
        widest = 0.0 if errors.lumps else _WIDEST
        parts["area_averaging"] = total * _between_pads(radius, effective, float(areas.mean()), widest)
    if effects.crosstalk is not None:
        share = effects.crosstalk.share
        given = share / (1 - share) * float(touched.sum())
        ring -= given / math.sqrt(count)
        unknown = 0.1 * given if count > 1 else 0.0
        parts["crosstalk"] = 0.4 * share * math.hypot(max(ring, 0.0), unknown)
    if effects.hysteresis is not None:
        late = effects.hysteresis.share
        parts["hysteresis"] = late * total * math.sqrt(1 / 6 + 2 / 9 * late + late**2 / 4)
    pressures = touched / areas.take(inside)
    if effects.saturation is not None:
        step = effects.quantisation.step if effects.quantisation else 0.0
        limit = effects.saturation.at
        full = pressures >= limit - step
        share = float(full.sum()) / (0.5 * (count + float(full.sum()) + 1))
        area = float(areas.take(inside)[full].sum())
        parts["saturation"] = math.sqrt(2) * area * limit * share / (2 * (1 - share))
        if full.any():
            place += parts["saturation"] ** 2 * float(squared.take(inside)[full].mean() / full.sum())
    if effects.threshold is not None:
        limit = effects.threshold.at
        dark = len(forces) - int(np.count_nonzero(forces))
        lost = 2 * math.pi * (count / math.pi) ** 0.75 * math.sqrt(limit / max(float(pressures.max()), limit))
        lost = min(lost, dark)
        parts["threshold"] = limit * float(areas.mean()) * math.sqrt(lost**2 / 9 + lost / 5)
        place += lost / 5 * (limit * float(areas.mean())) ** 2 * float(squared.mean())
    if effects.dead_taxels is not None:
        parts["dead_taxels"] = _broken(effects.dead_taxels, total, dot(forces, forces), areas)
        place += effects.dead_taxels.dead * dot(forces * forces, squared)
    if ring > 0:
        parts["ring"] = ring**3 / total**2
    return parts, place


def _between_pads(radius: float, effective: float, area: float, widest: float) -> float:
    """Return the relative standard uncertainty of a force that pads sample."""
    share = math.pi * radius**2 / area
    sampled = math.hypot(0.29 * effective**-1.25 * math.exp(-1.8 * share), 0.24 / effective)
    if effective < 1.1:
        wide = min(widest**2 * math.sqrt(0.75) / area, 1.0)
        return max(sampled, min(1 - wide * (0.42 - 0.17 * wide), 1 - share))
    return max(sampled, 0.3) if effective < 2 else sampled


def _broken(taxels: DeadTaxels, total: float, square: float, areas: FloatArray) -> float:
    stuck = taxels.stuck_at * areas
    variance = taxels.dead * square + (taxels.dead * total) ** 2
    return math.sqrt(variance + taxels.stuck * (dot(stuck, stuck) + square))
