# SPDX-License-Identifier: Apache-2.0
"""Writes docs/performance.md and its two figures from the results of espalier_bench.

    table.py PAGE.md GROWTH.svg RATIOS.svg RESULTS.json...
"""

import sys
import textwrap

import plots
import ratios
from results import read

THREADS = (("Espalier", "1"), ("Espalier 2 threads", "2"))
PEERS = ("OpenSubdiv", "Eigen")


def wrap(paragraph, mark=""):
    return textwrap.fill(" ".join(paragraph.split()), 104, initial_indent=mark,
                         subsequent_indent=" " * len(mark), break_on_hyphens=False)


def table(head, rows):
    rows = list(rows)
    if not rows:
        return "The peer was not installed."
    rows = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def ratio(theirs, ours):
    return f"{theirs / ours:.1f}"


def milliseconds(run):
    time = run["real_time"]
    return f"{time:.1f} ms" if time < 1000 else f"{time / 1000:.2f} s"


def nanoseconds(run, factor=1):
    """Returns the nanoseconds of one item, times `factor`."""
    return 1e6 * run["real_time"] / run["items"] * factor


def compared(run, peer):
    """Returns two columns: the peer's time, and the ratio."""
    return (milliseconds(peer), ratio(peer["real_time"], run["real_time"])) if peer else ("", "")


def our_applications(best):
    """Yields the runs of Espalier: (key of the case, components, who, label of the row, run)."""
    for name, run in best.items():
        kind, *case, who = name.split("/")
        if kind == "apply" and who.startswith("Espalier"):
            workload, real, components = case
            label = workload + (", in factors" if "factors" in who else "")
            threads = "2" if who.endswith("2 threads") else "1"
            yield "/".join([kind, workload, real]), int(components), who, (label, real, threads), run


def memory_columns(best, run, threads):
    """Returns two columns: the share of the memory bandwidth, and the size over compressed rows."""
    share = run["bytes_per_second"] / best[f"triad/threads/{threads}"]["bytes_per_second"]
    return f"{share:.2f}", f"{run['bytes of CSR']:.2f}"


def apply_rows(best):
    """Yields rows for one pose at a time, with the peers' times."""
    for key, components, who, label, run in our_applications(best):
        if components == 3 and "adjoint" not in who:
            columns = [compared(run, best.get(f"{key}/3/{peer}")) for peer in PEERS]
            yield (*label, milliseconds(run), *columns[0], *columns[1],
                   *memory_columns(best, run, label[2]))


