// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/stencils/stencil_table.h>

#include <span>
#include <vector>

namespace espalier::solve {

/// Places sections along an axis, for SectionVariables.
struct SectionOptions {
    Point3 axis = {0, 0, 1};    ///< direction of the axis: not zero, of any length
    Point3 chord = {1, 0, 0};   ///< direction of the chord: not parallel to the axis
    Point3 center = {0, 0, 0};  ///< a point on the axis

    /// Coordinates e·p of the sections along the axis, ascending, for the unit vector e of the
    /// axis: one or more.
    std::vector<double> stations = {};
};

/// Five design variables per section of a lattice, as for the sections of a wing: twist, scale of
/// the chord, and a translation. Between two sections, vertices take values that are linear in
/// their coordinate along the axis; beyond the first and the last section, those of that section.
///
/// Let h be the unit vector of the chord across the axis, and n = e × h. A vertex at f + a·h + b·n,
/// where f is on the axis, goes to
///
///     f + t + R(θ) (σ a h + b n)
///
/// for the twist θ (in radians, anticlockwise seen from the tip of the axis), the scale σ and the
/// translation t at its coordinate. So a section stays flat, and a twist turns it as a rigid body
/// about the axis, for any values of the other sections.
///
/// The values are in one array: θ, σ, tx, ty, tz of section 0, then of section 1, and so on. At
/// rest they are 0, 1, 0, 0, 0.
class ESPALIER_API SectionVariables {
public:
    /// \param positions of the vertices at rest
    /// \throws ArgumentError for an option that is out of range; Error naming a position
    ///         that is not finite
    SectionVariables(std::span<const Point3> positions, const SectionOptions& options);

    /// Returns the number of variables: five per section.
    Index count() const { return 5 * static_cast<Index>(stations_.size()); }

    /// Returns the values that leave the vertices at rest.
    std::vector<double> atRest() const;

    /// Returns the positions of the vertices for some values.
    /// \throws Error unless there are count() finite values
    std::vector<Point3> positions(std::span<const double> values) const;

    /// Returns the derivatives of the coordinates of the vertices by the variables, at some values:
    /// 3 · vertices × count(), in the form of DesignVariables::matrix(). With D, buildJacobian()
    /// makes the Jacobian of the points of it.
    /// \throws Error as positions()
    stencils::StencilTable<double> matrix(std::span<const double> values) const;

private:
    /// A vertex in the frame of the axis, and the sections that it depends on.
    struct Vertex {
        Point3 foot;           ///< its point on the axis
        double chord, normal;  ///< its coordinates a and b
        Index section;         ///< the section below, or the first one
        double fraction;       ///< fraction of the way to the next section; 0 beyond the ends
    };

    void check(std::span<const double> values) const;

    std::vector<double> stations_;
    Point3 axis_, chord_, normal_;
    std::vector<Vertex> vertices_;
};

}  // namespace espalier::solve
