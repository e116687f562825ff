#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws how many times as fast as OpenSubdiv Espalier is, from the tables of docs/performance.md.

    ratios.py PAGE.md FIGURE.svg

The page is the only source of the numbers, so that the figure agrees with it.
"""

import math
import re
import sys

from plots import COLOURS, line, text

WIDTH, MARGIN = 860, 18
AXIS_LEFT, AXIS_RIGHT = 292, 706  # the plot; labels are on its left, numbers on its right
NUMBERS = (766, 836)              # right ends of the columns of numbers, by threads
ROW, HEADING, TOP, BOTTOM = 21, 34, 98, 64
TICKS = (0.5, 1, 2, 5, 10, 20, 50, 100, 200)


def read(page):
    """Returns {heading: {label: {threads: ratio}}} for the rows that have OpenSubdiv's time."""
    sections, heading, head = {}, None, None
    for row in page.splitlines():
        if row.startswith("## "):
            heading = row[3:]
        if not row.startswith("|"):
            head = None
            continue
        cells = [cell.strip() for cell in row.strip("|").split("|")]
        if head is None:
            head = cells
        elif "OpenSubdiv" in head and not cells[0].startswith("---"):
            peer = head.index("OpenSubdiv")
            if cells[peer]:
                label = sections.setdefault(heading, {}).setdefault(cells[0], {})
                label[int(cells[head.index("threads")])] = float(cells[peer + 1])
    return sections


def subscripts(label):
    """Converts R_1 to R₁."""
    return re.sub(r"_(\d)", lambda match: chr(ord("₀") + int(match[1])), label)


def dot(x, y, colour):
    return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4.6" fill="{colour}"/>'


def figure(page):
    """Draws a row for each task, with a dot for one thread and a dot for two, on white."""
    sections = read(page)
    values = [ratio for tasks in sections.values() for threads in tasks.values()
              for ratio in threads.values()] or [1.0]
    low, high = min(1, *values) / 1.25, max(2, *values) * 1.15
    height = TOP + BOTTOM + sum(HEADING + ROW * len(tasks) for tasks in sections.values())
    bottom = height - BOTTOM

    def across(ratio):
        return AXIS_LEFT + (AXIS_RIGHT - AXIS_LEFT) * math.log(ratio / low) / math.log(high / low)

    bold = ' font-weight="bold"'
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" '
           f'width="{WIDTH}" height="{height}" font-family="Helvetica, Arial, sans-serif">',
           f'<rect width="{WIDTH}" height="{height}" rx="12" fill="#ffffff"/>',
           text(MARGIN, 34, "Speed of Espalier, OpenSubdiv = 1", "start", 17, "#111111", bold),
           text(MARGIN, 55, "Single precision. OpenSubdiv runs on one thread.", "start", 12.5,
                "#555555")]
    for tick in TICKS:
        if low <= tick <= high:
            x = across(tick)
            out += [line(x, TOP - 8, x, bottom, "#555555" if tick == 1 else "#e2e2e2",
                         1.4 if tick == 1 else 1.0),
                    text(x, bottom + 19, f"{tick:g} ×")]
    out += [text(across(1), TOP - 15, "as fast as OpenSubdiv", size=11.5, colour="#555555"),
            text((AXIS_LEFT + AXIS_RIGHT) / 2, bottom + 44,
                 "OpenSubdiv's time / Espalier's time (logarithmic; more is better)",
                 size=12.5)]
    for i, end in enumerate(NUMBERS):
        out += [dot(end - 14, TOP - 20, COLOURS[i]),
                text(end, TOP - 2, f"{i + 1} thread{'s' if i else ''}", "end", 12, COLOURS[i])]
    y = TOP
    for heading, tasks in sections.items():
        y += HEADING
        out.append(text(MARGIN, y - 12, heading, "start", 13, "#111111", bold))
        for label, threads in tasks.items():
            middle = y + ROW / 2 - 4
            out += [text(AXIS_LEFT - 14, middle + 4, subscripts(label), "end", 12.5),
                    line(across(1), middle, across(max(threads.values())), middle, "#c9c9c9", 2.2)]
            # Two threads first, so that the dot of one thread is visible where both are equal.
            for count, ratio in sorted(threads.items(), reverse=True):
                out += [dot(across(ratio), middle, COLOURS[count - 1]),
                        text(NUMBERS[count - 1], middle + 4, f"{ratio:.1f}", "end", 12.5,
                             COLOURS[count - 1])]
            y += ROW
    return "\n".join(out + ["</svg>", ""])


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1], encoding="utf-8") as file:
        drawn = figure(file.read())
    with open(sys.argv[2], "w", encoding="utf-8") as file:
        file.write(drawn)


if __name__ == "__main__":
    main()
