#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Compares Espalier's check of cells of second order with Gmsh's on random poses of whole meshes.

    bench/gmsh_agreement.py FOLDER_OF_THE_PYTHON_MODULE FILE... [--poses 50] [--seed 1]

A FILE is a .msh of second order with one type of elements of its dimension and no pyramids: gmsh -3 -order 2 A.geo -format
msh22. Prints a row of a table for each file, and all differences. Needs Gmsh's module for Python (Debian's package
python3-gmsh).
"""

import argparse
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tests/hosts"))
import gmsh_agreement  # noqa: E402


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("module", type=pathlib.Path)
    parser.add_argument("files", type=pathlib.Path, nargs="+")
    parser.add_argument("--poses", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    sys.path.insert(0, str(options.module))
    import espalier  # noqa: E402  (the path comes first)
    print("| mesh | elements | folded at rest | poses that fold elements | folded elements | differences |\n"
          "|---|---|---|---|---|---|")
    for path in options.files:
        begin = time.time()
        try:
            _, types, bad, poses, folded, differences = gmsh_agreement.compare(espalier, path, options.poses, options.seed)
        except (RuntimeError, ValueError) as error:
            print(f"{path}: {error}", file=sys.stderr)
            continue
        names = ", ".join(f"{number} of type {kind}" for kind, number in types.items())
        print(f"| {path.name} | {names} | {bad} | {poses} of {options.poses} | {folded} | {len(differences)} |", flush=True)
        print(f"{path}: {time.time() - begin:.1f} s", file=sys.stderr)
        for difference in differences[:20]:
            print("    pose {}, element {}: {} for Espalier; Gmsh's smallest determinant is {:.3g} of its largest".format(
                *difference[:2], "folded" if difference[2] else "valid", difference[3]), file=sys.stderr)


if __name__ == "__main__":
    main()
