# SPDX-License-Identifier: Apache-2.0
"""The steps of paraview_test.py that run with ParaView, in a folder with rest.vtu, pose.vtu and model.vtu.

    python3 paraview_steps.py FOLDER_OF_THE_PYTHON_MODULE
"""

import inspect
import pathlib
import sys

# ParaView 5.11.0 needs a function that Python 3.11 has removed.
if not hasattr(inspect, "getargspec"):
    inspect.getargspec = inspect.getfullargspec

sys.path.insert(0, sys.argv[1])
from paraview import simple  # noqa: E402

PLUGIN = pathlib.Path(__file__).resolve().parents[2] / "hosts/vtk/espalier_vtk.py"
simple.LoadPlugin(str(PLUGIN), remote=False, ns=globals())


def read(name):
    return simple.XMLUnstructuredGridReader(FileName=[name])


deform = EspalierDeform(Input=read("model.vtu"), Rest=read("rest.vtu"), Pose=read("pose.vtu"))
simple.RenameSource("deform", deform)
simple.SaveData("default.vtu", proxy=deform)
deform.Level = 1
deform.Outside = "nearest"
simple.SaveData("nearest.vtu", proxy=deform)
deform.Limit = True
deform.Outside = "keep"
simple.SaveData("limit.vtu", proxy=deform)

# The settings are part of ParaView's state.
simple.SaveState("state.pvsm")
simple.ResetSession()
simple.LoadPlugin(str(PLUGIN), remote=False, ns=globals())
simple.LoadState("state.pvsm")
again = simple.FindSource("deform")
assert (again.Level, again.Limit, again.Outside) == (1, 1, "keep"), (again.Level, again.Limit, again.Outside)
simple.SaveData("again.vtu", proxy=again)

sphere = simple.Sphere(Radius=0.4, Center=(0, 0, 0.5))
simple.SaveData("surface.ply", proxy=sphere)
simple.SaveData("surface_moved.ply",
                proxy=EspalierDeform(Input=sphere, Rest=read("rest.vtu"), Pose=read("pose.vtu")))
