// SPDX-License-Identifier: Apache-2.0
#include <espalier/compare/agreement.h>
#include <opensubdiv/version.h>

#include <algorithm>

namespace espalier::compare {

bool LevelAgreement::isWithin(const Bounds& bounds) const {
    return counts == openSubdivCounts && topologyDifference.empty() &&
           positionDifference <= bounds.position && weightDifference <= bounds.weight &&
           evaluatorDifference <= bounds.evaluator;
}

bool Agreement::isWithin(const Bounds& bounds) const {
    return !levels.empty() &&
           std::all_of(levels.begin(), levels.end(),
                       [&](const LevelAgreement& level) { return level.isWithin(bounds); });
}

std::string openSubdivVersion() {
    return std::to_string(OPENSUBDIV_VERSION_MAJOR) + "." +
           std::to_string(OPENSUBDIV_VERSION_MINOR) + "." +
           std::to_string(OPENSUBDIV_VERSION_PATCH);
}

}  // namespace espalier::compare
