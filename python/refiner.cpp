// SPDX-License-Identifier: Apache-2.0
#include "refiner.h"

#include <espalier/far/error.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>

#include <string>
#include <utility>

#include "arrays.h"

namespace espalier::python {

Refiner::Refiner(std::shared_ptr<Lattice> lattice, const far::RefinerOptions& options,
                 stencils::Rules rules)
    : lattice_(std::move(lattice)),
      rules_(rules),
      base_(lattice_->complex, options),
      deepest_(std::make_shared<far::TopologyRefiner>(base_)) {
    stencils::checkRules(base_, rules);
}

std::shared_ptr<const far::TopologyRefiner> Refiner::upTo(int level) const {
    if (level < 0) throw Error("level: expected 0 or more, got " + std::to_string(level));
    const std::lock_guard lock(mutex_);
    if (deepest_->maxLevel() < level) {
        // Others may be reading the levels that are there: they keep theirs.
        auto deeper = std::make_shared<far::TopologyRefiner>(*deepest_);
        deeper->refineUniform(level);
        deepest_ = std::move(deeper);
    }
    return deepest_;
}

std::shared_ptr<const Refiner> refinerOf(const RefinerLike& object) {
    if (py::isinstance<Refiner>(object)) return object.cast<std::shared_ptr<Refiner>>();
    if (!py::isinstance<Lattice>(object))
        throw py::type_error("expected a Lattice or a Refiner, got " + typeName(object));
    auto lattice = object.cast<std::shared_ptr<Lattice>>();
    return withoutGil([&] {
        const auto options = refinerOptions(*lattice);
        return std::make_shared<const Refiner>(std::move(lattice), options,
                                               stencils::Rules::Siggraph96);
    });
}

}  // namespace espalier::python
