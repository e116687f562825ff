// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

namespace espalier {

/// Divides the numbers 0 to n − 1 into sets. At first each number is a set of its own.
///
/// Each set is a tree: a number points to its parent, and the root represents the set. Searches
/// halve the paths that they follow.
class DisjointSets {
public:
    explicit DisjointSets(std::size_t count) { reset(count); }

    /// Makes each of the numbers 0 to count − 1 a set of its own.
    void reset(std::size_t count) {
        parents_.resize(count);
        setCount_ = count;
        std::iota(parents_.begin(), parents_.end(), std::size_t{0});
    }

    /// Returns the number that represents the set of `item`. Another number may represent the set
    /// after a call of join().
    std::size_t rootOf(std::size_t item) {
        while (parents_[item] != item) item = parents_[item] = parents_[parents_[item]];
        return item;
    }

    /// Joins the sets of two numbers.
    /// \cost O(log n) on average over a sequence of calls
    void join(std::size_t a, std::size_t b) {
        a = rootOf(a);
        b = rootOf(b);
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
