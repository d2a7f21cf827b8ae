"""Public names of ``tactile_maps`` are documented, and the examples in their docstrings run."""

from __future__ import annotations

import doctest
import inspect
import sys

import pytest

import tactile_maps

PUBLIC = tuple(tactile_maps.__all__)


@pytest.fixture(scope="module")
def notebook(tmp_path_factory):
    """Return the variables that the docstrings' examples use, in a temporary working folder."""
    import matplotlib as mpl

    folder = tmp_path_factory.mktemp("notebook")
    names: dict[str, object] = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setitem(mpl.rcParams, "backend", "agg")
        _run(tactile_maps.__doc__, "tactile_maps", names)
        _run(inspect.getdoc(tactile_maps.record), "record", names)
        yield names


@pytest.fixture(autouse=True)
def _no_figure_stays():
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")


def _run(text: str | None, name: str, names: dict[str, object]) -> int:
    """Run the examples in ``text`` with ``names``, which they may change; return the number of examples."""
    test = doctest.DocTestParser().get_doctest(text or "", names, name, None, None)
    output: list[str] = []
    result = doctest.DocTestRunner(verbose=False).run(test, out=output.append, clear_globs=False)
    names.update(test.globs)
    assert not result.failed, "".join(output)
    return result.attempted


def test_package_has_about_thirty_public_names():
    assert 25 <= len(PUBLIC) <= 35


@pytest.mark.long
@pytest.mark.parametrize("name", PUBLIC)
def test_example_of_a_public_name_runs(name, notebook):
    examples = 1 if name == "record" else _run(inspect.getdoc(getattr(tactile_maps, name)), name, dict(notebook))
    assert examples, f"{name} has no example"


def test_package_docstring_lists_all_public_names():
    assert tactile_maps.__doc__
    assert not [name for name in PUBLIC if f"``{name}``" not in tactile_maps.__doc__]
