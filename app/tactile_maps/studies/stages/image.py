"""Interpolation and number of pixels: errors of the tactile image of this map for known pressures."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.maps.model.interpolation import INTERPOLATIONS
from tactile_maps.maps.model.tactile_image import TactileImage, round_trip_mm
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Skin
from tactile_maps.studies.base.rows import p95, rms, rms_interval, scaled
from tactile_maps.studies.study.work_precision import ErrorKind, Setting, Stage, Subject, Trial, timed

PIXELS = (64, 128, 256, 512)
"""Side lengths of a square with as many pixels as the image."""
_PLACES = 20_000
_FRAMES = 15
_BUDGET = 0.2
_SEED = 0
_PRESS = 2.0
"""Radius of a press in pitches of the taxels."""
_WAVE = 12.0
"""Length of a smooth wave in pitches."""
ERRORS = (
    ErrorKind(
        "press",
        "A press",
        "%",
        "Root mean square error of the image of a fingertip's press, as a share of its "
        "peak: a round contact two taxels in radius, steep at its rim.",
        1e-2,
    ),
    ErrorKind("smooth", "Smooth pressure", "%", "The same for pressure that varies over twelve taxels.", 1e-2),
    ErrorKind(
        "place",
        "Round trip",
        "mm",
        "From the body to the map, to a pixel and back: 95th percentile of the error over taxels.",
        1e-3,
    ),
)


def settings(subject: Subject) -> list[Setting]:
    """Return every interpolation with every number of pixels."""
    return [Setting("image", method, {"pixels": pixels}) for method in INTERPOLATIONS for pixels in PIXELS]


def trials(subject: Subject, setting: Setting) -> Iterator[Trial]:
    """Yield the image of the whole map: its errors and the time of a frame [ms]."""
    map_ = subject.map
    pixels = int(setting.values["pixels"])
    image = TactileImage(map_, resolution=resolution(map_, pixels), interpolation=setting.method)
    samples = sample_fields(map_.skin)
    pixel = _pixels(image, map_.to_map_many(samples.patch, samples.face, samples.weights))
    press, taxels = samples.press
    fields = {
        "press": KnownField(taxels, pixel[samples.pressed], press[samples.pressed]),
        "smooth": KnownField(samples.smooth[1], pixel, samples.smooth[0]),
    }
    rows, columns = image.shape
    trial = frame_trial(
        setting, lambda values: image.render(1e3 * values), fields, name=f"{columns} × {rows} pixels", budget=_BUDGET
    )
    yield replace(trial, errors={**trial.errors, "place": p95(round_trip_mm(map_, image))})


@dataclass(frozen=True, eq=False)
class KnownField:
    """A field from 0 to 1 with known values at the taxels and at some pixels.

    Attributes:
        taxels: (taxels,) values at the taxels.
        pixels: (k,) numbers of pixels, row by row.
        truth: (k,) values at these pixels.
    """

    taxels: FloatArray
    pixels: IntArray
    truth: FloatArray


def frame_trial(
    setting: Setting,
    render: Callable[[FloatArray], NDArray[np.floating]],
    fields: Mapping[str, KnownField],
    *,
    name: str = "",
    repeats: int = _FRAMES,
    budget: float = math.inf,
) -> Trial:
    """Return the time of a frame [ms] and the rms error of the image of each field, in percent of its range.

    Args:
        setting: The setting.
        render: Function from values at the taxels to an image.
        fields: Fields by key of the error.
        name: Name of the trial.
        repeats: Number of timed frames after a warm-up.
        budget: Time after which no further frame begins [s].
    """
    first = next(iter(fields.values()))
    frame = timed(lambda: render(first.taxels), repeats=repeats, budget=budget, warm_up=True)
    off = {key: render(field.taxels).ravel()[field.pixels] - field.truth for key, field in fields.items()}
    errors = {key: scaled(rms(one), 100) for key, one in off.items()}
    found = {key: rms_interval(one) for key, one in off.items()}
    intervals = {key: (100 * ends[0], 100 * ends[1]) for key, ends in found.items() if ends is not None}
    return Trial(setting, name, frame.ms, errors, p95_ms=frame.p95_ms, intervals=intervals)


def resolution(map_: TactileMap, pixels: int) -> float:
    """Return the size of a pixel [m] for about ``pixels`` squared pixels, for any shape of the map."""
    return float(np.sqrt(np.ptp(map_.bounds, axis=0).prod())) / pixels


@dataclass(frozen=True, eq=False)
class FieldSamples:
    """Points spread evenly over the skin, and two fields from 0 to 1 with known values there and at the taxels.

    Attributes:
        patch: (k,) patch of each point.
        face: (k,) face of each point.
        weights: (k, 3) barycentric weights of each point.
        press: (k,) and (taxels,) values of a field of round presses.
        smooth: (k,) and (taxels,) values of a field of waves.
        pressed: (k,) whether a point is on or near a press.
    """

    patch: IntArray
    face: IntArray
    weights: FloatArray
    press: tuple[FloatArray, FloatArray]
    smooth: tuple[FloatArray, FloatArray]
    pressed: np.ndarray[tuple[int], np.dtype[np.bool_]]


def sample_fields(skin: Skin, *, count: int = _PLACES) -> FieldSamples:
    """Return random points, the same for every image of a skin. Cost: 20 ms."""
    generator = np.random.default_rng(_SEED)
    areas = np.concatenate([patch.surface.face_areas for patch in skin.patches])
    starts = np.cumsum([0, *(len(patch.surface.faces) for patch in skin.patches)])
    every = generator.choice(len(areas), count, p=areas / areas.sum())
    patch = np.searchsorted(starts, every, side="right") - 1
    face = every - starts[patch]
    weights = generator.dirichlet(np.ones(3), count)
    pitch = float(np.sqrt(areas.sum() / len(skin)))
    at = _positions_apart(skin, patch, face, weights)
    presses = _press_centres(at, _PRESS * pitch)
    tree = cKDTree(at[presses])
    away = tree.query(at)[0]
    taxels = _taxels_apart(skin)
    press = (hertz(away / (_PRESS * pitch)), hertz(tree.query(taxels)[0] / (_PRESS * pitch)))
    smooth = (_waves(at / (_WAVE * pitch)), _waves(taxels / (_WAVE * pitch)))
    return FieldSamples(patch, face, weights, press, smooth, away < 1.25 * _PRESS * pitch)


_APART = 1e3
"""Distance between patches [m], so large that nothing on one patch affects another."""


def _positions_apart(skin: Skin, patch: IntArray, face: IntArray, weights: FloatArray) -> FloatArray:
    at = np.zeros((len(patch), 3))
    for number, own in enumerate(skin.patches):
        here = patch == number
        at[here] = own.surface.points(face[here], weights[here]) + [_APART * number, 0, 0]
    return at


def _taxels_apart(skin: Skin) -> FloatArray:
    return np.concatenate([p.taxels.positions + [_APART * number, 0, 0] for number, p in enumerate(skin.patches)])


def _press_centres(at: FloatArray, radius: float) -> list[int]:
    """Points whose presses do not overlap, as many as fit in the given order."""
    tree = cKDTree(at)
    free = np.ones(len(at), dtype=bool)
    chosen = []
    for number in range(len(at)):
        if free[number]:
            chosen.append(number)
            free[tree.query_ball_point(at[number], 2.5 * radius)] = False
    return chosen


def hertz(away: FloatArray) -> FloatArray:
    """Return the pressure under a ball (Hertz) at distances in contact radii: from 1 to 0, steep at the rim."""
    return np.sqrt(np.maximum(1 - away**2, 0))


def _waves(at: FloatArray) -> FloatArray:
    turn = 2 * np.pi * at
    return np.asarray(0.5 + 0.5 * np.sin(turn[:, 0] + 1) * np.cos(turn[:, 1]) * np.cos(turn[:, 2] + 2))


def _pixels(image: TactileImage, points: FloatArray) -> IntArray:
    """(k,) number of the pixel that contains each map point (k, 2)."""
    rows, columns = image.shape
    steps = np.floor((points - image.extent[0]) / image.resolution).astype(np.int64)
    column, up = np.clip(steps, 0, [columns - 1, rows - 1]).T
    return (rows - 1 - up) * columns + column


def fingerprint(subject: Subject) -> str:
    """Return a digest of the charts."""
    digest = hashlib.blake2b(digest_size=8)
    for chart in subject.map.charts:
        digest.update(chart.plane.tobytes())
    return digest.hexdigest()


def seconds(subject: Subject) -> float:
    """Return the approximate duration of all trials [s]."""
    return 2 + 1e-3 * len(subject.map.skin)


STAGE = Stage(
    "image",
    "Image",
    "Which interpolation is the most accurate, with how many pixels, and how long does a frame take?",
    tuple(INTERPOLATIONS),
    ERRORS,
    settings,
    trials,
    fingerprint,
    seconds,
    "Upright lines are 95\u202f% intervals over the compared pixels.",
)
