// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

namespace espalier {

/// A position in space. Topology has none; the folders that do share this type.
using Point3 = std::array<double, 3>;

}  // namespace espalier
