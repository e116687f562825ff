// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/parallel.h>
#include <espalier/base/vector3.h>
#include <espalier/solve/constraint_patches.h>
#include <espalier/solve/mesh_quality.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "mesh_centres.h"
#include "surface_pieces.h"

namespace espalier::solve {
namespace {

// OpenFOAM's constants for double precision.
constexpr double kVerySmall = 1e-300, kRootVerySmall = 1e-150, kSmall = 1e-15;

constexpr Offset kGrain = 4096;

/// A corner of a cell with the ends of its three edges, right-handed.
using Corner = std::array<std::size_t, 4>;

std::span<const Corner> cornersOf(far::StandardCell kind) {
    static constexpr Corner kTetrahedron[] = {
        {0, 1, 2, 3}, {1, 2, 0, 3}, {2, 0, 1, 3}, {3, 0, 2, 1}};
    static constexpr Corner kPyramid[] = {{0, 1, 3, 4}, {1, 2, 0, 4}, {2, 3, 1, 4}, {3, 0, 2, 4}};
    // VTK's first triangle is clockwise seen from the other one.
    static constexpr Corner kWedge[] = {{0, 2, 1, 3}, {2, 1, 0, 5}, {1, 0, 2, 4},
                                        {3, 4, 5, 0}, {4, 5, 3, 1}, {5, 3, 4, 2}};
    static constexpr Corner kHexahedron[] = {{0, 1, 3, 4}, {1, 2, 0, 5}, {2, 3, 1, 6},
                                             {3, 0, 2, 7}, {4, 7, 5, 0}, {5, 4, 6, 1},
                                             {6, 5, 7, 2}, {7, 6, 4, 3}};
    switch (kind) {
        case far::StandardCell::Tetrahedron:
            return kTetrahedron;
        case far::StandardCell::Pyramid:
            return kPyramid;
        case far::StandardCell::Wedge:
            return kWedge;
        case far::StandardCell::Hexahedron:
            break;
    }
    return kHexahedron;
}

/// The determinant of the unit vectors at a corner of the regular cell.
double regularDeterminant(far::StandardCell kind) {
    switch (kind) {
        case far::StandardCell::Tetrahedron:
        case far::StandardCell::Pyramid:
            return std::numbers::sqrt2 / 2;
        case far::StandardCell::Wedge:
            return std::numbers::sqrt3 / 2;
        case far::StandardCell::Hexahedron:
            break;
    }
    return 1;
}

double degrees(double cosine) {
    return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
}

/// The centres and areas of a mesh.
struct Centres {
    std::vector<Point3> ofFaces, areas, ofCells;
    std::vector<double> volumes;

