// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>

#include <cstdint>
#include <string>
#include <vector>

namespace espalier {

/// The types of integers that files keep on vertices.
enum class IntegerType { Int8, UInt8, Int16, UInt16, Int32, UInt32, Int64, UInt64 };

/// Integers on the vertices of a lattice: identifiers, numbers of materials. They are never
/// averaged: a vertex has the integers of one vertex that it comes from, or noInteger().
struct VertexIntegers {
    std::string name;
    int components = 1;
    IntegerType type = IntegerType::Int64;

    /// `components` a vertex, vertex by vertex, in the range of the type. UInt64 has its bits here:
    /// 2^63 and above are negative.
    std::vector<std::int64_t> values;
};

/// Marks a vertex that has no integer: −1 of signed types, the largest number of unsigned ones.
ESPALIER_API std::int64_t noInteger(IntegerType type);

/// The name of a type: "UInt64".
ESPALIER_API const char* integerTypeName(IntegerType type);

}  // namespace espalier
