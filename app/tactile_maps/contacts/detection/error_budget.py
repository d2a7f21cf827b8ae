"""Standard uncertainties and 95 % intervals of a contact's force, with the named parts that they are made of, and the
standard uncertainty of its place.

Independent errors of the taxels propagate by the first derivatives (JCGM 100:2008, Guide to the Expression of
Uncertainty in Measurement, 5.1.2). Systematic errors of the whole contact are added in quadrature, a known bias with
its full size (F.2.4.5 there), because the force stays the plain sum of pressure times area. Most systematic errors are
not normally distributed: bounded, one-sided or with a long tail. Each part therefore has two half-widths, within which
68 % and 95 % of its errors are (JCGM 101:2008, 7.7). The first of all parts together is the standard uncertainty of the
force, the second gives the interval of 95 %. With pressures p_i, areas a_i, forces f_i = p_i a_i, F = sum f_i, shares
w_i = f_i / F, distances d_i from the centre, mean area a, effective number of taxels n = F² / sum f_i², n_t touched
taxels, n_d dark ones and n_s saturated ones with the area A_s, taxels at the depth d below the surface where the
contact model is half-space, and the area A of all taxels, the half-widths of the force are:

    noise, offset drift, gain spread     1 and 2 (sd² sum a_i²)^½, ((sd² + walk² t) sum a_i²)^½, (gain² sum f_i²)^½
    quantisation                         1 + 0.18 m^-1.5 and 2 - 0.355 m^-2.4 times (m step² / 12)^½ a
    hysteresis                           x share F / (1 - x share), x = 0.39 and 0.88
    area averaging                       see below
    threshold                            0.41 m at a and 2 (m² / 9 + m / 5)^½ at a, for m dark taxels of the rim
    saturation                           0.88 + 0.28 n_s and 2.3 + 0.27 n_s times at A_s
    dead taxels                          1 and 4.5 times the sum of the deviations of their estimated forces
                                         (``filled_readings``); where broken taxels are unknown
                                         (dead sum f_i² + dead² F²)^½, for stuck ones with their own force
    sampling, time averaging             1 and 2 lag |dF / dt|, the largest of the last samples
    ring                                 0 and the force beyond the contact, see below
    contact model                        0.019 F and 0.044 F for foundation, whose taxels read along their own normals;
                                         infinite for depth, see below

Readings of depth are penetration at the taxels' places. Their sum depends on the size of the body and on its place
between the taxels, which the skin does not know: the true force is 2 to 20 times the reading on a skin with a pitch of
16 mm, 5 to 110 times with 11 mm and 20 to 270 times with 5 mm, and 3, 9 and 26 % of the touches are felt at all. No
width covers all skins, so that none is stated.

Parts that only make the reading smaller (hysteresis, threshold, saturation, ring, contact model) have errors e of the
same sign: u² = sum u_i² + 2 * 0.8 sum u_i u_j over pairs i < j of these: the mean product of two errors is 0.6 times
the product of their root mean squares (0.78 for hysteresis, 0.8 for the foundation), and 68 % of such errors are within
0.9 of these. All other parts are independent. Threshold, saturation and ring do not lower the interval. The others of
these do: hysteresis makes readings larger after a force has fallen, and the foundation reads more on concave skin.

A load that is held for t, evenly distributed up to three time constants, lacks share exp(-t) of itself: 68 % are held
for more than 0.95 time constants, 95 % for more than 0.13.

An evenly distributed error is within 1.18 deviations in 68 % and within 1.645 in 95 % of cases; sums of m of them are
nearly normal (1.06 and 1.90 for two).

A mean over a tick is as old as the middle of the tick, so its error is the rate of change times its age. The rate is
known from earlier samples: 68 % of forces that swing with 0.2 to 2 Hz and are read every 50 ms are within 1.2 of it.
The age of a sample is distributed as well, which covers that.

Pressure falls to zero at the rim of a contact with a slope of 2 peak / radius (a ball on springs). A taxel of pitch h
that reaches x < h into the contact reads slope x² / 2 h, so those with x < (2 h at / slope)^½ are below the threshold
and lose a third of it in the mean, a fifth of its square: m = 2 pi (n_t / pi)^¾ (at / peak)^½ taxels, at most n_d.
Taxels that are wider than contacts have fewer on the rim: m is at most 15 mm / a^½ (the development set). Three or more
touched taxels may be a wider contact, such as a line or a face: for these m is not bounded, and for 95 % not for two
either. At that bound, many contacts lose nothing and others up to the load of one taxel at the threshold: the factors
of at a are at most 0.5 m - 0.12 and at least 1.3 - 0.23 / m (13 skins with pitches of 9 to 43 mm).

Saturated taxels only bound the force from below, and what the saturation cuts off grows with their number. Of a
paraboloid with a peak of q times the limit they lose (q - 1) / 2 at A_s, and n_s grows with q. A taxel that is wider
than the widest expected contact (16 mm) loses less, by the ratio of the areas. One that bears a force as a point
(``point``) loses 1.4 times as much.

Crosstalk has no part: the force that it passes beyond the ring is known and added (``ContactDetector``).

Pressed taxels that are connected to the ring are part of the contact. What is left out is next to it: taxels that read
less than noise, drift, creep and sensor threshold (``unpressed_readings``), at most as much on each taxel of the row
around the contact (``LeftOut.most``). Without these effects nothing is left out, tails of half-space stress included.

A contact is expected to have less beyond the ring. The ring's own force r is what the touched taxels do not give to it
by crosstalk. One touched taxel gives g = share F / (1 - share) for a reading F, all of it to the ring; n_t of them give
g / n_t^½. The ring is reached by the rim of a contact rather than by a tail, so that beyond it is at most the ratio
q = r / F again: F q q². Flat objects have more. Where the taxels of the row together read a force that noise does not
explain (``LeftOut.seen``), the part is at least that. A flat object on an inclined support presses with a pressure that
falls linearly from its peak, so that the share (level / peak)² of its force is on taxels that read less than
``LeftOut.level``: the part is at least that. With a peak of several times the level it is small.

With half-space, stress has tails: beyond a radius R passes s = (1 + R² / d²)^-1.5 of a point's force (Boussinesq), with
A = pi R². The model itself follows tails up to s = 0.01, so that beyond the contact are 0.5 and 1 times s / 0.01 s F.
Far tails fall like r^-5: beyond R is the share (1 + h / R)^-3 of it beyond the row of width h, which is less than a
quarter for R < 1.7 h (the touched taxels and their ring, R > 1.5 h), so that s / 0.01 s F is at most 4/3 of
``LeftOut.most``. Dark taxels around a contact each lose tails of 0.32 d / a^½ of the threshold, or of a step of the
converter (once for 68 %, twice for 95 %), by the development set.

Where the noise is not stated, it is estimated from the other taxels, with an offset that all of them read
(``unpressed_readings``). The offset times A is the part ``offset_drift``, with full size.

Pads sample the pressure on a lattice. By Poisson's summation formula the error of the sum is the spectrum of the
pressure at the reciprocal lattice, 4 pi / (3^½ h) for six vectors of a hexagonal one (Petersen and Middleton 1962),
times that of the pad, 2 J_1(x) / x ≈ exp(-x² / 8). A paraboloid of radius R has F 8 J_2(x) / x², x = G R, whose root
mean square over places is 11 x^-2.5 F, and n a = 3/4 pi R²: 0.27 n^-1.25, with the next vectors 0.29. A pad that is
displaced by s from the centroid of its cell adds s times the gradient, (9 pi / 4)^½ s / (a^½ n) in all. s² is the
squared distance of pad and taxel, which is known, and 0.07² a: 0.05² a for the cells (three skins have 0.04 to 0.06
a^½) and as much for the few quadrature points of a pad; where pads are unknown, s is 0.09 a^½. With the share u of a
pad in the area, the deviation is F (0.29² n^-2.5 exp(-3.6 u) + 7 s² / a n^-2)^½. Of one or two pads, n < 2, 95 % of the
development set are within (1 - u) F.

The pressure of a line or a face ends at an edge, so that its spectrum falls more slowly: 0.5 n^-0.75 instead of
0.29 n^-1.25 (boxes of 16 to 44 mm on four skins). Such a contact presses its pads more evenly: sum p_i² over the
largest p_i times sum p_i is 2/3 for a paraboloid, 4/5 for a parabolic line and 1 for a face, and the factor is
interpolated between the first two.

One pad alone says little: of contacts anywhere within its reach, whose radius is anything up to half of min(h, 16 mm),
P(F / reading < x) = 1 - 0.27 v / x, v = min((16 mm / h)², 1), so that 95 % are below 5.4 v. Narrow contacts, whose
force is less than the reading, are at most F off, and 68 % are less than 1 - 0.42 v + 0.17 v² off (a fit within 0.01).
A pad that holds the whole contact, and so any load of ``point``, reads 1 / u times too much.

Taxels at a depth d below the surface (``half-space``) read a contact between the pads by its tails, which fall like
d³ / r⁵ (Boussinesq), and the force is several times the reading. 95 % of the development set are within
0.066 (a / d² - 15), at least the reading, for n < 1.1 and 0.16 (a / d² - 6) for n < 5 times the reading; 68 % within
0.011 a / d², at most 0.75, and 0.00117 (a / d² - 6)².

The development set are 300 to 2,500 touches of each of eight skins with pitches of 5 to 23 mm, with the distributions
of the tests but other seeds.

The place has the independent errors with d_i² / F² in every term, 2 calibration² sum w_i² for misplaced taxels, the
speed of the contact times the lag, and the position within a taxel's area:

    cells    a / 6 (0.7 exp(-1.5 (n - 1)) + 0.15 n^-3 + 0.045 / n): a lump anywhere in one square is about a / 6, a
             wide contact less
    pads     v a / 8 n^-2, at depth d at least 0.22 exp(-0.75 n) a min(max((a / d² - 6) / 12, 0), 1), and sum w_i² s_i²
             for pads that are displaced by s_i from the taxels' places; at least a / 12 n^-½ for a face, whose edges
             are each anywhere in a pitch and differ from row to row, and a / 7 for a line

Of cells, these are root mean squares over round contacts of all sizes (paraboloids of pressure with radii of
0.03 to 2.5 pitches) on a hexagonal lattice whose taxels are displaced by 0 to 15 % of the pitch; of pads, they are
measured by the development set.

An edge loads a line of taxels, each at an unknown place across it: a / 24 n more, half of the variance of lumps at
random places across n taxels (lines of 10 to 70 mm on flat skins with pitches of 7 to 16 mm). A contact is a line if
its mean squared distance from the centre is twice that of a paraboloid, 4 n a / 9 pi, and in part from 1.3 times on;
round contacts have 0.7 to 1.25 times and faces up to 1.6.

``place`` is radial, the root of the two variances' sum. 63 % of normally distributed centres are within it and 98 %
within twice as much; of lumps anywhere in a taxel 52 % and 100 %.

Not included: errors that all taxels of a module share (a patch put on askew), and curvature.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from tactile_maps.contacts.detection.centre_of_pressure import SensorUncertainty
from tactile_maps.contacts.detection.filled_readings import LIMIT
from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, dot
from tactile_maps.tactile.mechanics.half_space_stress import TAIL_SHARE
from tactile_maps.tactile.sensors.sensor_effects import DeadTaxels

INDEPENDENT = ("noise", "quantisation", "offset_drift", "gain_spread")
"""Parts that are independent between taxels, so that an estimator propagates them."""
_WHITE = ("noise", "quantisation")
_SMOOTHING = 0.6
"""Weight of the newest sample in the rates of change."""
_WIDEST = 0.016
"""Diameter of the widest contact that a single pad is expected to feel [m], as of a fingertip or a ball on a cover."""
_USUALLY_LATE = 0.39
_LATE = 0.88
"""Shares of the late part that loads lack, at most 68 % and 95 % of them; see the module."""
_MODEL_LIMIT = 2.3
"""Limit of the contact model's error per standard uncertainty."""
_TURNING = 1.2
"""Change of a force within a tick, per change at the rate that earlier samples show; see the module."""
_RIM = 0.015
"""Length of the rim of the widest contact that is expected on taxels that are wider than it [m]."""
_WIDER = 3, 2
"""Numbers of touched taxels from which on a contact may be wider than expected, for 68 % and 95 %."""
_ONE_SIDED = ("hysteresis", "threshold", "saturation", "ring", "contact_model")
"""Parts whose true error makes the reading smaller."""
_LOSSES = ("threshold", "saturation", "ring")
"""Parts that never make the reading larger, so that they do not lower the interval."""
_ROUND = 4 / (9 * math.pi)
"""Mean squared distance from the centre of a paraboloid of pressure, per effective number of taxels and area."""
_LONG = 1.3, 2.0
"""Multiples of that above which a contact is in part, and as a whole, counted as a line."""
_ROUND_EVEN = 2 / 3
_LINE_EVEN = 4 / 5
"""Mean pressure, weighted by itself, over the largest, of a paraboloid and of a parabolic line; 1 for an even face."""
_ALIKE = 0.8
"""Mean product of two errors that have the same sign, per product of their uncertainties."""
_FURTHER = 4 / 3
"""Force of a tail beyond a contact, per force on the row of taxels around the contact; see the module."""
_OF_NOISE = 2 * _SMOOTHING**2 / (2 - _SMOOTHING)
"""Variance of a rate that is due to noise, per variance of the noise over the squared period."""


