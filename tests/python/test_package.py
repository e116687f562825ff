# SPDX-License-Identifier: Apache-2.0
"""Tests the package as users get it: stubs, docstrings, the installed files and the wheel."""

import ast
import importlib.util
import inspect
import os
import pathlib
import re
import site
import subprocess
import sys
import zipfile

import numpy as np
import pytest

import espalier
import espalier.dvgeometry
import espalier.openmdao

PACKAGE = pathlib.Path(espalier.__file__).parent
SOURCE = pathlib.Path(__file__).parents[2]
SITE = "lib/python{}.{}/dist-packages".format(*sys.version_info)
BINARY_DIR = os.environ.get("ESPALIER_BINARY_DIR")
CHECK = """
import numpy as np, espalier
assert espalier.__file__.startswith({root!r}), espalier.__file__
rest = espalier.shapes.box(cells=(2, 2, 2))
points = np.full((1, 3), 0.4)
assert np.allclose(espalier.bind(rest, points).deform(rest.positions), points)
from espalier.dvgeometry import DVGeometry
import espalier.openmdao
geo = DVGeometry(rest)
geo.addPointSet(points, "points")
assert geo.addLocalDV("up", axis="z") == 27
assert np.allclose(espalier.constraints.distances(rest.positions, [[0, 26]])[0], 3 ** 0.5)
print(espalier.__version__)
"""

needs_build = pytest.mark.skipif(BINARY_DIR is None, reason="ctest says where the build is")


def public_objects():
    """Returns the names and objects that users see."""
    for module in (espalier, espalier.constraints, espalier.dvgeometry, espalier.openmdao, espalier.pose,
                   espalier.shapes):
        for name in module.__all__:
            each = getattr(module, name)
            if inspect.ismodule(each) or isinstance(each, str):
                continue
            yield f"{module.__name__}.{name}", each
            if inspect.isclass(each) and name != "PointStatus":
                for member, value in vars(each).items():
                    if not member.startswith("_"):
                        yield f"{module.__name__}.{name}.{member}", value


def stub_functions():
    """Yields the qualified name and the syntax tree of each function in the stubs."""
    for file, prefix in (("__init__.pyi", "espalier"), ("constraints.pyi", "espalier.constraints"),
                         ("pose.pyi", "espalier.pose"),
                         ("shapes.pyi", "espalier.shapes")):
        for node in ast.parse((PACKAGE / file).read_text()).body:
            if isinstance(node, ast.FunctionDef):
                yield f"{prefix}.{node.name}", node
            elif isinstance(node, ast.ClassDef):
                for inner in node.body:
                    if isinstance(inner, ast.FunctionDef) and not inner.decorator_list:
                        yield f"{prefix}.{node.name}.{inner.name}", inner


def test_everything_has_a_docstring():
    for name, each in public_objects():
        assert each.__doc__ and len(each.__doc__) > 20, name


def test_docstrings_give_the_shapes_of_arrays():
    for name, each in public_objects():
        if "ArrayLike" in (each.__doc__ or "").split("\n")[0]:
            # The parameter is described in the docstring of the method, or of the class.
            owner = getattr(espalier, name.split(".")[1]).__doc__ if name.count(".") == 2 else ""
            assert re.search(r"array.*\(|arrays \(|\bvertices : int", each.__doc__ + owner,
                             re.DOTALL), name


def test_parameters_of_the_stubs_are_those_of_the_functions():
    """stubtest cannot read signatures of pybind11 functions; this test reads them in the docstrings."""
    seen = 0
    for name, node in stub_functions():
        each = espalier
        for part in name.split(".")[1:]:
            each = getattr(each, part, None)
        line = (each.__doc__ or "").split("\n")[0] if each is not None else ""
        if not re.match(r"\w+\(", line):
            continue  # a Python function, which stubtest reads, or a class of _compare
        text = re.sub(r"<[^>]*>|array\([^)]*\)", "0", line[line.index("("):])
        # A parameter is "name: type = default". Types hold no "=", and names no spaces.
        found = re.findall(r"[(,] ?(\*\w*|\w+): ?|[(,] ?(\*)(?=,)", text)
        names = [a or b for a, b in found]
        arguments = node.args
        wanted = [a.arg for a in arguments.args]
        if arguments.kwonlyargs:
            wanted += ["*", *(a.arg for a in arguments.kwonlyargs)]
        if arguments.vararg:
            continue
        assert names == wanted, (name, line)
        seen += 1
    assert seen > 50


