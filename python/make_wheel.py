#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Packs the installed package espalier as a wheel, offline: make_wheel.py INSTALLED OUT VERSION

INSTALLED is the folder that the package was installed to (.../dist-packages), OUT the folder for the
wheel. The script needs python3-wheel. The wheel is for this Python and this kind of machine, with the libraries of
the system that it was built on.
"""

import pathlib
import shutil
import subprocess
import sys
import sysconfig
import tempfile

METADATA = """Metadata-Version: 2.1
Name: espalier
Version: {version}
Summary: Sparse stencil tables for lattices of arbitrary polyhedral topology
License: Apache-2.0
Requires-Python: ~={python}.0
Requires-Dist: numpy>=1.22
Requires-Dist: scipy>=1.8
"""

WHEEL = """Wheel-Version: 1.0
Generator: espalier ({version})
Root-Is-Purelib: false
Tag: {tag}
"""


def tag():
    """Returns the tag of this Python by PEP 425: cp311-cp311-linux_x86_64."""
    version = "cp{}{}".format(*sys.version_info)
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    return f"{version}-{version}-{platform}"


def main():
    installed, out, version = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3]
    values = {"version": version, "tag": tag(), "python": "{}.{}".format(*sys.version_info)}
    with tempfile.TemporaryDirectory() as folder:
        tree = pathlib.Path(folder) / "tree"
        shutil.copytree(installed / "espalier", tree / "espalier",
                        ignore=shutil.ignore_patterns("__pycache__"))
        info = tree / f"espalier-{version}.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(METADATA.format(**values), encoding="utf-8")
        (info / "WHEEL").write_text(WHEEL.format(**values), encoding="utf-8")
        shutil.copy(pathlib.Path(__file__).parents[1] / "LICENSE", info)
        out.mkdir(parents=True, exist_ok=True)
        subprocess.run([sys.executable, "-m", "wheel", "pack", tree, "--dest-dir", out], check=True)


if __name__ == "__main__":
    main()
