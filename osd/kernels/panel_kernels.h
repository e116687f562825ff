// SPDX-License-Identifier: Apache-2.0
// Kernels for groups of rows: panels and outer products. Part of kernels_body.h.

/// Two numbers that need no more alignment than one.
template <class Real>
struct PairOf {
    typedef Real Type
        __attribute__((vector_size(2 * sizeof(Real)), aligned(sizeof(Real)), may_alias));
};

/// Returns true if any row of a panel is in the range.
template <class Real>
bool isAnyInRange(const Index* rows, Index count, const Destination<Real>& to) {
    for (Index lane = 0; lane < count; ++lane)
        if (isInRange(rows[lane], to)) return true;
    return false;
}

/// Writes components `from` to `from` + width − 1 of the rows of a panel, plus their addend.
template <int width, class Real>
void storeLanesPlusAddend(const Real (&results)[width][kLanes<Real>], const Index* rows,
                          Index count, Offset from, const Destination<Real>& to) {
    const AddendPlaces<width> places(from, to.addendLength);
    for (Index lane = 0; lane < count; ++lane) {
        if (!isInRange(rows[lane], to)) continue;
        Real* result = to.values + rows[lane] * to.stride + from;
        const Real* own = to.addend + rows[lane] * to.addendStride;
        for (int c = 0; c < width; ++c) result[c] = results[c][lane] + own[places.at[c]];
    }
}

/// Writes components `from` to `from` + width − 1 of the rows of a panel.
template <int width, class Real>
void storeLanes(const Real (&results)[width][kLanes<Real>], const Index* rows, Index count,
                Offset from, const Destination<Real>& to) {
    if (to.addend != nullptr) return storeLanesPlusAddend<width>(results, rows, count, from, to);
    // Stores two components at a time: one store costs as much as several additions.
    using Pair = typename PairOf<Real>::Type;
    const auto store = [&](Index lane, Offset stride) {
        Real* result = to.values + rows[lane] * stride + from;
        int c = 0;
        for (; c + 1 < width; c += 2)
            *reinterpret_cast<Pair*>(result + c) = Pair{results[c][lane], results[c + 1][lane]};
        if (c < width) result[c] = results[c][lane];
    };
    if (to.isWhole && count == kLanes<Real> && to.stride == 3) {
        for (Index lane = 0; lane < kLanes<Real>; ++lane) store(lane, 3);
    } else {
        for (Index lane = 0; lane < count; ++lane)
            if (isInRange(rows[lane], to)) store(lane, to.stride);
    }
}

/// Evaluates components `from` to `from` + width − 1 of one panel.
template <int width, class Real>
void evaluatePanel(const PanelRun<Real>& run, const Real* weights, const Index* rows, Index count,
                   Offset from, const Destination<Real>& to) {
    constexpr int lanes = kLanes<Real>, registerSize = kRegister<Real>,
                  parts = lanes / registerSize;
    using V = typename Vector<Real, registerSize>::Type;
    alignas(64) Real results[width][lanes];
    // Evaluates one register of rows at a time, with two sums for each component: each addition to
    // a single sum would have to wait for the one before.
    for (int part = 0; part < parts; ++part) {
        V even[width] = {}, odd[width] = {};
        const Real* points = run.points + from;
        const Real* own = weights + part * registerSize;
        Index k = 0;
        for (; k + 1 < run.columnCount; k += 2) {
            const V& first = at<V>(own);
            const V& second = at<V>(own + lanes);
            for (int c = 0; c < width; ++c) even[c] += first * points[c];
            for (int c = 0; c < width; ++c) odd[c] += second * points[run.pointStride + c];
            own += 2 * lanes;
            points += 2 * run.pointStride;
        }
        if (k < run.columnCount)
            for (int c = 0; c < width; ++c) even[c] += at<V>(own) * points[c];
        for (int c = 0; c < width; ++c)
            *reinterpret_cast<V*>(results[c] + part * registerSize) = even[c] + odd[c];
    }
    storeLanes<width>(results, rows, count, from, to);
}