def addend_rows(best):
    """Yields rows for points that an evaluation adds, compared with the evaluation alone."""
    for name, run in best.items():
        kind, *case, way = name.split("/")
        if kind == "addend" and way.endswith("addend"):
            workload, real, components = case
            form = way.split()[0]
            label = workload + (", in factors" if form == "factors" else "")
            without, by_pass = (best["/".join([kind, *case, f"{form} {other}"])]["real_time"]
                                for other in ("without", "pass"))
            yield (label, real, str(int(components) // 3), milliseconds({"real_time": without}),
                   f"{run['real_time'] / without:.2f}", f"{by_pass / without:.2f}")


def pose_rows(best):
    """Yields rows for several poses in one call, compared with one pose."""
    for key, components, who, label, run in our_applications(best):
        if components > 3:
            one, poses = best[f"{key}/3/{who}"], components // 3
            yield (label[0], milliseconds(one), f"{run['real_time'] / poses:.1f} ms",
                   f"{run['real_time'] / poses / one['real_time']:.2f}",
                   memory_columns(best, run, label[2])[0])


def adjoint_rows(best):
    for key, _, who, label, run in our_applications(best):
        if "adjoint" in who:
            forward = best[f"{key}/3/{who.replace(' adjoint', '')}"]
            yield (label[0], label[2], milliseconds(forward), milliseconds(run),
                   ratio(forward["real_time"], run["real_time"]),
                   *memory_columns(best, run, label[2]))


def compile_rows(best):
    """Yields rows for compiling a table, compared with copying it."""
    for name, run in best.items():
        kind, *case, who = name.split("/")
        if kind == "compile" and who != "copy":
            copy = best["/".join([kind, *case, "copy"])]
            yield (case[0] + (", transpose" if "adjoint" in who else ""),
                   "2" if who.endswith("2 threads") else "1", milliseconds(run), milliseconds(copy),
                   ratio(run["real_time"], copy["real_time"]))


def file_rows(best):
    """Yields rows for reading and writing a model, compared with cat."""
    copy = best["file/obj/copying"]
    for work in ("reading", "writing"):
        run = best[f"file/obj/{work}"]
        yield (work, milliseconds(run), f"{run['bytes_per_second'] / 1e6:.0f} MB/s", milliseconds(copy),
               ratio(run["real_time"], copy["real_time"]))


def levels(best, job, peer=None):
    """Yields our runs of a job on the surface and OpenSubdiv's runs of the same job, or of job `peer`:
    (level, threads, ours, theirs)."""
    for level in (3, 4, 5):
        theirs = best.get(f"{peer or job}/surface/{level}/OpenSubdiv")
        for who, threads in THREADS if theirs else ():
            yield level, threads, best[f"{job}/surface/{level}/{who}"], theirs


def lattices(best, job):
    """Yields our runs of a job on the lattice, and OpenSubdiv's run with the closest number of items."""
    peers = [(best[name], level) for level in (3, 4, 5)
             if (name := f"{job}/surface/{level}/OpenSubdiv") in best]
    for who, threads in THREADS if peers else ():
        ours = best[f"{job}/lattice/3/{who}"]
        theirs, level = min(peers, key=lambda peer: abs(peer[0]["items"] - ours["items"]))
        yield threads, ours, theirs, level


def refine_rows(best):
    for level, threads, ours, theirs in levels(best, "refine"):
        a, b = nanoseconds(theirs), nanoseconds(ours)
        yield f"levels 1 to {level}", threads, f"{b:.0f} ns", f"{a:.0f} ns", ratio(a, b)


def refine_lattice_rows(best):
    for threads, ours, theirs, level in lattices(best, "refine"):
        a, b = nanoseconds(theirs), nanoseconds(ours)
        yield ("a child", threads, f"{b:.0f} ns", f"{a:.0f} ns, levels 1 to {level}", ratio(a, b))


def build_rows(best):
    for level, threads, ours, theirs in levels(best, "build"):
        yield f"S_{level}", threads, milliseconds(ours), *compared(ours, theirs)


def build_lattice_rows(best):
    for threads, ours, theirs, level in lattices(best, "build"):
        a, b = nanoseconds(theirs, 64 / 13), nanoseconds(ours)
        yield ("a row", threads, f"{b:.0f} ns", f"{a:.0f} ns, a row of S_{level} × 64/13",
               ratio(a, b))
        # Both libraries make the same table, so it has as many entries.
        entries = best[f"build/surface/{level}/Espalier"]["entries"]
        a, b = 1e6 * theirs["real_time"] / entries, 1e6 * ours["real_time"] / ours["entries"]
        yield "an entry", threads, f"{b:.1f} ns", f"{a:.1f} ns, an entry of S_{level}", ratio(a, b)


def in_turn_rows(best):
    for job, what in (("in turn", "R_1 to R_{}, one after the other"), ("at once", "S_{} at once")):
        for level, threads, ours, theirs in levels(best, job, "in turn"):
            yield what.format(level), threads, milliseconds(ours), *compared(ours, theirs)


def bind_rows(best):
    theirs = best.get("bind/random/3/VTK")
    for job, points, work in (("bind/random/3", "random, level 3", "all of binding"),
                              ("embed/random/3", "random, level 3", "location only"),
                              ("bind/surface/5", "on a surface, level 5", "all of binding")):
        for who, threads in THREADS:
            ours = best[f"{job}/{who}"]
            yield (points, work, threads, milliseconds(ours),
                   *compared(ours, theirs if "random" in job else None))


def limit_rows(best):
    """Yields rows that compare the limit with levels, for binding and for applying."""
    for lattice in ("regular", "irregular"):
        def run(job, what, lattice=lattice):
            return best[f"limit/{job}/{lattice}/{what}"]
        for level in ("level 5", "level 6"):
            off = f"{run('bind', level)['distance from the limit']:.0e}"
            for who, threads in (("", "1"), (" 2 threads", "2")):
                theirs, ours = run("bind", level + who), run("bind", "limit" + who)
                yield (lattice, "binding", threads, f"{nanoseconds(ours) / 1000:.1f} µs", level, off,
                       f"{nanoseconds(theirs) / 1000:.1f} µs",
                       ratio(theirs["real_time"], ours["real_time"]))
            theirs, ours = run("apply", level), run("apply", "limit")
            yield (lattice, "applying", "1", f"{nanoseconds(ours):.1f} ns", level, off,
                   f"{nanoseconds(theirs):.1f} ns", ratio(theirs["real_time"], ours["real_time"]))


def memory_rows(best):
    for case, what in (("random/3", "random, level 3"), ("surface/5", "on a surface, level 5")):
        run = best[f"bindAndApply/{case}"]
        result, peak = run["result bytes"], run["peak bytes"]
        yield what, f"{result / 1e6:.0f} MB", f"{peak / 1e6:.0f} MB", ratio(peak, result)


def change_rows(best):
    for who, threads in THREADS:
        whole = best[f"change/all/{who}"]
        for moved in ("1 together", "10 together", "100 together", "10 apart", "100 apart"):
            ours = best[f"change/{moved}/{who}"]
            what = "1" if moved == "1 together" else moved.replace(" ", ", ")
            yield (what, threads, f"{ours['rows']:,.0f}", milliseconds(whole),
                   f"{ours['real_time']:.3f} ms", ratio(whole["real_time"], ours["real_time"]))


def absent(best):
    """Returns a sentence on the peers that were not installed."""
    there = {name.rsplit("/", 1)[1] for name in best}
    missing = [peer for peer in ("OpenSubdiv", "VTK") if peer not in there]
    if not missing:
        return ""
    return f" Not installed for this run, and so without figures: {' and '.join(missing)}."


FIGURES = (
    """**Deforming a regular model.** One pose of a million points takes {regular} on one thread.
    OpenSubdiv's evaluator takes {regular_osd:.0f} times as long with the same matrix, Eigen's product
    {regular_eigen:.0f} times.""",
    """**Deforming an irregular model.** One pose of a million points takes {irregular}, or {factors} if
    the matrix is left in its two factors. OpenSubdiv takes {irregular_osd:.0f} and {factors_osd:.0f} times as
    long.""",
    """**Memory.** The compiled matrix of the regular model takes {regular_bytes:.0f} % of the bytes of
    compressed sparse rows, the matrix of the irregular model {irregular_bytes:.0f} %, or {factors_bytes:.0f} % in
    factors.""",
    """**Dragging.** When one of 1,331 lattice vertices moves, the points that depend on it are evaluated in
    {drag:.3f} ms, {drag_ratio:.0f} times as fast as all points.""",
    """**Binding,** once for each model, takes {bind} for a million points in a lattice of 1,000 cells. VTK
    takes {vtk} for a part of this work.""")

BEHIND = """Espalier is not ahead everywhere. It refines the topology of a surface about as fast as OpenSubdiv
({refine_low:.1f} to {refine_high:.1f} times as fast on one thread). The product with the transpose can take
{adjoint:.1f} times as long as the product itself."""

SUMMARY = """## Five figures

{figures}

{behind}

![Speed relative to OpenSubdiv in {rows} tasks, on one thread and on two](figures/performance-ratios.svg)

*OpenSubdiv's time divided by Espalier's, for each task that both can do. Right of the line at 1, Espalier is
faster. OpenSubdiv always runs on one thread. The scale is logarithmic. The numbers are from the tables
below.*

"""


def summary(best, page):
    """Returns the first section, or nothing if a peer is missing. `page` is the page without it."""
    if absent(best):
        return ""

    def run(workload, who):
        return best[f"apply/{workload} model/float/3/{who}"]

    def over(workload, who, peer):
        return run(workload, peer)["real_time"] / run(workload, who)["real_time"]
    refine = [theirs["real_time"] / ours["real_time"]
              for _, threads, ours, theirs in levels(best, "refine") if threads == "1"]
    adjoint = [run["real_time"] / best[f"{key}/3/{who.replace(' adjoint', '')}"]["real_time"]
               for key, _, who, label, run in our_applications(best)
               if "adjoint" in who and label[2] == "1"]
    drag = best["change/1 together/Espalier"]["real_time"]
    values = dict(
        regular=milliseconds(run("regular", "Espalier")),
        regular_osd=over("regular", "Espalier", "OpenSubdiv"),
        regular_eigen=over("regular", "Espalier", "Eigen"),
        irregular=milliseconds(run("irregular", "Espalier")),
        irregular_osd=over("irregular", "Espalier", "OpenSubdiv"),
        factors=milliseconds(run("irregular", "Espalier factors")),
        factors_osd=over("irregular", "Espalier factors", "OpenSubdiv"),
        regular_bytes=100 * run("regular", "Espalier")["bytes of CSR"],
        irregular_bytes=100 * run("irregular", "Espalier")["bytes of CSR"],
        factors_bytes=100 * run("irregular", "Espalier factors")["bytes of CSR"],
        drag=drag, drag_ratio=best["change/all/Espalier"]["real_time"] / drag,
        bind=milliseconds(best["bind/random/3/Espalier"]),
        vtk=milliseconds(best["bind/random/3/VTK"]),
        refine_low=min(refine), refine_high=max(refine), adjoint=max(adjoint))
    figures = (wrap(figure.format(**values), f"{i}. ") for i, figure in enumerate(FIGURES, 1))
    return SUMMARY.format(figures="\n".join(figures), behind=wrap(BEHIND.format(**values)),
                          rows=sum(len(tasks) for tasks in ratios.read(page).values()))


def growth(best):
    """Returns sentences on each panel of the figure, with its numbers."""
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
        f"""**Binding, by number of points** (level 3 of 1,000 cells). The exponents on one thread and on
        two are {exponents("bind by points")}. They are below 1, because points share the cells that are
        refined for them. Two threads bind a million points {gain("bind by points"):.2f} times as fast as
        one.""",
        f"""**Applying, by number of points** (the same binding, compiled). The exponents are
        {exponents("apply by points")}. Two threads apply a pose to a million points
        {gain("apply by points"):.2f} times as fast as one.""",
        f"""**Binding, by level** (levels 1 to 6, 30,000 points in 1,000 cells). From the first level to the
        last the number of cells grows {levels_up:,.0f} times, and the time {level_cost:.1f} times.
        Only cells that hold points are refined, and the cells around them that the rules need.""",
        f"""**Binding, by number of base cells** (2³ to 100³ cells, 100,000 points at level 3). The number of
        cells grows {cells_up:,.0f} times, and the time {cell_cost:.1f} times.""")
    return "\n".join(wrap(item, "- ") for item in items)


