// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/embed/local_binding.h>
#include <espalier/embed/nested_lattices.h>
#include <espalier/stencils/composition.h>

#include <cmath>
#include <string>

namespace espalier::embed {

stencils::StencilTable<double> nestTables(const stencils::StencilTable<double>& child,
                                          std::span<const Point3> childPose,
                                          const RestLattice& parent,
                                          const BindingOptions& options) {
    if (std::ssize(childPose) != child.columnCount())
        throw Error("got " + std::to_string(childPose.size()) + " positions for " +
                    std::to_string(child.columnCount()) + " vertices of the child");
    for (std::size_t vertex = 0; vertex < childPose.size(); ++vertex)
        for (const double coordinate : childPose[vertex])
            if (!std::isfinite(coordinate))
                throw Error("the position of vertex " + std::to_string(vertex) +
                            " of the child is not finite");
    BindingOptions binding = options;
    if (binding.embedding.outside == OutsidePolicy::Error)
        binding.embedding.outside = OutsidePolicy::Keep;
    const auto bound = bindPoints(parent, childPose, binding);
    // A vertex that would stay in place has no row of weights.
    if (const auto without = bound.table.emptyRows(); !without.empty()) {
        const Index vertex = without.front();
        std::string why = "cannot be placed in the parent lattice: its cell is degenerate";
        if (bound.statuses[vertex] == PointStatus::Outside) why = "lies outside the parent lattice";
        if (bound.statuses[vertex] == PointStatus::Outside &&
            options.embedding.outside == OutsidePolicy::Nearest)
            why +=
                ", and the nearest cell cannot carry it: it is too far away, or the cell is flat";
        throw Error("vertex " + std::to_string(vertex) + " of the child " + why);
    }
    return stencils::multiply(child, bound.table);
}

}  // namespace espalier::embed