_HELD = 0.6
"""Share of a squared rate that counts after one more sample: where a force turns, its rate is zero but not its change
within the age of a reading."""
_HELD_NOISE = 1.45 * _OF_NOISE
"""The same for the squared rate that is held (mean of a simulation)."""


class Uncertainty(NamedTuple):
    """Standard uncertainties of one contact.

    Attributes:
        place: Radial uncertainty of the centre [m].
        force: Half-width of the interval that contains the true force in 68 % of contacts [N].
        parts: Parts of ``force`` [N] by effect of the sensor, ``ring`` or ``contact_model``.
        limits: Half-widths of the same parts that cover 95 % of contacts [N].
    """

    place: float
    force: float
    parts: Mapping[str, float]
    limits: Mapping[str, float]


class Widths(NamedTuple):
    """Half-widths of the intervals that hold an error for 68 % and 95 % of contacts."""

    standard: float
    limit: float

    @classmethod
    def normal(cls, deviation: float) -> Widths:
        """Return the widths of a normally distributed error."""
        return cls(deviation, 2 * deviation)


class LeftOut(NamedTuple):
    """Force on the row of taxels around a contact, which are no part of it, and what all taxels read in excess.

    Attributes:
        most: Force that would be noticed on each of them [N]; infinite where none is.
        seen: Force that they read together [N]; 0 if it may be noise.
        level: Reading that would be noticed [Pa]; 0 where none is known.
        offset: Reading without pressure [Pa], where the noise is not stated.
    """

    most: float = math.inf
    seen: float = 0.0
    level: float = 0.0
    offset: float = 0.0


