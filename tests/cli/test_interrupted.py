"""Ctrl-C, SIGTERM, SIGHUP, SIGQUIT and a closed terminal end every command at once, with one line, and leave no process
and no part of a file behind.
"""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import psutil
import pytest

from tactile_maps.cli.commands import study as study_command
from tactile_maps.cli.main import run_command
from tactile_maps.recording.player import open_recording

ROOT = Path(__file__).resolve().parents[2]
SECONDS = 60.0
CODES = [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129), (signal.SIGQUIT, 131)]


def interrupted(words: list[str], folder: Path, number: int, *, once) -> tuple[int, str, list[psutil.Process]]:
    """Exit code and errors of a command that gets a signal ``once`` this is so, and which of its children live on."""
    environment = os.environ | {"QT_QPA_PLATFORM": "offscreen"}
    command = [sys.executable, "-m", "tactile_maps", *words]
    process = subprocess.Popen(
        command, cwd=folder, env=environment, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    program = psutil.Process(process.pid)
    deadline = time.monotonic() + SECONDS
    while not once(program):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
    children = program.children(recursive=True)
    if number in (signal.SIGINT, signal.SIGHUP, signal.SIGQUIT):
        os.killpg(process.pid, number)  # a terminal sends it to all of them
    else:
        process.send_signal(number)
    _, errors = process.communicate(timeout=SECONDS)
    _, alive = psutil.wait_procs(children, timeout=SECONDS)
    return process.returncode, errors, alive


def under_way(seconds: float):
    """Two workers and their two keepers, the workers as long [CPU s]."""

    def reached(program) -> bool:
        children = program.children(recursive=True)
        return len(children) == 4 and sum(child.cpu_times().user > seconds for child in children[2:]) == 2

    return reached


@pytest.mark.long
@pytest.mark.parametrize("seconds", [0.05, 1.0], ids=["starting", "working"])
@pytest.mark.parametrize(("number", "code"), CODES)
def test_interrupted_study_ends_all_its_processes(tmp_path, number, code, seconds):
    words = ["study", "force-feedback", "--quick", "--jobs", "2"]
    found, errors, alive = interrupted(words, tmp_path, number, once=under_way(seconds))
    assert (found, alive) == (code, [])
    assert errors.splitlines()[-1] == "tactile-maps: interrupted"
    assert "Traceback" not in errors


def rows_of(folder: Path) -> list[dict]:
    rows = json.loads((folder / "image-cost.json").read_text())["rows"]
    return [{key: value for key, value in row.items() if not key.endswith("ms")} for row in rows]


@pytest.mark.long
def test_killed_study_resumes_with_the_same_table(tmp_path):
    words = [sys.executable, "-m", "tactile_maps", "study", "image-cost", "--quick", "-o"]
    environment = dict(os.environ)
    subprocess.run([*words, tmp_path / "whole"], env=environment, check=True)
    log = tmp_path / "killed" / "image-cost.cases.jsonl"
    kills = 0
    for lines in (2, 5, 9):
        process = subprocess.Popen([*words, tmp_path / "killed", "--resume"], env=environment)
        while not log.exists() or log.read_bytes().count(b"\n") < lines:
            assert process.poll() is None or kills
            if process.poll() is not None:
                break
        process.kill()
        kills += process.wait() == -signal.SIGKILL
    assert kills
    again = subprocess.run(
        [*words, tmp_path / "killed", "--resume", "--json"], env=environment, check=True, stdout=subprocess.PIPE
    )
    assert json.loads(again.stdout.splitlines()[-1])["known"] >= 2
    assert rows_of(tmp_path / "killed") == rows_of(tmp_path / "whole")


@pytest.mark.long
@pytest.mark.parametrize(("number", "code"), CODES)
def test_interrupted_recording_is_completed(tmp_path, number, code):
    file = tmp_path / "x.mcap"
    words = ["run", "poke", "--for", "600", "-o", str(file)]
    found, _, _ = interrupted(words, tmp_path, number, once=lambda program: file.exists() and file.stat().st_size > 3e6)
    assert found == code
    assert open_recording(file).complete


@pytest.mark.long
@pytest.mark.parametrize("controlling", [False, pytest.param(True, marks=pytest.mark.long)])
def test_closed_terminal_completes_the_recording(tmp_path, controlling):
    file = tmp_path / "x.mcap"
    command = [sys.executable, "-m", "tactile_maps", "run", "poke", "--for", "600", "-o", str(file)]
    environment = dict(os.environ)
    screen, terminal = os.openpty()
    process = subprocess.Popen(
        [*(["setsid", "--ctty", "--wait"] if controlling else []), *command],
        env=environment,
        stdin=terminal,
        stdout=terminal,
        stderr=terminal,
        start_new_session=True,
    )
    os.close(terminal)
    close_terminal(screen, once=lambda: file.exists() and file.stat().st_size > 1e6)
    assert process.wait(SECONDS) == 129
    assert open_recording(file).complete


def close_terminal(screen: int, *, once: Callable[[], bool]) -> None:
    """Read what a program shows on its terminal, and close the terminal ``once`` this is so."""
    deadline = time.monotonic() + SECONDS
    while not once():
        assert time.monotonic() < deadline
        if select.select([screen], [], [], 0.05)[0]:
            os.read(screen, 65536)
    os.close(screen)


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize(("number", "code"), CODES)
def test_signal_ends_a_command_with_one_line(tmp_path, capsys, monkeypatch, number, code):
    monkeypatch.setattr(study_command, "progress_line", lambda: lambda text, share: os.kill(os.getpid(), number))
    assert run_command(["study", "map-cost", "--quick", "-o", str(tmp_path / "out")], windows={}) == code
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL
    assert capsys.readouterr().err.splitlines()[-1] == "tactile-maps: interrupted"
    assert not list((tmp_path / "out").glob("*.csv"))


def test_interrupt_wrapped_by_a_library_counts_as_an_interrupt(capsys):
    def compiled(_):
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as error:
            raise SystemError("a callback failed") from error

    assert run_command(["gui"], windows={"gui": compiled}) == 130
    assert "interrupted" in capsys.readouterr().err
