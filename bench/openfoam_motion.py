#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Moves a body in the mesh of OpenFOAM by Espalier and by OpenFOAM's displacementLaplacian, on the same mesh.

    bench/openfoam_motion.py PROGRAM [--cells 40]

PROGRAM is the path of espalier. A box of CELLS³ cells around a ball, refined near the ball by snappyHexMesh, is
moved so that the ball goes 0.06 of the side of the box. Prints the processor times of both on one thread, from files
to files, and the quality of both results by checkMesh. Needs OpenFOAM (Debian's package openfoam).
"""

import argparse
import json
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tests/hosts"))
import foam_cases  # noqa: E402

MOVE = 0.06
DYNAMIC_MESH = """dynamicFvMesh dynamicMotionSolverFvMesh; motionSolverLibs (fvMotionSolvers);
motionSolver displacementLaplacian;
displacementLaplacianCoeffs { diffusivity inverseDistance (ball); }"""
SOLUTION = """solvers
{
    "cellDisplacement.*" { solver GAMG; smoother GaussSeidel; tolerance 1e-8; relTol 0; }
}"""
DISPLACEMENT = """dimensions [0 1 0 0 0 0 0]; internalField uniform (0 0 0);
boundaryField
{
    ball { type fixedValue; value uniform (%g 0 0); }
    ".*" { type fixedValue; value uniform (0 0 0); }
}"""


def timed(function, *arguments, **options):
    """Returns the processor time of the programs that a function runs, which does not depend on the load of the machine,
    and the result of the function."""
    def used():
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime
    begin = used()
    result = function(*arguments, **options)
    return used() - begin, result


def write_field(path, kind, text):
    path.write_text(foam_cases.dictionary(path.name, text).replace("class dictionary", f"class {kind}"))


def laplacian(case):
    """Moves the mesh by OpenFOAM. Returns the time."""
    (case / "constant/dynamicMeshDict").write_text(foam_cases.dictionary("dynamicMeshDict", DYNAMIC_MESH))
    (case / "system/fvSolution").write_text(foam_cases.dictionary("fvSolution", SOLUTION))
    (case / "0").mkdir(exist_ok=True)
    write_field(case / "0/pointDisplacement", "pointVectorField", DISPLACEMENT % MOVE)
    seconds, _ = timed(foam_cases.run, case, "moveDynamicMesh")
    return seconds


def espalier(program, case, target):
    """Moves the mesh by Espalier. Returns the time with the check of the cells, the time without, the time of one more
    pose of a mesh that is bound, and the report."""
    def run(*arguments):
        return subprocess.run([program, *map(str, arguments)], check=True, cwd=case.parent, text=True,
                              stdout=subprocess.PIPE).stdout
    run("shape", "around", case, "--cells", 8, 8, 8, "--margin", 0.01, "-o", "rest.vtu")
    run("pose", "rest.vtu", "--select", "ball", 0.5, 0.5, 0.5, 0.4, "--move", MOVE, 0, 0, "-o", "pose.vtu")
    (target / "constant").mkdir(parents=True)
    shutil.copytree(case / "constant/polyMesh", target / "constant/polyMesh")
    shutil.copytree(case / "system", target / "system")
    seconds, text = timed(run, "deform", case, "--rest", "rest.vtu", "--to", "pose.vtu", "-o", target, "--threads", 1,
                          "--report", "json")
    quiet, _ = timed(run, "deform", case, "--rest", "rest.vtu", "--to", "pose.vtu", "-o", target, "--threads", 1,
                     "--quiet")
    run("bind", case, "--rest", "rest.vtu", "-o", "mesh.espb", "--threads", 1, "--quiet")
    another, _ = timed(run, "apply", "mesh.espb", "--to", "pose.vtu", "-o", target, "--threads", 1, "--quiet")
    return seconds, quiet, another, json.loads(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--cells", type=int, default=40)
    options = parser.parse_args()
    if not foam_cases.is_installed():
        sys.exit("OpenFOAM is not installed: apt-get install openfoam")
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        case = foam_cases.snappy_mesh(folder / "case", options.cells)
        checking, output = timed(foam_cases.run, case, "checkMesh")
        cells = re.search(r"cells: +(\d+)", output).group(1)
        seconds, quiet, another, report = espalier(options.program.resolve(), case, folder / "ours")
        theirs = laplacian(case)
        found = {"Espalier": foam_cases.checked(folder / "ours")[-1],
                 "displacementLaplacian": foam_cases.checked(case)[-1]}
        mesh, = report["meshes"]
    print(f"{cells} cells; seconds of processor time on one thread, from files to files:")
    print(f"  displacementLaplacian (moveDynamicMesh)      {theirs:8.2f} s")
    print(f"  Espalier, cells checked                      {seconds:8.2f} s, {theirs / seconds:.1f} times as fast")
    print(f"  Espalier, not checked                        {quiet:8.2f} s, {theirs / quiet:.1f} times as fast")
    print(f"  Espalier, one more pose (apply)              {another:8.2f} s, {theirs / another:.1f} times as fast")
    print(f"  checkMesh on the mesh at rest                {checking:8.2f} s")
    print(f"  Espalier: {mesh['inverted']['count']} cells inverted, worst volume ratio "
          f"{mesh['smallest_ratio']['volume_ratio']:.3f}")
    for name, each in found.items():
        print(f"  {name}: smallest volume {each['smallest_volume']:.3g}, non-orthogonality "
              f"{each['non_orthogonality']:.1f}, skewness {each['skewness']:.2f}")


if __name__ == "__main__":
    main()