/// Adds a product to a sum, or begins the sum with it: without fused products, 0 + product would
/// take an eighth of the time.
template <int width, class V>
void beginOrAdd(bool isFirst, const V& factor, const V (&values)[width], V (&sum)[width]) {
    if (isFirst)
        for (int d = 0; d < width; ++d) sum[d] = factor * values[d];
    else
        for (int d = 0; d < width; ++d) sum[d] += factor * values[d];
}

/// Does the same for a panel of outer products: sums along axis 0, then sums of these along axis 1,
/// then along axis 2.
/// \tparam fixed the size along axis 0, for which the inner loop is unrolled; 0 for any size
template <int width, int fixed, class Real>
void evaluateProduct(const ProductRun<Real>& run, const Real* factors, const Index* rows,
                     Index count, Offset from, const Destination<Real>& to) {
    constexpr int lanes = kLanes<Real>, registerSize = kRegister<Real>,
                  parts = lanes / registerSize;
    using V = typename Vector<Real, registerSize>::Type;
    const Index n = fixed > 0 ? fixed : run.size[0], m = run.size[1], l = run.size[2];
    alignas(64) Real results[width][lanes];
    for (int part = 0; part < parts; ++part) {
        const Real* a = factors + part * registerSize;
        const Real* b = a + n * lanes;
        const Real* c = b + m * lanes;
        const Real* points = run.points + from;
        V all[width] = {};
        for (Index k = 0; k < l; ++k) {
            V plane[width] = {};
            for (Index j = 0; j < m; ++j) {
                V line[width];
                for (int d = 0; d < width; ++d) line[d] = at<V>(a) * points[d];
                points += run.pointStride;
                for (Index i = 1; i < n; ++i) {
                    const V& factor = at<V>(a + i * lanes);
                    for (int d = 0; d < width; ++d) line[d] += factor * points[d];
                    points += run.pointStride;
                }
                beginOrAdd<width>(j == 0, at<V>(b + j * lanes), line, plane);
            }
            beginOrAdd<width>(k == 0, at<V>(c + k * lanes), plane, all);
        }
        for (int d = 0; d < width; ++d)
            *reinterpret_cast<V*>(results[d] + part * registerSize) = all[d];
    }
    storeLanes<width>(results, rows, count, from, to);
}

/// Panels with at most this many columns are evaluated row by row, with components in the lanes, if
/// there are more than four components: these are then read and written contiguously. With twelve
/// components, rows of 8 entries take a third of the time; rows of 42 entries gain nothing.
constexpr Index kMaxWideColumns = 16;

/// Evaluates components `from` to `from` + width − 1 of one row of a panel. `width` fills one
/// register or a few.
/// \param weights the weight of the first column; weights of consecutive columns are kLanes apart
template <int width, class Real>
void evaluateComponents(const Real* weights, const Real* points, Offset pointStride,
                        Index columnCount, Real* result) {
    using V = typename Vector<Real, width>::Type;
    // Copied, since the address need not be aligned: a vector type with reduced alignment loses
    // that attribute as a template argument.
    const auto add = [&](V& sum, Index k) {
        V own;
        __builtin_memcpy(&own, points + k * pointStride, sizeof own);
        sum += weights[k * kLanes<Real>] * own;
    };
    V even = {}, odd = {};
    Index k = 0;
    for (; k + 1 < columnCount; k += 2) {
        add(even, k);
        add(odd, k + 1);
    }
    if (k < columnCount) add(even, k);
    const V sum = even + odd;
    __builtin_memcpy(result, &sum, sizeof sum);
}

/// Adds the entry `own` of the addend to all components of a result, four at a time.
template <class Real>
void addToRow(const Real* own, const Destination<Real>& to, Real* result) {
    using V = typename Vector<Real, 4>::Type;
    Offset c = 0;
    if (to.addendLength == 3) {
        // Points: the same three vectors follow each other.
        const V added[3] = {{own[0], own[1], own[2], own[0]},
                            {own[1], own[2], own[0], own[1]},
                            {own[2], own[0], own[1], own[2]}};
        for (int k = 0; c + 4 <= to.length; c += 4, k = k < 2 ? k + 1 : 0) {
            V sum;
            __builtin_memcpy(&sum, result + c, sizeof sum);
            sum += added[k];
            __builtin_memcpy(result + c, &sum, sizeof sum);
        }
    }
    for (; c < to.length; ++c) result[c] += own[c % to.addendLength];
}

