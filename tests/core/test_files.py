from __future__ import annotations

import errno
import io
import os
import subprocess
import sys
import tracemalloc
import zipfile
from pathlib import Path

import numpy as np
import pytest

from tactile_maps.core.errors import SkinError
from tactile_maps.core.files import (
    check_output,
    check_output_folder,
    make_atomically,
    make_output_folder,
    move_into_place,
    new_outputs,
    open_atomically,
    pack_arrays,
    read_bounded_text,
    unpack_array,
    unpack_arrays,
    unpack_bare_arrays,
    write_atomically,
    write_lines,
)
from tests.support.special_files import is_special, make_special_file, special_kinds


def members(**parts: bytes) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in parts.items():
            archive.writestr(f"{name}.npy", data)
    return buffer.getvalue()


def npy(array: np.ndarray, *, allow_pickle: bool = False) -> bytes:
    buffer = io.BytesIO()
    np.lib.format.write_array(buffer, array, allow_pickle=allow_pickle)
    return buffer.getvalue()


HEADER = npy(np.frombuffer(b"{}", np.uint8))


def test_packed_arrays_are_unpacked_unchanged():
    arrays = {"a": np.arange(6.0).reshape(2, 3), "b": np.array([1, 2]), "c": np.zeros((0, 3)), "d": np.array([True])}
    arrays["f"] = np.asfortranarray(np.arange(6).reshape(2, 3))
    data = pack_arrays({"title": "tést"}, arrays)
    header, back = unpack_arrays(data, error=SkinError)
    assert header == {"title": "tést"}
    assert set(back) == set(arrays)
    for name, values in arrays.items():
        assert back[name].dtype == values.dtype
        assert back[name].tolist() == values.tolist()
    assert data == pack_arrays({"title": "tést"}, arrays), "the same input gives the same bytes"


def test_failed_write_keeps_the_old_file(tmp_path, monkeypatch):
    """A full disk is detected when the last bytes are flushed."""
    path = tmp_path / "map.npz"
    path.write_bytes(b"before")

    def full(_descriptor: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("tactile_maps.core.files.os.fsync", full)
    with pytest.raises(SkinError, match=r"map\.npz: the file cannot be written.*No space left"):
        write_atomically(path, b"after", error=SkinError)
    assert path.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [path], "nothing is left behind"


def test_file_of_another_program_in_the_folder_is_kept(tmp_path):
    """A link laid where an earlier version wrote first would have led the bytes elsewhere."""
    other = tmp_path / "other"
    other.write_bytes(b"mine")
    (tmp_path / "map.npz.part").symlink_to(other)
    write_atomically(tmp_path / "map.npz", b"after", error=SkinError)
    assert other.read_bytes() == b"mine"
    assert (tmp_path / "map.npz").read_bytes() == b"after"
    assert (tmp_path / "map.npz").stat().st_mode == other.stat().st_mode, "others may read it as any file"


def test_longest_file_name_can_be_written(tmp_path):
    write_atomically(tmp_path / ("x" * 255), b"long", error=SkinError)
    assert (tmp_path / ("x" * 255)).read_bytes() == b"long"


@pytest.mark.parametrize("link", [False, True])
@pytest.mark.parametrize("kind", special_kinds())
def test_special_file_is_never_replaced(tmp_path, kind, link):
    special = make_special_file(kind, tmp_path / "special")
    path = special
    if link:
        path = tmp_path / "link"
        path.symlink_to(special)
    with pytest.raises(SkinError, match=rf"{path.name}: the output is not a regular file .found: a {kind}."):
        write_atomically(path, b"x", error=SkinError)
    with pytest.raises(SkinError, match="not a regular file"), make_atomically(path, error=SkinError, overwrite=True):
        raise AssertionError("refused before anything is written")
    (tmp_path / "part").write_bytes(b"x")
    with pytest.raises(SkinError, match="not a regular file"):
        move_into_place(tmp_path / "part", path, error=SkinError)
    with pytest.raises(SkinError, match=f"special: the folder cannot be created .found: a {kind} of this name"):
        check_output_folder(special, error=SkinError)
    assert is_special(special)
    assert (tmp_path / "part").exists()


def test_special_file_created_during_the_write_is_not_replaced(tmp_path):
    path = tmp_path / "map.npz"
    with pytest.raises(SkinError, match="not a regular file"), open_atomically(path, error=SkinError):
        make_special_file("pipe", path)
    assert is_special(path)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("exists", [True, False])
def test_target_of_a_symbolic_link_is_written(tmp_path, exists):
    (tmp_path / "links").mkdir()
    (tmp_path / "files").mkdir()
    target = tmp_path / "files" / "map.npz"
    link = tmp_path / "links" / "map.npz"
    if exists:
        target.write_bytes(b"before")
    link.symlink_to("../files/map.npz")
    with open_atomically(link, error=SkinError) as stream:
        stream.write(b"after")
        assert [path.name for path in (tmp_path / "links").iterdir()] == ["map.npz"]
    assert link.is_symlink()
    assert not target.is_symlink()
    assert target.read_bytes() == b"after"


def test_broken_links_are_rejected(tmp_path):
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "away").symlink_to("no/such/folder/map.npz")
    with pytest.raises(SkinError, match=r"loop: the file cannot be written .found: Too many levels"):
        write_atomically(tmp_path / "loop", b"x", error=SkinError)
    with pytest.raises(SkinError, match=r"away: the file cannot be written .*no/such/folder does not exist"):
        write_atomically(tmp_path / "away", b"x", error=SkinError)
    assert all(path.is_symlink() for path in tmp_path.iterdir())


