// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

namespace espalier {

/// Disjoint sets of the numbers 0 to n − 1.
class DisjointSets {
public:
    /// Makes one set of each number.
    explicit DisjointSets(std::size_t count) : parents_(count), setCount_(count) {
        std::iota(parents_.begin(), parents_.end(), std::size_t{0});
    }

    /// Returns the number that stands for the set of `item`.
    std::size_t find(std::size_t item) {
        while (parents_[item] != item) item = parents_[item] = parents_[parents_[item]];
        return item;
    }

    /// Joins the sets of two numbers. The set of `b` stands for both.
    void unite(std::size_t a, std::size_t b) {
        a = find(a);
        b = find(b);
        if (a == b) return;
        parents_[a] = b;
        --setCount_;
    }

    std::size_t setCount() const { return setCount_; }

private:
    std::vector<std::size_t> parents_;
    std::size_t setCount_;
};

}  // namespace espalier
