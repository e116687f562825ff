# SPDX-License-Identifier: Apache-2.0
"""Prints docs/performance.md from the measurements of espalier_bench, and draws its figure.

    table.py FIGURE.svg RESULTS.json...
"""

import sys
import textwrap

import plots
from results import read

OURS = (("Espalier", ""), ("Espalier 2 threads", ", 2 threads"))
FORMS = dict([*OURS, ("Espalier factors", ", in factors"),
              ("Espalier factors 2 threads", ", in factors, 2 threads"),
              ("Espalier adjoint", ", adjoint"),
              ("Espalier adjoint 2 threads", ", adjoint, 2 threads"),
              ("Espalier factors adjoint", ", in factors, adjoint"),
              ("Espalier factors adjoint 2 threads", ", in factors, adjoint, 2 threads")])


def wrap(paragraph, mark=""):
    return textwrap.fill(" ".join(paragraph.split()), 104, initial_indent=mark,
                         subsequent_indent=" " * len(mark), break_on_hyphens=False)


def table(head, rows):
    rows = list(rows)
    if not rows:
        return "The peer was not there."
    rows = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def ratio(other, ours):
    return f"{other / ours:.1f} ×"


def milliseconds(run):
    time = run["real_time"]
    return f"{time:.1f} ms" if time < 1000 else f"{time / 1000:.2f} s"


def nanoseconds(run, factor=1):
    """Nanoseconds per item."""
    return 1e6 * run["real_time"] / run["items"] * factor


def apply_rows(best):
    """Returns one row for each of our runs and each peer on the same data."""
    triad = {threads: best[f"triad/threads/{threads}"]["bytes_per_second"] for threads in (1, 2)}
    for name, ours in best.items():
        kind, *case, who = name.split("/")
        if kind != "apply" or not who.startswith("Espalier"):
            continue
        workload, real, components = case
        threads = 2 if who.endswith("2 threads") else 1
        share = ours["bytes_per_second"] / triad[threads]
        what = f"{workload}, {real}" + FORMS[who]
        if "adjoint" in who:
            forward = best["/".join([kind, *case, who.replace(" adjoint", "")])]
            yield (what, "forward", milliseconds(forward), milliseconds(ours),
                   ratio(forward["real_time"], ours["real_time"]), f"{share:.2f}",
                   f"{ours['bytes of CSR']:.2f}")
            continue
        if int(components) > 3:
            one = best["/".join([kind, workload, real, "3", who])]
            poses = int(components) // 3
            yield (f"{what}, {poses} poses, a pose", "one pose", milliseconds(one),
                   f"{ours['real_time'] / poses:.1f} ms",
                   f"{ours['real_time'] / poses / one['real_time']:.2f} of it", f"{share:.2f}",
                   f"{ours['bytes of CSR']:.2f}")
            continue
        for peer in ("OpenSubdiv", "Eigen"):
            other = best.get("/".join([kind, *case, peer]))
            if other:
                yield (what, peer, milliseconds(other), milliseconds(ours),
                       ratio(other["real_time"], ours["real_time"]), f"{share:.2f}",
                       f"{ours['bytes of CSR']:.2f}")


def levels(best, job, peer=None):
    """Returns our runs of a job on the surface and OpenSubdiv's of the same job, or of job `peer`:
    (level, threads, ours, peer's)."""
    for level in (3, 4, 5):
        other = best.get(f"{peer or job}/surface/{level}/OpenSubdiv")
        for who, threads in OURS if other else ():
            yield level, threads, best[f"{job}/surface/{level}/{who}"], other


def lattices(best, job):
    """Returns our runs of a job on the lattice, and OpenSubdiv's run with the closest number of items."""
    peers = [(best[name], level) for level in (3, 4, 5)
             if (name := f"{job}/surface/{level}/OpenSubdiv") in best]
    for who, threads in OURS if peers else ():
        ours = best[f"{job}/lattice/3/{who}"]
        other, level = min(peers, key=lambda peer: abs(peer[0]["items"] - ours["items"]))
        yield threads, ours, other, level