    Centres(const far::VolumeMesh& mesh, std::span<const Point3> positions)
        : ofFaces(mesh.faceCount()),
          areas(mesh.faceCount()),
          ofCells(mesh.cellCount()),
          volumes(mesh.cellCount()) {
        parallelFor(mesh.faceCount(), kGrain, [&](Offset first, Offset last) {
            for (auto face = static_cast<Index>(first); face < last; ++face) {
                const FaceCentre centre = faceCentre(mesh.face(face), positions);
                ofFaces[face] = centre.centre;
                areas[face] = centre.area;
            }
        });
        parallelFor(mesh.cellCount(), kGrain, [&](Offset first, Offset last) {
            for (auto cell = static_cast<Index>(first); cell < last; ++cell) {
                const CellCentre centre = cellCentre(mesh, cell, ofFaces, areas);
                ofCells[cell] = centre.centre;
                volumes[cell] = centre.volume;
            }
        });
    }
};

/// Returns the cosine of the angle between the normal of a face and the line between the centres.
double orthogonality(const Point3& line, const Point3& area) {
    return dot(line, area) / (length(line) * length(area) + kRootVerySmall);
}

/// Returns the skewness of a face.
/// \param toCentre from the centre of the owner to the centre of the face
/// \param line from the centre of the owner to the centre of the neighbour, or along the normal to
///        the boundary
/// \param share fraction of the line below which the size of the face does not matter
double skewness(std::span<const Index> loop, std::span<const Point3> positions,
                const Point3& centre, const Point3& area, const Point3& toCentre,
                const Point3& line, double share) {
    const double along = dot(area, toCentre) / (dot(area, line) + kRootVerySmall);
    const Point3 offset = difference(toCentre, scaled(line, along));
    const double size = length(offset);
    const Point3 direction = scaled(offset, 1 / (size + kRootVerySmall));
    double extent = share * length(line) + kRootVerySmall;
    for (const Index point : loop)
        extent = std::max(extent, std::abs(dot(direction, difference(positions[point], centre))));
    return size / extent;
}

/// Replaces the value if the new one is larger, or if there is none.
template <class Value>
void keepLargest(std::optional<Value>& kept, const Value& value) {
    if (!kept || value.value > kept->value) kept = value;
}

template <class Value>
void keepSmallest(std::optional<Value>& kept, const Value& value) {
    if (!kept || value.value < kept->value) kept = value;
}

/// The measures of a range of faces.
struct FaceMeasures {
    std::optional<FaceValue> smallestCosine, largestSkewness;
    double sumOfCosines = 0;
    Index cosineCount = 0, severe = 0, beyondRightAngle = 0, negativePyramids = 0;
};

/// Returns for each face of the boundary its coupling; null if it has none.
std::vector<const CoupledFace*> couplingsOf(const far::VolumeMesh& mesh,
                                            std::span<const CoupledFace> coupled) {
    std::vector<const CoupledFace*> couplings(mesh.faceCount() - mesh.internalFaceCount());
    for (const CoupledFace& each : coupled) couplings[each.face - mesh.internalFaceCount()] = &each;
    return couplings;
}

FaceMeasures measureFaces(const far::VolumeMesh& mesh, std::span<const Point3> positions,
                          const Centres& centres, std::span<const CoupledFace* const> couplings,
                          Index first, Index last) {
    constexpr double kSevereAngle = 70;
    const double severe = std::cos(kSevereAngle / 180 * std::numbers::pi);
    FaceMeasures measures;
    for (Index face = first; face < last; ++face) {
        const Point3 &centre = centres.ofFaces[face], &area = centres.areas[face];
        const Point3& owner = centres.ofCells[mesh.owner(face)];
        const Point3 toCentre = difference(centre, owner);
        const auto countPyramid = [&](double volume) {
            measures.negativePyramids += volume < -kSmall ? 1 : 0;
        };
        countPyramid(dot(area, toCentre) / 3);
        // checkMesh counts large angles at both coupled faces, and has one of them in the mean.
        const auto countAngle = [&](const Point3& toNeighbour, bool isInMean) {
            const double cosine = orthogonality(toNeighbour, area);
            if (isInMean) {
                keepSmallest(measures.smallestCosine, {face, cosine});
                measures.sumOfCosines += cosine;
                ++measures.cosineCount;
            }
            measures.severe += cosine < severe ? 1 : 0;
            measures.beyondRightAngle += cosine > kSmall ? 0 : 1;
        };
        Point3 line;
        const bool isInternal = face < mesh.internalFaceCount();
        const CoupledFace* const coupling =
            isInternal ? nullptr : couplings[face - mesh.internalFaceCount()];
        if (isInternal) {
            const Point3& neighbour = centres.ofCells[mesh.neighbour(face)];
            countPyramid(dot(area, difference(neighbour, centre)) / 3);
            line = difference(neighbour, owner);
            countAngle(line, true);
        } else if (coupling) {
            const Point3 beyond = difference(centres.ofCells[mesh.owner(coupling->image)],
                                             centres.ofFaces[coupling->image]);
            const auto& [x, y, z] = coupling->rotation;
            line = sum(toCentre, {dot(x, beyond), dot(y, beyond), dot(z, beyond)});
            countAngle(line, face < coupling->image);
        } else {
            const Point3 normal = scaled(area, 1 / (length(area) + kRootVerySmall));
            line = scaled(normal, dot(normal, toCentre));
        }
        constexpr double kInternalShare = 0.2, kBoundaryShare = 0.4;
        keepLargest(measures.largestSkewness,
                    {face, skewness(mesh.face(face), positions, centre, area, toCentre, line,
                                    isInternal || coupling ? kInternalShare : kBoundaryShare)});
    }
    return measures;
}

}  // namespace

double scaledJacobian(far::StandardCell kind, std::span<const Index> corners,
                      std::span<const Point3> positions) {
    double smallest = std::numeric_limits<double>::infinity();
    for (const Corner& corner : cornersOf(kind)) {
        std::array<Point3, 3> edges;
        double product = 1;
        for (std::size_t i = 0; i < 3; ++i) {
            edges[i] = difference(positions[corners[corner[i + 1]]], positions[corners[corner[0]]]);
            const double size = length(edges[i]);
            product *= size;
            if (size > 0) edges[i] = scaled(edges[i], 1 / size);
        }
        smallest = std::min(smallest, product > 0 ? dot(edges[0], cross(edges[1], edges[2])) : 0.0);
    }
    return smallest / regularDeterminant(kind);
}

MeshQuality meshQuality(const far::VolumeMesh& mesh, std::span<const Point3> positions,
                        std::span<const CoupledFace> coupled) {
    if (std::ssize(positions) != mesh.pointCount())
        throw Error(concat("got ", positions.size(), " positions for a mesh of ", mesh.pointCount(),
                           " points"));
    for (const CoupledFace& each : coupled)
        for (const Index face : {each.face, each.image})
            if (face < mesh.internalFaceCount() || face >= mesh.faceCount())
                throw Error(concat("a coupled face is ", face, "; the faces of the boundary are ",
                                   mesh.internalFaceCount(), " to ", mesh.faceCount() - 1));
    const auto couplings = couplingsOf(mesh, coupled);
    Centres centres(mesh, positions);
    std::vector<double> jacobians(mesh.cellCount());
    parallelFor(mesh.cellCount(), kGrain, [&](Offset first, Offset last) {
        for (auto cell = static_cast<Index>(first); cell < last; ++cell)
            if (const auto kind = mesh.kind(cell))
                jacobians[cell] = scaledJacobian(*kind, mesh.corners(cell), positions);
    });
    // The formula has the volume between the corners; curved edges enclose another one.
    std::vector<double>& volumes = centres.volumes;
    parallelFor(mesh.cellCount(), kGrain, [&](Offset first, Offset last) {
        for (auto cell = static_cast<Index>(first); cell < last; ++cell)
            if (mesh.isSecondOrder(cell))
                volumes[cell] = secondOrderVolume(mesh.points(cell), positions);
    });
    std::vector<FaceMeasures> ofRanges((mesh.faceCount() + kGrain - 1) / kGrain);
    parallelFor(mesh.faceCount(), kGrain, [&](Offset first, Offset last) {
        ofRanges[first / kGrain] =
            measureFaces(mesh, positions, centres, couplings, static_cast<Index>(first),
                         static_cast<Index>(last));
    });

    MeshQuality quality;
    for (Index cell = 0; cell < mesh.cellCount(); ++cell) {
        keepSmallest(quality.smallestVolume, {cell, centres.volumes[cell]});
        if (centres.volumes[cell] < kVerySmall) quality.nonPositiveVolumes.push_back(cell);
        if (mesh.kind(cell)) keepSmallest(quality.smallestScaledJacobian, {cell, jacobians[cell]});
    }
    std::optional<FaceValue> smallestCosine;
    double sumOfCosines = 0;
    Index cosineCount = 0;
    for (const FaceMeasures& range : ofRanges) {
        if (range.smallestCosine) keepSmallest(smallestCosine, *range.smallestCosine);
        if (range.largestSkewness) keepLargest(quality.largestSkewness, *range.largestSkewness);
        sumOfCosines += range.sumOfCosines;
        cosineCount += range.cosineCount;
        quality.severelyNonOrthogonal += range.severe;
        quality.beyondRightAngle += range.beyondRightAngle;
        quality.negativePyramids += range.negativePyramids;
    }
    if (smallestCosine) {
        quality.largestNonOrthogonality = {smallestCosine->face, degrees(smallestCosine->value)};
        quality.meanNonOrthogonality = degrees(sumOfCosines / cosineCount);
    }
    return quality;
}

MeshQuality surfaceQuality(const far::SurfaceMesh& mesh, std::span<const Point3> rest,
                           std::span<const Point3> positions) {
    for (const auto& points : {rest, positions})
        if (std::ssize(points) != mesh.pointCount())
            throw Error(concat("got ", points.size(), " positions for a mesh of ",
                               mesh.pointCount(), " points"));
    const std::vector<Point3> withNormals = SurfacePieces(mesh, rest).withNormals(positions);
    const double regularTriangle = std::sqrt(0.75);
    MeshQuality quality;
    for (Index face = 0; face < mesh.faceCount(); ++face) {
        const auto corners = mesh.corners(face);
        const Point3& normal = withNormals[mesh.pointCount() + face];
        const double size = length(normal);
        const Point3 unit = size > 0 ? scaled(normal, 1 / size) : normal;
        const double regular = corners.size() == 3 ? regularTriangle : 1;
        double jacobian = std::numeric_limits<double>::infinity();
        std::vector<Point3> loop;
        for (const Index corner : corners) loop.push_back(positions[corner]);
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Point3 to = difference(loop[(i + 1) % loop.size()], loop[i]),
                         from = difference(loop[(i + loop.size() - 1) % loop.size()], loop[i]);
            const double product = length(to) * length(from);
            jacobian = std::min(jacobian,
                                product > 0 ? dot(cross(to, from), unit) / product / regular : 0.0);
        }
        const double area = mesh.isSecondOrder(face)
                                ? secondOrderArea(mesh.points(face), positions, unit)
                                : dot(areaVector(loop), unit);
        keepSmallest(quality.smallestScaledJacobian, {face, jacobian});
        keepSmallest(quality.smallestVolume, {face, area});
        if (!(area > 0)) quality.nonPositiveVolumes.push_back(face);
    }
    return quality;
}

MeshQuality meshQuality(const far::SimulationMesh& mesh, std::span<const Point3> rest,
                        std::span<const Point3> positions) {
    if (mesh.isSurface()) return surfaceQuality(mesh.surface, rest, positions);
    const ConstraintPatches constraints(mesh.patches, rest);
    return meshQuality(mesh.volume, positions, constraints.coupledFaces(mesh.patches));
}

}  // namespace espalier::solve
