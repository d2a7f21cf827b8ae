"""Standard uncertainties of a contact's force and place, with the named parts that they are made of.

Independent errors of the taxels propagate by the first derivatives (JCGM 100:2008, Guide to the Expression of
Uncertainty in Measurement, 5.1.2). Systematic errors of the whole contact are added in quadrature, a known bias with
its full size (F.2.4.5 there), because the force stays the plain sum of pressure times area. With pressures p_i, areas
a_i, forces f_i = p_i a_i, F = sum f_i, shares w_i = f_i / F, distances d_i from the centre, mean area a,
effective number of taxels n = F² / sum f_i² and n_t touched taxels with the area A, the parts of the force are:

    noise, quantisation, offset drift    sd² sum a_i², with step / sqrt(12) and (sd² + walk² t)^½
    gain spread                          gain² sum f_i²
    hysteresis                           0.42 share F / (1 - 0.84 share): a load held for up to three time constants
    area averaging                       F (0.29² n^-2.5 exp(-3.6 u) + 7 s² / a n^-2)^½ with the pad's share u of the
                                         area and its displacement s, at least (1 - u) / 2 F for n < 2 and k F for
                                         n < 1.1
    crosstalk                            0.27 share (r² + (0.1 g)²)^½: what the ring's own force r gives beyond it
    threshold                            (m² / 9 + m / 5)^½ at a, m = 2 pi (n_t / pi)^¾ (at / peak)^½ taxels of the rim
    saturation                           2 at A_s min(c / a, 1) with the area A_s of the saturated taxels
    dead taxels                          sum of the deviations of their estimated forces (``filled_readings``); where
                                         broken taxels are unknown (dead sum f_i² + dead² F²)^½, for stuck ones the same
                                         with their own force
    sampling, time averaging             lag |dF / dt|, the largest of the last samples
    ring                                 r³ / F²: the force beyond the ring
    contact model                        0.023 F for foundation, whose taxels read along their own normals; infinite for
                                         depth, whose readings are penetration: their sum is not a force

Errors that are not normally distributed are stated as half of what 95 % of their sizes stay within (JCGM 101:2008,
7.7), so that twice the stated uncertainty is a coverage interval of 95 %. Within it once may then be more or fewer than
68 %. Such errors are those of hysteresis, area averaging, crosstalk, saturation and of the contact model.

Parts that only make the reading smaller (hysteresis, threshold, saturation, crosstalk, ring, contact model) have errors
e of the same sign: u² = sum u_i² + 2 * 0.6 sum u_i u_j over pairs i < j of these, since E(e) / E(e²)^½ is 0.78 for
hysteresis, 0.8 for the foundation and 0.6 to 1 for the others. All other parts are independent.

A load that is held for t, evenly distributed up to three time constants, lacks share exp(-t) of itself; 94 % are held
for more than 0.18 time constants, exp(-0.18) = 0.84, and 72 % for more than 0.83.

Pressure falls to zero at the rim of a contact with a slope of 2 peak / radius (a ball on springs). A taxel of pitch h
that reaches x < h into the contact reads slope x² / 2 h, so those with x < (2 h at / slope)^½ are below the threshold
and lose a third of it in the mean, a fifth of its square.

Saturated taxels only bound the force from below. 95 % of the saturated touches of the development set lose less than
4 at A_s. A taxel that is wider than the contact loses less, as the mean of its pressure is at most peak c / a, where
c = pi / 8 (16 mm)² is the area of the widest expected contact times its mean pressure over its peak.

The ring's own force r is what the touched taxels do not give to it by crosstalk. One touched taxel gives
g = share F / (1 - share) for a reading F, all of it to the ring; n_t of them give g / n_t^½, known to a tenth of g. Of
the neighbours of a ring taxel, a third are beyond the ring where it borders two touched taxels, half where it borders
one; 95 % have up to 0.54, half of which is 0.27. The ring is reached by the rim of a contact rather than by a tail, so
that beyond it is less than the ratio q = r / F again: F q q². With half-space, less than twice as much is beyond for
98 % of touches on the arm and for 93 % on a flat irregular skin.

Pads sample the pressure on a lattice. By Poisson's summation formula the error of the sum is the spectrum of the
pressure at the reciprocal lattice, 4 pi / (3^½ h) for six vectors of a hexagonal one (Petersen and Middleton 1962),
times that of the pad, 2 J_1(x) / x ≈ exp(-x² / 8). A paraboloid of radius R has F 8 J_2(x) / x², x = G R, whose root
mean square over places is 11 x^-2.5 F, and n a = 3/4 pi R²: 0.27 n^-1.25, with the next vectors 0.29. A pad that is
displaced by s from the centroid of its cell adds s times the gradient, (9 pi / 4)^½ s / (a^½ n) in all. s² is the
squared distance of pad and taxel, which is known, and 0.07² a: 0.05² a for the cells (three skins have 0.04 to
0.06 a^½) and as much for the few quadrature points of a pad; where pads are unknown, s is 0.09 a^½. Of one or two
pads, n < 2, 95 % of the development set are within (1 - u) F.

One pad alone says little: of contacts anywhere within its reach, whose radius is anything up to half of min(h, 16 mm),
P(F / reading < x) = 1 - 0.27 v / x, v = min((16 mm / h)², 1). 92.5 % are below 3.6 v, and 95 % of the development set:
k = (3.6 v - 1) / 2. Narrow contacts, whose force is less than the reading, are at most F off, and 68 % are less than
k = 1 - 0.42 v + 0.17 v² off (a fit within 0.01), which counts where it is larger. A pad that holds the whole contact,
and so any load of ``point``, reads 1 / u times too much.

Taxels at a depth d below the surface (``half-space``) read a contact between the pads by its tails, which fall like
d³ / r⁵ (Boussinesq), and the force is several times the reading. 95 % of the development set are within
0.06 (a / d² - 15), at least the reading, for n < 1.1 and 0.16 (a / d² - 6) for n < 5 times the reading.

The development set are 500 to 2,500 touches of each of eight skins with pitches of 5 to 23 mm, with the distributions
of the tests but other seeds.

The place has the independent errors with d_i² / F² in every term, 2 calibration² sum w_i² for misplaced taxels, the
speed of the contact times the lag, and the position within a taxel's area:

    cells    a / 6 (0.7 exp(-1.5 (n - 1)) + 0.15 n^-3 + 0.045 / n): a lump anywhere in one square is about a / 6, a
             wide contact less
    pads     v a / 8 n^-2, at depth d at least 0.22 exp(-0.75 n) a min(max((a / d² - 6) / 12, 0), 1), and sum w_i² s_i²
             for pads that are displaced by s_i from the taxels' places

Of cells, these are root mean squares over round contacts of all sizes (paraboloids of pressure with radii of
0.03 to 2.5 pitches) on a hexagonal lattice whose taxels are displaced by 0 to 15 % of the pitch; of pads, they are
measured by the development set.

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
_LATE = math.exp(-0.18)
"""Share of the late part that is missing of a load held for 0.18 time constants; 94 % of loads are held longer."""
_ONE_SIDED = ("hysteresis", "threshold", "saturation", "crosstalk", "ring", "contact_model")
"""Parts whose true error makes the reading smaller."""
_ALIKE = 0.6
"""Mean product of two errors that have the same sign, per product of their uncertainties."""
_OF_NOISE = 2 * _SMOOTHING**2 / (2 - _SMOOTHING)
"""Variance of a rate that is due to noise, per variance of the noise over the squared period."""


_HELD = 0.6
"""Share of a squared rate that counts after one more sample: where a force turns, its rate is zero but not its change
within the age of a reading."""
_HELD_NOISE = 1.45 * _OF_NOISE
"""As ``_OF_NOISE``, of the squared rate that is held (mean of a simulation)."""


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
        estimated: (k,) standard uncertainties of the forces on broken taxels, which are estimated, 0 for others [N];
            None where broken taxels are unknown.
    """

    forces: FloatArray
    areas: FloatArray
    taxels: IntArray
    inside: IntArray
    estimated: FloatArray | None = None


