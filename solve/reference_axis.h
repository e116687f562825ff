// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/base/word.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <span>
#include <vector>

namespace espalier::solve {

/// The order in which a section turns about the coordinate axes: Zxy is about z first, then x, y.
enum class TurnOrder { Xyz, Xzy, Yzx, Yxz, Zxy, Zyx };
inline constexpr Word<TurnOrder> kTurnOrderWords[] = {
    {"xyz", TurnOrder::Xyz}, {"xzy", TurnOrder::Xzy}, {"yzx", TurnOrder::Yzx},
    {"yxz", TurnOrder::Yxz}, {"zxy", TurnOrder::Zxy}, {"zyx", TurnOrder::Zyx}};

/// The point of the axis that a vertex is linked to. Of several such points, it is the one that is
/// nearest to the vertex.
enum class AxisLink {
    Nearest,  ///< the point nearest to the vertex
    Along,    ///< the point nearest to the line through the vertex in a direction
    Across    ///< the point nearest to the plane through the vertex with a normal
};
inline constexpr Word<AxisLink> kAxisLinkWords[] = {
    {"nearest", AxisLink::Nearest}, {"along", AxisLink::Along}, {"across", AxisLink::Across}};

/// Places a reference axis, for ReferenceAxis.
struct AxisOptions {
    /// The nodes of the axis, which straight lines join: two or more, neighbours apart.
    std::vector<Point3> nodes = {};

    AxisLink link = AxisLink::Nearest;
    Point3 direction = {0, 0, 1};  ///< of the lines or planes of `link`: not zero

    TurnOrder order = TurnOrder::Zxy;

    /// False: sections keep their direction when nodes move. True: sections turn with the axis, and
    /// only the part of a link across the axis counts.
    bool follows = false;

    /// The directions of the three scales along the axes of a section: orthonormal.
    std::array<Point3, 3> frame = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
};

/// Design variables of a reference axis that carries a lattice, such as the quarter-chord line of a
/// wing: each node has a position, turns and scales, and the vertices linked to the axis between
/// two nodes take values that are linear between them.
///
/// Let f be the point of the axis that a vertex is linked to, t₀ the unit vector along the axis at
/// rest there, and d = v − f the link at rest. When the nodes have moved, so that f is at f' and
/// the direction is t, the vertex goes to
///
///     f' + σ S R(t, θ) R d                        if sections keep their direction,
///     f' + σ R(t, θ) S ((t·t₀) d − (t·d) t₀)       if they follow the axis.
///
/// R is the product of the turns ρx, ρy, ρz about the coordinate axes in the order of the options;
/// R(t, θ) turns by the twist θ about t, anticlockwise seen from its tip; S scales by σ₁, σ₂, σ₃
/// along the directions of the frame; σ scales alike in all directions. At a node, t is the
/// direction of the next segment; at the last node, of the last segment.
///
/// The values are in one array: for each node x, y, z, ρx, ρy, ρz, θ, σ, σ₁, σ₂, σ₃; angles in
/// radians. At rest they are the position, 0, 0, 0, 0, 1, 1, 1, 1.
class ESPALIER_API ReferenceAxis {
public:
    /// The number of values of a node.
    static constexpr Index kValues = 11;

    /// \param positions of the vertices at rest
    /// \throws ArgumentError for an option that is out of range; Error naming a position that is
    ///         not finite
    /// \cost O(vertices · nodes)
    ReferenceAxis(std::span<const Point3> positions, const AxisOptions& options);

    /// Returns the same links for a lattice and an axis that have moved at rest, as a parent
    /// lattice moves them.
    /// \throws Error unless there are as many positions and nodes as before; for one that is not
    ///         finite, and neighbouring nodes at the same place
    ReferenceAxis movedTo(std::span<const Point3> positions, std::span<const Point3> nodes) const;

    Index vertexCount() const { return static_cast<Index>(vertices_.size()); }
    Index nodeCount() const { return static_cast<Index>(nodes_.size()); }

    /// Returns the number of values: eleven per node.
    Index count() const { return kValues * nodeCount(); }

    /// Returns the values that leave the vertices at rest. (If sections follow the axis, links have
    /// to be across it.)
    std::vector<double> atRest() const;

    /// Returns the point of the axis that each vertex is linked to, at rest.
    std::vector<Point3> feet() const;

    /// Returns the positions of the vertices for some values.
    /// \throws Error unless there are count() finite values, and neighbouring nodes are apart
    std::vector<Point3> positions(std::span<const double> values) const;

    /// Returns the derivatives of the coordinates of the vertices by the values: 3 · vertices ×
    /// count(), in the form of DesignVariables::matrix().
    /// \throws Error as positions()
    stencils::StencilTable<double> matrix(std::span<const double> values) const;

    /// Returns the derivatives by the lattice and the axis at rest: 3 · vertices × 3 · (vertices +
    /// nodes), with the coordinates of the vertices first. They are of movedTo() at equal values.
    /// \throws Error as positions()
    stencils::StencilTable<double> restMatrix(std::span<const double> values) const;

private:
    struct Link {
        Index segment;    ///< from node `segment` to the next one
        double fraction;  ///< of the segment
    };

    Link linkOf(const Point3& vertex, const AxisOptions& options) const;
    void requireNodes(std::span<const Point3> nodes) const;
    void check(std::span<const double> values) const;

    std::vector<Point3> nodes_, vertices_;
    std::vector<Link> links_;
    TurnOrder order_;
    bool follows_;
    std::array<Point3, 3> frame_;
};

}  // namespace espalier::solve
