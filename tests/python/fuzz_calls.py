# SPDX-License-Identifier: Apache-2.0
"""Calls every function, method and attribute of espalier with wrong arguments.

test_fuzz_calls.py runs this file in a separate process, so that an abort or a crash fails the test. A
call may return or raise any exception except SystemError.
"""

import copy
import copyreg
import importlib
import inspect
import pickle
import random
import sys

import numpy as np

import espalier

random.seed(22)
BOX = espalier.shapes.box(cells=(1, 1, 2))
REFINER = espalier.Refiner(BOX)
POINTS = np.array([[0.5, 0.5, 0.5], [0.2, 0.3, 0.9]])
BINDING = espalier.bind(BOX, POINTS, level=1)
TABLE = BINDING.table
COMPILED = espalier.CompiledTable(TABLE)
CHECK = espalier.ValidityCheck(BOX, 1)
OBJECTS = [
    BOX, REFINER, BINDING, TABLE, COMPILED, CHECK, espalier.CompiledAdjoint(TABLE),
    espalier.ChangeEvaluator(COMPILED), espalier.DesignVariables(12), espalier.ThreadLimit(1),
    espalier.MemoryLimit(2**40), espalier.fit(BOX, BINDING, 0 * POINTS),
    CHECK.check(BOX.positions), CHECK.largest_step(BOX.positions),
]
MODULES = [espalier._core]
try:
    MODULES.append(importlib.import_module("espalier._compare"))
except ImportError:
    pass  # built without OpenSubdiv
CLASSES = [each for module in MODULES for each in vars(module).values() if isinstance(each, type)]
# pybind11's base class and metaclass, which all classes share.
BASES = sorted({each for made in CLASSES for each in (*made.__mro__, *type(made).__mro__)
                if each not in CLASSES and each not in (object, type)}, key=repr)


class Derived(espalier.Lattice):
    """A class that a user derives from a class of Espalier."""


class OfTwo(espalier.Lattice, espalier.Refiner):
    """A class with two base classes. Its objects hold a C++ value for each."""


class OfNone(BASES[0]):
    """A class without a C++ value."""


EMPTY = [each.__new__(each) for each in (*CLASSES, Derived, OfTwo)]
READ_ONLY = np.zeros((12, 3))
READ_ONLY.setflags(write=False)
VALUES = OBJECTS + EMPTY + [
    None, True, 0, 1, -1, 3, 2**31 - 1, -2**31, 2**31, 2**63 - 1, -2**63, 2**64, 10**30, 0.0, -1.5,
    float("nan"), float("inf"), 1e308, 1j, "", "c1", "no such word", "\udcff", "\0", b"", b"\xff",
    [], [[]], [1, 2], {}, {"a": 1}, {(0, 1): 1.0}, {0: float("nan")}, (), object(), int, len,
    np.zeros(0), np.zeros((0, 3)), BOX.positions, BOX.positions[::-1], BOX.positions.T, READ_ONLY,
    np.asfortranarray(BOX.positions), np.full((12, 3), np.nan), np.full((12, 3), 1e308), POINTS,
    POINTS.astype("f4"), POINTS.astype(">f8"), POINTS.astype("f2"), POINTS.astype("c16"),
    POINTS.astype("O"), POINTS.astype("U8"), np.array([2**63], "u8"), np.array([2**31 - 1]),
    np.arange(8)[None], np.arange(12, dtype="i4"), np.zeros((2, 12, 3)), np.array(1.0),
    np.broadcast_to(0.0, (2**40, 3)), np.zeros((12, 3), "M8[s]"), BOX.cells, BOX.faces, np.ones(1),
    np.frombuffer(b"0" * 289, "f8", 36, 1).reshape(12, 3),
]
# VALUES without large integers. Some functions make a lattice of any size, which could take all memory.
SMALL = [each for each in VALUES if not (isinstance(each, int) and not isinstance(each, bool)
                                         and 3 < each < 2**63)]


def skips(name):
    return name in {"write", "save", "__class__"}


def attempt(function, *arguments, **options):
    try:
        return function(*arguments, **options)
    except (KeyboardInterrupt, SystemExit, SystemError):
        raise
    except BaseException as error:
        str(error)
        return error


