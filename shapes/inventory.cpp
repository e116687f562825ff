// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>
#include <espalier/shapes/extrude.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/transform.h>

#include <cmath>
#include <numbers>
#include <string>

#include "checks.h"

namespace espalier::shapes {
Lattice box(const BoxOptions& options) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        requireAtLeast("box", indexed("cells", axis), options.cells[axis], 1);
        requireInterval("box", indexed("min", axis), options.min[axis], indexed("max", axis),
                        options.max[axis]);
    }
    const auto& [cells, min, max] = options;
    requireCountable("box", {cells[0], cells[1], cells[2], 24});
    const Lattice base = gridMesh({{cells[0], cells[1]}, {min[0], min[1]}, {max[0], max[1]}});
    return sweep(base, stationsBetween({0, 0, min[2]}, {0, 0, max[2]}, cells[2]));
}

Lattice cylinder(const CylinderOptions& options) {
    requireAtLeast("cylinder", "sectors", options.sectors, 3);
    requireAtLeast("cylinder", "rings", options.pattern.rings, 1);
    requireAtLeast("cylinder", "layers", options.layers, 1);
    requirePositive("cylinder", "radius", options.radius);
    requireFinite("cylinder", "from", options.from);
    requireFinite("cylinder", "to", options.to);
    const Point3 axis = difference(options.to, options.from);
    if (!isFinite(axis))
        throw ArgumentError("cylinder", "to", textOf(options.to),
                            "a point at a finite distance from", {"from", ""});
    if (!(length(axis) > 0))
        throw ArgumentError("cylinder", "to", textOf(options.to), "a point other than",
                            {"from", ""});

    requireCountable("cylinder", {options.sectors, options.pattern.rings, options.layers, 6});
    const Lattice disk =
        diskMesh(regularPolygon(options.sectors, options.radius), {0, 0, 0}, options.pattern);
    const Affine turn = rotationBetween({0, 0, 1}, axis);
    std::vector<Affine> stations = stationsBetween(options.from, options.to, options.layers);
    for (Affine& station : stations) station = station * turn;
    return sweep(disk, stations);
}

Lattice torus(const TorusOptions& options) {
    requireAtLeast("torus", "segments", options.segments, 3);
    requireAtLeast("torus", "gridCells", options.gridCells, 1);
    requireAtLeast("torus", "sides", options.sides, 3);
    requireAtLeast("torus", "rings", options.pattern.rings, 1);
    requirePositive("torus", "majorRadius", options.majorRadius);
    requirePositive("torus", "minorRadius", options.minorRadius);
    const double radius = options.minorRadius;
    if (!(radius < options.majorRadius))
        throw ArgumentError("torus", "minorRadius", textOf(radius), "a number below",
                            {"majorRadius", textOf(options.majorRadius)});

    const bool isGrid = options.section == TorusSection::Grid;
    requireCountable("torus", {options.segments, isGrid ? options.gridCells : options.sides,
                               isGrid ? options.gridCells : options.pattern.rings, 6});
    const Lattice section =
        isGrid ? gridMesh(
                     {{options.gridCells, options.gridCells}, {-radius, -radius}, {radius, radius}})
               : diskMesh(regularPolygon(options.sides, radius), {0, 0, 0}, options.pattern);
    std::vector<Affine> stations;
    for (int segment = 0; segment < options.segments; ++segment) {
        const double angle = 2 * std::numbers::pi * segment / options.segments;
        const double cosine = std::cos(angle);
        const double sine = std::sin(angle);
        // The section's x is the z axis and its y points outwards, so its normal follows the ring.
        Affine station;
        station.linear = {{{0, cosine, -sine}, {0, sine, cosine}, {1, 0, 0}}};
        station.translation = {options.majorRadius * cosine, options.majorRadius * sine, 0};
        stations.push_back(station);
    }
    return sweep(section, stations, SweepEnds::Closed);
}

Lattice star(const StarOptions& options) {
    requireAtLeast("star", "points", options.points, 2);
    requireAtLeast("star", "rings", options.pattern.rings, 1);
    requireAtLeast("star", "layers", options.layers, 1);
    requirePositive("star", "innerRadius", options.innerRadius);
    requirePositive("star", "outerRadius", options.outerRadius);
    requirePositive("star", "height", options.height);
    requireCountable("star", {options.points, 2, options.pattern.rings, options.layers, 6});

    std::vector<Point3> outline = regularPolygon(2 * options.points, 1);
    for (std::size_t spoke = 0; spoke < outline.size(); ++spoke)
        outline[spoke] =
            scaled(outline[spoke], spoke % 2 == 0 ? options.outerRadius : options.innerRadius);
    const double half = options.height / 2;
    return sweep(diskMesh(outline, {0, 0, 0}, options.pattern),
                 stationsBetween({0, 0, -half}, {0, 0, half}, options.layers));
}

}  // namespace espalier::shapes
