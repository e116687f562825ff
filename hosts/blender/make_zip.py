#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the zip of the Blender add-on, with Espalier's Python module in it.

    hosts/blender/make_zip.py [BUILD] [-o ZIP]

BUILD is a build folder with the module (build/release by default). The module must be made for the Python
that Blender runs: Debian's Blender runs the Python of the system; the Blender of blender.org runs its own,
for which CMake makes the module with -DPython_EXECUTABLE=/path/of/that/python. Libraries in the module are
static, except for the C++ library and oneTBB. Install the zip by Edit > Preferences > Add-ons > Install.
"""

import argparse
import pathlib
import sys
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
TOP = HERE.parents[1]
ADD_ON = "espalier_lattice"


def files_of(build):
    """Returns pairs of a file and its name in the zip."""
    for path in sorted((HERE / ADD_ON).glob("*.py")):
        yield path, f"{ADD_ON}/{path.name}"
    package = build / "python/espalier"
    extensions = sorted(package.glob("_*.so"))
    if not any(path.name.startswith("_core.") for path in extensions):
        sys.exit(f"{package}: there is no Python module; build it first: scripts/build release "
                 "espalier_python_core")
    for path in [*sorted(package.glob("*.py")), *extensions]:
        yield path, f"{ADD_ON}/lib/espalier/{path.name}"
    yield TOP / "LICENSE", f"{ADD_ON}/LICENSE"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build", nargs="?", default=TOP / "build/release", type=pathlib.Path)
    parser.add_argument("-o", "--output", default="espalier_lattice.zip", type=pathlib.Path)
    options = parser.parse_args()
    with zipfile.ZipFile(options.output, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, name in files_of(options.build):
            # A fixed date, so that the same files give the same zip.
            entry = zipfile.ZipInfo(name, (2020, 1, 1, 0, 0, 0))
            entry.external_attr = 0o644 << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, path.read_bytes())
    print(f"{options.output}: {options.output.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
