// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/lattice.h>

#include <cstddef>
#include <limits>

namespace espalier {

std::int64_t noInteger(IntegerType type) {
    switch (type) {
        case IntegerType::UInt8:
            return std::numeric_limits<std::uint8_t>::max();
        case IntegerType::UInt16:
            return std::numeric_limits<std::uint16_t>::max();
        case IntegerType::UInt32:
            return std::numeric_limits<std::uint32_t>::max();
        default:
            return -1;  // For UInt64, these are the bits of the largest number.
    }
}

const char* integerTypeName(IntegerType type) {
    constexpr const char* kNames[] = {"Int8",  "UInt8",  "Int16", "UInt16",
                                      "Int32", "UInt32", "Int64", "UInt64"};
    return kNames[static_cast<std::size_t>(type)];
}

}  // namespace espalier
