# SPDX-License-Identifier: Apache-2.0
"""A small chart, drawn into an image."""

import numpy as np

from images import blank, disc, put_ink, put_text

#: What values fall by from a level to the next, in an approximation of second order.
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


def log_chart(levels, values, colour, x_name, y_name, size):
    """Values, one a level, on a logarithmic scale, and a line through the last of them that falls
    by FALL a level, as they must."""
    for before, after in zip(values, values[1:]):
        # A hundredth is less than half a pixel, where the charts have 70 a decade.
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
