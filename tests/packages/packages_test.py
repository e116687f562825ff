#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Installs a build, and links another project's program to it with CMake and with pkg-config."""

import concurrent.futures
import os
import pathlib
import shlex
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
CONSUMER = HERE / "consumer"
WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror"]
CMAKE = BUILD = None  # set by main: the program, and the build to install


class InstalledBuild(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.prefix = cls.folder / "installed"
        cls.run_program(CMAKE, "--install", BUILD, "--prefix", cls.prefix)
        # Test a relocated tree, which must not depend on the folder that it was made for.
        cls.prefix = cls.prefix.rename(cls.folder / "moved")

    @classmethod
    def run_program(cls, *command, code=0, **options):
        result = subprocess.run([str(part) for part in command], text=True, cwd=cls.folder,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
                                **options)
        if result.returncode != code:
            raise AssertionError(f"{command} exits with {result.returncode}:\n{result.stdout}")
        return result.stdout

    def environment(self, **more):
        libraries = [str(path.parent) for path in self.prefix.glob("lib*/**/libespalier_far.*")]
        return {**os.environ, "LD_LIBRARY_PATH": ":".join(libraries), **more}

    def configure(self, name, *options, code=0):
        return self.run_program(CMAKE, "-G", "Ninja", "-S", CONSUMER, "-B", name,
                                f"-DCMAKE_PREFIX_PATH={self.prefix}", *options, code=code)


class Packages(InstalledBuild):
    def test_find_package(self):
        self.configure("by-package", "-DCMAKE_BUILD_TYPE=Debug")
        self.run_program(CMAKE, "--build", "by-package")
        out = self.run_program("by-package/consumer", env=self.environment())
        self.assertIn("none.ovm", out)

    def test_the_program_has_its_manual_page_and_its_completion(self):
        for name in ("man/man1/espalier.1", "bash-completion/completions/espalier",
                     "zsh/site-functions/_espalier"):
            self.assertEqual((self.prefix / "share" / name).is_file(),
                             (self.prefix / "bin/espalier").is_file(), name)

    def test_components_that_are_not_there_are_named(self):
        (self.folder / "asks").mkdir()
        (self.folder / "asks/CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.25)\nproject(asks LANGUAGES CXX)\n"
            "find_package(espalier REQUIRED COMPONENTS io teapot)\n")
        out = self.run_program(CMAKE, "-S", "asks", "-B", "asks/build",
                               f"-DCMAKE_PREFIX_PATH={self.prefix}", code=1)
        self.assertIn("teapot", out)

    def test_optional_components_may_be_missing(self):
        (self.folder / "may").mkdir()
        (self.folder / "may/CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.25)\nproject(may LANGUAGES CXX)\n"
            "find_package(espalier REQUIRED COMPONENTS far OPTIONAL_COMPONENTS io teapot)\n"
            'message(STATUS "far: ${espalier_far_FOUND}, io: ${espalier_io_FOUND}, '
            'teapot: ${espalier_teapot_FOUND}, path: (${CMAKE_MODULE_PATH})")\n')
        options = ["-S", "may", "-B", "may/build", f"-DCMAKE_PREFIX_PATH={self.prefix}"]
        out = self.run_program(CMAKE, *options)
        self.assertIn("far: TRUE, io: TRUE, teapot: , path: ()", out)
        if (BUILD / "io/libespalier_io.a").is_file():  # a shared library finds its own
            out = self.run_program(CMAKE, *options, "-DCMAKE_DISABLE_FIND_PACKAGE_pugixml=ON")
            self.assertIn("far: TRUE, io: , teapot: , path: ()", out)
            out = self.run_program(CMAKE, "-S", CONSUMER, "-B", "no-pugixml",
                                   f"-DCMAKE_PREFIX_PATH={self.prefix}",
                                   "-DCMAKE_DISABLE_FIND_PACKAGE_pugixml=ON", code=1)
            self.assertIn("component io needs pugixml", " ".join(out.split()))

    def test_other_versions_are_refused(self):
        (self.folder / "newer").mkdir()
        (self.folder / "newer/CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.25)\nproject(newer LANGUAGES CXX)\n"
            "find_package(espalier 99.0 REQUIRED)\n")
        out = self.run_program(CMAKE, "-S", "newer", "-B", "newer/build",
                               f"-DCMAKE_PREFIX_PATH={self.prefix}", code=1)
        self.assertIn("99.0", out)

    def test_pkg_config(self):
        path = ":".join(str(p) for p in self.prefix.glob("lib*/**/pkgconfig"))
        flags = self.run_program("pkg-config", "--cflags", "--libs", "espalier-io", "espalier-osd",
                                 "espalier-solve", env=self.environment(PKG_CONFIG_PATH=path))
        self.assertNotIn("-Wall", flags)
        self.run_program("c++", "-std=c++20", CONSUMER / "main.cpp", "-o", "by-pkg-config",
                         *shlex.split(flags))
        self.run_program("./by-pkg-config", env=self.environment())

    def check_optional_component(self, name, source):
        """Builds a program of an optional component by CMake and by pkg-config, and runs it."""
        if not any(self.prefix.glob(f"lib*/**/espalier-{name}.pc")):
            self.skipTest(f"built without {name}")
        (self.folder / name).mkdir()
        (self.folder / name / "main.cpp").write_text(source)
        (self.folder / name / "CMakeLists.txt").write_text(
            f"cmake_minimum_required(VERSION 3.25)\nproject({name} LANGUAGES CXX)\n"
            f"find_package(espalier REQUIRED COMPONENTS {name})\n"
            f"add_executable(main main.cpp)\ntarget_link_libraries(main espalier::{name})\n")
        options = ["-S", name, "-B", f"{name}/build", f"-DCMAKE_PREFIX_PATH={self.prefix}"]
        self.run_program(CMAKE, *options)
        self.run_program(CMAKE, "--build", f"{name}/build")
        self.run_program(f"{name}/build/main", env=self.environment())

        path = ":".join(str(p) for p in self.prefix.glob("lib*/**/pkgconfig"))
        flags = self.run_program("pkg-config", "--cflags", "--libs", f"espalier-{name}",
                                 env=self.environment(PKG_CONFIG_PATH=path))
        self.run_program("c++", "-std=c++20", f"{name}/main.cpp", "-o", f"{name}/by-pkg-config",
                         *shlex.split(flags))
        self.run_program(f"{name}/by-pkg-config", env=self.environment())

    def test_cuda(self):
        # CUDA is not enabled as a language: its headers and its compiler are not needed.
        self.check_optional_component(
            "cuda", "#include <espalier/osd/cuda/cuda_evaluator.h>\n"
                    "int main() { return espalier::osd::cudaDeviceCount() >= 0 ? 0 : 1; }\n")

    def test_cgns(self):
        self.check_optional_component(
            "cgns", "#include <espalier/io/cgns/cgns_model.h>\n"
                    "#include <espalier/io/formats.h>\n"
                    "int main() { espalier::io::addCgnsModels();\n"
                    "             using enum espalier::io::FileContent;\n"
                    "             return espalier::io::isFileOf(Model, \"a.cgns\") ? 0 : 1; }\n")

    def test_headers_of_c(self):
        path = ":".join(str(p) for p in self.prefix.glob("lib*/**/pkgconfig"))
        flags = shlex.split(self.run_program("pkg-config", "--cflags", "--libs", "espalier-c",
                                             env=self.environment(PKG_CONFIG_PATH=path)))
        headers = sorted(path.name for path in self.prefix.glob("include/*.h"))
        self.assertEqual(headers, ["espalier.h", "espalier_model.h", "espalier_pose.h",
                                   "espalier_shapes.h", "espalier_solve.h"])
        # Each header compiles alone, and twice, in C and in C++; the library has its functions.
        calls = ["espalier_version()", "espalier_model_points(0, 0, 0)",
                 "espalier_pose_twist(1, 0, 0, 1.0, 0, 0)", "espalier_lattice_create_star(0, 0)",
                 "espalier_validity_base_cell(0, 0, 0)"]
        for header, call in zip(headers, calls, strict=True):
            for compiler, language in (("cc", "c"), ("c++", "c++")):
                source = self.folder / f"uses_{header}.{language}"
                source.write_text(f"#include <{header}>\n" * 2 +
                                  f"int main(void) {{ return {call} ? 0 : 1; }}\n")
                self.run_program(compiler, f"-std={'c99' if language == 'c' else 'c++20'}",
                                 *WARNINGS, source, "-o", "uses", *flags)
                self.run_program("./uses", env=self.environment())

    def test_nothing_of_the_build_is_left_in_the_package(self):
        for path in [*self.prefix.glob("**/*.cmake"), *self.prefix.glob("**/*.pc")]:
            text = path.read_text(encoding="utf-8")
            for place in (str(BUILD), str(HERE.parents[1]), str(self.folder)):
                self.assertNotIn(place, text, path)

    def test_private_headers_stay(self):
        headers = {str(path.relative_to(self.prefix / "include/espalier"))
                   for path in self.prefix.glob("include/espalier/**/*.h")}
        self.assertIn("embed/local_binding.h", headers)
        for name in ("limit/limit_search.h", "io/files/zip.h", "solve/bernstein.h",
                     "osd/cuda/cuda_launch.h", "embed/box_tree.h"):  # private, and one internal header
            self.assertTrue((HERE.parents[1] / name).is_file(), name)
            self.assertNotIn(name, headers)

    def test_only_headers_about_eigen_include_eigen(self):
        found = {str(path.relative_to(self.prefix / "include/espalier"))
                 for path in self.prefix.glob("include/espalier/**/*.h") if "#include <Eigen/" in path.read_text()}
        self.assertEqual(found, {"stencils/sparse_matrix.h", "embed/trilinear.h"})


class Headers(InstalledBuild):
    def test_each_header_compiles_alone_without_warnings(self):
        path = ":".join(str(p) for p in self.prefix.glob("lib*/**/pkgconfig"))
        names = [file.stem for file in self.prefix.glob("lib*/**/espalier-*.pc")]
        flags = self.run_program("pkg-config", "--cflags", *names,
                                 env=self.environment(PKG_CONFIG_PATH=path))
        # Other include folders become system folders, whose warnings are not shown.
        ours = f"-I{self.prefix}"
        flags = [flag if flag.startswith(ours) else flag.replace("-I", "-isystem", 1)
                 for flag in shlex.split(flags) if not flag.startswith("-D_FORTIFY_SOURCE")]
        headers = sorted(path.relative_to(self.prefix / "include")
                         for path in self.prefix.glob("include/espalier/**/*.h"))
        self.assertGreater(len(headers), 60)

        def compile_alone(header):
            # Twice: it may be included more than once.
            result = subprocess.run(
                ["c++", "-std=c++20", "-fsyntax-only", "-x", "c++", "-", *WARNINGS, *flags],
                input=f"#include <{header}>\n" * 2, text=True, capture_output=True, check=False)
            return f"{header}:\n{result.stderr}" if result.returncode or result.stderr else None

        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            self.assertEqual([error for error in pool.map(compile_alone, headers) if error], [])


if __name__ == "__main__":
    CMAKE = sys.argv.pop(1)
    BUILD = pathlib.Path(sys.argv.pop(1))
    unittest.main()
