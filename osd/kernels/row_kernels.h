// SPDX-License-Identifier: Apache-2.0
// Kernels for rows that have their own columns. Part of kernels_body.h.

/// Writes components `from` to `from` + width − 1 of rows, plus their addend.
template <int width, class Real>
class RowStore {
public:
    RowStore(Offset from, const Destination<Real>& to)
        : to_(to), from_(from), slots_(from, to.addend != nullptr ? to.addendLength : 1) {}

    template <class V>
    void operator()(const V& sum, Index row) const {
        V value = sum;
        Real* result = to_.values + row * to_.stride + from_;
        if (to_.addend != nullptr) {
            const Real* own = to_.addend + row * to_.addendStride;
            V added = {};
            for (int c = 0; c < width; ++c) added[c] = own[slots_.at[c]];
            value += added;
        }
        for (int c = 0; c < width; ++c) result[c] = value[c];
    }

private:
    const Destination<Real>& to_;
    Offset from_;
    AddendSlots<width> slots_;
};

/// Evaluates components `from` to `from` + width − 1 of each row.
template <int width, class Real>
void evaluateOwnWeights(const RowRun<Real>& run, Offset from, const Destination<Real>& to) {
    using V = typename Vector<Real, kPadding>::Type;
    const Real* points = run.points + from;
    const RowStore<width, Real> store(from, to);
    for (Index i = 0; i < run.rowCount; ++i) {
        if (!isInRange(run.rows[i], to)) continue;
        const Offset step = run.isShared ? 0 : run.length;
        const Real* weights = run.weights + i * step;
        const Index* columns = run.columns + Offset{i} * run.length;
        V even = {}, odd = {};
        Index k = 0;
        for (; k + 1 < run.length; k += 2) {
            addProduct(even, at<V>(points + columns[k] * run.pointStride), weights[k]);
            addProduct(odd, at<V>(points + columns[k + 1] * run.pointStride), weights[k + 1]);
        }
        if (k < run.length)
            addProduct(even, at<V>(points + columns[k] * run.pointStride), weights[k]);
        store(even + odd, run.rows[i]);
    }
}

/// Does the same for rows that all have the same weights, which stay in registers.
/// \tparam length number of entries of each row
/// \tparam stride run.pointStride if it is known, otherwise 0
template <int width, int stride, int length, class Real>
void evaluateSharedWeights(const RowRun<Real>& run, Offset from, const Destination<Real>& to) {
    using V = typename Vector<Real, kPadding>::Type;
    const Real* points = run.points + from;
    V weights[length];
    for (int k = 0; k < length; ++k) weights[k] = V{} + run.weights[k];
    const RowStore<width, Real> store(from, to);
    const Index* columns = run.columns;
    const Offset pointStride = stride > 0 ? stride : run.pointStride;
    for (Index i = 0; i < run.rowCount; ++i, columns += length) {
        if (!isInRange(run.rows[i], to)) continue;
        V sums[2] = {};
        for (int k = 0; k < length; ++k)
            addProduct(sums[k % 2], weights[k], at<V>(points + columns[k] * pointStride));
        store(sums[0] + sums[1], run.rows[i]);
    }
}

/// The most common row lengths of level tables have their own unrolled loops: 4, 6 and 9 on
/// surfaces, 8 and 12 in lattices. Rows of 18 and 27 entries have more weights than there are
/// registers.
template <int width, int stride, class Real>
void evaluateRowComponents(const RowRun<Real>& run, Offset from, const Destination<Real>& to) {
    if (run.isShared) switch (run.length) {
            case 4:
                return evaluateSharedWeights<width, stride, 4>(run, from, to);
            case 6:
                return evaluateSharedWeights<width, stride, 6>(run, from, to);
            case 8:
                return evaluateSharedWeights<width, stride, 8>(run, from, to);
            case 9:
                return evaluateSharedWeights<width, stride, 9>(run, from, to);
            case 12:
                return evaluateSharedWeights<width, stride, 12>(run, from, to);
        }
    evaluateOwnWeights<width>(run, from, to);
}

template <class Real>
void evaluateRows(const RowRun<Real>& run, const Destination<Real>& to) {
    forComponents(to.length, [&]<int width>(Offset from) {
        if (run.pointStride == kPadding)
            evaluateRowComponents<width, kPadding>(run, from, to);
        else
            evaluateRowComponents<width, 0>(run, from, to);
    });
}
