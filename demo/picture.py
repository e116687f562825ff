# SPDX-License-Identifier: Apache-2.0
"""Draws models and lattices off screen."""

from dataclasses import dataclass, field

import numpy as np
import vtk
from vtk.util import numpy_support

from geometry_files import points_of, surface, vtk_points, with_normals
from images import BACKGROUND, SUPERSAMPLING, shrunk, to_array, to_image

GHOST = (0.72, 0.74, 0.78)
LATTICE = (0.84, 0.37, 0.00)
#: Corner yellow, sharp red, boundary green, inside blue as in the paper's figure 5, in hues that
#: colour-blind readers can distinguish (Okabe and Ito).
STRATA = ((0.94, 0.78, 0.15), (0.80, 0.28, 0.05), (0.00, 0.62, 0.45), (0.00, 0.45, 0.70))


@dataclass
class View:
    """A parallel projection: the direction of the viewer, the up direction, and the visible window
    in the plane of the picture: left, bottom, right, top."""

    direction: tuple
    up: tuple
    window: tuple

    @staticmethod
    def axes(direction, up):
        """Right, up and towards the viewer, orthonormal."""
        back = np.asarray(direction, float) / np.linalg.norm(direction)
        right = np.cross(up, back)
        right /= np.linalg.norm(right)
        return np.array([right, np.cross(back, right), back])

    @classmethod
    def around(cls, point_sets, direction, up, crop=(0, 0, 1, 1), margin=0.04):
        """Returns the view that contains all points, or the part of it given by fractions."""
        right, above, _ = cls.axes(direction, up)
        flat = np.concatenate([np.stack([p @ right, p @ above], axis=1) for p in point_sets])
        low, high = flat.min(axis=0), flat.max(axis=0)
        size = high - low
        low, high = low + size * crop[:2], low + size * crop[2:]
        edge = margin * (high - low).max()
        return cls(direction, up, (*(low - edge), *(high + edge)))

    @property
    def extent(self):
        """The height of the window."""
        return self.window[3] - self.window[1]

    @property
    def aspect(self):
        left, bottom, right, top = self.window
        return (right - left) / (top - bottom)

    def apply(self, camera, points, widen):
        """Puts a camera just before the foremost point: far enough to see all points, and near
        enough for precise depths. The window is widened by a factor."""
        left, bottom, right, top = self.window
        axes = self.axes(self.direction, self.up)
        focus = axes.T @ [(left + right) / 2, (bottom + top) / 2, 0]
        camera.ParallelProjectionOn()
        camera.SetFocalPoint(*focus)
        depth = points @ axes[2]
        away = depth.max() + 0.1 * (np.ptp(depth) + top - bottom)
        camera.SetPosition(*(focus + axes[2] * away))
        camera.SetViewUp(*axes[1])
        camera.SetParallelScale((top - bottom) / 2 * widen)


@dataclass
class LatticeStyle:
    tube: float  # radius
    ball: float = 0.0  # radius of balls at points; none if 0
    only_corners: bool = False  # draws balls at corners only
    colours: tuple = (LATTICE,) * 4  # one for each stratum
    inside: bool = True  # draws edges inside the lattice
    hull: float = 0.0  # opacity of the boundary faces; not drawn if 0
    hull_colour: tuple = (0.96, 0.94, 0.90)


