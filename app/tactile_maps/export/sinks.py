"""Tables as files: a folder of CSV or Parquet, one npz, one HDF5. Rows are written as they arrive and are not kept."""

from __future__ import annotations

import shutil
import tempfile
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from tactile_maps.core.errors import packages_of
from tactile_maps.export.tables import Columns, column_unit, inner_dimensions, row_column

Labels = Mapping[str, Sequence[str]]
"""Label of each number in a row, by column with several numbers per row."""
ROW_GROUP = 8 * 2**20
"""Size of a row group of a Parquet file [bytes]."""
_BLOCK = 2**16


class CsvSink:
    """A folder with a CSV file for each table; numbers are written exactly.

    A column with several numbers per row becomes several columns, ``COLUMN.LABEL``.
    """

    def __init__(self, folder: Path, labels: Labels, files: ExitStack) -> None:
        self._folder = folder
        self._labels = labels
        self._files = files
        self._streams: dict[str, IO[str]] = {}

    def append(self, table: str, columns: Columns) -> None:
        stream = self._streams.get(table)
        if stream is None:
            path = self._folder / f"{table}.csv"
            stream = self._streams[table] = self._files.enter_context(path.open("w", encoding="utf8", newline=""))
            stream.write(",".join(name for part in columns for name in self._names(part, columns[part])) + "\n")
        cells = [_cells(values) for values in columns.values()]
        stream.writelines(",".join(row) + "\n" for row in zip(*cells, strict=True))

    def _names(self, column: str, values: NDArray[Any]) -> list[str]:
        if values.ndim == 1:
            return [_quoted(column)]
        labels = self._labels.get(column) or range(int(np.prod(values.shape[1:])))
        return [_quoted(f"{column}.{label}") for label in labels]


def _cells(values: NDArray[Any]) -> Iterator[str]:
    """Return the text of each row."""
    if values.dtype.kind == "U":
        return map(_quoted, values.tolist())
    if values.ndim == 1:
        return map(repr, values.tolist())
    rows = values.reshape(len(values), -1).tolist()
    return (",".join(map(repr, row)) for row in rows)


def _quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if any(mark in text for mark in ',"\r\n') else text


class RowGroups:
    """A Parquet file whose rows are collected in groups of some megabytes before they are written.

    The writer keeps about a kilobyte for each column of each group until the file is closed, so with small groups
    memory use would grow with the recording.

    Args:
        writer: A ``ParquetWriter``.
        files: Writes the remaining rows and closes the file.
    """

    def __init__(self, writer: Any, files: ExitStack) -> None:
        self._writer = files.enter_context(writer)
        self._waiting: list[Any] = []
        self._size = 0
        files.callback(self._write)

    def add(self, table: Any) -> None:
        """Add rows."""
        if table.num_rows:
            self._waiting.append(table)
            self._size += table.nbytes
        if self._size >= ROW_GROUP:
            self._write()

    def _write(self) -> None:
        import pyarrow

        if self._waiting:
            self._writer.write_table(pyarrow.concat_tables(self._waiting))
        self._waiting.clear()
        self._size = 0


class ParquetSink:
    """A folder with a Parquet file for each table.

    A column with several numbers per row is a list of fixed length; the field's metadata contain their ``labels`` and
    the ``shape`` of an image.
    """

    def __init__(self, folder: Path, labels: Labels, files: ExitStack) -> None:
        with packages_of("export"):
            import pyarrow
            import pyarrow.parquet
        self._arrow = pyarrow
        self._parquet = pyarrow.parquet
        self._folder = folder
        self._labels = labels
        self._files = files
        self._writers: dict[str, RowGroups] = {}

    def append(self, table: str, columns: Columns) -> None:
        arrow = self._arrow
        arrays = [self._array(values) for values in columns.values()]
        fields = [self._field(*item) for item in zip(columns, arrays, columns.values(), strict=True)]
        batch = arrow.Table.from_arrays(arrays, schema=arrow.schema(fields))
        if table not in self._writers:
            writer = self._parquet.ParquetWriter(self._folder / f"{table}.parquet", batch.schema, compression="zstd")
            self._writers[table] = RowGroups(writer, self._files)
        self._writers[table].add(batch)

    def _array(self, values: NDArray[Any]) -> Any:
        if values.dtype.kind == "U":
            return self._arrow.array(values.tolist(), self._arrow.string())
        if values.ndim == 1:
            return self._arrow.array(values)
        flat = self._arrow.array(np.ascontiguousarray(values).ravel())
        return self._arrow.FixedSizeListArray.from_arrays(flat, int(np.prod(values.shape[1:])))

    def _field(self, name: str, array: Any, values: NDArray[Any]) -> Any:
        metadata = {"labels": "\n".join(self._labels[name])} if name in self._labels else {}
        if values.ndim > 2:
            metadata["shape"] = " ".join(map(str, values.shape[1:]))
        return self._arrow.field(name, array.type, nullable=False, metadata=metadata)


