"""Export of a recording to formats of other programs: the formats, and one function for all of them."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from tactile_maps.core.errors import ExportError, install_line, is_installed
from tactile_maps.core.files import check_ending, make_atomically
from tactile_maps.core.plugins import Plugin, Registry, guard_call
from tactile_maps.core.progress import Progress, no_progress, part_of_progress
from tactile_maps.export.film import write_film
from tactile_maps.export.lerobot import write_lerobot
from tactile_maps.export.rerun_file import write_rerun
from tactile_maps.export.rosbag import write_rosbag
from tactile_maps.export.sinks import CsvSink, Hdf5Sink, ParquetSink, npz_sink
from tactile_maps.export.tables import Sink, column_labels, write_tables
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.trim import trim


@dataclass(frozen=True)
class ExportOptions:
    """Options of an export.

    Attributes:
        image_width: Width of tactile images on their longer side [px]; 0 leaves them out where they are optional.
        rate: Rate of a film, and of pictures in logs [Hz].
        fps: Rows per second of a LeRobot data set, each with all readings since the previous one; None for a row for
            each reading.
        begins: Session time from which a film counts [s]; None for the first frame of the recording, also in an export
            of a part.
    """

    image_width: int = 64
    rate: float = 25.0
    fps: int | None = None
    begins: float | None = None

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
        other_endings: Other suffixes of such files.
        write: Creates the file or folder at a path that does not exist.
        uses: Names of the ``ExportOptions`` that have an effect.
        needs: Modules that it imports besides those of the program.
        extra: Extra of the program that installs them.
    """

    name: str
    title: str
    ending: str
    write: Writer
    uses: tuple[str, ...] = ("image_width", "rate")
    needs: tuple[str, ...] = ()
    extra: str = "export"
    other_endings: tuple[str, ...] = ()

    def check_name(self, target: Path) -> None:
        """Check the name of a file that is to be written in this format; a folder may have any name.

        Raises:
            ExportError: It has the extension of another format.
        """
        if self.ending:
            check_ending(target, self.ending, *self.other_endings, error=ExportError)

    @property
    def install(self) -> str:
        """Command that installs the packages that it needs; empty if they are installed."""
        return "" if all(map(is_installed, self.needs)) else install_line(self.extra)


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


def _lerobot(player: RecordingPlayer, path: Path, options: ExportOptions, progress: Progress) -> None:
    write_lerobot(player, path, fps=options.fps, progress=progress)


def _film(player: RecordingPlayer, path: Path, options: ExportOptions, progress: Progress) -> None:
    begins = float(player.times[0]) if options.begins is None else options.begins
    write_film(player, path, rate=options.rate, begins=begins, progress=progress)


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
        ExportFormat("parquet", "Parquet tables", "", _tables(_parquet), _IMAGES, ("pyarrow",)),
        ExportFormat("npz", "NumPy arrays", ".npz", _tables(_npz), _IMAGES),
        ExportFormat("hdf5", "HDF5", ".h5", _tables(_hdf5), _IMAGES, ("h5py",), other_endings=(".hdf5",)),
        ExportFormat("lerobot", "LeRobot data set", "", _lerobot, ("fps",), ("pyarrow", "av")),
        ExportFormat("rosbag2", "ROS 2 bag", "", _at_rate(write_rosbag), _PICTURES, ("rosbags",)),
        ExportFormat("mp4", "Film of the tactile image", ".mp4", _film, _PICTURES, ("av",)),
        ExportFormat("rerun", "Rerun recording", ".rrd", _at_rate(write_rerun), _PICTURES, ("rerun",), "rerun"),
    ),
    _guarded,
)
"""Formats by name."""
_DEFAULT = ExportOptions()
_CUTTING = 0.2
"""Share of the progress of an export in which its part of the recording is cut out."""


def export_recording(
    source: RecordingPlayer | str | Path,
    target: str | Path,
    *,
    to: str,
    options: ExportOptions = _DEFAULT,
    span: tuple[float, float] | None = None,
    overwrite: bool = False,
    progress: Progress = no_progress,
) -> RecordingPlayer:
    """Export a recording to another format with a few frames in memory at a time; return the exported recording.

    A damaged recording is exported as far as possible. ``damage`` of the returned recording lists its losses, as does
    the table ``damage`` of the formats with tables. With a ``span``, it is the part, whose frames are no longer on
    disk.

    Args:
        source: A recording, or its file.
        target: The file or folder; it must not exist.
        to: Name of one of ``FORMATS``.
        options: Sizes and rates.
        span: Start and end of the exported part [s since the first frame]; None for the whole recording. The part is
            first written to a temporary recording next to the target.
        overwrite: Replace an existing file; a folder is never replaced.
        progress: Receives a description and the progress, 0 to 1; may raise to cancel, and then no output is left.

    Raises:
        ExportError: The format is unknown, a package that it needs is not installed, the name has the extension of
            another format, or the output cannot be written.
        RecordingError: The recording cannot be read.
    """
    chosen = FORMATS.get(to)
    if chosen is None:
        raise ExportError("unknown format", value=to, remedy=FORMATS.remedy(to))
    target = Path(target)
    chosen.check_name(target)
    player = source if isinstance(source, RecordingPlayer) else RecordingPlayer(source)
    with make_atomically(target, error=ExportError, overwrite=overwrite) as path, ExitStack() as parts:
        if span is not None:
            options = options if options.begins is not None else replace(options, begins=float(player.times[0]))
            folder = parts.enter_context(TemporaryDirectory(prefix=f".{target.name}-", dir=path.parent))
            player = _part(player, span, Path(folder), part_of_progress(progress, 0.0, _CUTTING))
            progress = part_of_progress(progress, _CUTTING, 1.0)
        chosen.write(player, path, options, progress)
    return player


def _part(player: RecordingPlayer, span: tuple[float, float], folder: Path, progress: Progress) -> RecordingPlayer:
    """Return a part of a recording, written to a folder under the same name."""
    start, end = span
    if not 0 <= start <= min(end, player.duration):
        remedy = f"Give a start and end within 0 to {player.duration:.2f} s"
        raise ExportError("invalid range", file=player.path, value=f"{start:g} to {end:g} s", remedy=remedy)
    target = folder / player.path.name
    trim(player.path, target, first=player.tick_at(start), last=player.tick_at(end), progress=progress)
    return RecordingPlayer(target)
