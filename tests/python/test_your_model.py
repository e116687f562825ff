# SPDX-License-Identifier: Apache-2.0
import pathlib
import re

import numpy as np

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs/your-model.md"


def test_the_program_of_the_page_turns_the_top_of_a_model(tmp_path, monkeypatch):
    points = np.random.default_rng(1).uniform(-1, 1, (50, 3))
    lines = ["v {} {} {}\n".format(*p) for p in points.tolist()]
    (tmp_path / "model.obj").write_text("".join(lines))
    monkeypatch.chdir(tmp_path)
    (program,) = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(encoding="utf-8"),
                            re.DOTALL | re.MULTILINE)
    exec(compile(program, PAGE.name, "exec"), {})
    turned = np.loadtxt(tmp_path / "turned.obj", usecols=(1, 2, 3))
    top, bottom = points[:, 1] > 0.9, points[:, 1] < -0.5
    np.testing.assert_allclose(turned[:, 1], points[:, 1], atol=1e-12)
    assert (np.abs(turned - points)[top].max(axis=1) > 0.1).all()
    # The part below the falloff moves only as far as the smooth weights of level 3 reach.
    assert np.abs(turned - points)[bottom].max() < np.abs(turned - points)[top].max() / 4
