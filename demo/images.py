# SPDX-License-Identifier: Apache-2.0
"""Images as arrays, height × width × 3, values 0 … 1: adding text, joining, writing PNG."""

import numpy as np
import vtk
from vtk.util import numpy_support

BACKGROUND = (1.0, 1.0, 1.0)
INK = (0.20, 0.21, 0.24)
SUPERSAMPLING = 2


def to_image(pixels):
    """A vtkImageData of rows × columns × components, the bottom row first."""
    image = vtk.vtkImageData()
    image.SetDimensions(pixels.shape[1], pixels.shape[0], 1)
    flat = np.ascontiguousarray(pixels).reshape(-1, pixels.shape[2])
    image.GetPointData().SetScalars(numpy_support.numpy_to_vtk(flat, deep=1))
    return image


def to_array(image):
    """A vtkImageData as height × width × components, the top row first."""
    width, height, _ = image.GetDimensions()
    values = numpy_support.vtk_to_numpy(image.GetPointData().GetScalars())
    return values.reshape(height, width, -1)[::-1]


def shrunk(pixels):
    """The mean of every square of SUPERSAMPLING pixels."""
    rows, columns = (n // SUPERSAMPLING for n in pixels.shape[:2])
    return pixels.reshape(rows, SUPERSAMPLING, columns, SUPERSAMPLING, -1).mean(axis=(1, 3))


def text_mask(text, size, bold=False):
    """Returns the coverage of a line of text, 0 … 1. The font has no Greek and no subscripts."""
    style = vtk.vtkTextProperty()
    style.SetFontFamilyToArial()
    style.SetFontSize(size * SUPERSAMPLING)
    style.SetBold(bold)
    style.SetColor(1, 1, 1)
    style.SetBackgroundOpacity(0)
    image, dimensions = vtk.vtkImageData(), [0, 0]
    vtk.vtkTextRenderer.GetInstance().RenderString(style, text, image, dimensions, 72)
    pixels = to_array(image)[-dimensions[1]:, :dimensions[0], 3:] / 255
    pixels = np.pad(pixels, [(0, -n % SUPERSAMPLING) for n in pixels.shape[:2]] + [(0, 0)])
    return shrunk(pixels)[..., 0]


def blank(width, height):
    return np.ones((height, width, 3)) * BACKGROUND


def put_ink(image, mask, left, top, colour):
    """Blends a colour into an image by a mask, which is cut off at the border."""
    low = np.maximum([top, left], 0)
    high = np.minimum([top + mask.shape[0], left + mask.shape[1]], image.shape[:2])
    if (low >= high).any():
        return
    area = image[low[0]:high[0], low[1]:high[1]]
    part = mask[low[0] - top:high[0] - top, low[1] - left:high[1] - left, None]
    area += part * (np.array(colour) - area)


def put_text(image, text, x, y, size, colour=INK, anchor=(0.5, 0.5), halo=False, bold=False):
    """Writes text into an image. `anchor` is the point of the text at (x, y): (0, 0) is its top left,
    (1, 1) its bottom right. A halo clears the background around the letters."""
    mask = text_mask(text, size, bold)
    left = round(x - anchor[0] * mask.shape[1])
    top = round(y - anchor[1] * mask.shape[0])
    if halo:
        put_ink(image, widened(mask, max(2, size // 8)), left - max(2, size // 8),
                top - max(2, size // 8), BACKGROUND)
    put_ink(image, mask, left, top, colour)


def widened(mask, radius):
    """Grows a mask by a radius on all sides."""
    padded = np.pad(mask, 2 * radius)
    grown = np.zeros(np.array(mask.shape) + 2 * radius)
    for dy in range(-radius, radius + 1):
        for dx in range(-radius, radius + 1):
            if dx * dx + dy * dy <= radius * radius + 1:
                grown = np.maximum(grown, padded[radius + dy:radius + dy + grown.shape[0],
                                                 radius + dx:radius + dx + grown.shape[1]])
    return grown


def disc(radius):
    """A mask of a filled circle with smooth rim."""
    reach = int(np.ceil(radius)) + 1
    y, x = np.mgrid[-reach:reach + 1, -reach:reach + 1]
    return np.clip(radius + 0.5 - np.hypot(x, y), 0, 1)


def bar(width, height):
    return np.ones((height, width))


def caption_strip(text, width, height, size, bold=False):
    """A line of text in the middle of an image."""
    strip, mask = blank(width, height), text_mask(text, size, bold)
    rows, columns = mask.shape
    if columns > width or rows > height:
        raise SystemExit(f"the caption '{text}' does not fit a panel {width} pixels wide")
    put_ink(strip, mask, (width - columns) // 2, (height - rows) // 2, INK)
    return strip


def legend(entries, width, size=18):
    """Returns an image with a row of marks and words in the middle. An entry is a colour, words, and
    the kind of mark: "line", "point" or "area"."""
    masks = [text_mask(words, size) for _, words, _ in entries]
    mark, near, far = round(1.5 * size), round(0.5 * size), round(1.7 * size)
    total = sum(mark + near + m.shape[1] for m in masks) + far * (len(masks) - 1)
    if total > width:
        raise SystemExit(f"the legend '{entries[0][1]} …' does not fit {width} pixels")
    strip = blank(width, round(2.2 * size))
    middle, x = strip.shape[0] // 2, (width - total) // 2
    for (colour, _, kind), mask in zip(entries, masks):
        if kind == "point":
            spot = disc(0.36 * size)
        else:
            spot = bar(mark, max(4, round(0.2 * size)) if kind == "line" else round(0.9 * size))
        put_ink(strip, spot, x + (mark - spot.shape[1]) // 2, middle - spot.shape[0] // 2, colour)
        put_ink(strip, mask, x + mark + near, middle - mask.shape[0] // 2, INK)
        x += mark + near + mask.shape[1] + far
    return strip


def captioned(image, caption, size):
    strip = caption_strip(caption, image.shape[1], round(2.4 * size), size)
    return np.concatenate([image, strip])


def row(images, gap=16):
    """Images of equal height from left to right."""
    return joined(images, gap, 1)


def column(images, gap=0):
    """Images from top to bottom, each in the middle of the widest."""
    width = max(image.shape[1] for image in images)
    sides = [(width - image.shape[1]) // 2 for image in images]
    return joined([row([blank(side, len(image)), image, blank(width - image.shape[1] - side, len(image))], 0)
                   for side, image in zip(sides, images)], gap, 0)


def joined(images, gap, axis):
    parts = []
    for image in images:
        between = (gap, image.shape[1]) if axis == 0 else (image.shape[0], gap)
        parts += [blank(between[1], between[0]), image]
    return np.concatenate(parts[1:], axis=axis)


def compose(images, captions, gap=16):
    """Panels of equal height in a row, a caption under each."""
    size = min(max(17, round(images[0].shape[0] / 22)), 24)
    return row([captioned(image, caption, size) for image, caption in zip(images, captions)], gap)


def write_png(path, image):
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(str(path))
    writer.SetCompressionLevel(9)
    writer.SetInputData(to_image((np.clip(image, 0, 1) * 255 + 0.5).astype(np.uint8)[::-1]))
    writer.Write()
    if writer.GetErrorCode():
        raise SystemExit(f"{path}: cannot be written")


def read_png(path):
    reader = vtk.vtkPNGReader()
    reader.SetFileName(str(path))
    reader.Update()
    return to_array(reader.GetOutput())[..., :3] / 255
