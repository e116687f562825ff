// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/topology_refiner.h>
#include <espalier/shapes/lattice.h>

#include <memory>
#include <mutex>

#include "arguments.h"

namespace espalier::python {

/// A lattice, how it is refined, and the levels made so far. Calls are safe from any number of
/// threads; make them without the GIL.
class Refiner {
public:
    Refiner(std::shared_ptr<Lattice> lattice, const far::RefinerOptions& options);

    const std::shared_ptr<Lattice>& lattice() const { return lattice_; }

    /// Level 0 alone.
    const far::TopologyRefiner& base() const { return base_; }

    /// Levels 0 to `level` at least.
    /// \throws Error for a level below 0; what far::TopologyRefiner::refineUniform() throws
    std::shared_ptr<const far::TopologyRefiner> upTo(int level) const;

private:
    std::shared_ptr<Lattice> lattice_;
    far::TopologyRefiner base_;
    mutable std::mutex mutex_;
    mutable std::shared_ptr<const far::TopologyRefiner> deepest_;
};

/// A Refiner, or a Lattice that is refined as is usual.
struct RefinerKind {
    static constexpr auto kName = py::detail::const_name("Refiner | Lattice");
};
using RefinerLike = Like<RefinerKind>;

/// For what needs a level that is refined.
/// \throws Error for a level below 1
void checkLevel(int level);

/// \throws py::type_error if it is neither
std::shared_ptr<const Refiner> refinerOf(const RefinerLike& object);

}  // namespace espalier::python
