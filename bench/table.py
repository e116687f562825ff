# SPDX-License-Identifier: Apache-2.0
"""Prints docs/performance.md from what espalier_bench measured.

    table.py RESULTS.json

Of the repetitions of a benchmark the quickest counts: a neighbour on the machine can only make one
slower.
"""

import json
import sys

PEERS = ("OpenSubdiv", "Eigen")


def read(path):
    """The quickest repetition of each benchmark, by name, and what the machine is."""
    with open(path, encoding="utf-8") as file:
        data = json.load(file)
    best = {}
    for run in data["benchmarks"]:
        if run.get("error_occurred"):
            sys.exit(f"{run['name']}: {run['error_message']}")
        name = run["run_name"].removesuffix("/real_time")
        if run["run_type"] == "iteration" and (
                name not in best or run["real_time"] < best[name]["real_time"]):
            best[name] = run
    return best, data["context"]


def milliseconds(run):
    return f"{run['real_time']:.1f} ms"


def rows(best):
    """One row for each of our runs and each peer on the same data."""
    triad = {threads: best[f"triad/threads/{threads}"]["bytes_per_second"] for threads in (1, 2)}
    for name, ours in best.items():
        kind, *case, who = name.split("/")
        if kind != "apply" or not who.startswith("Espalier"):
            continue
        workload, real, components = case
        threads = 2 if who.endswith("2 threads") else 1
        share = ours["bytes_per_second"] / triad[threads]
        what = f"{workload}, {real}" + (f", {threads} threads" if threads > 1 else "")
        if int(components) > 3:
            one = best["/".join([kind, workload, real, "3", who])]
            poses = int(components) // 3
            yield (f"{what}, {poses} poses, a pose", "one pose", milliseconds(one),
                   f"{ours['real_time'] / poses:.1f} ms",
                   f"{ours['real_time'] / poses / one['real_time']:.2f} of it", f"{share:.2f}",
                   f"{ours['bytes of CSR']:.2f}")
            continue
        for peer in PEERS:
            theirs = best.get("/".join([kind, *case, peer]))
            if theirs:
                yield (what, peer, milliseconds(theirs), milliseconds(ours),
                       f"{theirs['real_time'] / ours['real_time']:.1f} ×", f"{share:.2f}",
                       f"{ours['bytes of CSR']:.2f}")


PAGE = """# Performance

Applying a table to values: what happens for every pose. `scripts/bench` measures it, each figure
against a peer in the same run, on the same arrays, with each result compared with plain sums (every
997th row); it prints this page.
The quickest of five repetitions counts. One thread unless said; the peers always have one.

- *surface*: S_3 of a torus of quadrilaterals, 13 entries a row.
- *regular model*: a million points bound to a box by B-splines, 64 entries a row. A subdivided
  lattice has such rows between the planes of its base vertices.
- *irregular model*: the same points bound at level 3 to a cylinder around its irregular axis, 42
  entries a row.

Ours is [`osd::CompiledTable`](../osd/compiled_table.h): rows with the same columns lie together, with
one row in each lane of a register, and rows that are outer products as their factors. The peers are
OpenSubdiv's `Osd::CpuEvaluator`, which takes float only, and Eigen's row-major product. Bytes are those
of the compiled table over those of compressed sparse rows; the share of the triad is what the table and
the results take, over the bytes that a + s · b moves in the same time, with as many threads. It is no
share of the memory where a large last cache holds the table, as here: 260 MB, and the triad's arrays
take 768.

{table}

Triad: {one:.1f} GB/s with one thread, {two:.1f} with two. {cores} cores of {mhz} MHz, {date}. Built as
`Release`; instructions are chosen when the program runs.
"""


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    best, context = read(sys.argv[1])
    lines = ["| apply | peer | peer's time | our time | ratio | share of the triad | bytes |",
             "|---|---|---|---|---|---|---|"]
    lines += ["| " + " | ".join(row) + " |" for row in rows(best)]
    one, two = (best[f"triad/threads/{threads}"]["bytes_per_second"] / 1e9 for threads in (1, 2))
    print(PAGE.format(table="\n".join(lines), one=one, two=two, cores=context["num_cpus"],
                      mhz=context["mhz_per_cpu"], date=context["date"][:10]), end="")


if __name__ == "__main__":
    main()
