# SPDX-License-Identifier: Apache-2.0
"""A small chart, drawn into an image."""

import numpy as np

from images import blank, disc, put_ink, put_text

#: Factor between the values of consecutive levels in an approximation of second order.
FALL = 4
PALE, GUIDE = (0.88, 0.89, 0.91), (0.62, 0.64, 0.68)


def segment(shape, start, end, thickness):
    """A mask of a line between two pixels."""
    y, x = np.mgrid[:shape[0], :shape[1]]
    along = np.subtract(end, start)
    share = ((x - start[0]) * along[0] + (y - start[1]) * along[1]) / (along @ along)
    share = np.clip(share, 0, 1)
    distance = np.hypot(x - start[0] - share * along[0], y - start[1] - share * along[1])
    return np.clip((thickness + 1) / 2 - distance, 0, 1)


def polyline(shape, places, thickness):
    """A mask of a line through pixels."""
    mask = np.zeros(shape[:2])
    for start, end in zip(places, places[1:]):
        low = np.maximum(np.floor(np.minimum(start, end)) - thickness - 1, 0).astype(int)
        high = np.ceil(np.maximum(start, end)).astype(int) + thickness + 2
        part = mask[low[1]:high[1], low[0]:high[0]]
        np.maximum(part, segment(part.shape, start - low, end - low, thickness), out=part)
    return mask


def line_chart(curves, x_ticks, y_ticks, x_name, y_name, size):
    """Draws curves, each given as points (x, y), a colour and a thickness, later ones on top. Axes
    run from the first tick to the last; the y axis from bottom to top, even if ticks descend."""
    width, height = size
    image = blank(width, height)
    left, right, top, bottom = 62, width - 24, 40, height - 56

    def place(point):
        x = (point[0] - x_ticks[0]) / (x_ticks[-1] - x_ticks[0])
        y = (point[1] - y_ticks[0]) / (y_ticks[-1] - y_ticks[0])
        return np.array([left + (right - left) * x, bottom - (bottom - top) * y])

    for tick in y_ticks:
        ends = [place((x_ticks[0], tick)), place((x_ticks[-1], tick))]
        put_ink(image, polyline(image.shape, ends, 1), 0, 0, PALE if tick else GUIDE)
        put_text(image, f"{tick:g}".replace("-", "−"), left - 10, ends[0][1], 14, anchor=(1, 0.5))
    for tick in x_ticks:
        put_text(image, f"{tick:g}", place((tick, 0))[0], bottom + 18, 14)
    put_text(image, x_name, (left + right) / 2, bottom + 42, 15)
    put_text(image, y_name, 10, 14, 15, anchor=(0, 0.5))
    for points, colour, thickness in curves:
        places = [place(point) for point in points]
        put_ink(image, polyline(image.shape, places, thickness), 0, 0, colour)
    return image


def log_chart(levels, values, colour, x_name, y_name, size):
    """Draws the values of levels on a logarithmic scale, and a line through the last value that
    falls by FALL per level, as the values must."""
    for before, after in zip(values, values[1:]):
        # A hundredth is less than half a pixel, since the charts have 70 pixels per decade.
        if abs(before / after / FALL - 1) > 0.01:
            raise SystemExit(f"from {before:g} to {after:g}: a value does not fall by {FALL}")
    width, height = size
    image = blank(width, height)
    left, right, top, bottom = 96, width - 150, 34, height - 56
    decades = np.arange(np.floor(np.log10(min(values))), np.ceil(np.log10(max(values))) + 1)

    def place(level, value):
        x = left + (right - left) * (level - levels[0] + 0.35) / (levels[-1] - levels[0] + 0.7)
        y = bottom - (bottom - top) * (np.log10(value) - decades[0]) / np.ptp(decades)
        return x, y

    def draw_line(start, end, thickness, shade):
        put_ink(image, segment(image.shape, start, end, thickness), 0, 0, shade)

    for decade in decades:
        _, y = place(levels[0], 10.0**decade)
        draw_line((left, y), (right, y), 1, PALE)
        label = f"{10.0**decade:.{max(0, -int(decade))}f}"
        put_text(image, label, left - 10, y, 14, anchor=(1, 0.5))
    for level in levels:
        put_text(image, str(level), place(level, values[0])[0], bottom + 18, 14)
    put_text(image, x_name, (left + right) / 2, bottom + 42, 15)
    put_text(image, y_name, left - 10, 12, 15, anchor=(1, 0.5))
    fall = [values[-1] * float(FALL)**(levels[-1] - level) for level in levels]
    draw_line(place(levels[0], fall[0]), place(levels[-1], fall[-1]), 1.5, GUIDE)
    for level, value in zip(levels, values):
        spot = disc(5.5)
        x, y = place(level, value)
        put_ink(image, spot, round(x) - spot.shape[1] // 2, round(y) - spot.shape[0] // 2, colour)
    x, y = place(levels[-1], values[-1])
    put_text(image, f"falls by {FALL} a level", x + 14, y - 14, 14, anchor=(0, 0.5), halo=True)
    return image
