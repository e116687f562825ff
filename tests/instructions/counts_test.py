#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Counts the instructions of three small workloads, and fails if one needs 5 % more than counts.json says.

The count of instructions does not depend on how busy the machine is, as a time does. It depends by 1 % on the
processor, for which the C library chooses its memcpy(), and by much more on the compiler and its options, so the
table names the build that it is for, and other builds skip the test. After a change that needs more instructions for
a good reason, or far fewer, renew the table:

    cmake --build --preset test --target renew_instruction_counts

usage: counts_test.py PROGRAM BUILD [--renew]
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

TABLE = pathlib.Path(__file__).with_name("counts.json")
WORKLOADS = ("apply", "bind", "refine")
MAX_GROWTH = 1.05
SKIPPED = 77


def count_instructions(program, workload, folder):
    """Returns the number of instructions that the function counted() of the program takes."""
    out = folder / workload
    # A compiler may give a copy of counted() a longer name.
    run = subprocess.run(
        ["valgrind", "--tool=callgrind", "--toggle-collect=counted*", f"--callgrind-out-file={out}", program, workload],
        capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(f"{workload} failed under valgrind:\n{run.stdout}{run.stderr}")
    totals = re.search(r"^(?:summary|totals): (\d+)$", out.read_text(), re.MULTILINE)
    if not totals or int(totals[1]) == 0:
        sys.exit(f"{workload}: callgrind has counted nothing; is counted() in the program's symbols?")
    return int(totals[1])


def slips(counts, expected):
    """Returns a line for each workload that needs too many instructions."""
    return [f"{workload}: {counts[workload]:,} instructions, {counts[workload] / expected[workload] - 1:.1%} more than "
            f"{expected[workload]:,}" for workload in WORKLOADS if counts[workload] > MAX_GROWTH * expected[workload]]


def check_slips():
    """Checks that 5 % more are allowed, and that one instruction more is found and named."""
    expected = dict.fromkeys(WORKLOADS, 1000)
    assert slips(dict.fromkeys(WORKLOADS, 1050), expected) == []
    assert slips({**expected, "bind": 1051}, expected) == ["bind: 1,051 instructions, 5.1% more than 1,000"]


def main():
    program, build, renew = sys.argv[1], sys.argv[2], sys.argv[3:] == ["--renew"]
    check_slips()
    table = json.loads(TABLE.read_text())
    if not shutil.which("valgrind"):
        print("skipped: valgrind is not installed")
        return SKIPPED
    if not renew and table["build"] != build:
        print(f"skipped: the table is for the build\n  {table['build']}\nand this build is\n  {build}")
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        counts = {workload: count_instructions(program, workload, pathlib.Path(folder)) for workload in WORKLOADS}
    if renew:
        TABLE.write_text(json.dumps({"build": build, "counts": counts}, indent=2) + "\n")
        print(f"wrote {TABLE}")
        return 0
    for workload in WORKLOADS:
        print(f"{workload}: {counts[workload]:,} instructions, {counts[workload] / table['counts'][workload]:.4f} of the table's")
    found = slips(counts, table["counts"])
    if found:
        print("too many instructions:", *found, sep="\n  ")
        print(__doc__.split("\n\n")[1])
        print("    cmake --build --preset test --target renew_instruction_counts")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
