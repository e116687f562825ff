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

/// Returns true if all of some rows are in the range.
template <class Real>
bool areAllInRange(const Index* rows, Index count, const Destination<Real>& to) {
    for (Index i = 0; i < count; ++i)
        if (!isInRange(rows[i], to)) return false;
    return true;
}

/// Writes components `from` to `from` + width − 1 of the rows of a panel, plus their addend.
template <int width, class Real>
void storeLanesPlusAddend(const Real (&results)[width][kLanes<Real>], const Index* rows,
                          Index count, Offset from, const Destination<Real>& to) {
    const AddendSlots<width> slots(from, to.addendLength);
    for (Index lane = 0; lane < count; ++lane) {
        if (!isInRange(rows[lane], to)) continue;
        Real* result = to.values + rows[lane] * to.stride + from;
        const Real* own = to.addend + rows[lane] * to.addendStride;
        for (int c = 0; c < width; ++c) result[c] = results[c][lane] + own[slots.at[c]];
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
            for (int c = 0; c < width; ++c) addProduct(even[c], first, points[c]);
            for (int c = 0; c < width; ++c) addProduct(odd[c], second, points[run.pointStride + c]);
            own += 2 * lanes;
            points += 2 * run.pointStride;
        }
        if (k < run.columnCount)
            for (int c = 0; c < width; ++c) addProduct(even[c], at<V>(own), points[c]);
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
        for (int d = 0; d < width; ++d) addProduct(sum[d], factor, values[d]);
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
                    for (int d = 0; d < width; ++d) addProduct(line[d], factor, points[d]);
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

/// Panels with at most this many columns are evaluated with components in the lanes, if there are
/// more than four components and they fill a register: they are then read and written contiguously.
/// Rows of 42 entries gain nothing.
constexpr Index kMaxWideColumns = 16;

/// Returns true if a group is evaluated with components in the lanes.
template <class Real>
bool isWide(Index columnCount, const Destination<Real>& to) {
    return columnCount <= kMaxWideColumns && to.length > 4 && to.length >= kRegister<Real>;
}

/// Evaluates `registers` × `width` components of consecutive rows of a panel, from `from` on.
/// \param weights the first row's weight of the first column; weights of consecutive rows are
///        adjacent, and weights of consecutive columns kLanes apart
template <int registers, int width, int rowCount, class Real>
void evaluateComponents(const Real* weights, const Real* points, Offset pointStride,
                        Index columnCount, const Index* rows, Offset from,
                        const Destination<Real>& to) {
    using V = typename Vector<Real, width>::Type;
    // Loops over the sums are unrolled, so that the sums are in registers.
    V sums[rowCount * registers] = {};
    for (Index k = 0; k < columnCount; ++k) {
        // Copied, since the address need not be aligned: a vector type with reduced alignment loses
        // that attribute as a template argument.
        V own[registers];
#pragma GCC unroll 4
        for (int r = 0; r < registers; ++r)
            __builtin_memcpy(&own[r], points + k * pointStride + from + r * width, sizeof(V));
#pragma GCC unroll 4
        for (int i = 0; i < rowCount; ++i)
#pragma GCC unroll 4
            for (int r = 0; r < registers; ++r)
                addProduct(sums[i * registers + r], own[r], weights[k * kLanes<Real> + i]);
    }
#pragma GCC unroll 4
    for (int i = 0; i < rowCount; ++i)
#pragma GCC unroll 4
        for (int r = 0; r < registers; ++r)
            __builtin_memcpy(to.values + rows[i] * to.stride + from + r * width,
                             &sums[i * registers + r], sizeof(V));
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

/// Evaluates consecutive rows of a panel of few columns.
template <int rowCount, class Real>
void evaluateWideRows(const Real* weights, const Real* points, Offset pointStride,
                      Index columnCount, const Index* rows, const Destination<Real>& to) {
    Offset from = 0;
    const auto evaluate = [&]<int registers, int width>() {
        for (; from + registers * width <= to.length; from += registers * width)
            evaluateComponents<registers, width, rowCount>(weights, points, pointStride,
                                                           columnCount, rows, from, to);
    };
    evaluate.template operator()<2, kRegister<Real>>();
    evaluate.template operator()<1, kRegister<Real>>();
    evaluate.template operator()<1, 4>();
    if (from < to.length) {
        from = to.length - 4;  // evaluates some components again
        evaluate.template operator()<1, 4>();
    }
    if (to.addend == nullptr) return;
    for (int i = 0; i < rowCount; ++i)
        addToRow(to.addend + rows[i] * to.addendStride, to, to.values + rows[i] * to.stride);
}

/// Prepares the cache for writing the result of a row.
template <class Real>
void prefetchResult(Index row, const Destination<Real>& to) {
    constexpr Offset kLine = 64 / sizeof(Real);
    const Real* const result = to.values + row * to.stride;
    for (Offset c = 0; c < to.length; c += kLine) __builtin_prefetch(result + c, 1);
    __builtin_prefetch(result + to.length - 1, 1);
}

/// Evaluates a panel of few columns, several rows at a time: these share the loads of the source.
/// \param rowsLeft number of rows from `rows` on, at least `count`
template <class Real>
void evaluateWidePanel(const Real* weights, const Real* points, Offset pointStride,
                       Index columnCount, const Index* rows, Index count, Index rowsLeft,
                       const Destination<Real>& to) {
    constexpr Index kRowsAtOnce = 4;
    // Results may be anywhere in memory. Without prefetching, large surfaces take a quarter longer.
    constexpr Index kRowsAhead = 8;
    const auto evaluate = [&]<int rowCount>(Index lane) {
        for (Index i = lane + kRowsAhead; i < lane + kRowsAhead + rowCount && i < rowsLeft; ++i)
            if (isInRange(rows[i], to)) prefetchResult(rows[i], to);
        evaluateWideRows<rowCount>(weights + lane, points, pointStride, columnCount, rows + lane,
                                   to);
    };
    for (Index lane = 0; lane < count;) {
        if (lane + kRowsAtOnce <= count && areAllInRange(rows + lane, kRowsAtOnce, to)) {
            evaluate.template operator()<kRowsAtOnce>(lane);
            lane += kRowsAtOnce;
        } else {
            if (isInRange(rows[lane], to)) evaluate.template operator()<1>(lane);
            ++lane;
        }
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
        if (isWide(run.columnCount, to))
            evaluateWidePanel(weights, run.points, run.pointStride, run.columnCount,
                              run.rows + first, count, run.rowCount - first, to);
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
    alignas(64) Real weights[kMaxWideColumns * lanes];
    for (Index first = 0; first < run.rowCount; first += lanes) {
        const Index count = run.rowCount - first < lanes ? run.rowCount - first : lanes;
        if (!isAnyInRange(run.rows + first, count, to)) {
            // Nothing to do.
        } else if (isWide(columnCount, to)) {
            multiplyOut(factors, run.size, weights);
            evaluateWidePanel(weights, run.points, run.pointStride, columnCount, run.rows + first,
                              count, run.rowCount - first, to);
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