INTRO = """This page shows how long Espalier takes and how much memory it needs, and compares it with other
libraries on the same work. `scripts/bench` measures the times and writes the page. Each time of Espalier is
measured in the same run and on the same data as the time of its peer, and the results are compared."""

PAGE = """# Performance

{intro}

Measured on {cores} cores of {mhz} MHz on {date}; built as `Release` (`-O3 -DNDEBUG`). The instruction set of
the kernels is chosen when the program runs. Each time is the quickest of several repetitions: five for
applying, three for the other tasks, two for the growth of cost, one for memory. The peers always run on one
thread. Compare times within a table only: the tables were measured one after the other, and the speed of a machine
changes.

{summary}## How to read the tables

- **ratio** is the peer's time divided by Espalier's. Above 1, Espalier is faster.
- **threads** is the number of threads of Espalier.
- **R_k** is the matrix of one refinement: vertices of level k from vertices of level k − 1.
- **S_n** = R_n … R_1 computes the vertices of level n from the base vertices.
- **D**, the deformation matrix, computes the points of a model from the base vertices of its lattice.

## Deforming: a matrix times values

This work is done for every pose. The matrices:

- *surface 0.4 M* and *surface 1.6 M*: S_3 of a torus of quadrilaterals, with 0.4 and 1.6 million rows of 13
  entries.
- *regular model*: D of a million points in a box lattice, by B-splines; 64 entries a row. Subdivided
  lattices have rows of this kind wherever they are regular.
- *irregular model*: D of the same points at level 3 of a cylinder, around its irregular axis; 42 entries a
  row.
- *in factors*: the same D, not multiplied out. The base vertices move those vertices of level 3 that the
  points need, and these vertices move the points, by rows of 8 entries. The peers apply the whole matrix.

Espalier applies them by [`osd::CompiledTable`](../osd/compiled_table.h), and factors by
[`osd::CompiledChain`](../osd/compiled_chain.h). A compiled table puts rows with the same columns side by side,
one row in each lane of a register; keeps rows that are outer products as their factors; and stores equal
weights once. The peers are OpenSubdiv's `Osd::CpuEvaluator`, which knows single precision only, and Eigen's
product of a row-major sparse matrix. Every 997th row of a result is compared with plain sums.

{apply}

Each row is one matrix and one pose (x, y and z of every point). Times and sizes: lower is better; ratios:
higher is better. *Bandwidth*: the bytes of the matrix and the result, divided by the bytes that the loop
a + s · b moves in the same time on as many threads ({one:.1f} GB/s on one, {two:.1f} GB/s on two, arrays of
768 MB). Near 1 the memory is the limit; a matrix that fits in the last cache can exceed it. *Size*: the bytes of
the compiled matrix divided by those of compressed sparse rows.

### Twelve poses in one call

{poses}

Each row is one matrix in single precision on one thread. *One pose* is the time of one pose by itself;
*a pose of 12* is a twelfth of the time of twelve poses in one call; *share* is the second divided by the first
(lower is better). *Bandwidth* as above.

Twelve poses can share only what one pose reads. One pose of an irregular matrix mostly waits for the matrix
from memory; twelve poses share this wait. A surface or a regular model is limited by arithmetic and by storing the
results: for each coordinate, 16 rows of a regular model need 64 + 16 + 4 multiplications by vectors of 16 numbers, and
these are as many for each pose of twelve. Evaluating four rows at once, so that they share the loads of the source, made
surfaces 7 % faster and factors 9 % slower (measured on 2026-11-25), and was not kept.

### Adding the points at rest

x + D · (p′ − p) is exact where nothing moves. [`osd::Addend`](../osd/evaluation.h) lets the kernels add x to each
result before they write it. The alternative is a pass over the results after the evaluation.

{addend}

Each row is one matrix on one thread. *Without* is the time of D · p′. *Addend* and *pass* are the times of the two ways to
add x, divided by *without* (lower is better).

### The transpose: from gradients at points to gradients at lattice vertices

{adjoint}

Each row is one matrix in single precision, by [`osd::CompiledAdjoint`](../osd/compiled_adjoint.h), and in
factors by `osd::CompiledAdjointChain`. *Forward* is the time of the product with the matrix, *transposed* the
time of the product with its transpose, and the ratio is the first divided by the second (higher is better).
*Bandwidth* and *size* as above.

The transpose needs as many multiplications (256 for 16 rows of a regular model, forward 252), and in addition it gathers the
coordinates of each row into lanes and adds the lanes at the end.

### Compiling

A table is compiled once, before its first pose.

{compiling}

Each row is one matrix in single precision. *Compiling* is the time of making an `osd::CompiledTable`, or an
`osd::CompiledAdjoint` for the transpose; *copying* is the time of copying the compressed sparse rows, on
one thread; the ratio is the first divided by the second (lower is better).

More than half of the time for the irregular model, and a fourth for the regular one, is fresh memory, which the system
must clear: with memory that the process had used before (by glibc's `GLIBC_TUNABLES`), they compile in 234 and 451 ms of
processor time, instead of 582 and 596 ms in the same run on a busy machine. The rest is comparing rows with each other to
find equal columns and equal weights: several passes over all entries, where copying makes one.

## Moving some vertices

[`osd::ChangeEvaluator`](../osd/change_evaluator.h) evaluates only the rows that depend on the vertices that
moved. Its results are those of a whole evaluation, bit for bit. The matrix is that of the *regular model* in
single precision; its lattice has 1,331 vertices.

{change}

Each row is a number of vertices that move: neighbours (*together*), or spread over the lattice (*apart*).
*Rows* is the number of points that depend on them, of a million. *All rows* is the time of a whole evaluation,
*these rows* that of the change, and the ratio is the first divided by the second (higher is better). If most
points depend on the moved vertices, a whole evaluation is faster.

## Applying level by level

Where values change at every level, each R_k is applied in turn, and no S_n is made. Espalier does this by
[`osd::CompiledChain`](../osd/compiled_chain.h), OpenSubdiv by `Far::PrimvarRefiner`. The surface is a torus
of 1,600 quadrilaterals; single precision. The last rows apply S_n, compiled, in place of the chain.

{in_turn}

Each row is the way from the base vertices to one level. Times: lower is better; ratio: higher is better.

A row of R_k has 6.25 entries on average, and each entry has its own column. So a row reads and writes some 50 bytes
(columns, number of the row, source, result), and loads 12.5 columns and source entries. For levels 1 to 5 the bytes alone
take 3.9 ms at the pace of the loop a + s · b (measured on 2026-11-25).

## Refining topology

All levels up to the given one, of the same torus, without positions. The peer is `Far::TopologyRefiner`.

{refine}

Each row is a number of levels. Times are for one child face, with the two edges and the vertex that come with
it: lower is better; ratio: higher is better.

OpenSubdiv refines no lattices. The next table compares a lattice of 1,000 cells, levels 1 to 3, with the
surface that has the nearest number of children. A child cell of a lattice brings three faces, three edges and a
vertex with it, so more work is done for each.

{refine_lattice}

Times are for one child cell of the lattice and one child face of the surface: lower is better.

## Building tables

S_n of the same torus, in single precision. The peer is `Far::StencilTableFactory`.

{build}

Each row is one level. Times: lower is better; ratio: higher is better.

The next table compares S_3 of a lattice of 1,000 cells with a surface of similar size. A row of a lattice has
up to 64 entries ({row:.0f} on average in this box, because rows near the boundary are shorter), a row of the
surface about 13. So times are given for a row, with OpenSubdiv's time multiplied by 64/13, and for an entry.

{build_lattice}

Times are for one row or one entry: lower is better; ratio: higher is better.

## Binding

A million points in a box of 1,000 cells, in double precision, by
[`embed::bindPoints`](../embed/local_binding.h). *All of binding* starts from the base lattice: it refines the
cells, locates the points, and makes D. The peer is VTK's `vtkProbeFilter` with its static cell locator. It
gets the 512,000 finished cells of level 3, locates the points, and interpolates, but makes no matrix.
*Location only* gets the same finished cells. At rest, D returns the points to within 1e-12.

{bind}

Each row is one way of placing the points. Times: lower is better; ratio: higher is better. VTK was not
measured for the points on a surface.

In a profile of the random points on one thread, the system takes a third of the processor time to clear fresh memory: the
matrix has 0.56 GB, and the peak is 1.3 GB. A fourth is the location, an eighth the product W · S_n.

### The limit, compared with levels

No peer binds to [the limit](limits.md), so levels 5 and 6 are the comparison: 200,000 points of a surface, in
the box (*regular*) and in the cylinder of the *irregular model* (*irregular*). The tolerance is the default,
1e-6.

{limit}

Each row is one task for the limit and for a level. *Error of the level* is the mean distance of the points from
the limit, in a pose that moves vertices by a tenth of the lattice. Times are for one point: lower is better.
The ratio is the level's time divided by the limit's: above 1 the limit is faster.

On 2026-11-25 binding to the limit became faster: a point takes 1.05 µs of processor time on one thread where it took 2.3 µs
(regular), and 4.5 µs where it took 10.1 µs (irregular): both programs in turn on a busy machine, the quickest of four runs.

An irregular point takes 58,000 instructions: 32 % multiply its row by the rows of S, 20 % refine cells and select the
points of each child, 14 % solve for the place, 10 % search the base cells. Even without the solve, which takes 3.5 steps,
a point would take 3.9 µs: a better first guess, or solving for several points at once, saves little.

A point on an irregular edge takes 24 ms of processor time: about thirty levels, each with hundreds of cells around the
point, are refined for this point alone.

### Memory

Binding a million points and applying one pose, each in a process of its own.

{memory}

Each row is one way of placing the points. *D* is the size of the matrix (offsets, columns and weights), *peak*
the largest memory of the process, and the last column the second divided by the first. Lower is better.

On fine levels points share no cells, and the levels of a group of points take far more memory than its rows of D. So
groups are smaller there. For 62,001 points of the surface, on two threads:

| level | D | peak | peak / D | peak with groups of 16,384 points (2,048 from level 7 on) |
| --- | --- | --- | --- | --- |
| 3 | 40 MB | 100 MB | 2.5 | 95 MB |
| 4 | 44 MB | 160 MB | 3.7 | 193 MB |
| 5 | 46 MB | 156 MB | 3.4 | 565 MB |
| 6 | 47 MB | 148 MB | 3.1 | 1,445 MB |
| 7 | 48 MB | 158 MB | 3.3 | 678 MB |
| 8 | 48 MB | 171 MB | 3.6 | 1,166 MB |

The processor time is the same within a tenth. Points that fill the volume share cells only on coarse levels: 62,194 random
points at level 5 take up to 700 MB, 18 times D, where they took 3,760 MB.

## Reading and writing

An OBJ of a million points and as many quadrilaterals, read by `io::readModel` and written with all coordinates
changed, on one thread. The comparison is `cat` of the same file into another one.

{files}

Each row is one task. Times: lower is better; speed: higher is better; the ratio is Espalier's time divided by that of `cat`
(lower is better).

## Further peers

Other libraries and a program that can do one of the tasks above, on the same data. `peer_bench` measures them and compares
their results with the results of Espalier:
`scripts/install-packages peers && scripts/build release peer_bench && build/release/bench/peer_bench`.

(Measured on 2026-11-25 on two shared cores of an AMD EPYC with AVX-512: processor time on one thread, the quickest of
nine runs that alternate, of ten for libxsmm.)

| task | Espalier | peer | time of the peer | ratio |
| --- | --- | --- | --- | --- |
| one pose, double | 10.2 ms | ITK 5.2 | 524 ms | 51.4 |
| binding, compiling and one pose, double | 2.59 s | ITK 5.2 | 524 ms | 0.2 |
| one pose, float | 6.2 ms | Blender 3.4, points only | 159 ms | 25.6 |
| one pose, float | 6.2 ms | Blender 3.4, a mesh | 248 ms | 40.0 |
| location | 648 ms | Embree 3.13 | 1.30 s | 2.0 |
| location | 648 ms | Embree 3.13, points along a curve | 630 ms | 1.0 |
| location | 648 ms | nanoflann 1.4 | 1.57 s | 2.4 |
| location | 648 ms | nanoflann 1.4, points along a curve | 568 ms | 0.9 |
| one pose, float | 6.3 ms | libxsmm 1.17 | 346 ms | 54.9 |
| 12 poses in one call, float | 72.1 ms | libxsmm 1.17 | 535 ms | 7.4 |
| 32 poses in one call, float | 190 ms | libxsmm 1.17 | 245 ms | 1.3 |

Each row is one task and one peer. Times: lower is better; ratio: the peer's time divided by Espalier's (higher is better).

- **Poses** are poses of the *regular model*. ITK's `BSplineTransform` makes no matrix: it computes the 64 weights of each
  point for every pose. So it is faster for a few poses, and Espalier takes less time in total from the sixth pose on. The
  results differ by at most 1e-14. Blender's time is the time of an update of the scene after a change of the lattice, with
  a lattice modifier on a million points without faces or with as many quadrilaterals. Blender makes no matrix either, and
  computes in single precision: the results differ by at most 1e-6.
- **Location** is the task *location only* of [Binding](#binding). Embree gets the boxes of the cells (a user geometry, which
  it builds with low quality, because that takes less time in total), and `rtcPointQuery` with radius 0 finds the
  candidates; building takes 0.17 s of its time. nanoflann finds the nearest centre of a cell, and more centres if the point
  is not in that cell; building takes 0.10 s. Newton's method of `embed::Trilinear` decides whether a candidate contains the
  point. All find the same cells. Espalier visits the points along a space-filling curve, so that consecutive points use the
  same memory; *points along a curve* means that the peer visits them in Espalier's order, and its time includes sorting.
  The peers get the corners of the cells in an array; Espalier reads them from the lattice. The nearest centre is a good guess
  because the cells of this box are nearly cubes: for thin cells nanoflann would have to try many.
- **libxsmm** has two products with a sparse matrix. Its generated kernels put each entry into the code: they are for small
  matrices and were not measured. `libxsmm_spmdm` makes sparse blocks from a dense matrix, and reserves 6 bytes for each
  entry of the dense matrix: 8 GB for the *regular model*, and more than 200 GB for *surface 1.6 M*. It works on blocks of
  96 columns, which is 32 poses: it computes 32 poses in less time than 12.

## How cost grows

Each panel shows time by size, for points on a surface in a box. Both axes are logarithmic. The slope of the
fitted line is the exponent: with exponent 1, twice the size takes twice the time.

![Time of binding and applying by size](figures/performance-growth.svg)

{growth}

## On a GPU

No GPU was available, so there are no figures yet. `scripts/cuda` measures the evaluator on a machine that has
one, against cuSPARSE's product and against a kernel with one thread for each row
([what to expect](gpu.md#what-to-expect)).
"""