def refine_rows(best):
    for level, threads, ours, other in levels(best, "refine"):
        a, b = nanoseconds(other), nanoseconds(ours)
        yield (f"surface, levels 1 to {level}{threads}, a child face", "OpenSubdiv", f"{a:.0f} ns",
               f"{b:.0f} ns", ratio(a, b))
    for threads, ours, other, level in lattices(best, "refine"):
        a, b = nanoseconds(other), nanoseconds(ours)
        yield (f"lattice, levels 1 to 3{threads}, a child cell",
               f"OpenSubdiv, a child face of levels 1 to {level}", f"{a:.0f} ns", f"{b:.0f} ns",
               ratio(a, b))


def build_rows(best):
    for level, threads, ours, other in levels(best, "build"):
        yield (f"surface, S_{level}{threads}", "OpenSubdiv", milliseconds(other),
               milliseconds(ours), ratio(other["real_time"], ours["real_time"]))
    for threads, ours, other, level in lattices(best, "build"):
        a, b = nanoseconds(other, 64 / 13), nanoseconds(ours)
        yield (f"lattice, S_3{threads}, a row", f"OpenSubdiv, a row of S_{level} × 64/13",
               f"{a:.0f} ns", f"{b:.0f} ns", ratio(a, b))
        # OpenSubdiv's table equals ours, so it has the same number of entries.
        entries = best[f"build/surface/{level}/Espalier"]["entries"]
        a, b = 1e6 * other["real_time"] / entries, 1e6 * ours["real_time"] / ours["entries"]
        yield (f"lattice, S_3{threads}, an entry", f"OpenSubdiv, an entry of S_{level}",
               f"{a:.1f} ns", f"{b:.1f} ns", ratio(a, b))


def in_turn_rows(best):
    for job, what in (("in turn", "R_1 to R_{}"), ("at once", "S_{} at once")):
        for level, threads, ours, other in levels(best, job, "in turn"):
            yield (f"surface, {what.format(level)}{threads}", "OpenSubdiv", milliseconds(other),
                   milliseconds(ours), ratio(other["real_time"], ours["real_time"]))


def bind_rows(best):
    other = best.get("bind/random/3/VTK")
    for job, what in (("bind/random/3", "random points, level 3, all of binding"),
                      ("embed/random/3", "random points, level 3, finding them in its cells"),
                      ("bind/surface/5", "points of a surface, level 5, all of binding")):
        for who, threads in OURS:
            ours = best[f"{job}/{who}"]
            compared = other if "random" in job else None
            yield (what + threads, "VTK" if compared else "none",
                   milliseconds(compared) if compared else "", milliseconds(ours),
                   ratio(compared["real_time"], ours["real_time"]) if compared else "")


def limit_rows(best):
    """Returns the rows that compare the limit with levels: building a row, applying it."""
    for lattice in ("regular", "irregular"):
        def run(job, what, lattice=lattice):
            return best[f"limit/{job}/{lattice}/{what}"]
        for level in ("level 5", "level 6"):
            off = run("bind", level)["distance from the limit"]
            for who in ("", " 2 threads"):
                other, ours = run("bind", level + who), run("bind", "limit" + who)
                yield (f"{lattice}, binding, a point{who and ', 2 threads'}", level, f"{off:.0e}",
                       f"{nanoseconds(other) / 1000:.1f} µs", f"{nanoseconds(ours) / 1000:.1f} µs",
                       ratio(other["real_time"], ours["real_time"]))
            other, ours = run("apply", level), run("apply", "limit")
            yield (f"{lattice}, applying, a point", level, f"{off:.0e}",
                   f"{nanoseconds(other):.1f} ns", f"{nanoseconds(ours):.1f} ns",
                   ratio(other["real_time"], ours["real_time"]))


def memory_rows(best):
    for case, what in (("random/3", "random points, level 3"),
                       ("surface/5", "points of a surface, level 5")):
        run = best[f"bindAndApply/{case}"]
        result, peak = run["result bytes"], run["peak bytes"]
        yield what, f"{result / 1e6:.0f} MB", f"{peak / 1e6:.0f} MB", ratio(peak, result)