class Hdf5Sink:
    """HDF5 file with a group for each table and a compressed dataset for each column.

    Axes have dimension scales as in netCDF, so that xarray opens a group with named coordinates: the time (or else the
    first column) for rows, and ``taxel``, ``joint``, ``pixel_row`` and ``pixel_column``. Attributes are ``units`` (one
    unit for each joint if the joints differ), and ``labels`` if a column has one for each number in a row.

    Args:
        path: The file.
        labels: Labels by column.
        files: Closes the file.
        slides: For each joint of the robot, whether it slides; for the units.
    """

    def __init__(self, path: Path, labels: Labels, files: ExitStack, *, slides: Sequence[bool] = ()) -> None:
        with packages_of("export"):
            import h5py
        self._h5py = h5py
        self._slides = slides
        self._labels = labels
        self._file = files.enter_context(self._h5py.File(path, "w"))

    def append(self, table: str, columns: Columns) -> None:
        if table not in self._file:
            self._begin_table(self._file.create_group(table), columns)
        group = self._file[table]
        for name, values in columns.items():
            data = group[name]
            start = len(data)
            data.resize(start + len(values), axis=0)
            data[start:] = values.astype(object) if values.dtype.kind == "U" else values

    def _begin_table(self, group: Any, columns: Columns) -> None:
        for name, values in columns.items():
            self._begin(group, name, values)
        rows = row_column(columns)
        group[rows].make_scale(rows)
        for name, values in columns.items():
            if name != rows:
                group[name].dims[0].attach_scale(group[rows])
            dimensions = inner_dimensions(name, values) if values.ndim > 1 else []
            for axis, dimension in enumerate(dimensions, start=1):
                if dimension not in group:
                    self._add_scale(group, dimension, self._labels.get(name) or range(values.shape[axis]))
                group[name].dims[axis].attach_scale(group[dimension])

    def _add_scale(self, group: Any, name: str, places: Sequence[str | int]) -> None:
        words = any(isinstance(place, str) for place in places)
        kind = self._h5py.string_dtype() if words else np.dtype(np.int64)
        group.create_dataset(name, data=list(places), dtype=kind).make_scale(name)

    def _begin(self, group: Any, name: str, values: NDArray[Any]) -> None:
        kind = self._h5py.string_dtype() if values.dtype.kind == "U" else values.dtype
        shape = values.shape[1:]
        # Chunks of some hundred kB for wide rows, and of some thousand numbers for long columns.
        rows = max(1, min(4096, 2**18 // (8 * max(int(np.prod(shape)), 1))))
        data = group.create_dataset(
            name,
            (0, *shape),
            dtype=kind,
            maxshape=(None, *shape),
            chunks=(rows, *shape),
            compression="gzip",
            compression_opts=1,
            shuffle=values.dtype.kind != "U",
        )
        if name in self._labels:
            data.attrs.create("labels", list(self._labels[name]), dtype=self._h5py.string_dtype())
        unit = column_unit(name, self._slides)
        if isinstance(unit, list):
            data.attrs.create("units", unit, dtype=self._h5py.string_dtype())
        elif unit is not None:
            data.attrs["units"] = unit


class NpzSink:
    """Npz file with an array for each column, ``TABLE.COLUMN``. Rows are in temporary files until all have arrived.

    Args:
        path: The file.
        labels: Labels by column, stored as ``TABLE.COLUMN.labels``.
        waiting: A folder for the temporary files.
    """

    def __init__(self, path: Path, labels: Labels, waiting: Path) -> None:
        self._path = path
        self._labels = labels
        self._waiting = waiting
        self._arrays: dict[str, tuple[IO[bytes], np.dtype[Any], tuple[int, ...]]] = {}
        self._words: dict[str, dict[str, int]] = {}  # number of each word by column; rows are kept as numbers
        self._rows: dict[str, int] = {}

    def append(self, table: str, columns: Columns) -> None:
        for name, values in columns.items():
            key = f"{table}.{name}"
            if key not in self._arrays and name in self._labels:
                self._add(f"{key}.labels", np.array(self._labels[name], dtype=np.str_))
            self._add(key, values)

    def _add(self, key: str, values: NDArray[Any]) -> None:
        if values.dtype.kind == "U":
            known = self._words.setdefault(key, {})
            values = np.array([known.setdefault(word, len(known)) for word in values.tolist()], dtype=np.int64)
        if key not in self._arrays:
            stream = (self._waiting / str(len(self._arrays))).open("w+b")
            self._arrays[key] = (stream, values.dtype, values.shape[1:])
            self._rows[key] = 0
        self._arrays[key][0].write(np.ascontiguousarray(values).tobytes())
        self._rows[key] += len(values)

    def close(self) -> None:
        """Write the file."""
        with zipfile.ZipFile(self._path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
            for key, (stream, dtype, shape) in self._arrays.items():
                words = np.array(list(self._words[key]), dtype=np.str_) if key in self._words else None
                stream.seek(0)
                with archive.open(f"{key}.npy", "w", force_zip64=True) as member:
                    descr = npy.dtype_to_descr(dtype if words is None else words.dtype)
                    header = {"descr": descr, "fortran_order": False, "shape": (self._rows[key], *shape)}
                    npy.write_array_header_2_0(member, header)
                    if words is None:
                        shutil.copyfileobj(stream, member, 2**20)
                    else:
                        while block := stream.read(8 * _BLOCK):
                            member.write(words[np.frombuffer(block, dtype=np.int64)].tobytes())

    def abandon(self) -> None:
        """Close the temporary files."""
        for stream, _, _ in self._arrays.values():
            stream.close()


@contextmanager
def npz_sink(path: Path, labels: Labels) -> Iterator[NpzSink]:
    """Yield a sink with its temporary files in a folder next to ``path``, which is always removed."""
    with tempfile.TemporaryDirectory(dir=path.parent, prefix=".tactile-maps-", suffix=".part") as waiting:
        sink = NpzSink(path, labels, Path(waiting))
        try:
            yield sink
            sink.close()
        finally:
            sink.abandon()