class Readings(NamedTuple):
    """Readings of the taxels of one contact.

    Attributes:
        forces: (k,) [N], of sum > 0.
        areas: (k,) [m²].
        taxels: (k,) their numbers.
        inside: (c,) indices of the touched ones.
        left_out: Force next to the contact.
        estimated: (k,) standard uncertainties of the forces on broken taxels, which are estimated, 0 for others [N];
            None where broken taxels are unknown.
    """

    forces: FloatArray
    areas: FloatArray
    taxels: IntArray
    inside: IntArray
    left_out: LeftOut = LeftOut()
    estimated: FloatArray | None = None


class Motion(NamedTuple):
    """Rates of change of force and place of a contact, for the age of a reading.

    Attributes:
        time: Time of the last sample [s].
        samples: Number of samples.
        period: Time since the sample before [s].
        force: Force at the last sample [N].
        position: (3,) position at the last sample, link frame [m].
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
    effects = errors.effects
    count = len(pressures)
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
    forces = readings.forces
    areas = readings.areas
    effects = errors.effects
    total = float(forces.sum())
    square = dot(forces, forces)
    effective = max(total * total / square, 1.0)
    widths: dict[str, Widths] = {}
    place = 2 * errors.calibration**2 * square
    place, noise, shaken = _add_independent(widths, errors, readings, squared, place)
    place += _add_systematic(widths, errors, readings, squared, effective)
    if errors.model:
        widths["contact_model"] = Widths(errors.model * total, _MODEL_LIMIT * errors.model * total)
    moved = 0.0
    if motion is not None:
        rate = math.sqrt(max(motion.fastest - _HELD_NOISE * noise / motion.period**2, 0.0))
        turning = 1.0 if effects.sampling else _TURNING
        widths["sampling"] = Widths(turning * errors.lag * rate, 2 * errors.lag * rate)
        moved = errors.lag**2 * max(dot(motion.velocity, motion.velocity) - _OF_NOISE * shaken / motion.period**2, 0.0)
    area = dot(forces, areas) / total
    wide = dot(forces, squared) / (total * _ROUND * effective * area)
    long = min(max((wide - _LONG[0]) / (_LONG[1] - _LONG[0]), 0.0), 1.0)
    if effects.area_averaging is not None:
        inner = _within_pads(errors, effective, area, _edged(readings), long)
        if errors.displaced is not None:
            place += dot(forces * forces, errors.displaced.take(readings.taxels))
    else:
        inner = _within_cells(errors, effective, long)
    place = place / total**2 + inner * area + moved
    parts = {name: width.standard for name, width in widths.items()}
    limits = {name: width.limit for name, width in widths.items()}
    return Uncertainty(math.sqrt(place), combine_parts(parts), parts, limits)


def _add_independent(
    widths: dict[str, Widths], errors: SensorUncertainty, readings: Readings, squared: FloatArray, place: float
) -> tuple[float, float, float]:
    """Add the independent errors of the taxels of a contact to ``widths``.

    Returns:
        ``place`` with their variance of force times place [N² m²]; and of the errors that differ from sample to sample,
        the variances of force [N²] and place [m²].
    """
    forces = readings.forces
    areas = readings.areas
    total = float(forces.sum())
    noise = 0.0
    shaken = 0.0
    for name, variances in reading_variances(errors, forces / areas, readings.taxels).items():
        loads = variances * areas * areas
        variance = float(loads.sum())
        moment = dot(loads, squared)
        widths[name] = Widths.normal(math.sqrt(variance))
        place += moment
        if name == "quantisation" and variance > 0:
            widths[name] = _evenly_distributed(variance, variance**2 / dot(loads, loads))
        if name in _WHITE:
            noise += variance
            shaken += moment / total**2
    return place, noise, shaken


def coverage_interval(force: float, limits: Mapping[str, float]) -> tuple[float, float]:
    """Return the lowest and highest force [N] of the interval of 95 %; see the module.

    Args:
        force: Sum of pressure times area, or what an estimator finds [N].
        limits: Half-widths of its parts [N].
    """
    below = {name: limit for name, limit in limits.items() if name not in _LOSSES}
    return max(force - combine_parts(below), 0.0), force + combine_parts(limits)


def combine_parts(parts: Mapping[str, float]) -> float:
    """Return the half-width of a force's interval from those of its parts [N]; see the module."""
    one_sided = [parts[name] for name in _ONE_SIDED if name in parts]
    independent = math.hypot(*parts.values())
    if not math.isfinite(independent):
        return independent
    alike = sum(one_sided) ** 2 - sum(part * part for part in one_sided)
    return math.sqrt(independent**2 + _ALIKE * max(alike, 0.0))


