"""Which interpolation and how many pixels: what the tactile image of this map shows of a touch that is known."""

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
"""Side of a square with as many pixels as the image."""
_PLACES = 20_000
_FRAMES = 15
_BUDGET = 0.2
_SEED = 0
_PRESS = 2.0
"""Radius of a press, in pitches of the taxels."""
_WAVE = 12.0
"""Length of a smooth wave, in pitches."""
ERRORS = (
    ErrorKind("press", "A press", "%", "Root mean square error of the image of a fingertip's press, of its peak: "
              "a round contact two taxels in radius, steep at its rim.", 1e-2),
    ErrorKind("smooth", "Smooth pressure", "%", "The same of pressure that rises and falls over twelve taxels.", 1e-2),
    ErrorKind("place", "Round trip", "mm", "From the body to the map, to a pixel and back: 95th percentile of the "
              "error over taxels.", 1e-3),
)  # fmt: skip


def settings(subject: Subject) -> list[Setting]:
    """Every interpolation with every number of pixels."""
    return [Setting("image", method, {"pixels": pixels}) for method in INTERPOLATIONS for pixels in PIXELS]


def trials(subject: Subject, setting: Setting) -> Iterator[Trial]:
    """The whole map's image, its errors, and the milliseconds of a frame."""
    map_ = subject.map
    pixels = int(setting.values["pixels"])
    image = TactileImage(map_, resolution=resolution(map_, pixels), interpolation=setting.method)
    places = sample_fields(map_.skin)
    where = _pixels(image, map_.to_map_many(places.patch, places.face, places.weights))
    there, taxels = places.press
    fields = {
        "press": KnownField(taxels, where[places.pressed], there[places.pressed]),
        "smooth": KnownField(places.smooth[1], where, places.smooth[0]),
    }
    rows, columns = image.shape
    tried = frame_trial(
        setting, lambda values: image.render(1e3 * values), fields, name=f"{columns} × {rows} pixels", budget=_BUDGET
    )
    yield replace(tried, errors={**tried.errors, "place": p95(round_trip_mm(map_, image))})


@dataclass(frozen=True, eq=False)
class KnownField:
    """A field from 0 to 1 that is known at the taxels and at some pixels.

    Attributes:
        taxels: (taxels,) its values there.
        pixels: (k,) numbers of pixels, row by row.
        truth: (k,) its values at these.
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
    """The milliseconds of a frame, and the rms error of the image of each field, in percent of its range.

    Args:
        setting: What is tried.
        render: From values at the taxels to an image.
        fields: By the error's key.
        name: Of the trial.
        repeats: Frames by the clock, after one to warm up.
        budget: No frame is begun after so long [s].
    """
    first = next(iter(fields.values()))
    frame = timed(lambda: render(first.taxels), repeats=repeats, budget=budget, warm_up=True)
    off = {key: render(field.taxels).ravel()[field.pixels] - field.truth for key, field in fields.items()}
    errors = {key: scaled(rms(one), 100) for key, one in off.items()}
    found = {key: rms_interval(one) for key, one in off.items()}
    intervals = {key: (100 * ends[0], 100 * ends[1]) for key, ends in found.items() if ends is not None}
    return Trial(setting, name, frame.ms, errors, p95_ms=frame.p95_ms, intervals=intervals)


def resolution(map_: TactileMap, pixels: int) -> float:
    """Size of a pixel [m] such that the image has about ``pixels`` squared of them, however tall or wide the map."""
    return float(np.sqrt(np.ptp(map_.bounds, axis=0).prod())) / pixels


@dataclass(frozen=True, eq=False)
class FieldSamples:
    """Points spread evenly over the skin, and two fields from 0 to 1 that are known there and at the taxels.

    Attributes:
        patch: (k,) of each.
        face: (k,) likewise.
        weights: (k, 3) likewise.
        press: (k,) and (taxels,) a field of round presses.
        smooth: (k,) and (taxels,) one of waves.
        pressed: (k,) on and near a press.
    """

    patch: IntArray
    face: IntArray
    weights: FloatArray
    press: tuple[FloatArray, FloatArray]
    smooth: tuple[FloatArray, FloatArray]
    pressed: np.ndarray[tuple[int], np.dtype[np.bool_]]


def sample_fields(skin: Skin, *, count: int = _PLACES, seed: int = _SEED) -> FieldSamples:
    """Points at random, the same for every image of a skin. Cost: 20 ms."""
    generator = np.random.default_rng(seed)
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
"""Patches are put so far from each other [m] that nothing of one is near another."""


def _positions_apart(skin: Skin, patch: IntArray, face: IntArray, weights: FloatArray) -> FloatArray:
    at = np.zeros((len(patch), 3))
    for number, own in enumerate(skin.patches):
        here = patch == number
        at[here] = own.surface.points(face[here], weights[here]) + [_APART * number, 0, 0]
    return at


def _taxels_apart(skin: Skin) -> FloatArray:
    return np.concatenate([p.taxels.positions + [_APART * number, 0, 0] for number, p in enumerate(skin.patches)])


def _press_centres(at: FloatArray, radius: float) -> list[int]:
    """Points whose presses do not meet, as many as there is room for in the order given."""
    tree = cKDTree(at)
    free = np.ones(len(at), dtype=bool)
    chosen = []
    for number in range(len(at)):
        if free[number]:
            chosen.append(number)
            free[tree.query_ball_point(at[number], 2.5 * radius)] = False
    return chosen


def hertz(away: FloatArray) -> FloatArray:
    """Pressure under a ball (Hertz) at distances from its middle in radii: from 1 to 0, infinitely steep at the rim."""
    return np.sqrt(np.maximum(1 - away**2, 0))


def _waves(at: FloatArray) -> FloatArray:
    turn = 2 * np.pi * at
    return np.asarray(0.5 + 0.5 * np.sin(turn[:, 0] + 1) * np.cos(turn[:, 1]) * np.cos(turn[:, 2] + 2))


def _pixels(image: TactileImage, points: FloatArray) -> IntArray:
    """(k,) number of the pixel that holds each map point (k, 2)."""
    rows, columns = image.shape
    steps = np.floor((points - image.extent[0]) / image.resolution).astype(np.int64)
    column, up = np.clip(steps, 0, [columns - 1, rows - 1]).T
    return (rows - 1 - up) * columns + column


def fingerprint(subject: Subject) -> str:
    """The charts."""
    digest = hashlib.blake2b(digest_size=8)
    for chart in subject.map.charts:
        digest.update(chart.plane.tobytes())
    return digest.hexdigest()


def seconds(subject: Subject) -> float:
    """About how long all of it takes."""
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
    "Upright lines are 95\u202f% intervals over the pixels that were compared.",
)
