// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/bind/bind.h>
#include <espalier/osd/evaluation.h>

#include <memory>
#include <span>

namespace espalier::osd {

/// Deforms the points of a binding, for many poses:
///
///     const osd::Deformer<float> deformer(binding);   // once
///     deformer.deform(pose, points);                  // for each pose, or for all at once
///
/// It owns all that this takes: D in the form that is fastest to evaluate, the points and the
/// lattice at rest, and temporary memory, so the binding may be destroyed. Points whose row of D is
/// empty stay exactly where they are.
///
/// For other layouts, ranges of rows or values that are not positions, use CompiledTable or
/// CompiledChain, which a deformer calls.
///
/// Any number of threads may use a deformer at once. Copies share the data. A call takes no lock if
/// it runs on the calling thread (SerialExecutor). It allocates memory only if it needs more than
/// earlier calls, or if more calls run at once than before; more than eight at once always
/// allocate. The first deformChanged() allocates, too. So call both once before real time.
///
/// \tparam Real float or double, the precision of poses and results
/// \cite MacCracken & Joy 1996, section 5: x' = D · p'
template <class Real>
class ESPALIER_API Deformer {
public:
    /// Compiles D; and its factors, if the binding has them. Of the two, it keeps the form that
    /// takes less memory.
    ///
    /// \throws Error as bind::Binding::checkParts()
    /// \cost O(entries + rows log rows). The compiled form takes a tenth to two thirds of the bytes
    ///       of D. The deformer also stores 3 numbers for each point at rest (x), and 3 for each
    ///       vertex at rest (p)
    explicit Deformer(const bind::Binding& binding);

    Index pointCount() const;
    Index vertexCount() const;

    /// Memory of the deformer in bytes, without temporary memory.
    std::size_t byteCount() const;

    /// Computes x + D · (p' − p) for each pose, where x and p are the points and the lattice at
    /// rest, rounded to Real. So a point that no moved vertex influences is exactly at x, and
    /// rounding errors are relative to its displacement; they are given for CompiledTable. A pose
    /// alone and among others may differ by rounding, since rows of few entries are summed in
    /// another order for several poses.
    ///
    /// \param poses one or more poses, one after the other: the position of each vertex, 3 ·
    ///        vertexCount() numbers for a pose
    /// \param points receives the points of each pose, one pose after the other: 3 · pointCount()
    ///        numbers for a pose. Must not overlap the poses
    /// \throws Error if the poses are not whole, or `points` has another number of poses; nothing
    ///         has been written then
    /// \cost O(entries) for each pose, on all threads. If D takes much memory, a call reads it once
    ///       for every four poses, with temporary memory for their results
    void deform(Values<Real> poses, MutableValues<Real> points) const;

    /// Computes the points that depend on some vertices of the lattice, for example while they are
    /// dragged, with the same results. If `points` has the points of one pose, and the next pose
    /// differs from it in these vertices only, it then has the points of the next pose.
    ///
    /// \param pose positions of all vertices; they must be finite
    /// \param changed vertices, in any order; duplicates count once
    /// \throws Error as above, for one pose; if a vertex is not in the lattice
    /// \cost of ChangeEvaluator, which the first call makes; of deform() if the binding has factors
    void deformChanged(Values<Real> pose, std::span<const Index> changed,
                       MutableValues<Real> points) const;

private:
    struct Data;
    std::shared_ptr<const Data> data_;
};

}  // namespace espalier::osd
