// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/function_ref.h>
#include <espalier/bind/point_weights.h>
#include <espalier/embed/basis_functions.h>
#include <espalier/limit/limit_binding.h>

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <variant>
#include <vector>

// bind/: one way from points to a binding.
//
// In: a lattice at rest, points, and a target: a level, the limit volume, or a tensor basis. Out: a
// Binding, which holds all that is needed to deform the points.
//
// Types: Target says what the points are bound to; PointWeights say how far each point follows;
// Binding is the result; bindInGroups() makes the rows of some points at a time instead.
//
// Read this header, then point_weights.h. embed/ and limit/ do the work; osd/binding_evaluator.h
// applies a pose, and osd::deformPoints() there applies one without a Binding.
//
// Notation: x' = x + D · (p' − p), where x and p are the points and the lattice at rest, p' is a
// pose of the lattice, and D the table of the binding.
namespace espalier::bind {

/// A level of the lattice.
struct Level {
    int level = 3;  ///< 1 to embed::kMaxLevelOfPoints

    /// Makes Binding::factors. The points are then searched twice.
    bool factors = false;
};

/// The limit volume, which the levels converge to.
struct Limit {
    double tolerance = limit::kLimitTolerance;  ///< see limit::LimitOptions::tolerance
};

/// Points are bound to a level of subdivision, to the limit, or to a Bézier or B-spline basis. A
/// basis needs a lattice that is a box.
using Target = std::variant<Level, Limit, embed::Basis>;

struct BindOptions {
    embed::EmbeddingOptions embedding = {};

    /// Makes Binding::gradients, which carry normals, tangents and splats (io::Model::write()).
    bool gradients = false;

    /// How far each point follows. Points with the weight 0 are not sought, so they are no errors
    /// under OutsidePolicy::Error either.
    PointWeights weights = {};

    /// If above 0, points outside the lattice follow it as under OutsidePolicy::Nearest, with a
    /// weight that falls from 1 at the lattice to 0 at this distance (falloffWeight()), in the
    /// units of the lattice. So the deformation has no edge at the boundary of the lattice. Keep
    /// it smaller than the gaps between parts of the lattice: in the middle of a gap the nearest
    /// part changes. A point whose unweighted row would exceed
    /// embed::kMaxRowSum stays in place: a point beside a box more than 3.5 cells away.
    double falloff = 0;

    /// Called now and then with the number of points done, from any thread; may be empty.
    std::function<void(Offset)> progress = {};
};

/// The rows of D of some points, or of all points of a model.
///
/// A point whose row is empty is outside the lattice, could not be placed, or has the weight 0
/// (`statuses`). Since its displacement is 0, it is exactly where it was in every pose.
struct WeightedRows {
    /// Points × base vertices, with the weights of the points: each row sums to the weight of its
    /// point, which is 1 without weights and falloff.
    stencils::StencilTable<double> table;
    /// How F = ∂x'/∂X follows from a pose, for points that follow fully; made on request
    /// (osd::evaluateGradients()).
    std::optional<embed::Gradients> gradients = {};
    /// The weights that D has, one per point, for the gradients; or none, if all are 1 with the
    /// slope 0 or there are no gradients.
    std::vector<PointWeight> weights = {};
    std::vector<embed::PointStatus> statuses = {};  ///< how each point was found
    double largestResidual = 0;                     ///< see embed::BoundRows

    /// Returns the number of points with a status.
    Index count(embed::PointStatus status) const;

    friend bool operator==(const WeightedRows&, const WeightedRows&) = default;
};

/// Points that are bound to a lattice: all that is needed to deform them. Neither the lattice nor
/// its topology is needed any more. `table` is D.
struct Binding : WeightedRows {
    std::uint64_t topologyHash = 0;  ///< far::topologyHash of the base lattice
    /// D in its two factors, which are faster where cells of the level hold several points; only of
    /// a level that was asked for them.
    std::optional<stencils::FactoredTable<double>> factors = {};
    std::vector<Point3> points = {};  ///< x, one per row of D
    std::vector<Point3> rest = {};    ///< p, one per column of D

    /// Checks that the parts fit together. Bindings by bindPoints() need no check.
    /// \throws Error unless the gradients and the factors have the rows and the columns of D, each
    ///         row has a point and a status, and each column has a vertex at rest
    ESPALIER_API void checkParts() const;

    friend bool operator==(const Binding&, const Binding&) = default;
};

/// Numbers that describe a binding, for reports.
struct BindingStatistics {
    std::array<Index, 4> statuses = {};  ///< number of points with each embed::PointStatus
    Index rowCount = 0;                  ///< the points
    Index columnCount = 0;               ///< the base vertices
    Offset entryCount = 0;               ///< the weights of D
    Index emptyRowCount = 0;             ///< the points that no pose moves
    Index emptyOutsideCount = 0;         ///< those of them that are outside the lattice
    bool hasGradients = false;
    /// Number of points with the identity as gradient in every pose; 0 without gradients.
    Index identityCount = 0;
    double largestResidual = 0;  ///< see embed::BoundRows

    Index count(embed::PointStatus status) const {
        return statuses[static_cast<std::size_t>(status)];
    }

    /// Adds the numbers of other points of the same lattice.
    ESPALIER_API void add(const BindingStatistics& others);
};

ESPALIER_API BindingStatistics statisticsOf(const WeightedRows& rows);

/// Returns the gradients of a binding as tables over the lattice vertices, with its weights.
/// \throws Error if the binding has no gradients
/// \cost O(entries of the result), in parallel
ESPALIER_API embed::GradientTables gradientTables(const Binding& binding);

/// Binds points to a lattice at rest.
///
/// \param lattice the refiner has level 0 only. For a basis it must be a box of hexahedra without
///        marks; its rules have no effect then
/// \param points in the units of the lattice; the binding gets a copy
/// \throws Error as embed::bindPoints(), limit::bindLimit() and embed::TensorLattice do; Error for
///         a basis and a lattice with marks, which only subdivision applies; Error unless there
///         is one weight for each point, or none, of 0 to 1 (names the first other point), and
///         likewise finite slopes; Error for a falloff with OutsidePolicy::Error; ArgumentError for
///         a falloff that is negative or not finite
/// \cost of the function for the target: embed::bindPoints(), limit::bindLimit()
/// \cite MacCracken & Joy 1996, sections 1 and 5
ESPALIER_API Binding bindPoints(const embed::RestLattice& lattice, std::span<const Point3> points,
                                const Target& target, const BindOptions& options = {});

/// Gets the rows of some points, and the numbers of these points in the model, in the same order.
/// It may be called from several threads at once.
using GroupSink = FunctionRef<void(std::span<const Index> points, WeightedRows rows)>;

/// Binds points as bindPoints() does, but makes no D: gives the rows of each group of points to
/// `sink`, which uses them while they are in the cache. The rows have the same bits as those of D.
/// No group has the points with the weight 0 (BindOptions::weights); the statistics count them as
/// NotBound.
///
/// \param target Level::factors has no effect
/// \throws Error, ArgumentError as bindPoints(); under OutsidePolicy::Error for a point that is not
///         inside, after all groups
/// \cost as bindPoints(), without the memory of D (embed::bindInGroups())
ESPALIER_API BindingStatistics bindInGroups(const embed::RestLattice& lattice,
                                            std::span<const Point3> points, const Target& target,
                                            const BindOptions& options, GroupSink sink);

}  // namespace espalier::bind
