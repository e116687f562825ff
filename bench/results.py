# SPDX-License-Identifier: Apache-2.0
"""Reads the measurements of espalier_bench."""

import json
import re
import sys


def read(paths):
    """Returns the fastest repetition of each benchmark by name, and a description of the machine.

    Other load on the machine can only make a repetition slower.
    """
    best = {}
    for path in paths:
        with open(path, encoding="utf-8") as file:
            data = json.load(file)
        for run in data["benchmarks"]:
            if run.get("error_occurred"):
                sys.exit(f"{run['name']}: {run['error_message']}")
            name = re.sub(r"(/iterations:\d+)?(/real_time)?$", "", run["run_name"])
            if run["run_type"] == "iteration" and (
                    name not in best or run["real_time"] < best[name]["real_time"]):
                best[name] = run
    return best, data["context"]
