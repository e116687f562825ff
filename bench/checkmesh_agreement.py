#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares Espalier's check of cells and patches with OpenFOAM's checkMesh on random poses of cases.

    bench/checkmesh_agreement.py PROGRAM CASE... [--poses 100] [--seed 1] [--list]

PROGRAM is the path of espalier. A CASE is a folder with system/blockMeshDict or a polyMesh in ASCII, which is not
changed. A third of the poses move the vertices of a lattice around the case at random; a third move them so that planes,
wedges and periodic patches are kept; and a third are random with --slide for the planes. Prints a row of a table for each
case, and all differences with --list. Needs OpenFOAM (Debian's package openfoam).
"""

import argparse
import collections
import pathlib
import re
import shutil
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tests/hosts"))
import foam_agreement  # noqa: E402
import foam_cases  # noqa: E402

SLIDING = ("empty", "wedge", "symmetry", "symmetryPlane")
# The largest displacements, as shares of the size of the case.
LARGEST = 0.25


def copied(source, target):
    """Makes a case with the mesh of another one."""
    case = foam_cases.make_case(target)
    for place in ("system/blockMeshDict", "constant/polyMesh/blockMeshDict"):
        if (source / place).is_file():
            shutil.copy(source / place, case / "system/blockMeshDict")
            foam_cases.run(case, "blockMesh")
            return case
    shutil.copytree(source / "constant/polyMesh", case / "constant/polyMesh")
    return case


def poses_of(comparison, count):
    """Yields (name of the family, displacements of each pose, options)."""
    sizes = [LARGEST * (i + 1) / (count // 3) for i in range(count // 3)]
    kept = [comparison.keeping_moves(size) for size in sizes]
    slides = [option for name, (kind, _) in comparison.mesh.patches.items() if kind in SLIDING
              for option in ("--slide", name)]
    families = [("kept", kept, [])] if kept[0] else []
    families += [("slid", [comparison.free_moves(size) for size in sizes], slides)] if slides else []
    done = sum(len(moves) for _, moves, _ in families)
    left = count - done
    yield "free", [comparison.free_moves(LARGEST * (i + 1) / left) for i in range(left)], []
    yield from families


def compare(program, source, folder, count, seed):
    case = copied(source, folder / "case")
    comparison = foam_agreement.Comparison(program, case, seed)
    tally = foam_agreement.Tally()
    for family, moves, options in poses_of(comparison, count):
        for number, (ours, theirs) in enumerate(comparison.judge(moves, *options)):
            tally.add(f"{family} {number}", ours, theirs)
            if family != "free":
                tally.counts[f"broken {family}"] += bool(foam_agreement.broken_types(ours))
    kinds = collections.Counter({kind: n for kind, n in ours["cells"].items() if n})
    return comparison.mesh, kinds, tally


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("cases", type=pathlib.Path, nargs="+")
    parser.add_argument("--poses", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--list", action="store_true", help="list all differences")
    options = parser.parse_args()
    if not foam_cases.is_installed():
        sys.exit("OpenFOAM is not installed: apt-get install openfoam")
    print("| case | cells | constraint patches | valid | negative volumes | wrong pyramids | patches broken | for both | "
          "differences |\n|---|---|---|---|---|---|---|---|---|")
    total = collections.Counter()
    for source in options.cases:
        begin = time.time()
        with tempfile.TemporaryDirectory() as folder:
            try:
                mesh, kinds, tally = compare(options.program.resolve(), source, pathlib.Path(folder), options.poses,
                                             options.seed)
            except (RuntimeError, ValueError) as error:
                print(f"{source}: {re.sub(chr(10), ' ', str(error))[:1500]}", file=sys.stderr)
                continue
        counts = tally.counts
        total.update(counts)
        total["differences"] += len({pose for pose, _ in tally.differences})
        types = ", ".join(sorted(mesh.types() & {*SLIDING, "cyclic", "cyclicAMI"}))
        cells = ", ".join(f"{number} {kind}" for kind, number in kinds.items())
        print(f"| {source.name} | {cells} | {types} | {counts['valid']} of {counts['poses']} | {counts['negative']} | "
              f"{counts['pyramids']} | {counts['broken']} | {counts['broken for both']} | "
              f"{len({pose for pose, _ in tally.differences})} poses |", flush=True)
        print(f"{source}: {time.time() - begin:.1f} s; {dict(counts)}", file=sys.stderr)
        for text, number in collections.Counter(
                re.sub(r"[-+]?\d[\d.e+-]*", "#", text) for _, text in tally.differences).most_common():
            print(f"    {number} times: {text}", file=sys.stderr)
        if options.list:
            for pose, text in tally.differences:
                print(f"    {pose}: {text}", file=sys.stderr)
    print(f"{dict(total)}", file=sys.stderr)


if __name__ == "__main__":
    main()
