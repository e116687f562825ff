#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Meshes that OpenFOAM's programs make, deformed and judged by checkMesh. Skipped without OpenFOAM and
Gmsh.

    openfoam_test.py PATH_OF_ESPALIER
"""

import pathlib
import random
import shutil
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
import foam_agreement  # noqa: E402
import foam_cases  # noqa: E402
import json  # noqa: E402
import program  # noqa: E402
from program import CliTest  # noqa: E402

POSES = 270  # of each of the four meshes: 1,080 in all
MESHES = {"block": foam_cases.block_mesh, "snappy": foam_cases.snappy_mesh,
          "dual": foam_cases.dual_mesh, "gmsh": foam_cases.gmsh_mesh}


@unittest.skipUnless(foam_cases.is_installed() and shutil.which("gmsh"),
                     "OpenFOAM or Gmsh is not installed")
class OpenFoam(CliTest):
    def write_random_poses(self, count, size, seed=1):
        """Writes poses of rest.ovm whose vertices move by random parts of up to `size`."""
        rest = self.read_ovm_positions("rest.ovm")
        draws = random.Random(seed)
        for i in range(count):
            amplitude = size * (i + 1) / count
            self.write_positions(f"pose{i:04d}.ovm", "rest.ovm", [
                tuple(c + amplitude * draws.uniform(-1, 1) for c in p) for p in rest])
        return [f"pose{i:04d}.ovm" for i in range(count)]

    def deform_to_times(self, case, poses):
        """Deforms a case to one time for each pose, and returns the reports on its mesh."""
        for i in range(len(poses)):
            (case / str(i) / "polyMesh").mkdir(parents=True)
        report = self.run_program("deform", case, "--rest", "rest.ovm", "--to", *poses, "-n", 3,
                                  "-o", case / "%d/polyMesh/points", "--report", "json").stdout
        return json.loads(report)["meshes"]

    def test_checkmesh_agrees_on_random_poses(self):
        for name, make in MESHES.items():
            case = make(self.path / name)
            self.run_program("shape", "around", case, "--cells", 3, 3, 3, "-o", "rest.ovm")
            poses = self.write_random_poses(POSES, 0.55)
            reports = self.deform_to_times(case, poses)
            findings = {found["time"]: found for found in foam_cases.checked(case)}
            valid = inverted = negative = pyramids = 0
            for i, report in enumerate(reports):
                self.assertEqual(foam_agreement.differences(report, findings[str(i)]), [], f"{name} {i}")
                (valid, inverted) = (valid + (report["inverted"]["count"] == 0),
                                     inverted + (report["inverted"]["count"] > 0))
                negative += findings[str(i)]["negative_volumes"] > 0
                pyramids += findings[str(i)]["wrong_pyramids"] > 0
            kinds = {kind: count for kind, count in reports[0]["cells"].items() if count}
            print(f"{name}: {kinds}, {reports[0]['bad_at_rest']['count']} folded at rest; {valid} poses "
                  f"valid, {inverted} not; checkMesh: negative volumes in {negative}, wrong pyramids in "
                  f"{pyramids}", file=sys.stderr)
            # The comparison is worth something only if there are enough of both.
            self.assertGreater(valid, POSES // 4, name)
            self.assertGreater(inverted, POSES // 10, name)
            self.assertGreater(negative, 0, name)

    def test_checkmesh_agrees_on_patches(self):
        poses, largest = 30, 0.25
        for name, make, slides in (("flat", foam_cases.flat_mesh, ("frontAndBack", "bottom")),
                                   ("periodic", foam_cases.periodic_mesh, ("bottom",)),
                                   ("wedge", foam_cases.wedge_mesh, ("back", "front"))):
            comparison = foam_agreement.Comparison(program.ESPALIER, make(self.path / name))
            sizes = [largest * (i + 1) / poses for i in range(poses)]
            free, kept = foam_agreement.Tally(), foam_agreement.Tally()
            for family, tally, moves, options in (
                    ("free", free, [comparison.free_moves(size) for size in sizes], ()),
                    ("kept", kept, [comparison.keeping_moves(size) for size in sizes], ()),
                    ("slid", foam_agreement.Tally(), [comparison.free_moves(size) for size in sizes],
                     [option for patch in slides for option in ("--slide", patch)])):
                for i, (ours, theirs) in enumerate(comparison.judge(moves, *options)):
                    tally.add(f"{family} {i}", ours, theirs)
                    if family == "slid":
                        planes = {patch["name"]: patch["distance"] for patch in ours["patches"]
                                  if patch["type"] in ("symmetryPlane", "symmetry")}
                        self.assertLess(max(planes.values(), default=0), 1e-12)
                self.assertEqual(tally.differences, [], name)
            # Random poses break the patches, and poses that keep them do not.
            self.assertEqual((free.counts["broken"], free.counts["broken for both"], kept.counts["broken"]),
                             (poses, poses, 0), name)
            self.assertGreater(kept.counts["valid"], poses // 4)
            self.assertLess(kept.counts["valid"], poses)

    def test_the_largest_step_is_valid_for_checkmesh(self):
        for name, make in MESHES.items():
            case = make(self.path / name)
            self.run_program("shape", "around", case, "--cells", 2, 2, 2, "-o", "rest.ovm")
            self.write_random_poses(1, 1.5, seed=3)
            shutil.copytree(case, self.path / (name + "-far"))
            report = json.loads(self.run_program(
                "deform", case, "--rest", "rest.ovm", "--to", "pose0000.ovm", "-n", 3, "-o",
                name + "-far", "--largest-step", "--report", "json").stdout)["meshes"][0]
            self.assertGreater(report["inverted"]["count"], 0)
            self.assertGreater(report["written"], 0.01)
            self.assertLess(report["written"], 1)
            found, = foam_cases.checked(self.path / (name + "-far"))
            self.assertEqual(found["negative_volumes"], 0)
            self.assertGreater(found["smallest_volume"], 0)
            # One per cent further, the pose is refused.
            rest, pose = (self.read_ovm_positions(each) for each in ("rest.ovm", "pose0000.ovm"))
            share = 1.01 * report["written"]
            self.write_positions("further.ovm", "rest.ovm", [
                tuple(a + share * (b - a) for a, b in zip(p, q)) for p, q in zip(rest, pose)])
            before = (self.path / (name + "-far") / "constant/polyMesh/points").read_bytes()
            self.assertIn("inside out", self.error_of(
                "deform", case, "--rest", "rest.ovm", "--to", "further.ovm", "-n", 3, "-o",
                name + "-far", "--no-inverted", code=3))
            self.assertEqual((self.path / (name + "-far") / "constant/polyMesh/points").read_bytes(),
                             before)

    def test_files_are_kept_byte_for_byte(self):
        for write_format in ("ascii", "binary"):
            for name, make in MESHES.items():
                case = make(self.path / f"{name}-{write_format}", write_format=write_format)
                points = case / "constant/polyMesh/points"
                before = points.read_bytes()
                self.assertEqual(b"binary" in before, write_format == "binary")
                self.run_program("shape", "around", case, "-o", "rest.vtu")
                shutil.copytree(case, self.path / "copy")
                self.run_program("deform", case, "--rest", "rest.vtu", "--to", "rest.vtu", "-o", "copy")
                for path in case.rglob("*"):
                    if path.is_file():
                        copy = self.path / "copy" / path.relative_to(case)
                        self.assertEqual(copy.read_bytes(), path.read_bytes(), path)
                shutil.rmtree(self.path / "copy")

    def test_a_polymesh_is_a_lattice(self):
        for name, make in MESHES.items():
            for write_format in ("ascii", "binary"):
                case = make(self.path / f"{name}-{write_format}", write_format=write_format)
                found, = foam_cases.checked(case)
                self.run_program("refine", case, "-n", 0, "-o", "lattice.vtu")
                info = self.info("lattice.vtu", "-n", 0)
                self.assertIn(f"cells:            {info['levels'][0]['counts']['cells']}\n",
                              found["text"] + foam_cases.run(case, "checkMesh"))
                # A pose of it may be another time of the case.
                self.run_program("pose", case, "--move", 1, 0, 0, "-o", "moved.vtu")
                self.assertIn("inverted by the pose    0", self.run_program(
                    "check", "moved.vtu", "--rest", case, "-n", 1, "--list", 0).stdout)


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
