"""The digest of the program: of every module but those left out."""

from __future__ import annotations

from tactile_maps.session import program_digest as module
from tactile_maps.session.program_digest import program_digest


def test_digest_changes_with_every_relevant_module(tmp_path, monkeypatch):
    for name in ("core/a.py", "cli/b.py"):
        (tmp_path / name).parent.mkdir()
        (tmp_path / name).write_text("1")
    (tmp_path / "session").mkdir()
    monkeypatch.setattr(module, "__file__", str(tmp_path / "session" / "program_digest.py"))
    make = program_digest.__wrapped__
    whole = make()
    part = make(without=("cli",))
    (tmp_path / "cli/b.py").write_text("2")
    assert make() != whole
    assert make(without=("cli",)) == part != make()
    (tmp_path / "core/a.py").write_text("2")
    assert make(without=("cli",)) != part