def _evenly_distributed(variance: float, count: float) -> Widths:
    """Return the widths of a sum of ``count`` errors that are each evenly distributed, with this variance in all."""
    deviation = math.sqrt(variance)
    return Widths((1 + 0.18 * count**-1.5) * deviation, (2 - 0.355 * count**-2.4) * deviation)


def _saturation(errors: SensorUncertainty, readings: Readings, limit: float) -> tuple[BoolArray, Widths]:
    """Return which touched taxels are saturated at ``limit`` [Pa], and the widths of the force that they cut off."""
    step = errors.effects.quantisation.step if errors.effects.quantisation else 0.0
    areas = readings.areas.take(readings.inside)
    full = readings.forces.take(readings.inside) / areas >= limit - step
    number = int(np.count_nonzero(full))
    cut = limit * float(areas[full].sum()) * _peak_share(errors, float(readings.areas.mean()))
    return full, Widths((0.88 + 0.28 * number) * cut, (2.3 + 0.27 * number) * cut)


def _threshold(limit: float, pressures: FloatArray, dark: int, area: float) -> tuple[float, Widths]:
    """Return the number of taxels that a threshold hides on the rim of a contact as wide as expected, and the losses.

    Args:
        limit: Threshold of the sensor [Pa].
        pressures: (k,) pressures of the touched taxels [Pa].
        dark: Number of taxels of the contact that read nothing.
        area: Mean area of a taxel [m²].

    Returns:
        The number, and the widths of the loss in loads of a taxel at the threshold.
    """
    count = len(pressures)
    wide = _RIM / math.sqrt(area)
    whole = min(_rim_taxels(count, limit / max(float(pressures.max()), limit)), dark)
    rim = min(whole, wide)
    usual, most = _rim_losses(rim, wide)
    wider = _rim_losses(whole, math.inf)
    if count >= _WIDER[0]:
        usual = wider.standard
    if count >= _WIDER[1]:
        most = max(most, wider.limit)
    return rim, Widths(usual, most)


