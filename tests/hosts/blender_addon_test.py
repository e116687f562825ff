#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The Blender add-on (hosts/blender) and the point caches, in Blender itself. Skipped without Blender.

    blender_addon_test.py PATH_OF_ESPALIER BUILD_FOLDER
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

TOP = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(TOP / "tests/cli"))
import program  # noqa: E402
from program import CliTest  # noqa: E402

STEPS = TOP / "tests/hosts/blender_addon_steps.py"
BUILD = ""  # the folder with the Python module
# Runs a program with a window, on a screen in memory.
DISPLAY = ("xvfb-run", "-a", "-s", "-screen 0 1280x1024x24 -noreset") if shutil.which("xvfb-run") else ()
PICTURES = os.environ.get("ESPALIER_PICTURES")  # where to keep the rendered pictures


@unittest.skipUnless(shutil.which("blender"), "Blender is not installed")
class BlenderAddOn(CliTest):
    @classmethod
    def setUpClass(cls):
        cls.scripts = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.scripts.cleanup)
        cls.zip = pathlib.Path(cls.scripts.name) / "espalier_lattice.zip"
        subprocess.run([sys.executable, TOP / "hosts/blender/make_zip.py", BUILD, "-o", cls.zip], check=True,
                       stdout=subprocess.DEVNULL)
        cls.is_installed = False

    def run_blender(self, *arguments, before=(), timeout=600):
        """Runs Blender with the settings of the test, in which the add-on is enabled. Returns what Blender printed."""
        if not BlenderAddOn.is_installed:
            BlenderAddOn.is_installed = True
            self.blender("install", self.zip)
        environment = {**os.environ, "BLENDER_USER_SCRIPTS": self.scripts.name + "/scripts",
                       "BLENDER_USER_CONFIG": self.scripts.name + "/config"}
        result = subprocess.run([*before, "blender", *map(str, arguments)], cwd=self.path, text=True, timeout=timeout,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=environment)
        self.assertEqual(result.returncode, 0, result.stdout[-6000:])
        return result.stdout

    def blender(self, step, *arguments, before=(), window=False):
        """Runs a step of blender_steps/ in Blender with its factory settings."""
        printed = self.run_blender(*(() if window else ("--background",)), "--factory-startup",
                                   "--python-exit-code", 1, "--python", STEPS, "--", step, self.path, *arguments,
                                   before=before)
        self.assertIn("step passed: " + step, printed)
        self.assertNotIn("Traceback", printed)  # of a handler, which does not end Blender
        return printed

    def test_the_mesh_equals_the_result_of_the_program(self):
        import numpy as np
        self.blender("deform")
        kinds = sorted(path.stem for path in self.path.glob("*.npy"))
        self.assertEqual(len(kinds), 14)
        for kind in kinds:
            self.run_program("deform", f"{kind}.obj", "--rest", f"{kind}-rest.ovm", "--to",
                             f"{kind}-pose.ovm", "-n", 3, "-o", "out.obj", "--quiet")
            expected = np.array(self.read_points("out.obj"))
            found = np.load(self.path / f"{kind}.npy")
            # Blender's coordinates are floats of about 2: 2^-23 for each rounding, of the points, of the
            # lattice (whose weights sum to 1) and of the result.
            self.assertLess(np.abs(found - expected).max(), 3 * 2 ** -22, kind)

    def test_an_animation_is_saved_and_baked(self):
        self.blender("save")
        self.blender("reopen")
        self.blender("bake")
        self.blender("baked")

    def test_a_part_follows(self):
        self.blender("part")

    def test_custom_normals_turn(self):
        self.blender("custom_normals")

    def test_undo(self):
        self.blender("undo")

    def test_names_do_not_matter(self):
        self.blender("renamed")

    def test_cells_survive_editing(self):
        self.blender("edit")

    def test_points_outside_and_folded_cells_are_marked(self):
        self.blender("marks")

    def test_folded_cells_come_first(self):
        self.blender("folded_first")

    def test_all_buttons_in_all_states(self):
        self.blender("press_all")
        self.blender("press_at_random")

    def test_objects_that_share_a_mesh_get_their_own(self):
        self.blender("linked")

    def test_changes_after_binding_are_told(self):
        self.blender("changed")

    def test_only_what_was_made_is_removed(self):
        self.blender("keys")

    def test_frames_below_zero_are_baked(self):
        self.blender("frames")

    def test_a_cage_follows_the_faces(self):
        self.blender("cage")

    def test_the_speed_of_100000_points_is_printed(self):
        """A figure, not a timed test: the load of this machine is not known. Frames per second of processor time, of
        all cores together, do not depend on the load."""
        self.blender("speed")
        report = json.loads(self.text("speed.json"))
        self.assertGreaterEqual(report["points"], 100000)
        print(f"{report['points']} points: {report['frames_per_second']:.1f} frames a second, "
              f"{report['frames_per_cpu_second']:.1f} frames a second of processor time", file=sys.stderr)

    def test_renders_by_cycles_show_the_viewport(self):
        self.blender("rendered", "CYCLES")
        self.blender("motion_blur", "CYCLES")

    @unittest.skipUnless(DISPLAY, "xvfb-run is not installed")
    def test_renders_by_eevee_show_the_viewport(self):
        self.blender("rendered", "BLENDER_EEVEE", before=DISPLAY)
        self.blender("motion_blur", "BLENDER_EEVEE", before=DISPLAY)

    def test_files_of_this_and_of_earlier_versions_are_rendered(self):
        self.blender("save_scene")
        for name in ("new", "old"):
            self.run_blender("--background", self.path / f"{name}.blend", "-o", f"//{name}", "-F", "PNG", "-a")
            for frame in (24, 1):
                self.run_blender("--background", self.path / f"{name}.blend", "-o", f"//{name}-f", "-F", "PNG", "-f", frame)
        self.blender("compare_pictures", "new", "new-f", "old", "old-f")

    @unittest.skipUnless(DISPLAY, "xvfb-run is not installed")
    def test_a_window_renders_the_same(self):
        for engine in ("CYCLES", "BLENDER_EEVEE"):
            self.blender("render_in_window", engine, before=DISPLAY, window=True)
            self.assertEqual(self.text("window.txt"), "passed", engine)

    def test_pictures_are_rendered(self):
        self.blender("render")
        if PICTURES:
            for picture in self.path.glob("*.png"):
                shutil.copy(picture, PICTURES)

    def put_model_in_lattice(self, rest):
        """Makes a lattice, and model.obj inside it. Returns the points of the model, and its faces as loops."""
        import numpy as np
        self.run_program("shape", "cylinder", "--sectors", 6, "--layers", 3, "-o", rest)
        self.run_program("refine", rest, "-n", 0, "-o", "model.obj")
        points = np.array(self.read_points("model.obj")) * 0.8 + 0.05
        faces = [[int(word) - 1 for word in line.split()[1:]]
                 for line in self.text("model.obj").splitlines() if line.startswith("f ")]
        self.put("model.obj", "".join("v %.9g %.9g %.9g\n" % tuple(p) for p in points)
                 + "".join("f " + " ".join(str(v + 1) for v in face) + "\n" for face in faces))
        return points, faces

    def test_a_pose_of_a_model_with_y_up(self):
        """What is taken home from the page: the model, the lattice at rest and poses."""
        self.put_model_in_lattice("rest.vtu")
        self.run_program("pose", "rest.vtu", "--twist", "z", 50, "--move", 0.3, 0.2, -0.1, "-o", "pose.vtu")
        self.run_program("pose", "rest.vtu", "--bend", "z", 40, "-o", "bent.vtu")
        self.run_program("shape", "cylinder", "--sectors", 5, "--layers", 3, "-o", "other.vtu")
        self.deform("model.obj", "rest.vtu", "rest.vtu", out="model.glb")
        for name in ("pose", "bent"):
            self.run_program("deform", "model.obj", "--rest", "rest.vtu", "--to", f"{name}.vtu", "-n", 3, "-o",
                             f"{name}.obj", "--quiet")
        import numpy as np
        np.save(self.path / "expected.npy", [self.read_points(f"{name}.obj") for name in ("pose", "bent")])
        self.blender("poses_with_y_up")

    def test_caches_and_gltf_of_the_program(self):
        import numpy as np
        points, faces = self.put_model_in_lattice("rest.ovm")
        poses = []
        for i in range(5):
            poses.append(f"pose{i}.ovm")
            self.run_program("pose", "rest.ovm", "--twist", "z", 20 * i, "--move", 0.1 * i, 0, 0, "-o", poses[-1])
        self.run_program("bind", "model.obj", "--rest", "rest.ovm", "-n", 2, "-o", "m.espb", "--quiet")
        self.run_program("apply", "m.espb", "--to", *poses, "-o", "out%d.obj", "--quiet")
        for kind in ("pc2", "mdd", "glb"):
            self.run_program("apply", "m.espb", "--to", *poses, "-o", f"out.{kind}", "--quiet")
        expected = np.array([self.read_points(f"out{i}.obj") for i in range(5)], dtype=np.float32)
        np.save(self.path / "expected.npy", expected)
        np.save(self.path / "points.npy", points.astype(np.float32))
        self.put("faces.json", json.dumps(faces))
        self.blender("caches")

    def test_the_order_of_vertices_after_the_importers_of_obj(self):
        """The other importer is in tests/cli/blender_test.py."""
        self.run_program("shape", "star", "-o", "rest.ovm")
        self.run_program("refine", "rest.ovm", "-n", 0, "-o", "editor.obj")

        def faces_of(name):
            return [[int(word.split("/")[0]) - 1 for word in line.split()[1:]]
                    for line in self.text(name).splitlines() if line.startswith("f ")]

        self.blender("legacy_obj")
        points, faces = self.read_points("editor.obj"), faces_of("editor.obj")
        order = list(dict.fromkeys(vertex for face in faces for vertex in face))
        self.assertNotEqual(order, sorted(order))
        # Blender writes six decimals.
        self.assert_close(self.read_points("kept.obj"), points, 1e-6)
        self.assertEqual(faces_of("kept.obj"), faces)
        self.assert_close(self.read_points("legacy.obj"), [points[vertex] for vertex in order], 1e-6)
        self.assertEqual([[order[vertex] for vertex in face] for face in faces_of("legacy.obj")], faces)


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    BUILD = sys.argv.pop(1)
    unittest.main()
