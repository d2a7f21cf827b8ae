"""The report of a study: table, JSON and page, and the machine they name."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from tactile_maps.studies.base.figures import BarChart, Figure, Panel
from tactile_maps.studies.base.hypotheses import Hypothesis, Judgement, Verdict
from tactile_maps.studies.study.report import (
    RunState,
    StudyResult,
    describe_machine,
    write_page,
    write_report,
)
from tactile_maps.studies.study.study import Study


def test_processor_and_versions_are_listed():
    machine = describe_machine()
    assert machine["numpy"] == np.__version__
    assert int(machine["cores"]) >= 1
    assert all(isinstance(value, str) and value for value in machine.values())
    assert {"processor", "system", "Python", "tactile-maps", "libigl"} <= set(machine)


ROWS = [
    {"method": "a<b", "seconds": 0.5, "error": 0.25, "last": True},
    {"method": "c", "seconds": 1.0, "error": float("inf")},
    {"method": "d", "problem": 'it failed, "really"'},
]


def figures(rows):
    return [Figure("Error", "s", "e", [Panel("p", {row["method"]: [(row["seconds"], row["error"])] for row in rows})])]


def outcome(rows=ROWS):
    study = Study("toy", "What & why?", "By trying.", lambda quick, seed: [], lambda case: [], figures)
    return StudyResult(study, rows, {"processor": "fast"}, 3.25, 7, 2, True)


class Page(HTMLParser):
    def __init__(self):
        super().__init__()
        self.tags = []
        self.text = []
        self.links = []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.links += [value for name, value in attrs if name in ("src", "href")]

    def handle_data(self, data):
        self.text.append(data)


@pytest.fixture
def files(tmp_path):
    return {file.suffix: file for file in write_report(outcome(), tmp_path / "deep" / "folder")}


@pytest.mark.long
def test_table_contains_every_row(files):
    with files[".csv"].open(newline="", encoding="utf8") as file:
        rows = list(csv.DictReader(file))
    assert [row["method"] for row in rows] == ["a<b", "c", "d"]
    assert float(rows[0]["error"]) == 0.25
    assert rows[2]["problem"] == ROWS[2]["problem"]
    assert rows[1]["error"] == rows[2]["error"] == "", "what has no number is an empty cell"


@pytest.mark.long
def test_json_contains_the_machine(files):
    facts = json.loads(files[".json"].read_text(encoding="utf8"))
    assert (facts["name"], facts["seed"], facts["jobs"], facts["quick"]) == ("toy", 7, 2, True)
    assert facts["machine"] == {"processor": "fast"}
    assert facts["rows"][0] == ROWS[0]
    assert facts["rows"][1]["error"] is None, "JSON knows no infinity"


def test_page_is_self_contained(files):
    page = Page()
    page.feed(files[".html"].read_text(encoding="utf8"))
    assert page.links == []
    assert "script" not in page.tags
    assert page.tags.count("svg") == 1
    text = " ".join(page.text)
    assert "What & why?" in text
    assert "a<b" in text
    assert "fast" in text


def test_rows_with_a_problem_are_listed_but_not_drawn(files):
    text = files[".html"].read_text(encoding="utf8")
    assert "it failed" in text
    drawn = text[text.index("<svg") : text.index("</svg>")]
    assert ">a&lt;b<" in drawn
    assert ">d<" not in drawn


def test_notes_accompany_their_figure(tmp_path):
    records = [
        Figure("Error", "s", "e", [Panel("p", {})], note="It is <not> so."),
        BarChart("Price", "ms", {}, note="Nor this."),
    ]
    study = Study("toy", "What?", "By trying.", lambda quick, seed: [], lambda case: [], lambda rows: records)
    page = write_page(StudyResult(study, ROWS, {}, 1.0, 0, 1, False), tmp_path)
    text = page.read_text(encoding="utf8")
    first = text.index("It is &lt;not&gt; so.")
    second = text.index("Nor this.")
    assert text.index("</svg>") < first < text.index("Price") < second


@pytest.mark.long
def test_page_of_an_unfinished_run_reloads(tmp_path):
    running = write_page(replace(outcome(), state=RunState(12, 40, remaining=200.0)), tmp_path)
    assert 'http-equiv="refresh"' in running.read_text(encoding="utf8")
    stopped = write_page(replace(outcome(), state=RunState(12, 40)), tmp_path).read_text(encoding="utf8")
    assert "refresh" not in stopped
    assert "12 of 40" in stopped
    assert "cases are done" not in write_page(outcome(), tmp_path).read_text(encoding="utf8")


def test_undrawable_rows_are_noted_in_unfinished_tables_and_fail_in_complete_ones(tmp_path):
    def needs_all(rows):
        raise KeyError("seed")

    state = RunState(12, 40, known=5, remaining=200.0, undecided=("Of <b> one row is missing.",))
    part = replace(outcome(), study=replace(outcome().study, figures=needs_all), state=state)
    page = write_page(part, tmp_path).read_text(encoding="utf8")
    assert "cannot be drawn yet" in page
    assert "Still running: 3 min left. 12 of 40 cases are done. 5 cases measured by earlier runs." in page
    assert "<li>Of &lt;b&gt; one row is missing.</li>" in page
    with pytest.raises(KeyError):
        write_page(replace(part, state=None), tmp_path)


def test_hypotheses_without_rows_are_undecided(tmp_path):
    study = replace(outcome().study, hypotheses=(Hypothesis("H0", "It is so.", lambda rows: rows[7]),))
    part = replace(outcome(), study=study, state=RunState(3, 9))
    assert "H0: not decided." in write_page(part, tmp_path).read_text(encoding="utf8")
    with pytest.raises(IndexError):
        write_page(replace(part, state=RunState(9, 9)), tmp_path)


def test_hypotheses_and_verdicts_are_on_the_page_and_in_the_json(tmp_path):
    def judge(rows):
        return Judgement(Verdict.NOT_HELD, "2 [1, 3] < 4", len(rows))

    expecting = replace(outcome().study, hypotheses=(Hypothesis("H9", "All is well.", judge),))
    found = {
        file.suffix: file.read_text("utf8") for file in write_report(replace(outcome(), study=expecting), tmp_path)
    }
    (record,) = json.loads(found[".json"])["hypotheses"]
    assert (record["hypothesis"], record["verdict"], record["rows"]) == ("H9", "not held", 2)
    page = Page()
    page.feed(found[".html"])
    text = " ".join(page.text)
    for words in ("What was expected", "H9: not held.", "All is well.", "2 [1, 3] < 4"):
        assert words in text
