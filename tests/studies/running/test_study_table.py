"""Reading tables of studies: shipped tables, tables written here, and invalid files."""

from __future__ import annotations

import math

import pytest

from tactile_maps.core.assets import asset
from tactile_maps.core.errors import UsageError
from tactile_maps.core.file_kinds import FileKind
from tactile_maps.skin.formats.identify import kind_of
from tactile_maps.studies.base.hypotheses import bootstrap_median
from tactile_maps.studies.running.study_table import StudyTable, only, read_study_table, table_points
from tactile_maps.studies.running.tables import csv_table, parquet_table

ROWS = [
    {"robot": robot, "level": level, "seed": seed, "verdict": "met", "seconds": level + 0.1 * seed, "sure": True}
    for robot in ("arm", "icub")
    for level in (10.0, 2.0)
    for seed in range(5)
]


@pytest.fixture
def table(tmp_path):
    (tmp_path / "mine.csv").write_bytes(csv_table(ROWS))
    return read_study_table(tmp_path / "mine.csv")


def test_written_tables_are_read_unchanged(tmp_path, table):
    assert list(table.rows) == ROWS
    assert (table.case_columns, table.measures) == (["robot", "level"], ["seconds", "level"])
    (tmp_path / "mine.csv").write_bytes(csv_table(ROWS).decode().encode("utf-16"))
    assert list(read_study_table(tmp_path / "mine.csv").rows) == ROWS
    pytest.importorskip("pyarrow")
    (tmp_path / "mine.parquet").write_bytes(parquet_table(ROWS))
    assert list(read_study_table(tmp_path / "mine.parquet").rows) == ROWS


def test_shipped_tables_are_valid(tmp_path):
    shipped = sorted(asset("findings").glob("*.csv"))
    assert len(shipped) >= 5
    for path in shipped:
        assert kind_of(path) is FileKind.STUDY_TABLE
        assert read_study_table(path).measures


def test_point_is_the_median_over_seeds_with_its_interval(table):
    points = table_points(table, table.rows, "level", "seconds", "robot")
    assert [(point.x, point.series) for point in points] == [(2, "arm"), (2, "icub"), (10, "arm"), (10, "icub")]
    assert points[0].interval == bootstrap_median([2 + 0.1 * seed for seed in range(5)])
    assert len(points[0].rows) == 5
    assert not points[0].pooled


def test_rows_of_several_cases_at_one_point_are_reported(table):
    (first, _) = table_points(table, table.rows, "level", "seconds")
    assert first.pooled == ("robot",)
    rows = only(table.rows, "robot=arm, level=2")
    assert [row["seed"] for row in rows] == list(range(5))
    (point,) = table_points(table, rows, "level", "seconds")
    assert not point.pooled


def test_rows_of_one_case_differ_by_texts_which_cannot_be_plotted():
    table = read_study_table(asset("findings", "needs.csv"))
    assert table.case_columns == ["scene", "seconds", "effect"]
    assert "switched" not in table.measures, "some of what was switched are numbers, most are words"
    assert table.measures[0] == "change"
    (point, *_) = table_points(table, table.rows, "scene", "change")
    assert point.pooled == ("effect",)
    twice = StudyTable(table.file, (*table.rows, *table.rows))
    assert twice.case_columns == ["scene", "seconds"], "a row and its copy are equal"


def test_failures_are_infinite_and_missing_values_are_counted(table):
    rows = [{**row, "seconds": None, "verdict": "cannot" if row["seed"] < 3 else "met"} for row in table.rows[:5]]
    (point,) = table_points(table, rows, "level", "seconds")
    assert (point.interval.middle, point.missing) == (math.inf, 2)
    assert not table_points(table, rows[3:], "level", "seconds")


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.csv", b"", "no rows"),
        ("a.csv", b"seed,b\n", "no rows"),
        ("a.csv", b"x,y,z\n1,2,3\n", "column seed is missing"),
        ("a.csv", b"seed,b\n1\n", "line 2 is incomplete"),
        ("a.csv", b"seed,seed\n1,2\n", "two columns have the same name"),
        ("a.csv", b"seed,b\n1,word\n", "no column of numbers"),
        ("a.csv", b"\xff\xfe\x00", "not a CSV file"),
        ("a.txt", b"seed", "not a study table"),
    ],
)
def test_files_that_are_not_tables_are_rejected(tmp_path, name, content, message):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(UsageError, match=message):
        read_study_table(tmp_path / name)


def test_broken_parquet_is_rejected(tmp_path):
    pytest.importorskip("pyarrow")
    (tmp_path / "a.parquet").write_bytes(b"PAR1 and no more")
    with pytest.raises(UsageError, match="not a Parquet file"):
        read_study_table(tmp_path / "a.parquet")


def test_impossible_conditions_and_points_are_rejected(table):
    for condition in ("robot", "nothing=1"):
        with pytest.raises(UsageError, match="invalid condition"):
            only(table.rows, condition)
    many = [{**ROWS[0], "level": float(k)} for k in range(401)]
    with pytest.raises(UsageError, match="too many points to draw"):
        table_points(table, many, "level", "seconds")


def test_theory_columns_accompany_measured_columns():
    table = read_study_table(asset("findings", "loop-laws.csv"))
    assert [column.column for column in table.theory("measured")] == ["predicted", "explained"]
    assert not table.theory("x")
    rows = only(table.rows, "law=onset, plant=ideal joints, delay=1")
    (point,) = table_points(table, rows, "delay", "measured")
    assert point.predicted("predicted") == 2000
    assert not read_study_table(asset("findings", "needs.csv")).theory("change")
