// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "point_groups.h"

namespace espalier::cages {

/// The boundary of a lattice as a mesh. The boundary of every level of the lattice, and of its
/// limit volume, is the same level, and the limit, of this mesh.
class CageSurface {
public:
    static constexpr int kLevel = 3;

    /// \param lattice level 0 of a lattice
    /// \throws Error for semi-sharp marks; if a smooth vertex of the boundary has fewer than three
    ///         edges there, because weights would be negative
    explicit CageSurface(const far::TopologyRefiner& lattice);

    /// Centres of the faces of level 3 over the vertices of the lattice.
    const stencils::StencilTable<double>& fineCentres() const { return fineCentres_; }
    /// Centres of the faces of level 2.
    const stencils::StencilTable<double>& coarseCentres() const { return coarseCentres_; }
    /// Returns the face of level 2 that contains a face of level 3.
    Index coarseFaceOf(Index fineFace) const { return coarseOfFine_[fineFace]; }
    /// Returns the cell of the lattice that a face of level 2 bounds.
    Index cellOfCoarse(Index coarseFace) const { return cellOfCoarse_[coarseFace]; }

    /// The faces of a level, as loops of vertices, and the vertices whose convex hull contains the
    /// limit of a face, and all further levels of the face.
    struct Faces {
        std::vector<std::array<Index, 4>> loops;
        std::vector<Offset> hullOffsets = {0};
        std::vector<Index> hulls = {};
        std::vector<Index> cells = {};  ///< the cell of the lattice that each face bounds

        /// True: the limit of the face is a bicubic patch. hull() then has the 4 × 4 control points
        /// of the patch, one row after the other. The four in the middle are the corners of the
        /// face.
        std::vector<char> isPatch = {};

        Faces(const far::Level& level, std::vector<Index> cells);
        std::span<const Index> hull(Index face) const;

        /// Gets points whose convex hull contains the corners and the limit of a face, but not
        /// further levels. The hull of the Bézier points of a patch is four times thinner than the
        /// hull of its control points.
        void limitHull(Index face, std::span<const Point3> vertices,
                       std::vector<Point3>& hull) const;

        /// Returns the least dot product of a direction with the points of limitHull() of a face
        /// whose limit is one patch.
        double lowestOfPatch(Index face, std::span<const Point3> vertices,
                             const Point3& direction) const;
    };
    const Faces& fineFaces() const { return *fineFaces_; }
    std::vector<Point3> fineVertices(std::span<const Point3> positions) const;

    /// The faces of level 4.
    const Faces& finestFaces() const { return *finestFaces_; }
    std::vector<Point3> finestVertices(std::span<const Point3> fineVertices) const;

    /// Returns the vertices of level 4 around the faces of level 3 that are no patches.
    std::vector<Point3> irregularVertices(std::span<const Point3> fineVertices) const;
    /// Returns numbers of irregularVertices(), whose convex hull contains the limit of a face of
    /// level 3; none if the face is a patch.
    std::span<const Index> irregularHull(Index fineFace) const {
        const auto begin = irregularHulls_.offsets[fineFace],
                   end = irregularHulls_.offsets[fineFace + 1];
        return std::span(irregularHulls_.values).subspan(begin, end - begin);
    }

private:
    stencils::StencilTable<double> fineTable_, fineCentres_, coarseCentres_;
    stencils::StencilTable<double> finestTable_;     ///< level 4 over level 3
    stencils::StencilTable<double> irregularTable_;  ///< some rows of finestTable_
    std::optional<Faces> fineFaces_, finestFaces_;
    far::Rows<Index> irregularHulls_;  ///< rows of irregularTable_ for each face of level 3
    std::vector<Index> coarseOfFine_, cellOfCoarse_;
};

/// A group of points that is not proved to be inside.
struct Uncovered {
    Index group = 0;
    Index point = 0;                 ///< the worst point
    double depth = 0;                ///< how much further inside the point must be, about
    std::optional<Index> cell = {};  ///< the cell of a face whose box holds the point
    int winding = 1;  ///< how often the surface winds around the point, if no box contains it
};

/// Proves that points are inside a surface.
///
/// A point is covered if it is outside a box around the hull of every face of level 3, and the
/// triangles of level 3 wind once around it. While a surface changes continuously from the
/// triangles to the quadrilaterals of level 3 or to the limit, each face stays in its hull. So all
/// of them wind once around the point. A lattice fills what its boundary winds around, because its
/// map is continuous. If the Jacobian of the map is positive, exactly one place in the lattice maps
/// to the point.
///
/// Points that are in a box are tried again: with boxes around the four corners of each face for
/// level 3; for the limit, with level 4 and boxes around the corners and the limit of each face.
///
/// \param positions of the vertices of the lattice
/// \param margin least distance of the points from the hulls
/// \return groups with an uncovered point, ascending
std::vector<Uncovered> findUncovered(const CageSurface& surface, std::span<const Point3> positions,
                                     const PointGroups& points, double margin);

/// Returns the steps of findUncovered(), as Work counts them.
double workOfCoverage(const CageSurface& surface, const PointGroups& points);

}  // namespace espalier::cages
