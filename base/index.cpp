// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/index.h>

namespace espalier {

const char* dimensionName(int dimension) {
    constexpr const char* kNames[] = {"vertex", "edge", "face", "cell"};
    return dimension >= 0 && dimension <= kMaxDimension ? kNames[dimension] : "entity";
}

}  // namespace espalier
