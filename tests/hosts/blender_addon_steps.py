# SPDX-License-Identifier: Apache-2.0
"""Run by Blender (blender_addon_test.py): the steps of the test, one by one, by name. They are the functions of the
modules in blender_steps/.

    blender -b --python blender_addon_steps.py -- STEP FOLDER [ARGUMENT...]
"""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from blender_steps import cells, files, following, pressing, rendering  # noqa: E402
from blender_steps.common import ARGUMENTS  # noqa: E402

steps = {**vars(cells), **vars(files), **vars(following), **vars(pressing), **vars(rendering)}
steps[ARGUMENTS[0]]()
print("step passed:", ARGUMENTS[0])
