// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>

#include <string>

#include "checked_volume.h"

namespace espalier::solve {

CheckedVolume::CheckedVolume(const far::CellComplex& level) : cells_(level) {
    if (level.dimension() != 3)
        throw Error("cells are checked in a lattice only, not in a complex of dimension " +
                    std::to_string(level.dimension()));
    for (Index face = 0; face < level.count(2); ++face)
        if (level.relation(2, 0)[face].size() != 4)
            throw Error("face " + std::to_string(face) +
                        " is not a quadrilateral: checking cells needs a lattice refined at least "
                        "once");
}

CheckedVolume::CheckedVolume(const limit::LimitParts& limit)
    : cells_(limit.base()), limit_(limit) {}

Index CheckedVolume::partCount() const {
    return limit_ ? static_cast<Index>(limit_->parts().size()) : cells_.count(3);
}

Index CheckedVolume::cellOf(Index part) const {
    return limit_ ? limit_->parts()[part].baseCell : part;
}

limit::LimitPositions CheckedVolume::place(std::span<const Point3> positions) const {
    if (limit_) return limit_->place(positions);
    return {{}, {positions.begin(), positions.end()}};
}

}  // namespace espalier::solve
