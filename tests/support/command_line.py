"""The command line within this process."""

from __future__ import annotations

import json

from tactile_widgets.__main__ import main


def call(capsys, *words) -> tuple[int, str, str]:
    """Return the exit code, standard output and standard error of a command."""
    status = main([str(word) for word in words])
    captured = capsys.readouterr()
    return status, captured.out, captured.err


def result_of(capsys, *words) -> dict:
    """Return the result of a command that succeeds, from ``--json``."""
    status, out, err = call(capsys, *words, "--json")
    assert status == 0, err
    return json.loads(out.splitlines()[-1])