class Motion(NamedTuple):
    """How force and place of a contact change from sample to sample, for the age of a reading.

    Attributes:
        time: Of the last sample [s].
        samples: Number of samples.
        period: Since the sample before [s].
        force: At the last sample [N].
        position: (3,) at the last sample, link frame [m].
        rate: Change of the force [N/s].
        fastest: Square of the fastest recent change [N²/s²], reduced by ``_HELD`` with each sample.
        velocity: (3,) [m/s], link frame.
    """

    time: float
    samples: int
    period: float
    force: float
    position: FloatArray
    rate: float
    fastest: float
    velocity: FloatArray

    @classmethod
    def begin(cls, time: float, force: float, position: FloatArray, lag: float) -> Motion:
        """Return the motion of a contact that began within the last ``lag`` [s]."""
        return cls(time, 1, lag, force, position, force / lag, (force / lag) ** 2, np.zeros(3))

    def next(self, time: float, force: float, position: FloatArray) -> Motion:
        """Return the motion with one more sample."""
        weight = max(_SMOOTHING, 1 / self.samples)
        period = time - self.time
        rate = self.rate + weight * ((force - self.force) / period - self.rate)
        held = _HELD * self.fastest if self.samples > 1 else 0.0
        fastest = max(rate * rate, held)
        velocity = self.velocity + weight * ((position - self.position) / period - self.velocity)
        return Motion(time, self.samples + 1, period, force, position, rate, fastest, velocity)


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
        parts["sampling"] = errors.lag * math.sqrt(max(motion.fastest - _HELD_NOISE * noise / motion.period**2, 0.0))
        moved = errors.lag**2 * max(dot(motion.velocity, motion.velocity) - _OF_NOISE * white / motion.period**2, 0.0)
    area = dot(forces, areas) / total
    if effects.area_averaging is not None:
        inner = area * _within_pads(errors, effective, area)
        if errors.displaced is not None:
            place += dot(forces * forces, errors.displaced.take(readings.taxels))
    else:
        spread = effective * (1 - effects.crosstalk.share) ** 2 if effects.crosstalk else effective
        inner = area / 6 * (0.7 * math.exp(-1.5 * (spread - 1)) + 0.15 * spread**-3 + 0.045 / spread)
    place = place / total**2 + max(inner, 0.0) + moved
    return Uncertainty(math.sqrt(place), combine_parts(parts), parts)


