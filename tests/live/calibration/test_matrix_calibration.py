"""Matrices of three-axis taxels from logs of force vectors."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import LiveError
from tactile_maps.live.calibration.calibration import load_calibration, save_calibration
from tactile_maps.live.calibration.matrix_calibration import (
    ForceVectorLog,
    fit_matrices,
    has_force_vectors,
    read_force_vectors,
)
from tactile_maps.skin.model.skin import Skin, taxels_with_axes
from tactile_maps.skin.model.skin_file import save_skin
from tactile_widgets.__main__ import main
from tests.support.touch import bar_skin

OFFSET = np.array([1200.0, -300.0, 80.0])


@pytest.fixture(scope="module")
def skin():
    (patch,) = bar_skin().patches
    return Skin((replace(patch, taxels=taxels_with_axes(patch.taxels, 3)),))


def made(skin, *, taxels=(3, 8), rows=80, noise=0.0, seed=1):
    """A log of random force vectors, and the matrices [Pa per count] by which the readings were made."""
    random = np.random.default_rng(seed)
    matrices = {}
    parts = []
    for taxel in taxels:
        matrix = np.diag([40.0, 25.0, 25.0]) + random.normal(0.0, 4.0, (3, 3))
        forces = np.column_stack([random.uniform(0.2, 3.0, rows), random.normal(0.0, 0.7, (rows, 2))])
        forces[:4] = 0.0
        change = forces / skin.areas[taxel] @ np.linalg.inv(matrix).T
        readings = OFFSET + change + random.normal(0.0, noise, change.shape)
        matrices[taxel] = matrix
        parts.append((np.full(rows, taxel), forces, readings))
    return ForceVectorLog(*(np.concatenate(part) for part in zip(*parts, strict=True))), matrices


def test_matrices_are_recovered_from_exact_readings_and_reproduce_the_forces(skin):
    log, matrices = made(skin)
    found = fit_matrices(log, skin)
    for taxel, matrix in matrices.items():
        np.testing.assert_allclose(found.calibration.matrix[taxel], matrix, rtol=1e-9)
    assert found.error.max() < 1e-9
    assert (found.independent_error > 0.05).all(), "cross-talk"
    change = np.zeros((len(skin), 3))
    change[3] = np.linalg.solve(matrices[3], [5e3, -1e3, 2e3])
    pressure, shear = found.calibration.independent(change[:, 0], change[:, 1:])
    np.testing.assert_allclose([pressure[3], *shear[3]], [5e3, -1e3, 2e3])
    assert found.calibration.offset[3] == pytest.approx(1200.0)
    assert (len(found.pooled), found.rows[3]) == (len(skin) - 2, 76)


def test_uncertainty_and_held_out_errors_match_the_noise(skin):
    log, matrices = made(skin, taxels=(3,), rows=300, noise=20.0)
    found = fit_matrices(log, skin)
    true = skin.areas[3] * 20.0 * np.linalg.norm(matrices[3], axis=1)
    np.testing.assert_allclose(found.error, true, rtol=0.2)
    np.testing.assert_allclose(found.calibration.deviation[3], found.error[0] / skin.areas[3])
    off = np.linalg.norm(found.calibration.matrix[3] - matrices[3]) / np.linalg.norm(matrices[3])
    assert 0.3 * off < found.uncertainty[3] < 3 * off


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda log: replace(log, forces=log.forces * [1, 1, 0]), "forces do not determine a matrix.*taxel 3"),
        (lambda log: replace(log, readings=log.readings[:, [0, 1, 1]]), "channels do not determine a force.*taxel 3"),
        (lambda log: ForceVectorLog(log.taxels[:9], log.forces[:9], log.readings[:9]), "no taxel has enough rows"),
    ],
)
def test_logs_that_determine_no_matrix_are_rejected(skin, change, problem):
    log, _ = made(skin, taxels=(3,))
    with pytest.raises(LiveError, match=problem):
        fit_matrices(change(log), skin)


def written(path, log, *, header="taxel,force_n,force_t1,force_t2,p,t1,t2"):
    rows = np.column_stack([log.taxels, log.forces, log.readings]).tolist()
    lines = [",".join([str(int(row[0])), *map(repr, row[1:])]) for row in rows]
    path.write_text("\n".join([header, *lines, ""]))
    return path


def test_calibrate_writes_matrices_of_a_file_of_force_vectors(skin, tmp_path, capsys):
    log, matrices = made(skin)
    path = written(tmp_path / "log.csv", log)
    assert has_force_vectors(path)
    save_skin(skin, tmp_path / "skin.npz")
    output = tmp_path / "matrices.csv"
    arguments = ["calibrate", str(path), "--skin", str(tmp_path / "skin.npz"), "-o", str(output)]
    assert main(arguments) == 0
    said = capsys.readouterr()
    assert "Matrices" in said.out
    assert "of held-out rows" in said.out
    assert "with the common matrix" in said.err
    np.testing.assert_allclose(load_calibration(output, skin).matrix[8], matrices[8], rtol=1e-9)
    page = tmp_path / "report.html"
    assert main([*arguments[:-2], "--report", str(page), "--json"]) == 0
    table = page.read_text().split("<h2>Taxels</h2>")[1].split("</table>")[0]
    assert table.count("<tr><td>") == int(skin.three_axis.sum()), "one row for each taxel with three axes"
    assert f"<td>{matrices[8][0, 1]:.5g}</td>" in table
    assert "<td>common</td>" in table
    figures = json.loads(capsys.readouterr().out)
    assert figures["unit"] == "N"
    assert len(figures["error"]) == 3


def test_wrong_columns_and_taxels_are_named(skin, tmp_path):
    log, _ = made(skin)
    path = written(tmp_path / "log.csv", log, header="taxel,force_n,force_t1,force_t2,p,t1,x")
    with pytest.raises(LiveError, match=r"columns of the force vectors are missing.*t2"):
        read_force_vectors(path, skin)
    path = written(tmp_path / "log.csv", log)
    with pytest.raises(LiveError, match=r"line 2.*one axis"):
        read_force_vectors(path, bar_skin())


def test_saved_matrices_are_read_again(skin, tmp_path):
    log, _ = made(skin)
    found = fit_matrices(log, skin).calibration
    save_calibration(found, tmp_path / "one.csv")
    np.testing.assert_array_equal(load_calibration(tmp_path / "one.csv", skin).matrix, found.matrix)
