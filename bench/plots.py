# SPDX-License-Identifier: Apache-2.0
"""Plots the growth of costs: series of the growth/ benchmarks, their exponents, and an SVG figure."""

import math
from collections import namedtuple

Panel = namedtuple("Panel", "job title axis")

PANELS = (
    Panel("bind by points", "Binding, by points", "points"),
    Panel("apply by points", "Applying, by points", "points"),
    Panel("bind by level", "Binding, by level", "cells of the whole level"),
    Panel("bind by cells", "Binding, by base cells", "base cells"),
)
COLOURS = ("#1f5fa8", "#c4511a")
WIDTH, HEIGHT, MARGIN = 430, 300, 14
LEFT, RIGHT, TOP, BOTTOM = 62, 22, 46, 48  # margins of the plot in its panel


def series(best, job):
    """Returns the points (size, milliseconds) for each number of threads, ascending."""
    result = {}
    for name, run in best.items():
        kind, *rest = name.split("/")
        if kind == "growth" and rest[0] == job:
            threads = int(rest[2]) if len(rest) > 2 else 1
            result.setdefault(threads, []).append((run["size"], run["real_time"]))
    return {threads: sorted(points) for threads, points in sorted(result.items())}


def fit(points):
    """Fits time = a · size^b by least squares of the logarithms; returns (a, b)."""
    xs, ys = ([math.log(point[c]) for point in points] for c in (0, 1))
    x, y = sum(xs) / len(xs), sum(ys) / len(ys)
    b = sum((u - x) * (v - y) for u, v in zip(xs, ys)) / sum((u - x) ** 2 for u in xs)
    return math.exp(y - b * x), b


def number(value):
    for size, unit in ((1e9, " G"), (1e6, " M"), (1e3, " k")):
        if value >= size:
            return f"{value / size:g}{unit}"
    return f"{value:g}"


def duration(milliseconds):
    return f"{milliseconds / 1e3:g} s" if milliseconds >= 1e3 else f"{milliseconds:g} ms"


def decades(values):
    """Returns powers of ten that enclose positive values."""
    # A measured size may be slightly below the round number that was requested.
    low = math.floor(math.log10(min(values) * 1.001))
    high = math.ceil(math.log10(max(values) * 0.999))
    return [10.0 ** k for k in range(low, max(high, low + 1) + 1)]


def text(x, y, what, anchor="middle", size=12, colour="#333333", more=""):
    return (f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}" '
            f'fill="{colour}"{more}>{what}</text>')


def line(x1, y1, x2, y2, colour, width=1.0, more=""):
    return (f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{colour}" '
            f'stroke-width="{width}"{more}/>')


def draw(best, panel, left, top):
    """Draws one panel: grid, fitted lines, data points and legend."""
    lines = series(best, panel.job)
    sizes = decades([x for points in lines.values() for x, _ in points])
    fits = {threads: fit(points) for threads, points in lines.items()}
    times = decades([y for threads, points in lines.items() for x, measured in points
                     for y in (measured, fits[threads][0] * x ** fits[threads][1])])
    x0, x1 = left + LEFT, left + WIDTH - RIGHT
    y0, y1 = top + HEIGHT - BOTTOM, top + TOP

    def across(size):
        return x0 + (x1 - x0) * math.log(size / sizes[0]) / math.log(sizes[-1] / sizes[0])

    def up(time):
        return y0 + (y1 - y0) * math.log(time / times[0]) / math.log(times[-1] / times[0])

    exponents = ", ".join(f"{b:.2f}" for _, b in fits.values())
    yield text(left + WIDTH / 2, top + 24, f"{panel.title}: exponent {exponents}", size=14,
               colour="#111111", more=' font-weight="bold"')
    for size in sizes:
        yield line(across(size), y0, across(size), y1, "#dddddd")
        yield text(across(size), y0 + 17, number(size))
    for time in times:
        yield line(x0, up(time), x1, up(time), "#dddddd")
        yield text(x0 - 7, up(time) + 4, duration(time), anchor="end")
    yield text((x0 + x1) / 2, y0 + 36, panel.axis)
    for i, (threads, points) in enumerate(lines.items()):
        a, b = fits[threads]
        ends = points[0][0], points[-1][0]
        yield line(across(ends[0]), up(a * ends[0] ** b), across(ends[1]), up(a * ends[1] ** b),
                   COLOURS[i], 1.6, ' stroke-opacity="0.7"')
        for size, time in points:
            yield (f'<circle cx="{across(size):.1f}" cy="{up(time):.1f}" r="3.6" '
                   f'fill="{COLOURS[i]}"/>')
        if len(lines) > 1:
            y = y1 + 16 + 17 * i
            yield f'<circle cx="{x0 + 12:.1f}" cy="{y - 4:.1f}" r="3.6" fill="{COLOURS[i]}"/>'
            yield text(x0 + 22, y, f"{threads} thread{'s' if threads > 1 else ''}", anchor="start")


def figure(best):
    """Draws all panels, two in a row, on white, which is readable in dark mode too."""
    width, height = 2 * WIDTH + 2 * MARGIN, (len(PANELS) + 1) // 2 * HEIGHT + 2 * MARGIN
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
           f'width="{width}" height="{height}" font-family="Helvetica, Arial, sans-serif">',
           f'<rect width="{width}" height="{height}" rx="12" fill="#ffffff"/>']
    for i, panel in enumerate(PANELS):
        out += draw(best, panel, MARGIN + i % 2 * WIDTH, MARGIN + i // 2 * HEIGHT)
    return "\n".join(out + ["</svg>", ""])
