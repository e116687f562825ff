#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the zip of the Blender add-on, with Espalier's Python module in it. scripts/blender builds the module, and calls
this script.

    hosts/blender/make_zip.py [BUILD] [-o ZIP]

BUILD is a build folder with the module (build/blender by default). If the zip cannot be made, there is no zip afterwards,
also where there was an older one.
"""

import argparse
import os
import pathlib
import sys
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
TOP = HERE.parents[1]
ADD_ON = "espalier_lattice"


def files_of(build):
    """Returns pairs of a file and its name in the zip."""
    found = [(path, f"{ADD_ON}/{path.name}") for pattern in ("*.py", "*.toml")
             for path in sorted((HERE / ADD_ON).glob(pattern))]
    package = build / "python/espalier"
    extensions = sorted(package.glob("_*.so"))
    if not any(path.name.startswith("_core.") for path in extensions):
        sys.exit(f"{package}: there is no Python module; run scripts/blender, which builds it")
    found += [(path, f"{ADD_ON}/lib/espalier/{path.name}") for path in [*sorted(package.glob("*.py")), *extensions]]
    return [*found, (TOP / "LICENSE", f"{ADD_ON}/LICENSE")]


def write(output, files):
    with zipfile.ZipFile(output, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, name in files:
            # A fixed date lets the same files give the same zip.
            entry = zipfile.ZipInfo(name, (2020, 1, 1, 0, 0, 0))
            entry.external_attr = 0o644 << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, path.read_bytes())


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build", nargs="?", default=TOP / "build/blender", type=pathlib.Path)
    parser.add_argument("-o", "--output", default="espalier_lattice.zip", type=pathlib.Path)
    options = parser.parse_args()
    output = options.output
    part = output.with_name(output.name + ".part")
    output.unlink(missing_ok=True)
    try:
        write(part, files_of(options.build))
        os.replace(part, output)
    except OSError as error:
        sys.exit(f"{output}: {error}")
    finally:
        part.unlink(missing_ok=True)
    print(f"{output}: {output.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
