// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/embed/cell_place.h>
#include <espalier/far/topology_refiner.h>

#include <Eigen/Core>
#include <array>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

// The limit on layered edges, without refinement.
//
// An edge is layered if it is inside a lattice, and the cells around it continue beyond both of its
// ends: n hexahedra around each of three edges in a row. Its surroundings are four layers of
// vertices, the second and third of which contain the ends of the edge. Each layer has a vertex on
// the axis and a ring of 2n vertices. Refinement halves the edge. Both halves are layered, and the
// same weights give the layers of each half from the layers of the edge, on all levels. So every
// point of the limit on the edge follows from a product of these weights.
//
// The weights are the same in each of the n directions. So the points on the edge depend only on
// the averages of the n vertices of each kind. Likewise, the derivatives across the edge depend
// only on the first Fourier coefficients around the axis. Therefore the weights reduce to small
// matrices, one for the averages and one for the coefficients, with three numbers for each layer:
// for the axis, for the n vertices on edges of the axis vertex, and for the n vertices opposite to
// it in a face.
//
// The limit on the edge is no cubic B-spline under `siggraph96` and `cse96`, since their rule for a
// vertex is a tensor product only for n = 4.
namespace espalier::limit {

/// The weights of vertices in a point of the limit on a layered edge, and in three directions that
/// span the tangents of the limit there. The weights of the position sum to 1, the weights of a
/// direction to 0.
struct EdgeRows {
    std::vector<embed::VertexWeight> position;
    std::array<std::vector<embed::VertexWeight>, 3> directions;
};

/// Returns the four layers of vertices around an edge, from its first end to its second one;
/// nothing if the edge is not layered. A layer has the vertex on the axis, then the ring, which
/// starts with a vertex that an edge joins to the vertex on the axis. The order depends on the
/// order of the entities, not on their numbers.
/// \param level has all cells that contain an end of the edge
std::optional<std::vector<Index>> layersAround(const far::Level& level, Index edge);

/// The refinement of layered edges with a given number of cells around them, under given rules.
class EdgeRefinement {
public:
    /// Takes the weights from the level table of a lattice of three layers of hexahedra.
    /// \param cellCount 3 or more
    /// \return nothing if the weights do not have the properties that are described above
    static std::optional<EdgeRefinement> make(far::Rules rules, Index cellCount);

    /// Three numbers for each of the four layers.
    using Weights = Eigen::Matrix<double, 1, 12>;
    using ControlPoints = Eigen::Matrix<double, 12, 3>;

    /// Returns the averages that the limit on the edge depends on.
    /// \param layers of layersAround()
    ControlPoints controlPoints(std::span<const Index> layers,
                                std::span<const Point3> positions) const;

    /// Returns the place on the edge, 0 to 1, at which the limit is within a distance of a point.
    /// Nothing if there is none, or the edge is so strongly bent that the search misses it; the
    /// edges of further levels are bent less.
    std::optional<double> find(ControlPoints edge, const Eigen::Vector3d& point,
                               double distance) const;

    /// Returns the rows of the place `at` on the edge, 0 to 1. The directions are along the edge
    /// and two across it. They are the directions at the nearest dyadic place, at most 1e-14 away.
    EdgeRows rowsAt(std::span<const Index> layers, double at) const;

private:
    using Vertex = Eigen::Matrix<double, 1, 9>;        ///< weights of three layers
    using Refinement = Eigen::Matrix<double, 15, 12>;  ///< gives five layers, half as far apart

    explicit EdgeRefinement(Index cellCount);

    static std::optional<Vertex> leading(const Refinement& refinement, Vertex weights,
                                         double parity);

    Index cellCount_;
    std::vector<double> cosines_, sines_;  ///< the first waves around the axis, for a layer
    Refinement averages_;                  ///< refines the averages
    Refinement waves_;                     ///< refines the first Fourier coefficients
    Vertex limit_;   ///< weights of the averages in the limit of the vertex of the middle layer
    Vertex along_;   ///< and in its derivative along the edge
    Vertex across_;  ///< weights of the coefficients in its derivative across the edge
};

/// The refinements of layered edges under one set of rules, made on first use. Any number of
/// threads may use it at once.
class EdgeRefinements {
public:
    explicit EdgeRefinements(far::Rules rules) : rules_(rules) {}

    /// Returns the refinement of edges with a number of cells, or null if there is none.
    const EdgeRefinement* of(Index cellCount) const;

private:
    far::Rules rules_;
    mutable std::mutex mutex_;
    mutable std::map<Index, std::optional<EdgeRefinement>> known_;
};

}  // namespace espalier::limit
