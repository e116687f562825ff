// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/far/simulation_mesh.h>
#include <espalier/far/standard_cells.h>
#include <espalier/solve/validity.h>

#include <array>
#include <optional>
#include <span>
#include <vector>

// Measures the quality of meshes; of volumes with the definitions of OpenFOAM's checkMesh.
namespace espalier::solve {

/// A face and its value.
struct FaceValue {
    Index face = 0;
    double value = 0;
    friend bool operator==(const FaceValue&, const FaceValue&) = default;
};

/// The quality of a volume mesh. Where several cells or faces have the same value, the first
/// counts.
///
/// All but the scaled Jacobian are, for straight cells, defined as in OpenFOAM 1912
/// (primitiveMeshTools), for the centres of faces and cells that OpenFOAM computes. A pair of
/// coupled faces (CoupledFace) counts as an internal face for angles and skewness; the other
/// coupled patches, as of processors or of OpenFOAM's `cyclicAMI`, count as boundaries.
struct MeshQuality {
    /// The smallest scaled Jacobian of the tetrahedra, pyramids, wedges and hexahedra
    /// (scaledJacobian()); empty if there are only polyhedra.
    std::optional<CellValue> smallestScaledJacobian;

    /// The smallest volume of a cell, of second order that of its quadratic map; empty if there are
    /// no cells. Negative for a cell that is
    /// inside out.
    std::optional<CellValue> smallestVolume;

    /// The cells whose volume is not positive, as checkMesh counts them (at most 1e-300),
    /// ascending.
    std::vector<Index> nonPositiveVolumes;

    /// Number of pyramids from the centre of a cell to one of its faces whose volume is negative
    /// (below −1e-15), as checkMesh counts them. A face between two cells has two pyramids.
    Index negativePyramids = 0;

    /// The largest angle between the normal of an internal face and the line that joins the centres
    /// of its two cells, in degrees, 0 to 180; empty if there are no internal faces.
    std::optional<FaceValue> largestNonOrthogonality;

    /// The angle whose cosine is the mean of the cosines of these angles, in degrees.
    double meanNonOrthogonality = 0;

    /// Number of internal faces whose angle is above 70 degrees: the faces that checkMesh calls
    /// severe, and those above 90 degrees, which it counts apart as errors. As for checkMesh, each
    /// of two coupled faces counts.
    Index severelyNonOrthogonal = 0;

    /// Number of internal faces whose angle is above 90 degrees, or exactly 90: checkMesh refuses
    /// these.
    Index beyondRightAngle = 0;

    /// The largest skewness of a face: the distance of its centre from the line between the centres
    /// of its cells, relative to the size of the face in this direction; on the boundary, from the
    /// normal through the centre of its cell. checkMesh warns above 4.
    std::optional<FaceValue> largestSkewness;
};

/// A face of a periodic patch, whose cell borders on the cell of another face. Each of the two
/// faces has such an entry.
struct CoupledFace {
    Index face = 0;
    Index image = 0;  ///< the face of the partner

    /// The rows of the rotation that turns the cell at the image to the side of the face.
    std::array<Point3, 3> rotation = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
};

/// Measures a mesh.
/// \param coupled the faces of periodic patches: faces of the boundary
/// \param mesh its cells are right-handed, that is their loops are anticlockwise seen from outside
/// \param positions one per point
/// \throws Error if `positions` does not fit
/// \cost O(points of faces), in parallel: 1 µs per hexahedron
ESPALIER_API MeshQuality meshQuality(const far::VolumeMesh& mesh, std::span<const Point3> positions,
                                     std::span<const CoupledFace> coupled = {});

/// Measures the faces of a surface, which are its cells: the smallest scaled Jacobian and the
/// smallest area along the normals of ValidityCheck, and the faces whose area is not positive. The
/// scaled Jacobian is the sine of the angle at a corner, relative to a regular triangle or a
/// square. Measures between cells are left empty.
///
/// \param mesh of faces of second order, the area is exact, and the scaled Jacobian measured at the
///        corners, with straight edges
/// \param rest, positions one per point
/// \throws Error if `rest` or `positions` does not fit
/// \cost O(points of faces)
ESPALIER_API MeshQuality surfaceQuality(const far::SurfaceMesh& mesh, std::span<const Point3> rest,
                                        std::span<const Point3> positions);

/// Measures the cells of a mesh: meshQuality() of its volume with its coupled faces
/// (ConstraintPatches::coupledFaces()), or surfaceQuality() of its surface.
/// \param rest, positions one per point
/// \throws Error if `rest` or `positions` does not fit
ESPALIER_API MeshQuality meshQuality(const far::SimulationMesh& mesh, std::span<const Point3> rest,
                                     std::span<const Point3> positions);

/// Returns the smallest determinant of three unit vectors along the edges at a corner of a cell,
/// relative to the determinant in the regular cell: 1 for a cube, a regular tetrahedron, a wedge of
/// squares over a regular triangle, or a pyramid of regular triangles over a square (whose apex
/// does not count); at most √2 otherwise, 0 for a flat corner, and negative for a folded one.
///
/// \param corners in VTK's order
/// \param positions of all points
ESPALIER_API double scaledJacobian(far::StandardCell kind, std::span<const Index> corners,
                                   std::span<const Point3> positions);

}  // namespace espalier::solve
