"""Rows as files."""

from __future__ import annotations

import io

import pytest

from tactile_maps.studies.running.tables import csv_table, parquet_table

ROWS = [{"a": 1, "b": "x", "c": 1}, {"a": 2, "b": [1, 2], "c": 0.5, "d": True}]


def test_csv_has_every_column_and_empty_cells():
    assert csv_table(ROWS).decode().split() == ["a,b,c,d", "1,x,1,", '2,"[1,', '2]",0.5,True']


def test_parquet_has_numbers_as_numbers_and_the_rest_as_text():
    parquet = pytest.importorskip("pyarrow.parquet")
    table = parquet.read_table(io.BytesIO(parquet_table(ROWS)))
    assert [str(field.type) for field in table.schema] == ["int64", "string", "double", "bool"]
    assert table.to_pylist()[1] == {"a": 2, "b": "[1, 2]", "c": 0.5, "d": True}
    assert parquet_table([]) is None