@dataclass
class Drawing:
    """Actors, to be rendered together."""

    actors: list = field(default_factory=list)
    points: list = field(default_factory=list)

    def add_model(self, model):
        actor = self._add(model)
        actor.GetProperty().SetSpecular(0.12)
        actor.GetProperty().SetSpecularPower(18)
        self.points.append(points_of(model))
        return self

    def add_ghost(self, model):
        """A model in the background: pale, and translucent."""
        self._add(model, GHOST, 0.22)
        self.points.append(points_of(model))
        return self

    def add_lattice(self, lattice, style):
        for stratum in range(4):
            edges = lattice.edges[lattice.edge_strata == stratum]
            if len(edges) and (style.inside or stratum < 3):
                thick = 1.35 if stratum <= 1 else 0.75 if stratum == 3 else 1.0
                self._add(tubes(lattice.points, edges, style.tube * thick), style.colours[stratum])
            points = lattice.points[lattice.point_strata == stratum]
            drawn = stratum == 0 if style.only_corners else style.inside or stratum < 3
            if len(points) and style.ball > 0 and drawn:
                self._add(balls(points, style.ball * (1.3 if stratum == 0 else 1)),
                          style.colours[stratum])
        if style.hull > 0:
            actor = self._add(surface(lattice.points, lattice.boundary), style.hull_colour,
                              style.hull)
            actor.GetProperty().SetInterpolationToFlat()
        self.points.append(lattice.points)
        return self

    def add_faces(self, points, loops, colour, opacity=1.0, smooth=False):
        """Adds polygons; with `smooth`, shaded as the surface that they approximate."""
        data = surface(points, loops)
        if smooth:
            data = with_normals(data)
        look = self._add(data, colour, opacity).GetProperty()
        if smooth:
            look.SetInterpolationToPhong()
        else:
            look.SetInterpolationToFlat()
        self.points.append(points)
        return self

    def add_edges(self, points, edges, colour, radius):
        if len(edges):
            self._add(tubes(points, np.asarray(edges), radius), colour)
        self.points.append(points)
        return self

    def add_points(self, points, colour, radius):
        if len(points):
            self._add(balls(np.asarray(points), radius), colour)
            self.points.append(np.asarray(points))
        return self

    def add_ground_shadow(self, model, up):
        """A soft shadow on the plane below the model."""
        self.actors.append(ground_shadow(model, np.asarray(up, float)))
        return self

    def _add(self, data, colour=None, opacity=1.0):
        mapper = vtk.vtkPolyDataMapper()
        mapper.SetInputData(data)
        mapper.SetScalarVisibility(colour is None)
        actor = vtk.vtkActor()
        actor.SetMapper(mapper)
        look = actor.GetProperty()
        if colour is not None:
            look.SetColor(*colour)
        look.SetOpacity(opacity)
        look.SetAmbient(0.27)
        look.SetDiffuse(0.82)
        self.actors.append(actor)
        return actor


class Studio:
    """Renders drawings, all from one view.

    Occlusion makes corners and gaps darker; drawings of lines only are cleaner without.

    All drawings use one window. Separate windows would close the connection to the display in
    between, and a virtual display restarts when its last client leaves.
    """

    #: Margin that is cut off, in pixels: ambient occlusion is wrong along the borders.
    FRAME = 12

    def __init__(self, view, height, occlusion=True):
        self.view, self.height, self.width = view, height, round(height * view.aspect)
        self.occlusion = occlusion
        self.window = vtk.vtkRenderWindow()
        self.window.SetOffScreenRendering(1)
        self.window.SetMultiSamples(0)
        self.window.SetSize((self.width + 2 * self.FRAME) * SUPERSAMPLING,
                            (self.height + 2 * self.FRAME) * SUPERSAMPLING)

    def render(self, drawing):
        """An image, height × width × 3, values 0 … 1."""
        renderer = self._lit_renderer()
        for actor in drawing.actors:
            renderer.AddActor(actor)
        self.view.apply(renderer.GetActiveCamera(), np.concatenate(drawing.points),
                        1 + 2 * self.FRAME / self.height)
        renderer.ResetCameraClippingRange()
        self.window.AddRenderer(renderer)
        self.window.Render()
        grab = vtk.vtkWindowToImageFilter()
        grab.SetInput(self.window)
        grab.ReadFrontBufferOff()
        grab.Update()
        self.window.RemoveRenderer(renderer)
        image = to_array(grab.GetOutput())[..., :3] / 255
        edge = self.FRAME * SUPERSAMPLING
        return shrunk(image[edge:-edge, edge:-edge])

    def pixels_of(self, points):
        """Returns the positions of points in the images, n × 2: from the left and from the top."""
        left, _, right, top = self.view.window
        axes = self.view.axes(self.view.direction, self.view.up)
        flat = np.asarray(points, float) @ axes[:2].T
        return (flat * [1, -1] + [-left, top]) * (self.width / (right - left))

    def _lit_renderer(self):
        renderer = vtk.vtkRenderer()
        renderer.SetBackground(*BACKGROUND)
        for position, intensity in (((-0.5, 0.7, 1.0), 0.72), ((0.9, -0.1, 0.8), 0.34),
                                    ((0.0, -0.3, 1.0), 0.22), ((0.2, 0.9, -0.9), 0.25)):
            light = vtk.vtkLight()
            light.SetLightTypeToCameraLight()
            light.SetPosition(*position)
            light.SetIntensity(intensity)
            renderer.AddLight(light)
        extent = self.view.extent
        renderer.SetUseSSAO(self.occlusion)
        renderer.SetSSAORadius(0.06 * extent)
        renderer.SetSSAOBias(0.006 * extent)
        renderer.SetSSAOKernelSize(128)
        renderer.SSAOBlurOn()
        renderer.UseFXAAOn()
        return renderer


