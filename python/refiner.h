// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/face_varying.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/shapes/lattice.h>

#include <memory>
#include <mutex>
#include <optional>

#include "arguments.h"

namespace espalier::python {

/// A lattice, the rules that refine it, and the levels made so far. Any number of threads may call
/// it, without the GIL.
class Refiner {
public:
    /// \param faceVarying mode for texture coordinates; nothing for the tag of the lattice
    Refiner(std::shared_ptr<Lattice> lattice, const far::RefinerOptions& options,
            std::optional<far::FaceVaryingLinear> faceVarying = {});

    const std::shared_ptr<Lattice>& lattice() const { return lattice_; }

    std::optional<far::FaceVaryingLinear> faceVarying() const { return faceVarying_; }

    /// Returns the refiner with level 0 only.
    const far::TopologyRefiner& base() const { return base_; }

    /// Returns a refiner with levels 0 to `level` or more.
    /// \throws Error for a level below 0, and as far::TopologyRefiner::refineUniform()
    std::shared_ptr<const far::TopologyRefiner> upTo(int level) const;

private:
    std::shared_ptr<Lattice> lattice_;
    std::optional<far::FaceVaryingLinear> faceVarying_;
    far::TopologyRefiner base_;
    mutable std::mutex mutex_;
    mutable std::shared_ptr<const far::TopologyRefiner> deepest_;
};

/// An argument that is a Refiner, or a Lattice that is refined by the default rules.
struct RefinerKind {
    static constexpr auto kName = py::detail::const_name("Refiner | Lattice");
};
using RefinerLike = Like<RefinerKind>;

/// Checks the level of a function that needs a refined level.
/// \throws Error for a level below 1
void checkLevel(int level);

/// Returns the Refiner, or a new one for a Lattice.
/// \throws py::type_error if it is neither
std::shared_ptr<const Refiner> refinerOf(const RefinerLike& object);

}  // namespace espalier::python
