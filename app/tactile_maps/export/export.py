"""Export of a recording to formats of other programs: the formats, and one function for all of them."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

from tactile_maps.core.errors import ExportError
from tactile_maps.core.files import make_atomically
from tactile_maps.core.plugins import Plugin, Registry, guard_call
from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.export.film import write_film
from tactile_maps.export.lerobot import write_lerobot
from tactile_maps.export.rerun_file import write_rerun
from tactile_maps.export.rosbag import write_rosbag
from tactile_maps.export.sinks import CsvSink, Hdf5Sink, ParquetSink, npz_sink
from tactile_maps.export.tables import Sink, column_labels, write_tables
from tactile_maps.recording.player import RecordingPlayer


@dataclass(frozen=True)
class ExportOptions:
    """Options of an export.

    Attributes:
        image_width: Width of tactile images on their longer side [px]; 0 leaves them out where they are optional.
        rate: Rate of a film, and of pictures in logs [Hz].
    """

    image_width: int = 64
    rate: float = 25.0

    def __post_init__(self) -> None:
        if not 0 <= self.image_width <= 2048:
            raise ExportError("invalid image width", value=self.image_width, remedy="Give 0 to 2048 pixels")
        if not 0.1 <= self.rate <= 1000:
            raise ExportError("invalid rate of pictures", value=self.rate, remedy="Give 0.1 to 1000 Hz")


Writer = Callable[[RecordingPlayer, Path, ExportOptions, Progress], None]


@dataclass(frozen=True)
class ExportFormat:
    """A file format.

    Attributes:
        name: Name on the command line.
        title: Name for display.
        ending: Suffix of the file; empty for a folder.
        write: Creates the file or folder at a path that does not exist.
        uses: Names of the ``ExportOptions`` that have an effect.
    """

    name: str
    title: str
    ending: str
    write: Writer
    uses: tuple[str, ...] = ("image_width", "rate")


def _tables(open_sink: Callable[[RecordingPlayer, Path, ExitStack], Sink], *, images: bool = True) -> Writer:
    """Return a writer of the tables, with or without tactile images."""

    def write(player: RecordingPlayer, path: Path, options: ExportOptions, progress: Progress) -> None:
        with ExitStack() as files:
            sink = open_sink(player, path, files)
            write_tables(player, sink, image_width=options.image_width if images else 0, progress=progress)

    return write


def _csv(player: RecordingPlayer, path: Path, files: ExitStack) -> Sink:
    path.mkdir()
    return CsvSink(path, column_labels(player.prepared), files)


def _parquet(player: RecordingPlayer, path: Path, files: ExitStack) -> Sink:
    path.mkdir()
    return ParquetSink(path, column_labels(player.prepared), files)


def _hdf5(player: RecordingPlayer, path: Path, files: ExitStack) -> Sink:
    slides = [joint.slide for joint in player.prepared.robot.joints]
    return Hdf5Sink(path, column_labels(player.prepared), files, slides=slides)


def _npz(player: RecordingPlayer, path: Path, files: ExitStack) -> Sink:
    return files.enter_context(npz_sink(path, column_labels(player.prepared)))


def _at_rate(write: Callable[..., None]) -> Writer:
    """Return a writer that passes only the rate to ``write``."""

    def with_rate(player: RecordingPlayer, path: Path, options: ExportOptions, progress: Progress) -> None:
        write(player, path, rate=options.rate, progress=progress)

    return with_rate


def _guarded(plugin: Plugin, form: ExportFormat) -> ExportFormat:
    """Return a plug-in's format that can be cancelled by an error of the progress and raises if it writes nothing."""
    guarded = guard_call(plugin, form.write, "player", "path", "options", "progress")

    def write(player: RecordingPlayer, path: Path, options: ExportOptions, progress: Progress) -> None:
        stops: list[Exception] = []

        def report(text: str, fraction: float) -> None:
            try:
                progress(text, fraction)
            except Exception as stop:
                stops.append(stop)
                raise

        try:
            guarded(player, path, options, report)
        except Exception:
            if stops:
                raise stops[0] from None
            raise
        if stops:  # the plug-in suppressed it
            raise stops[0]
        if not path.exists():
            raise plugin.error("it wrote nothing")

    return replace(form, write=write)


_IMAGES = ("image_width",)
_PICTURES = ("rate",)
FORMATS: Registry[ExportFormat] = Registry(
    "exporters",
    ExportFormat,
    (
        ExportFormat("csv", "CSV tables", "", _tables(_csv, images=False), ()),
        ExportFormat("parquet", "Parquet tables", "", _tables(_parquet), _IMAGES),
        ExportFormat("npz", "NumPy arrays", ".npz", _tables(_npz), _IMAGES),
        ExportFormat("hdf5", "HDF5", ".h5", _tables(_hdf5), _IMAGES),
        ExportFormat("lerobot", "LeRobot data set", "", lambda p, f, o, t: write_lerobot(p, f, progress=t), ()),
        ExportFormat("rosbag2", "ROS 2 bag", "", _at_rate(write_rosbag), _PICTURES),
        ExportFormat("mp4", "Film of the tactile image", ".mp4", _at_rate(write_film), _PICTURES),
        ExportFormat("rerun", "Rerun recording", ".rrd", _at_rate(write_rerun), _PICTURES),
    ),
    _guarded,
)
"""Formats by name."""
_DEFAULT = ExportOptions()


def export_recording(
    source: RecordingPlayer | str | Path,
    target: str | Path,
    *,
    to: str,
    options: ExportOptions = _DEFAULT,
    overwrite: bool = False,
    progress: Progress = no_progress,
) -> RecordingPlayer:
    """Export a recording to another format with a few frames in memory at a time; return the opened recording.

    A damaged recording is exported as far as possible. ``damage`` of the returned recording lists its losses, as does
    the table ``damage`` of the formats with tables.

    Args:
        source: A recording, or its file.
        target: The file or folder; it must not exist.
        to: Name of one of ``FORMATS``.
        options: Sizes and rates.
        overwrite: Replace an existing file; a folder is never replaced.
        progress: Receives a description and the progress, 0 to 1; may raise to cancel, and then no output is left.

    Raises:
        ExportError: The format is unknown, a package that it needs is not installed, or the output cannot be written.
        RecordingError: The recording cannot be read.
    """
    chosen = FORMATS.get(to)
    if chosen is None:
        raise ExportError("unknown format", value=to, remedy=FORMATS.remedy(to))
    target = Path(target)
    player = source if isinstance(source, RecordingPlayer) else RecordingPlayer(source)
    with make_atomically(target, error=ExportError, overwrite=overwrite) as part:
        chosen.write(player, part, options, progress)
    return player
