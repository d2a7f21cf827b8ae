"""Standard streams that are closed, full or ASCII, long names and a full disk: one message, never a crash.

Each command runs in a process of its own, as its streams are the process's. The default run tries a few commands.
"""

from __future__ import annotations

import io
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tactile_maps.cli.main import run_command
from tactile_maps.cli.shared.output import StandardOutputError, prepare_streams, print_line
from tests.cli.test_outputs import OUTPUTS, WORDS, commands
from tests.support.recordings import record, small_arm

ROOT = Path(__file__).resolve().parents[2]
ASCII = {"LC_ALL": "C", "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
QUICK = [["--version"], ["guide", "--json"]]
"""Lines of which each prints something."""
ALL = [
    *([command, "--help"] for command in sorted(commands())),
    ["cache"],
    ["inspect", "arm"],
    ["inspect", "arm", "--json"],
    ["run", "arm", "--for", "0.05"],
    ["weigh", "arm"],
    ["map", "arm", "--taxels", "200"],
]
LINES = [*QUICK, *(pytest.param(words, marks=pytest.mark.long) for words in ALL)]
LIMITED = """
import resource, signal, sys
sys.dont_write_bytecode = True  # it would be cut
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))
from tactile_widgets.__main__ import main
sys.exit(main(sys.argv[1:]))
"""
"""A limit on the file size that simulates a full disk."""


def run_words(words, redirect="", *, env=(), unbuffered=False) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of a line, with redirections of the shell."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONUNBUFFERED"} | dict(env)
    environment |= {"QT_QPA_PLATFORM": "offscreen", **({"PYTHONUNBUFFERED": "1"} if unbuffered else {})}
    line = ["sh", "-c", f'"$@" {redirect}', "sh", sys.executable, "-m", "tactile_maps", *words]
    done = subprocess.run(line, cwd=ROOT, env=environment, capture_output=True, check=False, timeout=300)
    error = done.stderr.decode(errors="replace")
    assert "unexpected" not in error
    assert "Traceback" not in error
    assert "Exception ignored" not in error
    return done.returncode, done.stdout.decode(errors="replace"), error


@pytest.mark.parametrize("words", LINES)
def test_full_disk_behind_standard_output_gives_one_message(words):
    code, _, error = run_words(words, ">/dev/full")
    assert code == 1
    assert error.count("standard output: the output cannot be written (found: No space left on device)") == 1


@pytest.mark.long
def test_unbuffered_help_is_checked_for_write_errors():
    code, _, error = run_words(["--version"], ">/dev/full", unbuffered=True)
    assert (code, "No space left" in error) == (1, True)


@pytest.mark.parametrize("words", LINES)
def test_closed_streams_lose_only_the_output(words):
    assert run_words(words, "<&- >&- 2>&-") == (0, "", "")


@pytest.mark.long
@pytest.mark.parametrize("words", LINES)
def test_closed_pipe_of_the_consumer_is_not_reported(words):
    code, _, error = run_words(words, "| true; exit 0")
    assert (code, error) == (0, run_words(words, ">/dev/null")[2]), "the warnings of any run, and nothing else"


@pytest.mark.long
def test_exit_code_is_1_even_if_the_failure_cannot_be_reported():
    assert run_words(["inspect", "nowhere"], "2>/dev/full")[0] == 1
    assert run_words(["inspect"], "2>&-")[0] == 2


@pytest.mark.long
@pytest.mark.parametrize("words", LINES)
def test_ascii_terminal_gets_replacements(words):
    code, output, error = run_words(words, env=ASCII)
    assert code == 0
    assert (output + error).isascii()


def test_unsupported_characters_are_written_in_plain_letters(monkeypatch):
    written = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(written, encoding="ascii", errors="strict"))
    prepare_streams()
    print_line("12° 3 mm² × 5 µm → é … 漢 \udcff")
    sys.stdout.flush()
    assert written.getvalue().decode() == "12 deg 3 mm2 x 5 um -> e ... ? ?\n"
    monkeypatch.undo()