def combine_parts(parts: Mapping[str, float]) -> float:
    """Return the uncertainty of a force from its parts [N]; see the module."""
    one_sided = [parts[name] for name in _ONE_SIDED if name in parts]
    independent = math.hypot(*parts.values())
    if not math.isfinite(independent):
        return independent
    alike = sum(one_sided) ** 2 - sum(part * part for part in one_sided)
    return math.sqrt(independent**2 + _ALIKE * max(alike, 0.0))


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
        displaced = 0.09**2 * float(areas.mean())
        if errors.displaced is not None:
            displaced = 0.07**2 * float(areas.mean()) + dot(forces, errors.displaced.take(readings.taxels)) / total
        parts["area_averaging"] = total * _between_pads(errors, effective, float(areas.mean()), displaced)
    if effects.crosstalk is not None:
        share = effects.crosstalk.share
        given = share / (1 - share) * float(touched.sum())
        ring -= given / math.sqrt(count)
        unknown = 0.1 * given if count > 1 else 0.0
        parts["crosstalk"] = 0.27 * share * math.hypot(max(ring, 0.0), unknown)
    if effects.hysteresis is not None:
        late = effects.hysteresis.share
        parts["hysteresis"] = 0.5 * total * _LATE * late / (1 - _LATE * late)
    pressures = touched / areas.take(inside)
    if effects.saturation is not None:
        step = effects.quantisation.step if effects.quantisation else 0.0
        limit = effects.saturation.at
        full = pressures >= limit - step
        area = float(areas.take(inside)[full].sum())
        parts["saturation"] = 2 * area * limit * _peak_share(errors, float(areas.mean()))
        if full.any():
            place += parts["saturation"] ** 2 * float(squared.take(inside)[full].mean() / full.sum())
    if effects.threshold is not None:
        limit = effects.threshold.at
        dark = len(forces) - int(np.count_nonzero(forces))
        lost = 2 * math.pi * (count / math.pi) ** 0.75 * math.sqrt(limit / max(float(pressures.max()), limit))
        lost = min(lost, dark)
        parts["threshold"] = limit * float(areas.mean()) * math.sqrt(lost**2 / 9 + lost / 5)
        place += lost / 5 * (limit * float(areas.mean())) ** 2 * float(squared.mean())
    if readings.estimated is not None:
        parts |= _estimated(readings.estimated)
        place += dot(readings.estimated**2, squared)
    elif effects.dead_taxels is not None:
        parts["dead_taxels"] = _broken(effects.dead_taxels, total, dot(forces, forces), areas)
        place += effects.dead_taxels.dead * dot(forces * forces, squared)
    if ring > 0:
        parts["ring"] = ring**3 / total**2
    return parts, place