def _rim_taxels(count: int, share: float) -> float:
    """Return the number of taxels below the threshold around a contact of ``count`` taxels.

    Args:
        count: Touched taxels.
        share: Threshold as a share of the largest pressure.
    """
    return 2 * math.pi * (count / math.pi) ** 0.75 * math.sqrt(share)


def _rim_losses(rim: float, wide: float) -> Widths:
    """Return the widths of what contacts with ``rim`` dark taxels on the rim lose, in loads at the threshold.

    Args:
        rim: Number of these taxels.
        wide: Their number where taxels are wider than contacts.
    """
    usual = 0.41 * rim
    most = 2 * math.sqrt(rim**2 / 9 + rim / 5)
    return (
        Widths(min(usual, max(0.5 * rim - 0.12, 0.0)), max(most, 1.3 - 0.23 / rim))
        if rim == wide
        else Widths(usual, most)
    )


def _add_systematic(
    widths: dict[str, Widths], errors: SensorUncertainty, readings: Readings, squared: FloatArray, effective: float
) -> float:
    """Add what the taxels of a contact share to ``widths``; return its variance of force times place [N² m²]."""
    effects = errors.effects
    forces = readings.forces
    areas = readings.areas
    inside = readings.inside
    touched = forces.take(inside)
    count = len(inside)
    total = float(forces.sum())
    area = float(areas.mean())
    dark = len(forces) - int(np.count_nonzero(forces))
    tails = 0.32 * dark * errors.depth * math.sqrt(area)
    place = 0.0
    ring = total - float(touched.sum())
    if effects.area_averaging is not None:
        displaced = 0.09**2 * area
        if errors.displaced is not None:
            displaced = 0.07**2 * area + dot(forces, errors.displaced.take(readings.taxels)) / total
        between = _between_pads(errors, effective, area, displaced, _edged(readings))
        widths["area_averaging"] = Widths(total * between.standard, total * between.limit)
    if effects.crosstalk is not None:
        share = effects.crosstalk.share
        given = share / (1 - share) * float(touched.sum())
        ring -= given / math.sqrt(count)
    if effects.hysteresis is not None:
        late = effects.hysteresis.share
        widths["hysteresis"] = Widths(*(total * held * late / (1 - held * late) for held in (_USUALLY_LATE, _LATE)))
    pressures = touched / areas.take(inside)
    if effects.saturation is not None:
        full, widths["saturation"] = _saturation(errors, readings, effects.saturation.at)
        if full.any():
            place += widths["saturation"].standard ** 2 * float(squared.take(inside)[full].mean() / full.sum())
    if effects.threshold is not None:
        limit = effects.threshold.at
        rim, (usual, most) = _threshold(limit, pressures, dark, area)
        widths["threshold"] = Widths(limit * (usual * area + tails), limit * (most * area + tails))
        place += rim / 5 * (limit * area) ** 2 * float(squared.mean())
    if readings.estimated is not None:
        broken = float(readings.estimated.sum())  # neighbouring estimates err together
        if broken > 0:
            widths["dead_taxels"] = Widths(broken, LIMIT * broken)
        place += dot(readings.estimated**2, squared)
    elif effects.dead_taxels is not None:
        widths["dead_taxels"] = Widths.normal(_broken(effects.dead_taxels, total, dot(forces, forces), areas))
        place += effects.dead_taxels.dead * dot(forces * forces, squared)
    rounded = tails * effects.quantisation.step if effects.quantisation and not effects.threshold else 0.0
    tail = (1 + float(areas.sum()) / (math.pi * errors.depth**2)) ** -1.5 if errors.depth else 0.0
    most, seen, level, offset = readings.left_out
    outside = min(min(tail / TAIL_SHARE, 1.0) * tail * total, _FURTHER * most)
    rim = min(max(ring, 0.0) ** 3 / total**2, most)
    inclined = 0.0 if effects.threshold else total * min(level / float(pressures.max()), 1.0) ** 2
    beyond = max(math.hypot(rim, outside, 2 * rounded), seen, inclined)
    if offset:
        excess = offset * float(areas.sum())
        widths["offset_drift"] = Widths(excess, excess)
    if beyond > 0:
        widths["ring"] = Widths(math.hypot(0.5 * outside, rounded), beyond)
    return place


