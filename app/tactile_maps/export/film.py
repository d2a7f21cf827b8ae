"""Film of the tactile image of a recording: H.264 in MP4, in simulated time, with colour bar and contacts."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactile_maps.core.errors import ExportError, packages_of
from tactile_maps.core.progress import Progress, part_of_progress
from tactile_maps.export.pictures import FilmFrame
from tactile_maps.maps.pressure_colours import rounded_scale
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.session.inputs import MapEdited


class FilmWriter:
    """A film being written, picture by picture. Created by ``open_film``."""

    def __init__(self, container: Any, stream: Any, av: Any) -> None:
        self._container = container
        self._stream = stream
        self._av = av
        self._count = 0

    def add(self, picture: NDArray[np.uint8]) -> None:
        """Add the next picture (height, width, 3)."""
        frame = self._av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")
        frame.pts = self._count
        self._count += 1
        for packet in self._stream.encode(frame):
            self._container.mux(packet)

    def finish(self) -> None:
        """Write the pictures that the encoder still buffers."""
        for packet in self._stream.encode():
            self._container.mux(packet)


@contextmanager
def open_film(path: Path, size: tuple[int, int], rate: Fraction, *, quality: int = 20) -> Iterator[FilmWriter]:
    """Yield a writer for pictures of ``size`` (width, height) [px], both even.

    Args:
        path: The file, with any name.
        size: Size of each picture.
        rate: Pictures per second.
        quality: Quality of H.264 (CRF): 0 is lossless, 51 is worst.

    Raises:
        ExportError: PyAV is not installed, or does not support H.264.
    """
    with packages_of("export"):
        import av
    if "libx264" not in av.codecs_available:
        remedy = "pip install av: the wheels of PyAV support it"
        raise ExportError("this PyAV cannot write H.264", file=path, value=av.__version__, remedy=remedy)
    with av.open(str(path), "w", format="mp4") as container:
        stream = container.add_stream("libx264", rate=rate, options={"crf": str(quality), "preset": "veryfast"})
        stream.width, stream.height = size
        stream.pix_fmt = "yuv420p"
        stream.thread_count = 1
        writer = FilmWriter(container, stream, av)
        yield writer
        writer.finish()


def write_film(player: RecordingPlayer, path: Path, *, rate: float, begins: float, progress: Progress) -> None:
    """Write the film with one colour scale, up to the next round number above the highest pressure shown.

    Captions state the time since ``begins`` [s of the session]. If frames are missing, the previous one stays.

    Cost: 10 ms per picture.
    """
    count = int(player.duration * rate + 1e-9) + 1
    highest = 0.0
    look = part_of_progress(progress, 0.0, 0.1)
    for done in range(count):
        if done % 100 == 0:
            look("Looking for the highest pressure", done / count)
        frame = player.frame(player.number_at(done / rate))
        highest = max(highest, frame.highest_pressure)
    edits = [tick for tick, session_input in player.inputs if isinstance(session_input, MapEdited)]
    passed = 0
    draw = part_of_progress(progress, 0.1, 1.0)
    canvas = FilmFrame(player.prepared.map, rounded_scale(1e-3 * highest), begins=begins)
    with open_film(path, canvas.size, Fraction(rate).limit_denominator(1000)) as film:
        for done in range(count):
            frame = player.frame(player.number_at(done / rate))
            if (now := sum(tick <= frame.tick for tick in edits)) != passed:
                canvas.use_map(player.runtime_settings_at(frame.tick).map)
                passed = now
            film.add(canvas.picture(frame))
            if done % 20 == 0:
                draw("Filming", done / count)
    progress("Filming", 1.0)