def test_replaced_file_keeps_permissions_and_owner(tmp_path):
    path = tmp_path / "map.npz"
    path.write_bytes(b"before")
    path.chmod(0o640)
    root = os.geteuid() == 0
    if root:
        os.chown(path, 1234, 5678)
    write_atomically(path, b"after", error=SkinError)
    found = path.stat()
    assert found.st_mode & 0o777 == 0o640
    assert (found.st_uid, found.st_gid) == ((1234, 5678) if root else (os.geteuid(), found.st_gid))
    with make_atomically(path, error=SkinError, overwrite=True) as part:
        part.write_bytes(b"again")
    assert path.stat().st_mode & 0o777 == 0o640


def test_hard_link_keeps_the_old_content(tmp_path):
    (tmp_path / "first").write_bytes(b"before")
    (tmp_path / "second").hardlink_to(tmp_path / "first")
    write_atomically(tmp_path / "first", b"after", error=SkinError)
    assert [(tmp_path / name).read_bytes() for name in ("first", "second")] == [b"after", b"before"]


def test_read_only_file_is_not_replaced(tmp_path):
    path = tmp_path / "map.npz"
    path.write_bytes(b"before")
    path.chmod(0o444)
    with pytest.raises(SkinError, match=r"map\.npz: the file is read-only.*make the file writable"):
        write_atomically(path, b"after", error=SkinError)
    assert path.read_bytes() == b"before"


def test_existing_output_is_rejected_inside_the_block(tmp_path):
    path = tmp_path / "map.npz"
    other = tmp_path / "other.npz"
    with new_outputs([path]):
        write_atomically(path, b"first", error=SkinError)
        with pytest.raises(SkinError, match=r"already exists.*--overwrite"):
            write_atomically(path, b"second", error=SkinError)
        with pytest.raises(SkinError, match=r"already exists.*--overwrite"):
            check_output(path, error=SkinError, overwrite=False)
        write_atomically(other, b"first", error=SkinError)
        write_atomically(other, b"second", error=SkinError)
    assert (path.read_bytes(), other.read_bytes()) == (b"first", b"second")
    write_atomically(path, b"third", error=SkinError)
    assert path.read_bytes() == b"third"
    with pytest.raises(SkinError, match=r"already exists.*\(overwrite=True\)"):
        check_output(path, error=SkinError, overwrite=False)


@pytest.mark.parametrize("name", ["", "/", "..", "x" * 300, "a\0b", "file/x"])
def test_impossible_file_names_are_rejected(tmp_path, name):
    (tmp_path / "file").write_bytes(b"")
    path = Path(name) if name in ("", "/") else tmp_path / name
    with pytest.raises(SkinError, match=r"cannot be written|folder of this name"):
        write_atomically(path, b"x", error=SkinError)


def test_output_folder_is_created_or_rejected(tmp_path):
    folder = tmp_path / "a" / "b"
    assert make_output_folder(folder, error=SkinError) == folder == make_output_folder(folder, error=SkinError)
    (tmp_path / "link").symlink_to(folder)
    make_output_folder(tmp_path / "link", error=SkinError)
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(SkinError, match="file: the folder cannot be created .found: a file of this name"):
        make_output_folder(tmp_path / "file", error=SkinError)
    for bad in (tmp_path / "file" / "x", tmp_path / ("x" * 300)):
        with pytest.raises(SkinError, match="the folder cannot be created"):
            make_output_folder(bad, error=SkinError)


_WRITER = """
import sys
from pathlib import Path
from tactile_maps.core.errors import SkinError
from tactile_maps.core.files import write_atomically
print("ready", flush=True)
for _ in range(int(sys.argv[3])):
    write_atomically(Path(sys.argv[1]), sys.argv[2].encode() * 2_000_000, error=SkinError)
"""


