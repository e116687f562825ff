// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>
#include <espalier/base/point.h>

#include <array>
#include <charconv>
#include <string>

namespace espalier {

/// Returns the shortest text that reads back as `value`.
inline std::string textOf(double value) {
    std::array<char, 32> text;
    return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

inline std::string textOf(const Point3& point) {
    return concat("(", textOf(point[0]), ", ", textOf(point[1]), ", ", textOf(point[2]), ")");
}

}  // namespace espalier
