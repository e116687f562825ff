# SPDX-License-Identifier: Apache-2.0
"""Makes the demo's models from nothing: figure.obj, disk.obj and block.obj.

    make_models.py OUT_DIR

The result is the same on every run. Needs numpy only.
"""

import argparse
import pathlib

from figure import SPACING, make_figure
from parametric import make_block, make_disk
from quad_mesh import check, write_materials, write_obj

LIBRARY = "demo.mtl"


def main():
    parser = argparse.ArgumentParser(description="Makes the demo's models.")
    parser.add_argument("out_dir", type=pathlib.Path, metavar="OUT_DIR")
    out = parser.parse_args().out_dir
    out.mkdir(parents=True, exist_ok=True)
    write_materials(out / LIBRARY)
    for name, make, least_area in (("figure", make_figure, 0.02 * SPACING**2),
                                   ("disk", make_disk, 1e-5), ("block", make_block, 1e-4)):
        mesh = make()
        check(mesh, least_area)
        path = out / f"{name}.obj"
        write_obj(path, name, mesh, LIBRARY)
        print(f"{path}: {len(mesh.points)} vertices, {len(mesh.quads)} quads")


if __name__ == "__main__":
    main()