@pytest.mark.skipif(importlib.util.find_spec("mypy") is None, reason="mypy is not installed")
def test_stubs_are_those_of_the_module(tmp_path):
    # pybind11's types have a metaclass. All of them have an __init__, even if it only raises.
    types = [name for name in espalier.__all__
             if type(getattr(espalier, name)).__name__ == "pybind11_type"]
    (tmp_path / "allowed").write_text(
        "".join(f"espalier.{name}\nespalier.{name}.__init__\n" for name in types))
    done = subprocess.run(
        [sys.executable, "-m", "mypy.stubtest", "espalier", "--allowlist", tmp_path / "allowed",
         "--ignore-unused-allowlist"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
        env={**os.environ, "MYPYPATH": str(PACKAGE.parent), "MYPY_CACHE_DIR": str(tmp_path)})
    assert done.returncode == 0, done.stdout + done.stderr


# The code of the page, the names that it uses, and members that users of pyGeo and OpenMDAO know.
PAGE_CODE = """
import pathlib
from typing import Any
import numpy as np
import numpy.typing as npt
from espalier.dvgeometry import DVGeometry
from espalier.openmdao import GeometryComponent
tmp_path = pathlib.Path()
points = by_points = np.zeros((2, 3))
problem: Any = None
thickness: Any = None
{code}
geo.rot_x["axis"].coef[:], geo.scale["axis"].s, geo.coef
geo.DV_listGlobal["twist"].value, geo.DV_listLocal["shape"].lower
jacobian = geo.JT["wing"]
if jacobian is not None:
    jacobian @ points.ravel()
geometry.add_input("more", val=0.0)
geometry.options["config"] = "cruise"
"""


@pytest.mark.skipif(importlib.util.find_spec("mypy") is None, reason="mypy is not installed")
def test_the_code_of_the_page_of_pygeo_has_types(tmp_path):
    page = (SOURCE / "docs/from-pygeo-pygem-su2.md").read_text()
    section = page[page.index("### DVGeometry"):page.index("## PyGeM")]
    code = "\n".join(re.findall(r"```py(?:thon)?\n(.*?)```", section, re.DOTALL))
    assert "rot_theta" in code and "GeometryComponent(" in code
    # A function with types, so that mypy reads its body.
    code = code.replace("def twist(values, geo):",
                        "def twist(values: npt.NDArray[np.float64], geo: DVGeometry) -> None:")
    program = PAGE_CODE.format(code=code)
    (tmp_path / "page.py").write_text(program)
    done = mypy(tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    # mypy reads the stubs: a word that is wrong is found.
    (tmp_path / "page.py").write_text(program + "geo.rot_theta['axis'].coefficients\ngeo.getNDVs()\n")
    assert mypy(tmp_path).stdout.count("error: ") == 2


def mypy(folder):
    return subprocess.run([sys.executable, "-m", "mypy", "page.py"], cwd=folder, capture_output=True, text=True, check=False,
                          env={**os.environ, "MYPYPATH": str(PACKAGE.parent), "MYPY_CACHE_DIR": str(folder)})


def install(prefix, *components):
    for component in components:
        subprocess.run([os.environ["ESPALIER_CMAKE"], "--install", BINARY_DIR, "--prefix", prefix,
                        "--component", component], check=True, capture_output=True)


def check_import(folder):
    """Checks that another Python process imports the package from this folder."""
    return subprocess.run([sys.executable, "-c", CHECK.format(root=str(folder))], check=True,
                          capture_output=True, text=True, cwd="/",
                          env={**os.environ, "PYTHONPATH": str(folder)}).stdout.strip()


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    prefix = tmp_path_factory.mktemp("prefix")
    # The component "libraries" has the shared libraries. It is empty if the libraries are static.
    install(prefix, "python", "libraries")
    return prefix / SITE


@needs_build
def test_installed_where_debians_python_looks(installed):
    for prefix in ("/usr", "/usr/local"):
        assert f"{prefix}/{SITE}" in site.getsitepackages()
    assert check_import(installed) == espalier.__version__
    names = {path.name for path in (installed / "espalier").iterdir()}
    assert names >= {"__init__.py", "__init__.pyi", "constraints.py", "constraints.pyi", "dvgeometry.py",
                     "dvgeometry.pyi", "openmdao.py", "openmdao.pyi", "pose.py", "pose.pyi", "shapes.py",
                     "shapes.pyi", "py.typed"}
    assert not any(path.is_symlink() for path in (installed / "espalier").iterdir())


@needs_build
def test_extensions_show_one_symbol_each(installed):
    if list(installed.parents[2].glob("lib/**/libespalier_far.so*")):
        pytest.skip("of shared libraries")
    extensions = list((installed / "espalier").glob("*.so"))
    assert extensions
    for extension in extensions:
        shown = subprocess.run(["nm", "-D", "--defined-only", extension], check=True,
                               capture_output=True, text=True).stdout.split("\n")
        names = [line.split()[-1] for line in shown if line]
        assert names == ["PyInit_" + extension.name.split(".")[0]]


@needs_build
def test_a_wheel_is_built_offline(installed, tmp_path):
    if list(installed.parents[2].glob("lib/**/libespalier_far.so*")):
        pytest.skip("a wheel takes static libraries")
    if importlib.util.find_spec("wheel") is None:
        pytest.skip("python3-wheel is not installed")
    subprocess.run([sys.executable, SOURCE / "python/make_wheel.py", installed, tmp_path / "out",
                    espalier.__version__], check=True, capture_output=True)
    (wheel,) = (tmp_path / "out").iterdir()
    python = "cp{}{}".format(*sys.version_info)
    assert re.fullmatch(rf"espalier-{espalier.__version__}-{python}-{python}-linux_\w+\.whl",
                        wheel.name)
    target = tmp_path / "target"
    if importlib.util.find_spec("pip") is None:
        zipfile.ZipFile(wheel).extractall(target)
    else:
        subprocess.run([sys.executable, "-m", "pip", "install", "--no-index", "--no-deps",
                        "--target", target, wheel], check=True, capture_output=True)
    assert check_import(target) == espalier.__version__
    assert np.loadtxt(next(target.glob("*.dist-info/RECORD")), dtype=str, delimiter=",").size > 0
