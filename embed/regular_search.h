// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/embed/box_tree.h>
#include <espalier/embed/embedding.h>
#include <espalier/embed/point_descent.h>
#include <espalier/embed/tricubic_patch.h>

#include <algorithm>
#include <array>
#include <span>
#include <vector>

namespace espalier::embed {

/// The places of some points in regular cells of the base.
struct RegularPlaces {
    /// A place in patches[patch].
    struct Place {
        std::array<double, 3> uvw = {};
        Index patch = 0;
        Index length = 0;  ///< number of weights of the point; 0 if it has no place
    };
    std::vector<Place> places;           ///< one per point
    std::vector<TricubicPatch> patches;  ///< the patches of cells that contain a point
    double largestResidual = 0;          ///< see PlacedPoints::largestResidual()

    /// Returns how many points have a place.
    Offset count() const {
        return std::count_if(places.begin(), places.end(),
                             [](const Place& place) { return place.length > 0; });
    }

    /// Writes the row of a point that has a place: vertices of the base, ascending, and weights.
    void writeRow(Offset point, double spacing, Index* vertices, double* weights) const {
        const Place& place = places[point];
        const TricubicPatch& patch = patches[place.patch];
        patch.writeRow(patch.axisWeights(Eigen::Vector3d(place.uvw.data()), spacing), vertices,
                       weights);
    }
};

/// Finds points in the regular cells of the base of a lattice, in a level or in the limit, without
/// refining anything: there the map is a product of splines, and the row of a point follows from
/// its place. A point in several cells belongs to the cell of the lowest number.
///
/// Points in all other cells are left for another search. So are points in cells that are so
/// strongly bent that they might overlap themselves, where the other search decides which part
/// counts. Any number of threads may use one search at once.
/// \cite MacCracken & Joy 1996, section 2.2
class ESPALIER_API RegularSearch {
public:
    /// \param lattice in units (LengthUnit); must outlive this object
    /// \param descent of the same lattice
    /// \param spacing of the level: spacingOf(), or kLimitSpacing
    /// \cost O(base cells · log base cells)
    RegularSearch(const RestLattice& lattice, const PointDescent& descent, double spacing);

    const far::CellComplex& base() const { return lattice_.base.level(0).complex; }
    double spacing() const { return spacing_; }

    /// True if the base has no regular cell.
    bool isEmpty() const { return cells_.empty(); }

    /// \param points each near the one before
    /// \cost O(points · log base cells)
    RegularPlaces locate(std::span<const Point3> points) const;

private:
    RestLattice lattice_;
    double spacing_;
    double size_;               ///< the size of the lattice
    std::vector<Index> cells_;  ///< the regular ones, ascending
    BoxTree tree_;              ///< the tree of these cells
};

}  // namespace espalier::embed
