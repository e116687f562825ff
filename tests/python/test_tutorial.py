# SPDX-License-Identifier: Apache-2.0
"""The code of the tutorial runs, and prints what the page shows."""

import contextlib
import io
import pathlib
import re

import pytest

TUTORIAL = pathlib.Path(__file__).parents[2] / "docs/tutorial-python.md"
CELLS = re.findall(r"```python\n(.*?)```(?:\n+```text\n(.*?)```)?", TUTORIAL.read_text(), re.DOTALL)


def test_the_tutorial_runs_cell_by_cell(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # the code writes files
    assert len(CELLS) > 8
    names = {"__name__": "tutorial"}
    for number, (code, text) in enumerate(CELLS, 1):
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(code, f"{TUTORIAL.name}, cell {number}", "exec"), names)
        assert printed.getvalue() == text, f"cell {number}"


def test_cells_that_fail_are_noticed():
    code, _ = CELLS[-1]
    with pytest.raises(NameError):  # without the blocks before
        exec(compile(code, "cell", "exec"), {})
