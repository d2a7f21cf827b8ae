"""Meshes gathered once, under names that do not clash."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.errors import RobotError
from app.robots import asset_store
from app.robots.asset_store import AssetStore


def test_a_file_is_read_once_and_a_variant_gets_its_own_name(tmp_path: Path, rod: bytes) -> None:
    (tmp_path / "rod.stl").write_bytes(rod)
    store = AssetStore()
    names = [store.add(tmp_path / "rod.stl"), store.add(tmp_path / "rod.stl")]
    assert names == ["rod.msh", "rod.msh"]
    assert store.add(tmp_path / "rod.stl", variant="2 2 2") == "rod_2.msh"
    assert store.files["rod.msh"] == store.files["rod_2.msh"]
    assert store.findings == []


def test_a_missing_file_is_replaced_and_said(tmp_path: Path) -> None:
    store = AssetStore()
    store.add(tmp_path / "absent.stl")
    assert [(finding.kind, finding.where) for finding in store.findings] == [
        ("missing-mesh", str(tmp_path / "absent.stl"))
    ]


def test_all_meshes_together_are_bounded(tmp_path: Path, rod: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(asset_store, "MAX_FACES", 20)
    (tmp_path / "rod.stl").write_bytes(rod)
    store = AssetStore()
    store.add(tmp_path / "rod.stl")
    with pytest.raises(RobotError, match="together"):
        store.add(tmp_path / "rod.stl", variant="again")
