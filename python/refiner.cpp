// SPDX-License-Identifier: Apache-2.0
#include "refiner.h"

#include <espalier/shapes/refiner_options.h>

#include <utility>

#include "arguments.h"

namespace espalier::python {

Refiner::Refiner(std::shared_ptr<Lattice> lattice, const far::RefinerOptions& options,
                 std::optional<far::FaceVaryingLinear> faceVarying)
    : lattice_(std::move(lattice)),
      faceVarying_(faceVarying),
      base_(lattice_->complex, options),
      deepest_(std::make_shared<far::TopologyRefiner>(base_)) {}

std::shared_ptr<const far::TopologyRefiner> Refiner::upTo(int level) const {
    if (level < 0) throw Error(concat("level: expected 0 or more, got ", level));
    std::unique_lock lock(mutex_);
    const auto levels = deepest_;
    lock.unlock();
    if (levels->maxLevel() >= level) return levels;
    // Others may be reading the levels that are there: they keep theirs. Not locked, since a signal
    // handler of Python may come here again meanwhile; what two make at once is the same.
    auto deeper = std::make_shared<far::TopologyRefiner>(*levels);
    deeper->refineUniform(level);
    lock.lock();
    if (deepest_->maxLevel() < level) deepest_ = std::move(deeper);
    return deepest_;
}

void checkLevel(int level) {
    if (level < 1) throw Error(concat("level: expected 1 or more, got ", level));
}

std::shared_ptr<const Refiner> refinerOf(const RefinerLike& object) {
    if (py::isinstance<Refiner>(object)) return object.cast<std::shared_ptr<Refiner>>();
    if (!py::isinstance<Lattice>(object))
        throw py::type_error("expected a Lattice or a Refiner, got " + typeName(object));
    auto lattice = object.cast<std::shared_ptr<Lattice>>();
    return withoutGil([&] {
        const auto options = refinerOptions(*lattice);
        return std::make_shared<const Refiner>(std::move(lattice), options);
    });
}

}  // namespace espalier::python