/// Evaluates a panel of few columns row by row.
template <class Real>
void evaluateWidePanel(const Real* weights, const Real* points, Offset pointStride,
                       Index columnCount, const Index* rows, Index count,
                       const Destination<Real>& to) {
    constexpr int registerSize = kRegister<Real>;
    for (Index lane = 0; lane < count; ++lane) {
        if (!isInRange(rows[lane], to)) continue;
        Real* result = to.values + rows[lane] * to.stride;
        Offset c = 0;
        for (; c + registerSize <= to.length; c += registerSize)
            evaluateComponents<registerSize>(weights + lane, points + c, pointStride, columnCount,
                                             result + c);
        for (; c + 4 <= to.length; c += 4)
            evaluateComponents<4>(weights + lane, points + c, pointStride, columnCount, result + c);
        for (; c < to.length; ++c)
            evaluateComponents<1>(weights + lane, points + c, pointStride, columnCount, result + c);
        if (to.addend != nullptr) addToRow(to.addend + rows[lane] * to.addendStride, to, result);
    }
}

/// Computes the weights of a panel of outer products with few columns.
template <class Real>
void multiplyOut(const Real* factors, const Index (&size)[3], Real* weights) {
    constexpr int lanes = kLanes<Real>, registerSize = kRegister<Real>;
    using V = typename Vector<Real, registerSize>::Type;
    const Real *a = factors, *b = a + size[0] * lanes, *c = b + size[1] * lanes;
    for (Index k = 0; k < size[2]; ++k)
        for (Index j = 0; j < size[1]; ++j)
            for (int part = 0; part < lanes; part += registerSize) {
                const V plane = at<V>(c + k * lanes + part) * at<V>(b + j * lanes + part);
                Real* to = weights + (k * size[1] + j) * size[0] * lanes + part;
                for (Index i = 0; i < size[0]; ++i)
                    *reinterpret_cast<V*>(to + i * lanes) = plane * at<V>(a + i * lanes + part);
            }
}

template <class Real>
void evaluatePanels(const PanelRun<Real>& run, const Destination<Real>& to) {
    constexpr Index lanes = kLanes<Real>;
    const Real* weights = run.weights;
    for (Index first = 0; first < run.rowCount; first += lanes) {
        const Index count = run.rowCount - first < lanes ? run.rowCount - first : lanes;
        if (to.length > 4 && run.columnCount <= kMaxWideColumns)
            evaluateWidePanel(weights, run.points, run.pointStride, run.columnCount,
                              run.rows + first, count, to);
        else if (isAnyInRange(run.rows + first, count, to))
            forComponents(to.length, [&]<int width>(Offset from) {
                evaluatePanel<width>(run, weights, run.rows + first, count, from, to);
            });
        weights += static_cast<Offset>(run.columnCount) * lanes;
    }
}

template <class Real>
void evaluateProducts(const ProductRun<Real>& run, const Destination<Real>& to) {
    constexpr Index lanes = kLanes<Real>;
    const Real* factors = run.factors;
    const Index columnCount = run.size[0] * run.size[1] * run.size[2];
    const bool isWide = to.length > 4 && columnCount <= kMaxWideColumns;
    alignas(64) Real weights[kMaxWideColumns * lanes];
    for (Index first = 0; first < run.rowCount; first += lanes) {
        const Index count = run.rowCount - first < lanes ? run.rowCount - first : lanes;
        if (!isAnyInRange(run.rows + first, count, to)) {
            // Nothing to do.
        } else if (isWide) {
            multiplyOut(factors, run.size, weights);
            evaluateWidePanel(weights, run.points, run.pointStride, columnCount, run.rows + first,
                              count, to);
        } else {
            forComponents(to.length, [&]<int width>(Offset from) {
                if (run.size[0] == 4)
                    evaluateProduct<width, 4>(run, factors, run.rows + first, count, from, to);
                else
                    evaluateProduct<width, 0>(run, factors, run.rows + first, count, from, to);
            });
        }
        factors += (run.size[0] + run.size[1] + run.size[2]) * lanes;
    }
}
