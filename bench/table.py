# SPDX-License-Identifier: Apache-2.0
"""Writes docs/performance.md and its two figures from the results of espalier_bench.

    table.py PAGE.md GROWTH.svg RATIOS.svg RESULTS.json...
"""

import pathlib
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

BEHIND = """Espalier is not ahead everywhere. ITK computes a first pose in a box lattice in a third of the time
(see *Further peers*). The smallest lead over OpenSubdiv is in refining the topology of a surface: {refine_low:.1f} to
{refine_high:.1f} times as fast on one thread."""

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
        refine_low=min(refine), refine_high=max(refine))
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
        two are {exponents("bind by points")}. Two threads bind a million points {gain("bind by points"):.2f} times as fast as
        one.""",
        f"""**Applying, by number of points** (the same binding, compiled). The exponents are
        {exponents("apply by points")}. Two threads apply a pose to a million points
        {gain("apply by points"):.2f} times as fast as one.""",
        f"""**Binding, by level** (levels 1 to 6, 30,000 points in the cylinder of the *irregular model*). From
        the first level to the last the number of cells grows {levels_up:,.0f} times, and the time
        {level_cost:.1f} times. Only cells that hold points are refined, and the cells around them that the
        rules need. In regular cells, as in the other panels, nothing is refined, and the level does not matter.""",
        f"""**Binding, by number of base cells** (2³ to 100³ cells, 100,000 points at level 3). The number of
        cells grows {cells_up:,.0f} times, and the time {cell_cost:.1f} times.""")
    return "\n".join(wrap(item, "- ") for item in items)


INTRO = """This page shows how long Espalier takes and how much memory it needs, and compares it with other
libraries on the same work. `scripts/bench` measures the times and writes the page. Each time of Espalier is
measured in the same run and on the same data as the time of its peer, and the results are compared."""

# The page, with a name in braces for each part that is computed.
PAGE = pathlib.Path(__file__).with_name("performance.md.in").read_text(encoding="utf-8")


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
