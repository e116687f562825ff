#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Decomposed and compressed cases of OpenFOAM, made by decomposePar, against the same pose of the whole case.
Skipped without OpenFOAM.

    foam_decomposed_test.py PATH_OF_ESPALIER
"""

import gzip
import json
import pathlib
import re
import shutil
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
import foam_cases  # noqa: E402
import program  # noqa: E402
from program import CliTest  # noqa: E402

PARTS = 4
DECOMPOSITION = f"numberOfSubdomains {PARTS}; method simple; simpleCoeffs {{ n (2 2 1); delta 0.001; }}"
POINTS = pathlib.Path("constant/polyMesh/points")

# A square pipe of 6 x 4 x 4 cells whose ends are periodic. The decomposition cuts it into halves along x, so that
# the periodic patches are in different processes.
PIPE = """scale 1; vertices ((0 0 0)(3 0 0)(3 1 0)(0 1 0)(0 0 1)(3 0 1)(3 1 1)(0 1 1));
blocks (hex (0 1 2 3 4 5 6 7) (6 4 4) simpleGrading (1 1 1)); edges ();
boundary (
    left { type cyclic; neighbourPatch right; faces ((0 4 7 3)); }
    right { type cyclic; neighbourPatch left; faces ((2 6 5 1)); }
    low { type symmetryPlane; faces ((0 1 2 3)); }
    walls { type wall; faces ((1 5 4 0)(3 7 6 2)(4 5 6 7)); });"""


def cyclic_mesh(case, **options):
    case = foam_cases.make_case(case, **options)
    (case / "system/blockMeshDict").write_text(foam_cases.dictionary("blockMeshDict", PIPE))
    foam_cases.run(case, "blockMesh")
    return case


MESHES = {"block": foam_cases.block_mesh, "snappy": foam_cases.snappy_mesh, "cyclic": cyclic_mesh}


def text_of(path):
    """Returns the text of a file, which may be compressed."""
    return path.read_text("latin1") if path.exists() else gzip.decompress(
        path.with_name(path.name + ".gz").read_bytes()).decode("latin1")


def texts_of(case, name):
    """Returns the texts of a file for all processes, without their heads."""
    collated = case / f"processors{PARTS}" / POINTS.with_name(name)
    if collated.exists():
        texts = re.split(r"// Processor\d+\n", collated.read_text("latin1"))[1:]
    else:
        texts = [text_of(case / f"processor{i}" / POINTS.with_name(name)) for i in range(PARTS)]
    return [re.sub(r"(?s).*FoamFile.*?\}", "", text) for text in texts]


def points_in(text):
    return re.findall(r"\(([^()]+ [^()]+ [^()]+)\)", text)


def labels_in(text):
    return [int(word) for word in re.search(r"\n\d+\n?\(([\d\s]+)\)", text).group(1).split()]


@unittest.skipUnless(foam_cases.is_installed() and shutil.which("decomposePar"), "OpenFOAM is not installed")
class DecomposedCases(CliTest):
    def decompose(self, whole, name, collated=False, compressed=False, keeps_whole=False):
        case = self.path / name
        shutil.copytree(whole, case)
        (case / "system/decomposeParDict").write_text(
            foam_cases.dictionary("decomposeParDict", DECOMPOSITION))
        control = case / "system/controlDict"
        control.write_text(control.read_text() + f"writeCompression {'on' if compressed else 'off'};\n")
        foam_cases.run(case, "decomposePar", *(["-fileHandler", "collated"] if collated else []))
        self.assertEqual((case / f"processors{PARTS}").exists(), collated)
        if not collated:
            self.assertEqual((case / "processor0" / f"{POINTS}.gz").exists(), compressed)
        if not keeps_whole:
            shutil.rmtree(case / "constant/polyMesh")
        return case

    def deform(self, case, out, pose="posed.vtu", *options):
        return json.loads(self.run_program("deform", case, "--rest", "rest.vtu", "--to", pose, "-n", 2,
                                           "-o", out, "--report", "json", *options).stdout)["meshes"][0]

    def test_each_part_moves_as_the_whole_mesh(self):
        for name, make in MESHES.items():
            whole = make(self.path / name)
            self.run_program("shape", "around", whole, "--cells", 3, "-o", "rest.vtu")
            # This bends the symmetry plane and breaks the period.
            self.run_program("pose", "rest.vtu", "--twist", "x", 25, "-o", "posed.vtu")
            moved = self.path / f"{name}-moved"
            shutil.copytree(whole, moved)
            expected = self.deform(whole, moved)
            self.assertEqual([patch["broken"] for patch in expected["patches"]],
                             [True] * 3 if name == "cyclic" else [])
            places = points_in((moved / POINTS).read_text())
            for form in ({}, {"collated": True}, {"compressed": True}, {"keeps_whole": True},
                         {"collated": True, "keeps_whole": True}):
                with self.subTest(mesh=name, **form):
                    case = self.decompose(whole, f"{name}-{'-'.join(form)}-", **form)
                    copy = self.path / f"{case.name}moved"
                    shutil.copytree(case, copy)
                    self.deform(case, copy, "rest.vtu")
                    for path in case.rglob("*"):
                        if path.is_file():
                            self.assertEqual((copy / path.relative_to(case)).read_bytes(), path.read_bytes())
                    report = self.deform(case, copy)
                    count = 0
                    for text, numbers in zip(texts_of(copy, "points"), texts_of(case, "pointProcAddressing")):
                        own = points_in(text)
                        self.assertEqual(own, [places[number] for number in labels_in(numbers)])
                        count += len(own)
                    self.assertGreater(count, len(places))
                    if "keeps_whole" in form:
                        self.assertEqual((copy / POINTS).read_bytes(), (moved / POINTS).read_bytes())
                    self.assertEqual("parts" in report, "keeps_whole" not in form)
                    for key in ("cells", "quality", "solver"):
                        found, wanted = self.rounded(report[key]), self.rounded(expected[key])
                        if key == "quality" and "parts" in report:
                            found, wanted = self.within_parts(found, wanted)
                        self.assertEqual(found, wanted, key)
                    self.assertEqual([(p["name"], p["type"], round(p["distance"], 12)) for p in report["patches"]],
                                     [(p["name"], p["type"], round(p["distance"], 12))
                                      for p in expected["patches"]])

    @staticmethod
    def within_parts(*qualities):
        """Leaves out what is measured across cyclic faces, too: not where parts are joined."""
        across = ("orthogonal", "skewness", "right_angle")
        return [{time: {key: value for key, value in numbers.items()
                        if not any(word in key for word in across)}
                 for time, numbers in quality.items()} for quality in qualities]

    def rounded(self, value):
        """Rounds numbers: means are sums in another order of the cells."""
        if isinstance(value, dict):
            return {key: self.rounded(inner) for key, inner in value.items()}
        return round(value, 9) if isinstance(value, float) else value

    def test_openfoam_puts_the_parts_together(self):
        whole = foam_cases.snappy_mesh(self.path / "case")
        self.run_program("shape", "around", whole, "--cells", 3, "-o", "rest.vtu")
        self.run_program("pose", "rest.vtu", "--twist", "x", 25, "-o", "posed.vtu")
        case = self.decompose(whole, "parts")
        copy = self.path / "copy"
        shutil.copytree(case, copy)
        report = self.deform(case, copy)
        foam_cases.run(copy, "reconstructParMesh", "-constant")
        found, = foam_cases.checked(copy, "-constant")
        self.assertEqual(found["negative_volumes"], report["quality"]["after"]["non_positive_volumes"])
        self.assertAlmostEqual(found["smallest_volume"], report["quality"]["after"]["smallest_volume"], delta=1e-12)
        self.assertAlmostEqual(found["non_orthogonality"], report["quality"]["after"]["non_orthogonality"], delta=1e-6)
        self.assertAlmostEqual(found["skewness"], report["quality"]["after"]["skewness"], delta=1e-6)

    def test_a_binding_writes_all_parts(self):
        whole = foam_cases.block_mesh(self.path / "case")
        self.run_program("shape", "around", whole, "--cells", 3, "-o", "rest.vtu")
        self.run_program("pose", "rest.vtu", "--twist", "x", 25, "-o", "posed.vtu")
        case = self.decompose(whole, "parts", keeps_whole=True)
        for name in ("deformed", "applied"):
            shutil.copytree(case, self.path / name)
        self.deform(case, self.path / "deformed")
        self.run_program("bind", case, "--rest", "rest.vtu", "-n", 2, "-o", "case.espb")
        self.run_program("apply", "case.espb", "--to", "posed.vtu", "-o", "applied")
        for i in range(PARTS):
            self.assertEqual((self.path / "applied" / f"processor{i}" / POINTS).read_bytes(),
                             (self.path / "deformed" / f"processor{i}" / POINTS).read_bytes())
        self.assertEqual((self.path / "applied" / POINTS).read_bytes(),
                         (self.path / "deformed" / POINTS).read_bytes())

    def test_cells_are_named_by_their_process(self):
        whole = foam_cases.block_mesh(self.path / "case")
        self.run_program("shape", "around", whole, "--cells", 3, "-o", "rest.vtu")
        self.run_program("pose", "rest.vtu", "--select", "vertices", 42, "--move", 1, 1, 1, "-o", "posed.vtu")
        case = self.decompose(whole, "parts")
        copy = self.path / "copy"
        shutil.copytree(case, copy)
        before = (copy / "processor0" / POINTS).read_bytes()
        error = self.error_of("deform", case, "--rest", "rest.vtu", "--to", "posed.vtu", "-o", copy,
                              "--no-inverted", code=3)
        cell, own, process = map(int, re.search(r"cell (\d+) \((\d+) of processor(\d)\)", error).groups())
        counts = [len(set(labels_in(text))) for text in texts_of(case, "cellProcAddressing")]
        self.assertEqual(cell, sum(counts[:process]) + own)
        self.assertEqual((copy / "processor0" / POINTS).read_bytes(), before)


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