def change_rows(best):
    for who, threads in OURS:
        whole = best[f"change/all/{who}"]
        for moved in ("1 together", "10 together", "100 together", "10 apart", "100 apart"):
            ours = best[f"change/{moved}/{who}"]
            what = "1" if moved == "1 together" else moved.replace(" ", ", ")
            yield (f"{what}{threads}", f"{ours['rows']:,.0f}", milliseconds(whole),
                   f"{ours['real_time']:.3f} ms", ratio(whole["real_time"], ours["real_time"]))


def absent(best):
    """Returns a sentence on the peers that were not available."""
    there = {name.rsplit("/", 1)[1] for name in best}
    missing = [peer for peer in ("OpenSubdiv", "VTK") if peer not in there]
    if not missing:
        return ""
    return f" Not there when this was built, so without rows: {' and '.join(missing)}."


def growth(best):
    """Returns a sentence on each panel of the figure, with its numbers."""
    def exponents(job):
        return " and ".join(f"{plots.fit(points)[1]:.2f}"
                            for points in plots.series(best, job).values())

    def change(job):
        points = plots.series(best, job)[1]
        first, last = points[0], points[-1]
        return last[0] / first[0], last[1] / first[1]

    def gain(job):
        one, two = (plots.series(best, job)[threads][-1][1] for threads in (1, 2))
        return one / two

    levels_up, level_cost = change("bind by level")
    cells_up, cell_cost = change("bind by cells")
    items = (
        f"""*Binding, by points*, level 3 of 1,000 cells: time goes with the number of points to the
        power {exponents("bind by points")} (one thread, two). 1 would be linear; it is below, for
        points share the cells that are refined for them. Two threads bind a million
        {gain("bind by points"):.2f} times as fast as one.""",
        f"""*Applying, by points*, the same binding compiled: to the power
        {exponents("apply by points")}. Two threads apply a million
        {gain("apply by points"):.2f} times as fast as one.""",
        f"""*Binding, by level*, 1 to 6, 30,000 points in 1,000 cells: the whole level has
        {levels_up:,.0f} times the cells, and binding takes {level_cost:.1f} times as long. Only cells
        that hold points are refined, with what their rules need around them.""",
        f"""*Binding, by base cells*, 2³ to 20³, 100,000 points at level 3: {cells_up:,.0f} times the
        cells, {cell_cost:.1f} times as long.""")
    return "\n".join(wrap(item, "- ") for item in items)


INTRO = """What Espalier takes, against peers that do the like. `scripts/bench` measures it, each
figure and its peer's in the same run and on the same data, compares the results, and prints this page.
The quickest of the repetitions counts: five of applying, three of the rest, two of growth, one of memory.
One thread unless said; the peers always have one. Ratios are the peer's time over ours."""