def test_library_output_never_reaches_a_file_if_standard_output_is_closed(tmp_path):
    """The first file that is opened would otherwise become standard output."""
    code = (
        "import os, sys\nfrom tactile_maps.cli.shared.output import prepare_streams\nprepare_streams()\n"
        "stream = open(sys.argv[1], 'wb')\nos.write(1, b'printed')\nassert stream.fileno() > 2\n"
    )
    line = ["sh", "-c", '"$@" <&- >&- 2>&-', "sh", sys.executable, "-c", code, str(tmp_path / "x")]
    assert subprocess.run(line, cwd=ROOT, check=False, timeout=300).returncode == 0
    assert (tmp_path / "x").read_bytes() == b""


def test_write_that_fails_names_standard_output(monkeypatch):
    with Path("/dev/full").open("w", buffering=1) as full:
        monkeypatch.setattr(sys, "stdout", full)
        with pytest.raises(StandardOutputError, match=r"standard output.*No space left"):
            print_line("x")
        monkeypatch.undo()


LONG = "x" * 300
NAMES = [
    ["inspect", LONG],
    ["inspect", f"{LONG}.urdf"],
    ["inspect", f"{LONG}.toml"],
    ["map", LONG],
    ["map", f"{LONG}.stl"],
    ["map", f"{LONG}.csv"],
    pytest.param(["map", "arm", "--uv", LONG], marks=pytest.mark.long),
    ["run", LONG],
    ["run", "--scene", LONG],
    ["run", "--robot", f"{LONG}.urdf"],
    ["run", "arm", "--skin", LONG],
    ["run", "arm", "--stimuli", LONG],
    ["run", "arm", "--sweep", LONG, "-o", "d"],
    ["listen", LONG],
    ["listen", "x.csv", "--skin", f"{LONG}.csv"],
    pytest.param(["listen", "x.csv", "--calibration", LONG], marks=pytest.mark.long),
    ["weigh", LONG],
    ["calibrate", LONG],
    ["place", LONG],
    ["replay", LONG],
    ["trim", LONG, "-o", "a"],
    ["export", LONG, "--to", "csv", "-o", "a"],
    ["compare", LONG, "--controllers", "qp"],
    ["study", LONG],
    ["budget", LONG, "--milliseconds", "1"],
    ["run", "arm", "--package-root", LONG],
]


@pytest.mark.parametrize("words", NAMES, ids=lambda words: " ".join(words).replace(LONG, "LONG"))
def test_too_long_file_name_gives_one_message(words, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run_command(words, windows={}) in (1, 2)
    error = capsys.readouterr().err
    assert "unexpected" not in error
    assert len(error) > 0
    assert list(tmp_path.iterdir()) == []


@pytest.fixture(scope="module")
def source(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("source") / "in.mcap"
    record(small_arm(), path, ticks=160)
    return path


SHORT = {
    "compare": ["--for", "0.05"],
    "inspect": [],
    "weigh": [],
    "run": ["--for", "0.05"],
    "study": ["--quick"],
    "screenshot": ["--scene", "arm", "--at", "0"],
    "film": ["--to", "0.1"],
}
"""Words that make a command short."""
DISK_QUICK = {("recover", "--output"), ("run", "--output")}


@pytest.mark.long
@pytest.mark.parametrize(
    ("command", "option"),
    [
        pytest.param(*one, marks=() if one in DISK_QUICK else pytest.mark.long)
        for one in OUTPUTS
        if "in.csv" not in WORDS[one[0]]
    ],
)
def test_full_disk_exits_with_1_and_leaves_no_file(command, option, source, tmp_path):
    given = {"in.mcap": str(source), "in.stl": "arm"}
    words = [command, *(given.get(word, word) for word in WORDS[command]), *SHORT.get(command, [])]
    if command == "map":
        words += ["--taxels", "200"]
    words += [
        option,
        str(tmp_path / ("out" if command in ("compare", "study", "export") else f"out{_ending(option, command)}")),
    ]
    done = subprocess.run(
        [sys.executable, "-c", LIMITED, *words],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
        env=os.environ | {"QT_QPA_PLATFORM": "offscreen"},
    )
    assert done.returncode == 1, done.stderr
    assert "cannot be" in done.stderr
    assert "unexpected" not in done.stderr
    left = [path for path in tmp_path.rglob("*") if path.is_file() and path.stat().st_size and path.suffix != ".jsonl"]
    assert left == []


def _ending(option: str, command: str) -> str:
    endings = {"--report": ".html", "--stimuli": ".toml"}
    return endings.get(option, {"map": ".npz", "screenshot": ".png", "film": ".mp4"}.get(command, ".mcap"))