def _writer(path: Path, letter: str, times: int) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", _WRITER, str(path), letter, str(times)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=Path(__file__).resolve().parents[2])
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    return process


def test_concurrent_writers_never_mix_their_content(tmp_path):
    path = tmp_path / "map.npz"
    writers = [_writer(path, letter, 20) for letter in "ab"]
    found = set()
    while any(writer.poll() is None for writer in writers):
        if path.exists():
            data = path.read_bytes()
            found |= {(len(data), *set(data))}
    assert [writer.communicate() and writer.returncode for writer in writers] == [0, 0]
    assert found <= {(2_000_000, ord("a")), (2_000_000, ord("b"))}
    assert [file.name for file in tmp_path.iterdir()] == ["map.npz"]


def test_output_with_a_shared_lock_is_not_in_use(tmp_path):
    fcntl = pytest.importorskip("fcntl", reason="Windows has no shared locks")
    path = tmp_path / "map.npz"
    path.write_bytes(b"old")
    with path.open("rb") as stream:
        fcntl.flock(stream.fileno(), fcntl.LOCK_SH)  # as while another program checks it
        assert check_output(path, error=SkinError) == path
        fcntl.flock(stream.fileno(), fcntl.LOCK_EX)
        with pytest.raises(SkinError, match="another program is writing this file"):
            check_output(path, error=SkinError)


def test_pickles_are_rejected():
    data = members(header=HEADER, bad=npy(np.array([{}], dtype=object), allow_pickle=True))
    with pytest.raises(SkinError, match="only arrays of numbers"):
        unpack_arrays(data, error=SkinError)


def test_compression_bomb_is_rejected_before_unpacking():
    data = members(header=HEADER, bomb=npy(np.zeros(1_000_000)))
    assert len(data) < 100_000
    with pytest.raises(SkinError, match="implausible size"):
        unpack_arrays(data, error=SkinError, max_bytes=1_000_000)


def test_array_with_too_many_rows_is_rejected_before_unpacking():
    data = members(**{"header": HEADER, "12_places": npy(np.zeros((1_000_000, 3)))})
    tracemalloc.start()
    try:
        with pytest.raises(SkinError, match=r"12_places\.npy: an array has too many rows \(found: 1000000\).*100,000"):
            unpack_arrays(data, error=SkinError, max_rows={"places": 100_000})
        assert tracemalloc.get_traced_memory()[1] < 4_000_000
    finally:
        tracemalloc.stop()
    assert len(unpack_arrays(data, error=SkinError, max_rows={"places": 1_000_000})[1]["12_places"]) == 1_000_000


@pytest.mark.long
def test_too_many_arrays_are_rejected():
    with pytest.raises(SkinError, match="implausible size"):
        unpack_arrays(members(**{f"m{i}": b"" for i in range(10_001)}), error=SkinError)


def test_wrong_array_shape_in_a_header_allocates_no_memory():
    false_shape = npy(np.zeros(4)).replace(b"(4,)", b"(4000000000000,)")
    with pytest.raises(SkinError):
        unpack_arrays(members(header=HEADER, false_shape=false_shape), error=SkinError)
    short = npy(np.zeros(40)).replace(b"(40,)", b"(99,)")
    with pytest.raises(SkinError, match="does not fit"):
        unpack_arrays(members(header=HEADER, short=short), error=SkinError)


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"", "damaged"),
        (b"nothing like a zip", "damaged"),
        (members(header=HEADER)[:-30], "damaged"),
        (members(), "no header"),
        (members(header=b"not an array"), "damaged"),
        (members(header=npy(np.frombuffer(b"{", np.uint8))), "damaged"),
        (members(header=npy(np.frombuffer(b'{"a": 1, "a": 2}', np.uint8))), "the key a twice"),
        (members(header=npy(np.frombuffer(b"[]", np.uint8))), "not an object"),
        (members(header=b"\x93NUMPY\x09\x00"), "unknown format"),
    ],
)
def test_broken_files_are_rejected_by_name(data, problem):
    with pytest.raises(SkinError, match=f"hand.npz.*{problem}"):
        unpack_arrays(data, file="hand.npz", error=SkinError)


def npy_header(text: str, body: bytes = b"") -> bytes:
    """An npy file whose header says anything."""
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text.encode("latin1") + body


def described(descr: str, shape: str, order: str = "False") -> str:
    """An npy header as numpy writes it."""
    return f"{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}"