def page(best, context):
    one, two = (best[f"triad/threads/{threads}"]["bytes_per_second"] / 1e9 for threads in (1, 2))
    head = ["threads", "Espalier", "OpenSubdiv", "ratio"]
    memory = ["bandwidth", "size"]
    lattice = best["build/lattice/3/Espalier"]
    text = PAGE.format(
        intro=wrap(INTRO + absent(best)), one=one, two=two, cores=context["num_cpus"],
        mhz=context["mhz_per_cpu"], date=context["date"][:10], summary="{summary}",
        apply=table(["matrix", "precision", *head, "Eigen", "ratio", *memory], apply_rows(best)),
        poses=table(["matrix", "one pose", "a pose of 12", "share", "bandwidth"], pose_rows(best)),
        addend=table(["matrix", "precision", "poses", "without", "addend", "pass"],
                     addend_rows(best)),
        adjoint=table(["matrix", "threads", "forward", "transposed", "ratio", *memory],
                      adjoint_rows(best)),
        compiling=table(["matrix", "threads", "compiling", "copying", "ratio"], compile_rows(best)),
        files=table(["task", "Espalier", "speed", "cat", "ratio"], file_rows(best)),
        change=table(["vertices moved", "threads", "rows", "all rows", "these rows", "ratio"],
                     change_rows(best)),
        in_turn=table(["applied", *head], in_turn_rows(best)),
        refine=table(["refined", *head], refine_rows(best)),
        refine_lattice=table(["time of", *head[:2], "OpenSubdiv, a surface", "ratio"],
                             refine_lattice_rows(best)),
        build=table(["table", *head], build_rows(best)), row=lattice["entries"] / lattice["items"],
        build_lattice=table(["time of", *head[:2], "OpenSubdiv, a surface", "ratio"],
                            build_lattice_rows(best)),
        bind=table(["points", "work", *head[:2], "VTK", "ratio"], bind_rows(best)),
        limit=table(["lattice", "work", "threads", "limit", "level", "error of the level",
                     "time of the level", "ratio"], limit_rows(best)),
        memory=table(["points", "D", "peak", "peak / D"], memory_rows(best)), growth=growth(best))
    return text.replace("{summary}", summary(best, text))


def main():
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    best, context = read(sys.argv[4:])
    text = page(best, context)
    for path, content in zip(sys.argv[1:4], (text, plots.figure(best), ratios.figure(text))):
        with open(path, "w", encoding="utf-8") as file:
            file.write(content)


if __name__ == "__main__":
    main()