def _edged(readings: Readings) -> float:
    """Return how much a contact resembles a line or a face, whose pressure ends at an edge, from 0 to 1."""
    pressures = readings.forces.take(readings.inside) / readings.areas.take(readings.inside)
    even = dot(pressures, pressures) / float(pressures.max() * pressures.sum())
    return min(max((even - _ROUND_EVEN) / (_LINE_EVEN - _ROUND_EVEN), 0.0), 1.0)


def _between_pads(errors: SensorUncertainty, effective: float, area: float, displaced: float, edged: float) -> Widths:
    """Return the relative widths of a force that pads with squared displacement [m²] sample; see ``_edged``."""
    assert errors.effects.area_averaging is not None
    share = math.pi * errors.effects.area_averaging.radius**2 / area
    spectrum = 0.29 * effective**-1.25
    if not errors.depth:
        spectrum += edged * (0.5 * effective**-0.75 - spectrum)
    sampled = math.hypot(spectrum * math.exp(-1.8 * share), math.sqrt(7 * displaced / area) / effective)
    depths = area / errors.depth**2 if errors.depth else 0.0
    if effective < 1.1 and depths:
        return Widths(
            max(sampled, min(0.011 * depths, 0.75)), max(2 * sampled, 0.066 * (depths - 15), min(1.0, 2 * (1 - share)))
        )
    if effective < 1.1:
        wide = 0.0 if errors.lumps else _width(area)
        narrow = min(1 - wide * (0.42 - 0.17 * wide), 1 - share)
        return Widths(max(sampled, narrow), max(2 * sampled, 5.4 * wide - 1, 2 * narrow))
    deep = max(depths - 6, 0.0) if effective < 5 else 0.0
    limit = max(2 * sampled, 0.16 * deep, 1 - share if effective < 2 else 0.0)
    return Widths(max(sampled, min(0.00117 * deep, 0.08) * deep), limit)