PAGE = """# Performance

{intro}

{cores} cores of {mhz} MHz, {date}; built as `Release` (`-O3 -DNDEBUG`); instructions are chosen when the
program runs.

## Applying a table to values

What happens for every pose.

- *surface*: S_3 of a torus of quadrilaterals, 13 entries a row.
- *regular model*: a million points bound to a box by B-splines, 64 entries a row. A subdivided
  lattice has such rows between the planes of its base vertices.
- *irregular model*: the same points bound at level 3 to a cylinder around its irregular axis, 42
  entries a row. *In factors*: not multiplied out. A pose moves the vertices of level 3 that the points
  need, and these the points, by rows of 8 entries. The peers' time is that of the whole table.

Ours is [`osd::CompiledTable`](../osd/compiled_table.h): rows with the same columns lie together, with
one row in each lane of a register; rows that are outer products as their factors; weights that come
again once. Factors are applied by [`osd::CompiledChain`](../osd/compiled_chain.h). The peers are
OpenSubdiv's `Osd::CpuEvaluator`, which takes float only, and Eigen's row-major product. Bytes are those
of the compiled table over those of compressed sparse rows; the share of the triad is what the table and
the results take, over the bytes that a + s · b moves in the same time, with as many threads: {one:.1f} GB/s
with one, {two:.1f} with two. It is no share of the memory where a last cache holds the table; the triad's
arrays take 768 MB. Every 997th row is compared with plain sums. *Adjoint* is
[`osd::CompiledAdjoint`](../osd/compiled_adjoint.h), of factors `osd::CompiledAdjointChain`, from gradients by the rows to gradients by the columns,
beside what applying takes.

{apply}

## Moving some vertices

The *regular model* in single precision, where some of the 1,331 vertices of its lattice move: around one of
them (together), or all over the lattice (apart). [`osd::ChangeEvaluator`](../osd/change_evaluator.h)
evaluates the rows that depend on them, with the result of a whole evaluation, bit for bit. The ratio is that
of the time of a whole evaluation to its.

{change}

## Applying level by level

R_1, then R_2 and so on, to values that change, where no table of the whole way is wanted: ours by
[`osd::CompiledChain`](../osd/compiled_chain.h), theirs by `Far::PrimvarRefiner`, single precision, from
the levels of a torus of 1,600 quadrilaterals. Beside it S_n, compiled, which needs no values in between.

{in_turn}

## Refining topology

All levels, from the same torus, and from a box of 1,000 cells. Times are a child: a child *face* of a
surface comes with two edges and a vertex, a child *cell* of a lattice with three faces, three edges and a
vertex. The peer is `Far::TopologyRefiner`, which refines surfaces only; a lattice is set beside the
surface with the most like number of children.

{refine}

## Building tables

S_n, single precision, of the same two. The peer is `Far::StencilTableFactory`; rows of a lattice have up
to 64 entries where those of a surface have 13 or so, and are set beside so much of its time. Near the
boundary they have fewer, on the average of this box {row:.0f}, so entries are compared too.

{build}

## Binding

A million points in a box of 1,000 cells, by [`stencils::bindPoints`](../embed/local_binding.h) from the
base lattice, refinement included; double precision. The peer is VTK's `vtkProbeFilter` with its static
cell locator: it is given the 512,000 cells of level 3, and finds and interpolates, where ours also makes
the rows over the base vertices. *Finding them in its cells* is given the cells as VTK is. The rest pose
gives the points back to 1e-12.

{bind}

The limit ([docs/limits.md](limits.md)), which no peer has, is set beside levels: 200,000 points of a
surface, in the box and in the cylinder of the *irregular model*. How far a level is off, from the limit, is
the average of the points in a pose that moves vertices by a tenth of the lattice; the limit is asked for
with its usual tolerance, 1e-6.

{limit}

The memory that binding and applying one pose take, each in a process of its own: the bytes of D —
offsets, columns and weights — and the peak of the whole process.

{memory}

## How cost grows

Time by size, both axes logarithmic, with the fitted power of the size. The points are those of a surface
in a box.

![Time of binding and applying by size](figures/performance-growth.svg)

{growth}

## On a GPU

`scripts/cuda` measures it, on a machine that has one: against cuSPARSE's product, and against a thread a
row. No such machine was at hand yet, so there are no figures ([what to expect](gpu.md#what-is-tested-and-where)).
"""


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    best, context = read(sys.argv[2:])
    with open(sys.argv[1], "w", encoding="utf-8") as file:
        file.write(plots.figure(best))
    one, two = (best[f"triad/threads/{threads}"]["bytes_per_second"] / 1e9 for threads in (1, 2))
    head = ["peer", "peer's time", "our time", "ratio"]
    print(PAGE.format(
        intro=wrap(INTRO + absent(best)), one=one, two=two, cores=context["num_cpus"],
        mhz=context["mhz_per_cpu"], date=context["date"][:10],
        apply=table(["apply", *head, "share of the triad", "bytes"], apply_rows(best)),
        change=table(["move", "rows", "all rows", "these rows", "ratio"], change_rows(best)),
        in_turn=table(["apply in turn", *head], in_turn_rows(best)),
        refine=table(["refine", *head], refine_rows(best)),
        build=table(["build", *head], build_rows(best)),
        row=best["build/lattice/3/Espalier"]["entries"] / best["build/lattice/3/Espalier"]["items"],
        bind=table(["bind", *head], bind_rows(best)),
        limit=table(["limit", "peer", "off by", *head[1:]], limit_rows(best)),
        memory=table(["bind and apply", "D", "peak", "peak over D"], memory_rows(best)),
        growth=growth(best)), end="")


if __name__ == "__main__":
    main()
