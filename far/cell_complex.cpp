// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/lazy.h>
#include <espalier/base/loop_context.h>
#include <espalier/far/cell_complex.h>

#include <cassert>
#include <memory>
#include <mutex>
#include <numeric>

namespace espalier::far {
namespace {

/// A relation that is derived by the first thread that needs it.
///
/// Other threads wait for the first thread. A thread does not wait if a third thread may be waiting
/// for it (LoopContext::isAwaited), because this could be a deadlock: while a thread derives a
/// relation, it may run another task of its host, or a callback, which needs the same relation
/// again; or it may need a relation that a second thread derives, which in turn needs this one.
/// Such a thread derives the relation itself, and the first result wins.
class LazyRelation {
public:
    template <class Derive>
    const Incidence& get(Derive derive) {
        if (const Incidence* known = relation_.known()) return *known;
        LoopContext context = loopContext();
        std::unique_lock lock(mutex_, std::defer_lock);
        if (!std::exchange(context.isAwaited, true)) lock.lock();
        return relation_.get([&] {
            const LoopContextScope scope(context);
            return derive();
        });
    }

private:
    std::mutex mutex_;
    Lazy<Incidence> relation_;
};

}  // namespace

struct CellComplex::Data {
    int dimension = 0;
    Index vertexCount = 0;
    Boundaries boundaries;

    /// derived[from][to].
    mutable std::array<std::array<LazyRelation, kMaxDimension + 1>, kMaxDimension + 1> derived;
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
    return data_->boundaries[dimension - 1];
}

namespace {

/// Returns face → vertices in loop order: the vertex where the loop enters each edge.
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

/// Returns cell → vertices or cell → edges: the union over the cell's faces, ascending.
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
    Array<Index> all(count);
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
    if (to >= 0 && from == to + 1) return boundary(from).unsignedRows();
    return data_->derived[from][to].get([&] { return deriveRelation(*this, from, to); });
}

}  // namespace espalier::far
