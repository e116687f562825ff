#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Cages of the models of demo/cage_models.py, and of the models beside the repository where they are.

    cage_models_test.py MEASURE_CAGE [--table] [--sizes N...] [NAME...]

Checks what docs/cages.md promises, at 60, 200, 500 and 2,000 vertices. With --table, prints the table
of that page instead of a test report; times there are CPU times of all threads.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "demo"))
import cage_models  # noqa: E402

SHARED = ROOT.parent / "shared/data/models"

# Handles and components of the models beside the repository.
KNOWN = {"rocker-arm": (1, 1), "spot": (1, 0), "stanford-bunny": (1, 0)}


# Components with --keep-apart: from how many vertices on, models whose parts are near each other stay
# apart. Below, there may be no cage.
KEPT_APART = {"chain": (200, 3), "pair": (60, 2)}


def measure(program, path, vertices, *mode):
    """Returns what measure_cage prints; a text is an error."""
    result = subprocess.run([program, path, str(vertices), *mode], capture_output=True, text=True)
    if result.returncode == 0:
        return json.loads(result.stdout)
    return result.stdout.strip() or f"exit code {result.returncode}"


def faults_of(name, wanted, found, is_solid, components=None):
    """Returns what is wrong with a cage.

    components: expected of a cage that keeps parts apart
    """
    if isinstance(found, str):
        return [found]
    faults = []
    if not 0.8 * wanted <= found["vertices"] <= 1.2 * wanted:
        faults.append(f"{found['vertices']} vertices")
    for key in ("outside_level", "outside_limit", "bad_cells"):
        if found[key]:
            faults.append(f"{key}: {found[key]}")
    if not found["manifold"]:
        faults.append("the boundary is not a manifold")
    # At 2,000 vertices, the cells of these models are smaller than their gaps and holes.
    expected = KNOWN.get(name)
    if name in cage_models.MODELS:
        model = EXPECTED[name]
        expected = (model.components, model.handles)
    if wanted == 2000 and expected != (None, None) and expected != (found["components"], found["handles"]):
        faults.append(f"{found['components']} components and {found['handles']} handles; "
                      f"the model has {expected}")
    if components is not None and found["components"] != components:
        faults.append(f"{found['components']} components; expected {components}")
    ratio = found["limit_volume"] / found["model_volume"] if is_solid else 0
    if wanted == 500 and components is None and ratio > 1.5:
        faults.append(f"{ratio:.2f} times the volume of the model")
    return faults


def row(name, wanted, found, is_solid):
    """Returns a row of a table, with CPU seconds and megabytes at the end."""
    if isinstance(found, str):
        return f"| {name} | {wanted:,} | {found} |"
    ratio = f"{found['limit_volume'] / found['model_volume']:.2f}" if is_solid else "–"
    share = 100 * found["irregular_edges"] / max(found["interior_edges"], 1)
    return (f"| {name} | {wanted:,} | {found['vertices']:,} | {found['cells']:,} | "
            f"{found['components']} / {found['handles']} / {found['cavities']} | {ratio} | "
            f"{found['scaled_jacobian']:.2f} | {share:.0f} % | {found['seconds']:.1f} | {found['megabytes']} |")


EXPECTED = {}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", metavar="MEASURE_CAGE")
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--table", action="store_true")
    parser.add_argument("--sizes", nargs="+", type=int, default=[60, 200, 500, 2000])
    arguments = parser.parse_args()
    count = 0
    with tempfile.TemporaryDirectory() as folder:
        paths = {}
        for name, make in cage_models.MODELS.items():
            if arguments.names and name not in arguments.names:
                continue
            EXPECTED[name] = make()
            paths[name] = pathlib.Path(folder) / f"{name}.obj"
            cage_models.write_obj(paths[name], EXPECTED[name])
        if not SHARED.is_dir():
            print(f"skipped the models of {SHARED}, which is absent", file=sys.stderr)
        for name in KNOWN:
            path = SHARED / f"{name}.obj"
            if path.exists() and (not arguments.names or name in arguments.names):
                paths[name] = path
        for name, path in paths.items():
            is_solid = name in KNOWN or EXPECTED[name].is_solid
            for wanted in arguments.sizes:
                found = measure(arguments.program, path, wanted)
                if arguments.table:
                    print(row(name, wanted, found, is_solid), flush=True)
                for fault in faults_of(name, wanted, found, is_solid):
                    print(f"{name} at {wanted} vertices: {fault}", file=sys.stderr, flush=True)
                    count += 1
            least, components = KEPT_APART.get(name, (0, None))
            for wanted in arguments.sizes if components else []:
                if arguments.table or wanted < least:
                    continue
                found = measure(arguments.program, path, wanted, "keep-apart")
                for fault in faults_of(name, wanted, found, is_solid, components):
                    print(f"{name} at {wanted} vertices, kept apart: {fault}", file=sys.stderr, flush=True)
                    count += 1
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main())