@pytest.mark.parametrize(
    "text",
    [
        described("'<f8'", "(2,)"),
        described("'<f8'", "(1, 2)", "True"),
        described("'<i4'", "(2,2)"),
        described("'|b1'", "(16,)"),
        "{'descr':'<f8','fortran_order':False,'shape':(2,)}",
        '{"descr": "<f8", "fortran_order": False, "shape": (2,)}   \n',
    ],
)
def test_headers_of_other_programs_are_read(text):
    known = np.load(io.BytesIO(npy_header(text, bytes(16))))
    found = unpack_array(npy_header(text, bytes(16)), place="a", error=SkinError)
    assert (found.dtype, found.shape, found.flags.f_contiguous) == (known.dtype, known.shape, known.flags.f_contiguous)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{}",
        "x",
        "(" * 9000,
        "-" * 9000 + "1",
        "[" * 60_000,
        "\x00" * 100,
        described("'<f8'", "(10000000000000, 3)"),
        described("'<f8'", "(0, 999999999999999999, 999999999999999999)"),
        described("'<f8'", "(-1,)"),
        described("'<f8'", "(2L,)"),
        described("'<f8'", "(" + "1, " * 2000 + ")"),
        described("'<c16'", "()"),
        described("'|O'", "()"),
        described("[('a', '<f8')]", "()"),
        described("'f8,f8'", "()"),
        described("'<f3'", "()"),
        described("'<f8'", "()", "1"),
        described("'<f8'", "'\\d'"),
    ],
)
def test_invalid_headers_are_rejected_by_name(text):
    with pytest.raises(SkinError, match=r"hand\.npy, column a: "):
        unpack_array(npy_header(text), file="hand.npy", place="column a", error=SkinError)


def test_flipped_bit_is_detected():
    data = bytearray(pack_arrays({}, {"a": np.random.default_rng(0).random(1000)}))
    data[len(data) // 2] ^= 1
    with pytest.raises(SkinError, match="damaged"):
        unpack_arrays(bytes(data), error=SkinError)


def test_arrays_of_other_programs_need_no_header():
    buffer = io.BytesIO()
    np.savez(buffer, places=np.eye(3), numbers=np.arange(3))
    arrays = unpack_bare_arrays(buffer.getvalue(), error=SkinError)
    assert list(arrays) == ["places", "numbers"]
    np.testing.assert_array_equal(arrays["places"], np.eye(3))
    with pytest.raises(SkinError, match="no header"):
        unpack_arrays(buffer.getvalue(), error=SkinError)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig", "utf-8"])
def test_text_is_read_in_its_encoding(tmp_path, encoding):
    """Excel saves "Unicode text" as UTF-16 with a mark."""
    path = tmp_path / "file"
    path.write_bytes("x\tÅ\n".encode(encoding))
    assert read_bounded_text(path, error=SkinError) == "x\tÅ\n"


def test_text_is_read_completely_up_to_the_limit(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"\xef\xbb\xbfx\xff")
    assert read_bounded_text(path, error=SkinError) == "x\ufffd"
    with pytest.raises(SkinError, match="file.*too large.*5 bytes.*The maximum is 4 bytes"):
        read_bounded_text(path, most=4, error=SkinError)
    path.write_bytes(bytes(2**20))
    with pytest.raises(SkinError, match="The maximum is 64 KiB"):
        read_bounded_text(path, most=2**16, error=SkinError)
    path.write_bytes(b"\xef\xbb\xbfx\xff")
    for missing in (tmp_path / "nowhere", tmp_path):
        with pytest.raises(SkinError, match="cannot be read"):
            read_bounded_text(missing, error=SkinError)


def test_lines_are_written_completely_or_not_at_all(tmp_path):
    write_lines(tmp_path / "file", ["one", "two \ud800"], error=SkinError)
    assert (tmp_path / "file").read_bytes() == b"one\ntwo ?\n"
    with pytest.raises(SkinError, match="cannot be written.*folder .*no does not exist.*Create the folder"):
        write_lines(tmp_path / "no" / "file", [], error=SkinError)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize("folder", [True, False])
def test_output_of_a_library_is_complete_or_absent(tmp_path, folder):
    def make(name, text, error=None):
        with make_atomically(tmp_path / name, error=SkinError) as part:
            if folder:
                part.mkdir()
            (part / "inside" if folder else part).write_text(text)
            assert part.parent == tmp_path
            if error is not None:
                raise error

    make("made", "whole")
    assert [path.name for path in tmp_path.iterdir()] == ["made"]
    with pytest.raises(KeyboardInterrupt):
        make("other", "half", KeyboardInterrupt())
    assert [path.name for path in tmp_path.iterdir()] == ["made"]
    with pytest.raises(SkinError, match=r"folder of this name|already exists"):
        make("made", "again")
    assert ((tmp_path / "made" / "inside") if folder else (tmp_path / "made")).read_text() == "whole"
