// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

// base/ has the types and functions that all other folders use. It has no geometry.
//
// Its types are Index and Offset (this header), Error (error.h), Array (array.h), parallelFor()
// (parallel.h), ExecutorScope (executor.h), ProgressScope (progress.h), MemoryLimit (memory.h).
//
// Read this header first, then error.h, argument_error.h and parallel.h; read the others as needed.
namespace espalier {

/// Number of an entity among the entities of its dimension, counted from 0.
using Index = std::int32_t;

/// Position in the values of a CSR relation. A relation may have more entries than an Index can
/// count.
using Offset = std::int64_t;

inline constexpr Index kMaxIndex = std::numeric_limits<Index>::max();

/// Largest dimension of a complex: a lattice.
inline constexpr int kMaxDimension = 3;

/// A vertex, edge, face or cell whose dimension is known only at run time. Refinement and masks use
/// this type, so that the same code serves every dimension.
struct Entity {
    int dimension = 0;
    Index index = 0;
    friend auto operator<=>(const Entity&, const Entity&) = default;
};

/// A value for every entity of a complex, by dimension and index.
template <class T>
using ByEntity = std::array<std::vector<T>, kMaxDimension + 1>;

/// Index of an entity whose dimension is known at compile time. Ids of different dimensions are
/// different types.
template <int Dimension>
struct Id {
    Index value = 0;

    constexpr Id() = default;
    constexpr explicit Id(Index index) : value(index) {}
    constexpr operator Entity() const { return {Dimension, value}; }
    friend constexpr auto operator<=>(const Id&, const Id&) = default;
};

using VertexId = Id<0>;
using EdgeId = Id<1>;
using FaceId = Id<2>;
using CellId = Id<3>;

/// Returns the name of an entity of this dimension in messages: "vertex", "edge", "face" or "cell".
inline const char* dimensionName(int dimension) {
    constexpr const char* kNames[] = {"vertex", "edge", "face", "cell"};
    return dimension >= 0 && dimension <= kMaxDimension ? kNames[dimension] : "entity";
}

/// A row of a relation, read as typed ids.
template <int Dimension>
class ESPALIER_API IdSpan {
public:
    class Iterator {
    public:
        using value_type = Id<Dimension>;
        using difference_type = std::ptrdiff_t;

        Iterator() = default;
        explicit Iterator(const Index* at) : at_(at) {}
        value_type operator*() const { return value_type(*at_); }
        Iterator& operator++() {
            ++at_;
            return *this;
        }
        Iterator operator++(int) {
            Iterator before = *this;
            ++at_;
            return before;
        }
        friend bool operator==(const Iterator&, const Iterator&) = default;

    private:
        const Index* at_ = nullptr;
    };

    explicit IdSpan(std::span<const Index> indices) : indices_(indices) {}
    Iterator begin() const { return Iterator(indices_.data()); }
    Iterator end() const { return Iterator(indices_.data() + indices_.size()); }
    std::size_t size() const { return indices_.size(); }
    Id<Dimension> operator[](std::size_t position) const {
        return Id<Dimension>(indices_[position]);
    }

private:
    std::span<const Index> indices_;
};

}  // namespace espalier
