"""``calibrate``: a log becomes a calibration file that ``listen`` uses."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tactile_maps.maps.formats.map_file import save_map
from tactile_widgets.__main__ import main
from tests.support.touch import bar_map, bar_skin

AREAS = bar_skin(12).areas
FORCES = np.concatenate([np.zeros(5), np.linspace(0.1, 2, 15), np.linspace(2, 0.1, 15)])


@pytest.fixture(scope="module")
def skin(tmp_path_factory):
    path = tmp_path_factory.mktemp("skin") / "bar.npz"
    save_map(bar_map(12), path)
    return str(path)


@pytest.fixture
def log(tmp_path):
    """Eleven of twelve taxels, loaded one by one; the reading is a root of the pressure."""
    path = tmp_path / "log.csv"
    rows = [f"{taxel},{force},{300 + 10 * np.sqrt(force / AREAS[taxel])}" for taxel in range(11) for force in FORCES]
    path.write_text("\n".join(["taxel,force,reading", *rows]))
    return str(path)


def test_log_becomes_a_calibration_that_listen_applies(log, skin, tmp_path, capsys):
    target, page, readings = (tmp_path / name for name in ("curves.csv", "page.html", "readings.csv"))
    assert main(["calibrate", log, "--skin", skin, "-o", str(target), "--report", str(page), "--json"]) == 0
    captured = capsys.readouterr()
    found = json.loads(captured.out)
    assert found["curves"] == {"power": 12}
    assert (found["pooled"], found["rows"], found["unit"], found["largest"]) == ([11], 385, "N", 2.0)
    assert found["error"] < 0.01 < 0.1 < found["errors"]["linear"]
    assert "too few rows of 1 taxel, with the common curve of the others: taxel 11" in captured.err
    assert "power, common" in page.read_text()
    values = np.full(12, 300.0)
    values[4] += 10 * np.sqrt(5.0 / AREAS[4])
    readings.write_text("time," + ",".join(map(str, range(12))) + "\n0," + ",".join(map(str, values)) + "\n")
    assert main(["listen", str(readings), "--skin", skin, "--calibration", str(target), "--json"]) == 0
    heard = json.loads(capsys.readouterr().out)
    assert heard["calibrated"]
    assert heard["max_force_N"] == pytest.approx(5.0, rel=0.25), "beyond the log the last slope continues"


def test_result_is_described_in_text(log, skin, capsys):
    assert main(["calibrate", log, "--skin", skin]) == 0
    text = capsys.readouterr().out
    assert "385, up to 2 N" in text
    assert "12 power" in text
    assert "root mean square of held-out rows" in text


def test_log_without_zero_load_names_the_option(log, skin, tmp_path, capsys):
    path = tmp_path / "loaded.csv"
    lines = Path(log).read_text().splitlines()
    path.write_text("\n".join(line for line in lines if ",0.0," not in line))
    assert main(["calibrate", str(path), "--skin", skin]) == 1
    assert f"{path}: no reading at zero load" in capsys.readouterr().err
    assert main(["calibrate", log, "--skin", skin, "--folds", "1"]) == 2
    assert "--folds: must be 2 to 20: 1" in capsys.readouterr().err