def _between_pads(errors: SensorUncertainty, effective: float, area: float, displaced: float) -> float:
    """Return the relative standard uncertainty of a force that pads with squared displacement [m²] sample."""
    assert errors.effects.area_averaging is not None
    share = math.pi * errors.effects.area_averaging.radius**2 / area
    sampled = math.hypot(0.29 * effective**-1.25 * math.exp(-1.8 * share), math.sqrt(7 * displaced / area) / effective)
    depths = area / errors.depth**2 if errors.depth else 0.0
    if effective < 1.1 and depths:
        return max(sampled, 0.03 * (depths - 15), min(0.5, 1 - share))
    if effective < 1.1:
        wide = 0.0 if errors.lumps else _width(area)
        return max(sampled, 0.5 * (3.6 * wide - 1), min(1 - wide * (0.42 - 0.17 * wide), 1 - share))
    tails = 0.08 * (depths - 6) if effective < 5 else 0.0
    return max(sampled, tails, 0.5 * (1 - share) if effective < 2 else 0.0)


def _within_pads(errors: SensorUncertainty, effective: float, area: float) -> float:
    """Return the variance of the place of a contact that pads feel, in areas of a taxel."""
    wide = 1.0 if errors.lumps else _width(area)
    depths = area / errors.depth**2 if errors.depth else 0.0
    tails = 0.22 * math.exp(-0.75 * effective) * min(max((depths - 6) / 12, 0.0), 1.0)
    return max(wide / 8 * effective**-2, tails)


def _peak_share(errors: SensorUncertainty, area: float) -> float:
    """Return the largest mean pressure of a taxel of this area [m²] over the peak of a contact."""
    return 1.0 if errors.lumps else min(math.pi / 8 * _WIDEST**2 / area, 1.0)


def _width(area: float) -> float:
    """Return the squared width of the widest expected contact over that of a taxel of this area [m²], at most 1."""
    return min(_WIDEST**2 * math.sqrt(0.75) / area, 1.0)


def _estimated(deviations: FloatArray) -> dict[str, float]:
    """Return the part of broken taxels whose forces are estimated; empty where a contact has none."""
    size = float(deviations.sum())  # neighbouring estimates err together
    return {"dead_taxels": size} if size > 0 else {}


def _broken(taxels: DeadTaxels, total: float, square: float, areas: FloatArray) -> float:
    stuck = taxels.stuck_at * areas
    variance = taxels.dead * square + (taxels.dead * total) ** 2
    return math.sqrt(variance + taxels.stuck * (dot(stuck, stuck) + square))
