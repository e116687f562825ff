// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/deformation_gradient.h>
#include <espalier/base/point.h>
#include <espalier/bind/bind.h>
#include <espalier/osd/evaluation.h>
#include <espalier/stencils/factored_table.h>

#include <array>
#include <span>
#include <vector>

namespace espalier::osd {

/// Returns the points of a bound model for a pose of the lattice: D · p'. Points that the binding
/// keeps in place get their rest positions. Table is StencilTable<Real> or FactoredTable<Real>. For
/// many poses use CompiledTable or CompiledChain, which are faster.
///
/// \param pose positions of the base vertices
/// \throws Error if the pose does not have binding.table.columnCount() vertices
/// \cost O(entries), on all threads; memory for the pose and the result as Real
/// \cite MacCracken & Joy 1996, section 5
template <class Table>
ESPALIER_API std::vector<Point3> evaluateBinding(const embed::BindingOf<Table>& binding,
                                                 std::span<const Point3> pose);

/// A bound model and its lattice at rest.
struct RestPositions {
    std::span<const Point3> points;    ///< one per row of D
    std::span<const Point3> vertices;  ///< one per column of D
};

/// Returns the points of a bound model as x + D · (p' − p), where x and p are the points and the
/// lattice at rest. A point that no moved vertex influences is exactly where it was, and the
/// rounding error is relative to the displacement of a point, not to its coordinates. The placement
/// error of the binding cancels too.
///
/// \param pose positions of the base vertices
/// \throws Error as above, or if there is not one position for each row and each column
/// \cost the cost of evaluateBinding() above, and one addition per coordinate
template <class Table>
ESPALIER_API std::vector<Point3> evaluateBinding(const embed::BindingOf<Table>& binding,
                                                 const RestPositions& rest,
                                                 std::span<const Point3> pose);

/// Returns the points of a binding for a pose of the lattice: x + D · (p' − p), as above; D · p' if
/// the binding does not know x and p.
/// \throws Error if there is not one position for each column
ESPALIER_API std::vector<Point3> evaluateBinding(const bind::Binding& binding,
                                                 std::span<const Point3> pose);

/// Returns the deformation gradient of each point for a pose of the lattice: 1 + G · (p' − p),
/// where p is the lattice at rest. A point that no moved vertex influences has exactly the
/// identity.
///
/// \param gradients limit::LimitTable::gradients: table j times p' is column j of F
/// \param rest, pose positions of the base vertices
/// \throws Error if there is not one position for each column
/// \cost O(entries), on all threads
ESPALIER_API std::vector<DeformationGradient> evaluateGradients(
    const std::array<stencils::StencilTable<double>, 3>& gradients, std::span<const Point3> rest,
    std::span<const Point3> pose);

/// The same for a binding with gradients.
/// \throws Error as above; if the binding has no gradients
ESPALIER_API std::vector<DeformationGradient> evaluateGradients(const bind::Binding& binding,
                                                                std::span<const Point3> pose);

/// Writes the rest positions of the points that the binding keeps in place. Evaluators of
/// binding.table write 0 for these points, so call this after each evaluation. The two calls
/// allocate nothing:
///
///     compiled.evaluate(pose, xyz, points, xyz, {0, compiled.rowCount()}, workspace);
///     osd::writeKept<float>(binding, points, xyz);
///
/// The precisions of the binding and of the destination may differ.
///
/// \param destination has point i at entry i of `layout`, whose length is 3
/// \throws Error if the layout is invalid or the destination too short for all points; nothing has
///         been written then
/// \cost O(kept points)
template <class Real, class Table>
void writeKept(const embed::BindingOf<Table>& binding, MutableValues<Real> destination,
               const BufferDescriptor& layout) {
    const Index count = binding.table.rowCount();
    checkEvaluation(count, 0, 0, BufferDescriptor::packed(3), destination.size(), layout,
                    {0, count});
    for (std::size_t i = 0; i < binding.kept.size(); ++i)
        for (Offset c = 0; c < 3; ++c)
            destination[layout.offset + binding.kept[i] * layout.stride + c] =
                static_cast<Real>(binding.keptAt[i][c]);
}

}  // namespace espalier::osd