def _within_cells(errors: SensorUncertainty, effective: float, long: float) -> float:
    """Return the variance of the place of a contact on cells without gaps, in areas of a taxel."""
    crosstalk = errors.effects.crosstalk
    spread = effective * (1 - crosstalk.share) ** 2 if crosstalk else effective
    lump = (0.7 * math.exp(-1.5 * (spread - 1)) + 0.15 * spread**-3 + 0.045 / spread) / 6
    return max(lump + long / (24 * effective), 0.0)


def _within_pads(errors: SensorUncertainty, effective: float, area: float, edged: float, long: float) -> float:
    """Return the variance of the place of a contact that pads feel, in areas of a taxel; see ``_edged``."""
    wide = 1.0 if errors.lumps else _width(area)
    depths = area / errors.depth**2 if errors.depth else 0.0
    tails = 0.22 * math.exp(-0.75 * effective) * min(max((depths - 6) / 12, 0.0), 1.0)
    edges = edged * ((1 - long) / 12 * effective**-0.5 + long / 7) if effective > 1.1 and not errors.depth else 0.0
    return max(wide / 8 * effective**-2, tails, edges)


def _peak_share(errors: SensorUncertainty, area: float) -> float:
    """Return the factor of what saturation cuts off: taxels wider than contacts lose less, those of points more."""
    return 1.4 if errors.lumps else _width(area)


def _width(area: float) -> float:
    """Return the squared width of the widest expected contact over that of a taxel of this area [m²], at most 1."""
    return min(_WIDEST**2 * math.sqrt(0.75) / area, 1.0)


def _broken(taxels: DeadTaxels, total: float, square: float, areas: FloatArray) -> float:
    stuck = taxels.stuck_at * areas
    variance = taxels.dead * square + (taxels.dead * total) ** 2
    return math.sqrt(variance + taxels.stuck * (dot(stuck, stuck) + square))
