#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the Debian packages of a build, and uses them in an otherwise empty root.

Needs root's rights, debootstrap and a mirror of Debian; otherwise the test is skipped with a reason.
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
MIRROR = "http://deb.debian.org/debian"
CPACK = BUILD = None  # set by main: the program, and the build to pack


def run_program(*command, **options):
    result = subprocess.run([str(part) for part in command], text=True, check=False,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **options)
    if result.returncode != 0:
        raise AssertionError(f"{command} exits with {result.returncode}:\n{result.stdout}")
    return result.stdout


class DebianPackages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if os.geteuid() != 0 or shutil.which("debootstrap") is None:
            raise unittest.SkipTest("needs root's rights and debootstrap")
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.root = cls.folder / "root"
        run_program(CPACK, "--config", BUILD / "CPackConfig.cmake", "-B", cls.folder / "packages")
        cls.packages = sorted((cls.folder / "packages").glob("*.deb"))
        try:
            run_program("debootstrap", "--variant=minbase", "bookworm", cls.root, MIRROR)
        except AssertionError as error:
            raise unittest.SkipTest(f"no mirror of Debian: {error}")
        shutil.copytree(HERE / "consumer", cls.root / "root/consumer")
        shutil.copy(HERE.parents[1] / "examples/deform.c", cls.root / "root")
        for package in cls.packages:
            shutil.copy(package, cls.root / "root")

    def in_root(self, command):
        return run_program("chroot", self.root, "sh", "-ec",
                           "export DEBIAN_FRONTEND=noninteractive; cd /root; " + command)

    def install(self, *names):
        self.in_root("apt-get update -qq; apt-get install -y -qq --no-install-recommends "
                     + " ".join(names))

    def file_of(self, name):
        found = [path.name for path in self.packages if path.name.startswith(name + "_")]
        self.assertEqual(len(found), 1, self.packages)
        return "./" + found[0]

    def own_libraries(self):
        return [f"./{path.name}" for path in self.packages
                if path.name.startswith("libespalier") and "-dev" not in path.name]

    # Tests run in this order: each finds what the ones before it have installed.

    def test_1_the_program_alone(self):
        self.install(self.file_of("espalier"), *self.own_libraries())
        self.assertRegex(self.in_root("espalier --version"), r"^espalier \d+\.\d+\.\d+\b")
        self.in_root("espalier shape box --cells 2 2 2 -o rest.vtu")
        self.in_root("espalier deform rest.vtu --rest rest.vtu --to rest.vtu -n 2 -o moved.vtu")
        self.assertTrue((self.root / "root/moved.vtu").is_file())
        for name in ("man/man1/espalier.1", "bash-completion/completions/espalier",
                     "zsh/site-functions/_espalier"):
            self.assertTrue((self.root / "usr/share" / name).is_file(), name)

    def test_2_somebody_elses_program(self):
        self.install(self.file_of("libespalier-dev"), "g++", "cmake", "ninja-build", "pkg-config")
        self.in_root("cmake -G Ninja -S consumer -B built; cmake --build built; built/consumer")
        self.in_root("c++ -std=c++20 consumer/main.cpp -o linked "
                     "$(pkg-config --cflags --libs espalier-io espalier-osd espalier-solve); "
                     "./linked")

    def test_3_a_program_in_c(self):
        self.install("gcc", "pkg-config")
        self.in_root("gcc deform.c -o deform $(pkg-config --cflags --libs espalier-c)")
        self.assertEqual(self.in_root("./deform rest.vtu rest.vtu"),
                         "0.1 0.2 0.3\n0.5 0.5 0.5\n0.9 0.1 0.7\n")

    def test_4_python(self):
        self.install(self.file_of("python3-espalier"))
        out = self.in_root("python3 -c 'import espalier; rest = espalier.read(\"rest.vtu\"); "
                           "print(espalier.bind(rest, [(.5, .5, .5)]).deform(rest.positions + 1))'")
        self.assertEqual(out, "[[1.5 1.5 1.5]]\n")

    def test_5_nothing_is_left(self):
        names = " ".join(path.name.split("_")[0] for path in self.packages)
        self.in_root(f"apt-get remove -y -qq {names}")
        for pattern in ("usr/bin/espalier", "usr/share/man/man1/espalier*", "usr/include/espalier*", "usr/lib/**/*espalier*"):
            self.assertEqual(list(self.root.glob(pattern)), [])


if __name__ == "__main__":
    CPACK = sys.argv.pop(1)
    BUILD = pathlib.Path(sys.argv.pop(1))
    unittest.main()
