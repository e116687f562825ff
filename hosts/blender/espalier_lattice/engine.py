# SPDX-License-Identifier: Apache-2.0
"""Finds Espalier's Python module: in the folder `lib` of the add-on, where its zip has it, or where Python
finds it."""

import pathlib
import sys


def load():
    """Returns the module espalier.

    Raises an ImportError that says what to do if it is missing, or made for another Python."""
    library = pathlib.Path(__file__).parent / "lib"
    if library.is_dir() and str(library) not in sys.path:
        sys.path.insert(0, str(library))
    try:
        import espalier
    except ImportError as error:
        version = f"{sys.version_info.major}.{sys.version_info.minor}"
        raise ImportError(
            f"Espalier's Python module cannot be loaded ({error}). This Blender runs Python {version}: make "
            f"the zip of the add-on with the module for that version (scripts/blender --python PROGRAM), or "
            f"install the module for Blender's Python") from error
    return espalier