def parameters_of(function):
    """Returns the names of the parameters, from the signature that pybind11 writes."""
    text = (function.__doc__ or "").split(") ->")[0]
    return [part.split(":")[0].strip() for part in text.split("(", 1)[-1].split(", ")
            if ":" in part and part.split(":")[0].strip().isidentifier()]


def call_with_all(function, calls):
    names = [name for name in parameters_of(function) if name != "self"]
    for value in SMALL:
        attempt(function, value)
    for _ in range(calls):
        attempt(function, *random.choices(SMALL, k=random.randrange(5)))
        attempt(function, **{name: random.choice(SMALL) for name in names if random.random() < 0.7})


def check_without_value(made):
    """Checks that every attribute and method raises TypeError."""
    for name in dir(made):
        descriptor = inspect.getattr_static(type(made), name, None)
        if isinstance(descriptor, property):
            error = attempt(getattr, made, name)
            assert isinstance(error, TypeError), (type(made), name, error)
    for protocol in range(6):
        assert isinstance(attempt(pickle.dumps, made, protocol), TypeError), (type(made), protocol)
    attempt(repr, made), attempt(copy.deepcopy, made)


def check_bases():
    """Checks that pybind11's classes make no objects, cannot be changed, and raise for other calls."""
    assert [each.__name__ for each in BASES] == ["pybind11_object", "pybind11_type"], BASES
    base, metaclass = BASES
    for made in base, OfNone, metaclass("OfNoneHere", (base,), {}):
        for make in (made, made.__new__, metaclass.__call__, type.__call__):
            arguments = () if make is made else (made,)
            assert isinstance(attempt(make, *arguments), TypeError), (made, make)
    for made in OBJECTS:
        for protocol in range(6):
            attempt(object.__reduce_ex__, made, protocol)
        attempt(object.__reduce__, made), attempt(copyreg.__reduce_ex__, made, 0)
        attempt(copyreg._reconstructor, type(made), base, made)
    for each in BASES:
        call_with_all(each, 500)
        for name, member in vars(each).items():
            for function in (member, attempt(getattr, each, name)):
                if callable(function) and not skips(name):
                    call_with_all(function, 200)
                    for made in (*OBJECTS, *EMPTY, *CLASSES, *BASES, OfNone):
                        attempt(function, made), attempt(function, made, (), {})
                        attempt(function, made, random.choice(SMALL))


def check_classes_are_not_changed():
    """Checks that objects and classes cannot be changed so that an object is read as another class."""
    for made in OBJECTS + EMPTY:
        for other in (*CLASSES, Derived, OfTwo, OfNone):
            if other is not type(made) and {other, type(made)} & set(CLASSES):
                assert isinstance(attempt(setattr, made, "__class__", other), TypeError)
    for each in (*CLASSES, *BASES):
        for name, value in (("__bases__", (OfNone,)), ("__new__", object.__new__), ("more", 1)):
            assert isinstance(attempt(setattr, each, name, value), TypeError), (each, name)


def main():
    assert len(CLASSES) >= 15, CLASSES
    check_bases()
    if sys.version_info >= (3, 10):
        check_classes_are_not_changed()
    for made in EMPTY:
        check_without_value(made)
    with espalier.MemoryLimit(3 * 10**9):
        for made in OBJECTS + EMPTY:
            for protocol in range(6):
                dumped = attempt(pickle.dumps, made, protocol)
                assert isinstance(dumped, (bytes, TypeError)), (made, protocol, dumped)
                if isinstance(dumped, bytes):
                    assert type(pickle.loads(dumped)) is type(made)
            attempt(made.__reduce__)
            for name in dir(made):
                method = attempt(getattr, made, name)
                if callable(method) and not skips(name) and not isinstance(method, Exception):
                    if not name.startswith("__") or name in {"__init__", "__setstate__", "__exit__"}:
                        call_with_all(method, 200)
        for each in CLASSES:
            call_with_all(each, 500)
            attempt(each.__init__)
        for module in espalier, espalier.shapes:
            for name, function in vars(module).items():
                if inspect.isbuiltin(function) and not name.startswith("_"):
                    call_with_all(function, 500)
    print("done")


main()
sys.exit(0)
