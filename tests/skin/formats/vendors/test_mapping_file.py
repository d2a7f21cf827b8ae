"""Mapping files: taxels of any JSON, YAML or table by the names of its fields; templates; mistakes with their place."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tactile_maps.core.errors import SkinError
from tactile_maps.skin.formats.taxel_files import read_taxel_sets, read_taxels
from tactile_maps.skin.formats.vendors.mapping_file import mapping_path, mapping_template
from tactile_widgets.__main__ import main

HAND = {
    "hand": {
        "thumb": {
            "cells": [{"no": 7, "place": {"a": 1.0, "b": 2.0, "c": 3.0}, "out": [0, 0, 1], "board": 2, "wire": 5}]
        },
        "index": {
            "cells": [{"no": 7, "place": {"a": 4.0, "b": 5.0, "c": 6.0}, "out": [1, 0, 0], "board": 3, "wire": 6}]
        },
    }
}
HAND_MAPPING = """
records = "hand.*.cells"
position = ["place.a", "place.b", "place.c"]
unit = "mm"
normal = "out"
id = "no"
module = "board"
channel = "wire"
link = "*"
"""


def mapped(folder, name, content, mapping):
    path = folder / name
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    mapping_path(path).write_text(mapping)
    return path


def test_records_below_each_key_are_read_with_the_key_as_link(tmp_path):
    thumb, index = read_taxel_sets(mapped(tmp_path, "hand.json", HAND, HAND_MAPPING))
    assert [thumb.link, index.link] == ["thumb", "index"]
    np.testing.assert_allclose(index.positions, [[0.004, 0.005, 0.006]])
    np.testing.assert_allclose(index.normals, [[1, 0, 0]])
    assert [one.tolist() for one in (index.ids, index.modules, index.channels)] == [[7], [3], [6]]


def test_parallel_lists_are_read_row_by_row(tmp_path):
    document = {"unit": "mm", "x": [0.0, 5.0], "y": [0.0, 0.0], "z": [1.0, 1.0], "taxel": [30, 31], "frame": "palm"}
    text = 'position = ["x", "y", "z"]\nunit = "mm"\nid = "taxel"\nlink = "frame"\n'
    taxels = read_taxels(mapped(tmp_path, "lists.json", document, text))
    assert (taxels.link, taxels.ids.tolist()) == ("palm", [30, 31])
    np.testing.assert_allclose(taxels.positions, [[0, 0, 0.001], [0.005, 0, 0.001]])


def test_vectors_in_parallel_lists_and_yaml_are_read(tmp_path):
    text = "skin:\n  place: [[0, 0, 1], [5, 0, 1], [0, 5, 1]]\n  key: [4, 5, 6]\n"
    pytest.importorskip("yaml")
    path = mapped(tmp_path, "skin.yaml", text, 'records = "skin"\nposition = "place"\nunit = "cm"\nid = "key"\n')
    taxels = read_taxels(path)
    np.testing.assert_allclose(taxels.positions[1], [0.05, 0, 0.01])
    assert taxels.ids.tolist() == [4, 5, 6]


def test_columns_of_a_table_are_named_by_its_mapping(tmp_path):
    text = 'position = ["Breite", "Länge", "Höhe"]\nunit = "mm"\nid = "Nr."\narea = "Fläche"\n'
    path = mapped(tmp_path, "pad.csv", "Nr.;Breite;Länge;Höhe;Fläche\n3;0;0;1.5;9\n4;4;0;1.5;9\n", text)
    taxels = read_taxels(path)
    assert taxels.ids.tolist() == [3, 4]
    np.testing.assert_allclose(taxels.positions[1], [0.004, 0, 0.0015])
    np.testing.assert_allclose(taxels.areas, 9e-6)


@pytest.mark.parametrize(
    ("mapping", "problem"),
    [
        ("", r"hand\.json\.mapping\.toml: a key is missing \(found: position\)"),
        ('position = "place"\npositions = "x"\n', r"mapping\.toml, positions: unknown key.*Did you mean position"),
        ('position = ["a", "b"]\n', r"position: must be the name of one field, or a list of three"),
        ('position = "place"\nunit = "inch"\n', r"unit: unknown unit \(found: inch\)\. Choose one of: m, cm, mm"),
        ('position = "place"\nrecords = "hand.cells"\n', r"hand: a field is missing \(found: cells\).*thumb, index"),
        ('position = "place"\nrecords = "hand.*.cells"\n', r"hand\.thumb\.cells\.0, place: must be three numbers"),
        ('position = "out"\nrecords = "hand.*.cells"\nid = "out"\n', r"cells\.0, out: must be a number"),
        ('position = "out"\nrecords = "hand.*.cells"\nlink = "out"\n', r"cells\.0, out: must be a text"),
        ("position = [\n", "not TOML"),
    ],
)
def test_invalid_mapping_entry_is_reported_with_its_place(tmp_path, mapping, problem):
    with pytest.raises(SkinError, match=problem):
        read_taxel_sets(mapped(tmp_path, "hand.json", HAND, mapping))


def test_lists_of_different_length_are_rejected(tmp_path):
    path = mapped(tmp_path, "lists.json", {"x": [0, 1], "y": [0], "z": [0, 1]}, 'position = ["x", "y", "z"]\n')
    with pytest.raises(SkinError, match=r"y: the lists differ in length \(found: 1 and 2\)"):
        read_taxels(path)


@pytest.mark.parametrize(
    ("name", "content", "lines"),
    [
        (
            "points.json",
            {"unit": "mm", "cells": [{"index": 1, "x_mm": 0, "y_mm": 0, "z_mm": 0, "heat": 3}]},
            ['records = "cells"', 'position = ["x_mm", "y_mm", "z_mm"]', 'unit = "mm"', 'id = "index"'],
        ),
        ("hand.json", {"f": {"a": {"cells": [{"pos": [0, 0, 0]}]}, "b": {"cells": []}}}, ['position = "pos"']),
        ("bare.json", [[0, 0, 1], [0, 1, 1]], ['records = ""', 'position = ["0", "1", "2"]']),
        ("table.csv", "a;b\n1;2\n", ["# Fields of a record: a, b", 'position = ["x", "y", "z"]']),
    ],
)
def test_template_lists_fields_and_fills_in_known_names(tmp_path, capsys, name, content, lines):
    path = tmp_path / name
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    assert main(["inspect", str(path), "--mapping"]) == 0
    printed = capsys.readouterr().out
    assert not [line for line in lines if line not in printed]


def test_template_alone_opens_a_file_with_common_names(tmp_path):
    path = tmp_path / "points.json"
    path.write_text(json.dumps({"cells": [{"index": k, "x_mm": 5 * k, "y_mm": 0, "z_mm": 0} for k in range(3)]}))
    with pytest.raises(SkinError, match=r"layout of taxels in this JSON file is unknown.*points\.json\.mapping\.toml"):
        read_taxels(path)
    mapping_path(path).write_text(mapping_template(path))
    assert read_taxels(path).ids.tolist() == [0, 1, 2]


def test_unknown_table_names_the_mapping_file(tmp_path):
    path = tmp_path / "pad.csv"
    path.write_text("Nr;Breite\n1;2\n")
    with pytest.raises(
        SkinError, match=r"columns are missing: x, y, z.*pad\.csv\.mapping\.toml.*inspect pad\.csv --mapping"
    ):
        read_taxels(path)