def tubes(points, edges, radius):
    lines = vtk.vtkPolyData()
    lines.SetPoints(vtk_points(points))
    stream = np.column_stack([np.full(len(edges), 2), edges]).astype(np.int64)
    cells = vtk.vtkCellArray()
    cells.ImportLegacyFormat(numpy_support.numpy_to_vtkIdTypeArray(stream.ravel(), deep=1))
    lines.SetLines(cells)
    tube = vtk.vtkTubeFilter()
    tube.SetInputData(lines)
    tube.SetRadius(radius)
    tube.SetNumberOfSides(10)
    tube.CappingOn()
    tube.Update()
    return tube.GetOutput()


def balls(points, radius):
    centres = vtk.vtkPolyData()
    centres.SetPoints(vtk_points(points))
    sphere = vtk.vtkSphereSource()
    sphere.SetRadius(radius)
    sphere.SetThetaResolution(20)
    sphere.SetPhiResolution(14)
    glyph = vtk.vtkGlyph3D()
    glyph.SetInputData(centres)
    glyph.SetSourceConnection(sphere.GetOutputPort())
    glyph.ScalingOff()
    glyph.Update()
    return glyph.GetOutput()


def ground_shadow(model, up, cells=256, darkness=0.42):
    """Returns a square under the model, darker where more of the model is above, and nearer."""
    points = points_of(model)
    axis = int(np.abs(up).argmax())
    a, b = (axis + 1) % 3, (axis + 2) % 3
    height = points[:, axis] * np.sign(up[axis])
    floor, tall = height.min(), np.ptp(height)
    centre = np.array([(points[:, i].min() + points[:, i].max()) / 2 for i in (a, b)])
    half = 0.75 * max(np.ptp(points[:, a]), np.ptp(points[:, b]))
    edges = np.linspace(-half, half, cells + 1)
    density = np.zeros((cells, cells))
    # Parts near the ground cast a darker and sharper shadow than the rest.
    for low, high, blur, share in ((0.0, 0.08, 4, 0.65), (0.0, 0.35, 12, 0.45)):
        chosen = (height >= floor + low * tall) & (height <= floor + high * tall)
        count, _, _ = np.histogram2d(points[chosen, a] - centre[0], points[chosen, b] - centre[1],
                                     [edges, edges])
        density += share * blurred(np.minimum(blurred(count, 2) * 4, 1), blur)
    plane = vtk.vtkPlaneSource()
    corner = np.zeros(3)
    corner[axis] = floor * np.sign(up[axis])
    for setter, u, v in ((plane.SetOrigin, -half, -half), (plane.SetPoint1, half, -half),
                         (plane.SetPoint2, -half, half)):
        corner[a], corner[b] = centre[0] + u, centre[1] + v
        setter(*corner)
    return black_film(plane, np.clip(density, 0, 1).T * darkness)


def black_film(plane, opacity):
    """Returns a plane that darkens the background, with one opacity per pixel (rows × columns)."""
    pixels = np.zeros((*opacity.shape, 4), np.uint8)
    pixels[..., 3] = opacity * 255
    texture = vtk.vtkTexture()
    texture.SetInputData(to_image(pixels))
    texture.InterpolateOn()
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(plane.GetOutputPort())
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.SetTexture(texture)
    actor.GetProperty().LightingOff()
    actor.ForceTranslucentOn()
    return actor


def blurred(grid, radius):
    """Three box filters: nearly a Gaussian."""
    kernel = np.ones(2 * radius + 1) / (2 * radius + 1)
    for _ in range(3):
        for axis in (0, 1):
            grid = np.apply_along_axis(np.convolve, axis, grid, kernel, "same")
    return grid
