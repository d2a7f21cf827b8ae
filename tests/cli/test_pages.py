"""HTML pages of commands: they contain the printed results and are self-contained."""

from __future__ import annotations

import pytest

from tactile_maps.cli.shared.pages import write_fact_page
from tactile_maps.core.errors import ExportError
from tactile_maps.studies.base.figures import BarChart


def test_facts_tables_and_charts_are_on_one_page(tmp_path):
    file = tmp_path / "page.html"
    facts = {"Name": "a <b>", "Patches": [1, 2], "Nothing": ""}
    charts = [BarChart("Cost", "ms", {"qp": 1.5})]
    write_fact_page(file, "What & why", facts, tables={"Rows": [{"x": 1.25, "y": None}], "None": []}, charts=charts)
    text = file.read_text(encoding="utf8")
    assert "<h1>What &amp; why</h1>" in text
    assert "<td>a &lt;b&gt;</td>" in text
    assert "<td>1, 2</td>" in text
    assert "Nothing" not in text
    assert "<td>1.25</td><td></td>" in text
    assert "<h2>None</h2>" not in text
    assert text.count("<svg") == 1
    assert "src=" not in text


def test_unwritable_page_is_named(tmp_path):
    with pytest.raises(ExportError, match="missing"):
        write_fact_page(tmp_path / "missing" / "page.html", "x", {})
