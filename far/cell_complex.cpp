// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/cell_complex.h>

#include <atomic>
#include <cassert>
#include <mutex>
#include <numeric>

namespace espalier::far {

struct CellComplex::Data {
    int dimension = 0;
    Index vertexCount = 0;
    Boundaries boundaries;

    /// Relations derived on first use, at [from][to].
    struct Lazy {
        std::mutex mutex;
        std::atomic<bool> isThere = false;
        Incidence incidence;
    };
    mutable std::array<std::array<Lazy, kMaxDimension + 1>, kMaxDimension + 1> derived;
};

CellComplex::CellComplex() : CellComplex(0, 0, {}) {}

CellComplex::CellComplex(int dimension, Index vertexCount, Boundaries boundaries) {
    auto data = std::make_shared<Data>();
    data->dimension = dimension;
    data->vertexCount = vertexCount;
    data->boundaries = std::move(boundaries);
    data_ = std::move(data);
}

int CellComplex::dimension() const {
    return data_->dimension;
}

Index CellComplex::count(int dimension) const {
    return dimension == 0 ? data_->vertexCount : boundary(dimension).unsignedRows().rowCount();
}

Index CellComplex::eulerCharacteristic() const {
    return count(0) - count(1) + count(2) - count(3);
}

const SignedIncidence& CellComplex::boundary(int dimension) const {
    assert(dimension >= 1 && dimension <= kMaxDimension);
    return data_->boundaries[static_cast<std::size_t>(dimension) - 1];
}

namespace {

/// Face → vertices in loop order: the vertex at which the loop enters each edge.
Incidence faceLoops(const CellComplex& complex) {
    const SignedIncidence& edges = complex.boundary(2);
    const SignedIncidence& ends = complex.boundary(1);
    return Incidence(buildRows<Index>(complex.count(2), [&](Index face, std::vector<Index>& loop) {
        const auto signs = edges.signs(face);
        std::size_t position = 0;
        for (const Index edge : edges[face])
            loop.push_back(ends[edge][signs[position++] > 0 ? 0 : 1]);
    }));
}

/// Cell → vertices or edges: the union over its faces, ascending.
Incidence cellClosure(const CellComplex& complex, int to) {
    const Incidence& faces = complex.relation(3, 2);
    const Incidence& parts = complex.relation(2, to);
    return Incidence(
        buildRows<Index>(complex.count(3), [&](Index cell, std::vector<Index>& closure) {
            const auto begin = static_cast<std::ptrdiff_t>(closure.size());
            for (const Index face : faces[cell])
                closure.insert(closure.end(), parts[face].begin(), parts[face].end());
            std::sort(closure.begin() + begin, closure.end());
            closure.erase(std::unique(closure.begin() + begin, closure.end()), closure.end());
        }));
}

Incidence identity(Index count) {
    Array<Index> all(static_cast<std::size_t>(count));
    std::iota(all.begin(), all.end(), Index{0});
    return Incidence::uniform(1, std::move(all));
}

Incidence deriveRelation(const CellComplex& complex, int from, int to) {
    if (from == to) return identity(complex.count(from));
    if (from < to) return complex.relation(to, from).transposed(complex.count(from));
    return from == 2 ? faceLoops(complex) : cellClosure(complex, to);
}

}  // namespace

const Incidence& CellComplex::relation(int from, int to) const {
    assert(0 <= from && from <= data_->dimension && 0 <= to && to <= data_->dimension);
    if (from == to + 1) return boundary(from).unsignedRows();
    Data::Lazy& lazy = data_->derived[static_cast<std::size_t>(from)][static_cast<std::size_t>(to)];
    // Not std::call_once: work may be cancelled, and not every platform's lets exceptions out.
    if (!lazy.isThere.load(std::memory_order_acquire)) {
        const std::lock_guard lock(lazy.mutex);
        if (!lazy.isThere.load(std::memory_order_relaxed)) {
            lazy.incidence = deriveRelation(*this, from, to);
            lazy.isThere.store(true, std::memory_order_release);
        }
    }
    return lazy.incidence;
}

}  // namespace espalier::far
