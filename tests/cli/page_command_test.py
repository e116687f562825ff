#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`espalier page`: web pages with files inside. tests/web/page opens such a page in a browser.

    page_command_test.py PATH_OF_ESPALIER
"""

import base64
import json
import os
import re
import shutil
import struct
import sys
import unittest

import program
from program import CliTest, icosphere_points

ELEMENT = '<script type="application/json" id="espalier-files"></script>'
EMPTY = f"<!DOCTYPE html>\n<title>p</title>{ELEMENT}<p>\u00e4</p>\n"


class Page(CliTest):
    def setUp(self):
        super().setUp()
        self.put("empty.html", EMPTY)
        self.write_model(icosphere_points(20))
        self.run_program("shape", "box", "-o", "rest.vtu")
        self.run_program("pose", "rest.vtu", "--move", 0, 0, 1, "-o", "pose.vtu")
        self.run_program("refine", "pose.vtu", "-n", 0, "-o", "editor.obj")

    def page(self, *options, empty="empty.html", output="page.html"):
        """Returns the JSON that the page holds."""
        out = self.run_program("page", *options, "--page", empty, "-o", output).stdout
        self.assertRegex(out, rf"^{output}: [0-9.]+ kB\n$")
        before, after = EMPTY.split("</script>")
        text = self.text(output)
        self.assertTrue(text.startswith(before) and text.endswith("</script>" + after))
        return json.loads(text[len(before):len(text) - len(after) - len("</script>")])

    def companions(self, model):
        page = self.page(model)
        return [page["companions"][i] for i in page["models"][0]["companions"]]

    def assert_holds(self, entry, name):
        self.assertEqual(entry["name"], name)
        self.assertEqual(base64.b64decode(entry["data"], validate=True), self.bytes(name))

    def test_files_and_options(self):
        files = self.page("model.obj")
        self.assertEqual(set(files), {"version", "models", "poses", "options"})
        self.assertEqual((files["version"], files["poses"]), (1, []))
        self.assertEqual(files["options"], {"level": 3, "limit": False})
        self.assert_holds(files["models"][0], "model.obj")
        files = self.page("model.obj", "--rest", "rest.vtu", "--to", "pose.vtu", "editor.obj", "-n", 2)
        self.assert_holds(files["models"][0], "model.obj")
        self.assert_holds(files["rest"], "rest.vtu")
        self.assert_holds(files["poses"][0], "pose.vtu")
        self.assert_holds(files["poses"][1], "editor.obj")
        self.assertEqual(files["options"], {"level": 2, "limit": False})
        self.assertEqual(self.page("model.obj", "--limit")["options"]["limit"], True)

    def test_files_that_belong_to_the_model(self):
        os.makedirs(self.path / "art/skins")
        self.put("art/paint.mtl", "newmtl a\n\tmap_Kd -s 1 1 1 my skin.png\r\nmap_bump C:\\here\\skins\\rough.JPG\n"
                                  "map_Ks ../secret.txt\nmap_Ka none.png\nmap_Kd ../out.png\nmap_Kd link.png\nKd 1 1 1\nbump my skin.png\n")
        for name in ("art/my skin.png", "art/skins/rough.JPG", "secret.txt", "out.png", "art/other.png"):
            self.put(name, name)
        os.symlink("../secret.txt", self.path / "art/link.png")
        self.put("art/model.obj", "mtllib paint.mtl\n" + self.text("model.obj"))
        files = self.companions("art/model.obj")
        self.assertEqual([each["name"] for each in files], ["paint.mtl", "my skin.png"])
        self.assertEqual(base64.b64decode(files[1]["data"]), b"art/my skin.png")
        note = self.run_program("page", "art/model.obj", "--page", "empty.html", "-o", "page.html").stderr
        self.assertIn("art/model.obj: 5 of the files that it names are not in the page: "
                      "C:\\here\\skins\\rough.JPG, ../secret.txt, none.png, ../out.png, link.png", note)
        # Folders of another computer do not count, if the file is beside the model.
        os.rename(self.path / "art/skins/rough.JPG", self.path / "art/rough.JPG")
        files = self.companions("art/model.obj")
        self.assertEqual([each["name"] for each in files], ["paint.mtl", "my skin.png", "rough.JPG"])
        os.rename(self.path / "art/rough.JPG", self.path / "art/Rough.jpg")
        self.assertEqual(self.companions("art/model.obj")[2]["name"], "Rough.jpg")
        # glTF has its points in a file beside it.
        points = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
        (self.path / "the points.bin").write_bytes(points)
        self.put("one.gltf", json.dumps({
            "asset": {"version": "2.0", "generator": "by hand " * 20},
            "buffers": [{"uri": "the%20points.bin", "byteLength": 36}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                           "min": [0, 0, 0], "max": [1, 1, 0]}],
            "images": [{"uri": "data:image/png;base64,AAAA"}, {"uri": "gone.png"}, {"uri": "secret.txt%00.png"}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "nodes": [{"mesh": 0}],
            "scenes": [{"nodes": [0]}], "scene": 0}))
        files = self.companions("one.gltf")
        self.assertEqual([(each["name"], base64.b64decode(each["data"])) for each in files],
                         [("the points.bin", points)])

    def test_nothing_in_a_name_ends_the_element(self):
        name = "<!-- <script> & \" \\ .obj"
        os.rename(self.path / "model.obj", self.path / name)
        files = self.page(name)
        self.assert_holds(files["models"][0], name)
        self.assertNotIn("<", re.search('files">(.*?)</script>', self.text("page.html"))[1])

    def test_the_empty_page_is_found(self):
        os.environ["ESPALIER_PAGE"] = "empty.html"
        self.addCleanup(os.environ.pop, "ESPALIER_PAGE")
        self.run_program("page", "model.obj", "-o", "page.html")
        os.environ["ESPALIER_PAGE"] = "none.html"
        self.assertIn("none.html", self.error_of("page", "model.obj", "-o", "other.html"))

    def test_a_program_without_a_page_says_what_to_do(self):
        os.environ.pop("ESPALIER_PAGE", None)
        alone = self.path / "bin/espalier"
        alone.parent.mkdir()
        shutil.copy(program.ESPALIER, alone)
        here, program.ESPALIER = program.ESPALIER, str(alone)
        try:
            message = self.error_of("page", "model.obj", "-o", "page.html")
            self.assertIn("scripts/web", message)
            self.assertIn("ESPALIER_PAGE", message)
            (self.path / "share/espalier").mkdir(parents=True)
            self.put("share/espalier/espalier.html", EMPTY)
            self.run_program("page", "model.obj", "-o", "page.html")
        finally:
            program.ESPALIER = here

    def refused(self, text, *options, code=1):
        options = [*options] if "--page" in options else [*options, "--page", "empty.html"]
        self.assertIn(text, self.error_of("page", *options, "-o", "page.html", code=code))
        self.assertFalse((self.path / "page.html").exists())

    def test_errors(self):
        self.put("other.html", "<p>")
        self.refused("is not the empty page", "model.obj", "--page", "other.html")
        self.put("other.html", EMPTY + ELEMENT)
        self.refused("is not the empty page", "model.obj", "--page", "other.html")
        self.put("broken.obj", "v 1 x 2\n")
        self.refused("broken.obj:1", "broken.obj")
        self.refused("--rest", "model.obj", "--to", "pose.vtu", code=2)
        self.refused("--limit", "model.obj", "--limit", "-n", 2, code=2)
        self.refused("a page opens files that end in .ovm, .vtu or .vtk", "model.obj", "--rest", "editor.obj")
        self.run_program("shape", "star", "-o", "star.vtu")
        self.refused("is not a pose of rest.vtu", "model.obj", "--rest", "rest.vtu", "--to", "star.vtu")
        os.mkdir(self.path / "case.obj")
        self.refused("is not a file that a page can hold", "case.obj")
        os.rmdir(self.path / "case.obj")
        self.assertIn(".html", self.error_of("page", "model.obj", "--page", "empty.html", "-o", "p.txt"))
        self.assert_nothing_is_lost_on_a_full_disk("page", "model.obj", "--page", "empty.html",
                                                   output="page.html", room=100)


if __name__ == "__main__":
    program.ESPALIER = os.path.abspath(sys.argv.pop(1))
    unittest.main()
