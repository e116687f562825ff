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
    bool isRefined = false;

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

CellComplex CellComplex::refined(int dimension, Index vertexCount, Boundaries boundaries) {
    CellComplex complex;
    auto data = std::make_shared<Data>();
    data->dimension = dimension;
    data->vertexCount = vertexCount;
    data->boundaries = std::move(boundaries);
    data->isRefined = true;
    complex.data_ = std::move(data);
    return complex;
}

bool CellComplex::isRefined() const {
    return data_->isRefined;
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
    return fillRows(edges.unsignedRows().starts(), [&](Index face, Index* loop) {
        const std::int8_t* sign = edges.signs(face).data();
        for (const Index edge : edges[face]) *loop++ = ends[edge][*sign++ > 0 ? 0 : 1];
    });
}

/// Returns cell → vertices or cell → edges: the union over the cell's faces, ascending.
Incidence cellClosure(const CellComplex& complex, int to) {
    constexpr std::ptrdiff_t kFew = 16;  // up to this number, a scan is faster than sorting
    const Incidence& faces = complex.relation(3, 2);
    const Incidence& parts = complex.relation(2, to);
    return Incidence(
        buildRows<Index>(complex.count(3), [&](Index cell, std::vector<Index>& closure) {
            const auto begin = static_cast<std::ptrdiff_t>(closure.size());
            for (const Index face : faces[cell])
                for (const Index part : parts[face]) {
                    const auto few = std::min(std::ssize(closure) - begin, kFew);
                    if (!contains(std::span<const Index>(closure).subspan(begin, few), part))
                        closure.push_back(part);
                }
            std::sort(closure.begin() + begin, closure.end());
            closure.erase(std::unique(closure.begin() + begin, closure.end()), closure.end());
        }));
}

/// Returns the lengths of the rows of cell → vertices or cell → edges of a refined lattice, as
/// perType · n + more for a cell of type n.
RowStarts refinedStarts(const Incidence& faces, Index perType, Index more) {
    if (faces.commonLength() > 0)
        return {faces.rowCount(), faces.commonLength() / 2 * perType + more};
    Array<Index> lengths(faces.rowCount());
    for (Index cell = 0; cell < faces.rowCount(); ++cell)
        lengths[cell] = static_cast<Index>(faces[cell].size()) / 2 * perType + more;
    return RowStarts::ofLengths(lengths);
}

/// Returns cell → vertices of a refined lattice: for the cell [v, c], the vertices v, e, f and c,
/// with the edges e and the faces f between v and c ascending.
Incidence refinedCellVertices(const CellComplex& complex) {
    const Incidence& faces = complex.relation(3, 2);
    const Incidence& loops = complex.relation(2, 0);
    return fillRows(refinedStarts(faces, 2, 2), [&](Index cell, Index* vertices) {
        const std::span<const Index> all = faces[cell];
        const std::size_t n = all.size() / 2;
        const auto firsts = all.first(n), seconds = all.last(n);
        *vertices++ = loops[firsts.front()][0];
        // The faces [e, c] have the order of their edges.
        for (const Index face : seconds) *vertices++ = loops[face][0];
        Index* const inner = vertices;
        for (const Index face : firsts) *vertices++ = loops[face][2];
        std::sort(inner, vertices);
        *vertices = loops[seconds.front()][2];
    });
}

/// Returns cell → edges of a refined lattice: for the cell [v, c], the edges [v, e], then [e, f],
/// then [f, c], ascending.
///
/// The faces of the cell with their signs run around v, so each of them leaves v along another
/// edge; likewise at c.
Incidence refinedCellEdges(const CellComplex& complex) {
    const SignedIncidence& faces = complex.boundary(3);
    const Incidence& faceEdges = complex.relation(2, 1);
    return fillRows(refinedStarts(faces.unsignedRows(), 4, 0), [&](Index cell, Index* edges) {
        const std::span<const Index> all = faces[cell];
        const std::int8_t* signs = faces.signs(cell).data();
        const std::size_t n = all.size() / 2;
        for (std::size_t i = 0; i < n; ++i) {
            const std::span<const Index> loop = faceEdges[all[i]];
            edges[i] = loop[signs[i] > 0 ? 0 : 3];
            edges[n + 2 * i] = loop[1];
            edges[n + 2 * i + 1] = loop[2];
            edges[3 * n + i] = faceEdges[all[n + i]][signs[n + i] > 0 ? 1 : 2];
        }
        std::sort(edges, edges + n);
        std::sort(edges + n, edges + 3 * n);
        std::sort(edges + 3 * n, edges + 4 * n);
    });
}

Incidence identity(Index count) {
    Array<Index> all(count);
    std::iota(all.begin(), all.end(), Index{0});
    return Incidence::uniform(1, std::move(all));
}

Incidence deriveRelation(const CellComplex& complex, int from, int to) {
    if (from == to) return identity(complex.count(from));
    if (from < to) return complex.relation(to, from).transposed(complex.count(from));
    if (from == 2) return faceLoops(complex);
    if (!complex.isRefined()) return cellClosure(complex, to);
    return to == 0 ? refinedCellVertices(complex) : refinedCellEdges(complex);
}

}  // namespace

const Incidence& CellComplex::relation(int from, int to) const {
    assert(0 <= from && from <= data_->dimension && 0 <= to && to <= data_->dimension);
    if (to >= 0 && from == to + 1) return boundary(from).unsignedRows();
    return data_->derived[from][to].get([&] { return deriveRelation(*this, from, to); });
}

}  // namespace espalier::far
