// SPDX-License-Identifier: Apache-2.0
// The kernels. Each kernels_*.cpp includes this file once, inside its own namespace and with its
// own processor flags. Hence there is no #pragma once, and there are no includes.

/// A vector of `count` numbers. It takes several registers if a register of the processor is
/// shorter.
template <class Real, int count>
struct Vector {
    typedef Real Type __attribute__((vector_size(count * sizeof(Real)), may_alias));
};

/// Two numbers that need no more alignment than one.
template <class Real>
struct PairOf {
    typedef Real Type
        __attribute__((vector_size(2 * sizeof(Real)), aligned(sizeof(Real)), may_alias));
};

template <class V, class Real>
const V& at(const Real* address) {
    return *reinterpret_cast<const V*>(address);
}

/// How many numbers a register of this processor holds.
template <class Real>
constexpr int kRegister = ESPALIER_REGISTER_BYTES / sizeof(Real);

/// Returns true if a row is in the range to be evaluated.
template <class Real>
bool isInRange(Index row, const Destination<Real>& to) {
    return to.isWhole || (row >= to.first && row < to.last);
}

/// Returns true if any row of a panel is in the range.
template <class Real>
bool isAnyInRange(const Index* rows, Index count, const Destination<Real>& to) {
    for (Index lane = 0; lane < count; ++lane)
        if (isInRange(rows[lane], to)) return true;
    return false;
}

/// The places in an entry of the addend that components `from` to `from` + width − 1 add.
template <int width>
struct AddendPlaces {
    Offset at[width];

    AddendPlaces(Offset from, Offset addendLength) {
        if (from >= addendLength) from %= addendLength;
        for (int c = 0; c < width; ++c) {
            at[c] = from;
            from = from + 1 < addendLength ? from + 1 : 0;
        }
    }
};

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

/// Calls step<width>(from) until all components are done, at most 4 at a time.
template <class Step>
void forComponents(Offset length, Step step) {
    Offset from = 0;
    for (; from + 4 < length; from += 4) step.template operator()<4>(from);
    switch (length - from) {
        case 1:
            return step.template operator()<1>(from);
        case 2:
            return step.template operator()<2>(from);
        case 3:
            return step.template operator()<3>(from);
        default:
            return step.template operator()<4>(from);
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

/// Writes components `from` to `from` + width − 1 of rows, plus their addend.
template <int width, class Real>
class RowStore {
public:
    RowStore(Offset from, const Destination<Real>& to)
        : to_(to), from_(from), places_(from, to.addend != nullptr ? to.addendLength : 1) {}

    template <class V>
    void operator()(V sum, Index row) const {
        Real* result = to_.values + row * to_.stride + from_;
        if (to_.addend != nullptr) {
            const Real* own = to_.addend + row * to_.addendStride;
            V added = {};
            for (int c = 0; c < width; ++c) added[c] = own[places_.at[c]];
            sum += added;
        }
        for (int c = 0; c < width; ++c) result[c] = sum[c];
    }

private:
    const Destination<Real>& to_;
    Offset from_;
    AddendPlaces<width> places_;
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
            even += weights[k] * at<V>(points + columns[k] * run.pointStride);
            odd += weights[k + 1] * at<V>(points + columns[k + 1] * run.pointStride);
        }
        if (k < run.length) even += weights[k] * at<V>(points + columns[k] * run.pointStride);
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
            sums[k % 2] += weights[k] * at<V>(points + columns[k] * pointStride);
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

/// Number of registers of columns that are summed at once, so that all sums stay in registers. AVX2
/// has 16 of them; an outer product needs some for its factors.
template <int width, bool isProduct>
constexpr Index kRegistersAtOnce = ESPALIER_REGISTER_BYTES < 64 &&
                                           (width == 4 ||
                                            (isProduct && ESPALIER_REGISTER_BYTES == 32))
                                       ? 2
                                       : 4;

/// Number of columns of weights that are summed at once.
template <class Real>
constexpr Index kAdjointColumns = 4 * kRegister<Real>;

/// Returns the register of numbers that starts at an address, which need not be aligned.
template <class Real>
auto loadRegister(const Real* numbers) {
    typename Vector<Real, kRegister<Real>>::Type result;
    __builtin_memcpy(&result, numbers, sizeof result);
    return result;
}

/// The weights of one row, some registers of them.
template <class Real>
struct WeightRow {
    const Real* weights;
    auto operator()(int r) const { return loadRegister(weights + r * kRegister<Real>); }
};

/// Number of registers that hold 4 × 4 numbers.
template <class Real>
constexpr int kProductParts = 16 / kRegister<Real>;

/// The weights of one row that is an outer product with size[0] and size[1] ≤ 4. Register k has
/// part `part` of the weights a_i · b_j · c_k, with i and j from 0 to 3, i first. Those beyond the
/// size have no meaning.
template <int part, class Real>
class ProductRow {
public:
    ProductRow(const Real* a, const Index (&size)[3], Index firstK)
        : ab_(multiplied(a, a + size[0], std::make_integer_sequence<int, kRegister<Real>>())),
          c_(a + size[0] + size[1] + firstK) {}
    auto operator()(int k) const { return ab_ * c_[k]; }

private:
    using V = typename Vector<Real, kRegister<Real>>::Type;
    template <int... lane>
    static V multiplied(const Real* a, const Real* b, std::integer_sequence<int, lane...>) {
        constexpr int first = part * kRegister<Real>;
        const V fromA = loadRegister(a + first % 4), fromB = loadRegister(b + first / 4);
        return __builtin_shufflevector(fromA, fromA, (lane % 4)...) *
               __builtin_shufflevector(fromB, fromB, (lane / 4)...);
    }

    V ab_;
    const Real* c_;
};

/// Makes GCC load a vector once. It would load it again for each use otherwise, which makes
/// surfaces 14 % slower.
template <class V>
void keepInRegister([[maybe_unused]] V& vector) {
#ifdef __x86_64__
    asm("" : "+v"(vector));
#endif
}

/// Adds Σ weight · value over some rows to the sums of some registers of columns.
/// \param weightsOf returns the weights of row i, a WeightRow or a ProductRow
/// \param sums width × kRegister for each register; those of consecutive registers are `sumStride`
///        apart
template <int width, int registers, class Real, class WeightsOf>
void addRows(const RowValues<Real>& source, Offset from, const Index* rows, Index rowCount,
             WeightsOf weightsOf, Real* sums, Offset sumStride) {
    using V = typename Vector<Real, kRegister<Real>>::Type;
    V all[registers * width] = {};
    for (Index i = 0; i < rowCount; ++i) {
        const auto weights = weightsOf(i);
        const Real* const values = source.values + rows[i] * source.stride + from;
        // Unrolled, so that the sums are in registers.
#pragma GCC unroll 4
        for (int r = 0; r < registers; ++r) {
            V own = weights(r);
            keepInRegister(own);
#pragma GCC unroll 4
            for (int d = 0; d < width; ++d) all[r * width + d] += own * values[d];
        }
    }
#pragma GCC unroll 16
    for (int e = 0; e < registers * width; ++e)
        reinterpret_cast<V*>(sums + e / width * sumStride)[e % width] += all[e];
}

/// Calls step<registers>(first) for `count` registers, at most `atOnce` at a time.
template <Index atOnce, class Step>
void forRegisters(Index count, Step step) {
    Index first = 0;
    for (; first + atOnce <= count; first += atOnce) step.template operator()<atOnce>(first);
    switch (count - first) {
        case 1:
            return step.template operator()<1>(first);
        case 2:
            return step.template operator()<2>(first);
        case 3:
            return step.template operator()<3>(first);
    }
}

/// Evaluates components `from` to `from` + width − 1 of a group of rows with weights.
template <int width, class Real>
void sumWeightedRows(const AdjointRun<Real>& run, const RowValues<Real>& source, Offset from,
                     Real* result, Real* sums) {
    constexpr Offset lanes = kRegister<Real>, sumStride = width * lanes;
    const Offset columns = run.columnCount;
    for (Offset e = 0; e < (columns + lanes - 1) / lanes * sumStride; ++e) sums[e] = 0;
    for (Index first = 0; first < run.rowCount; first += kAdjointRows) {
        const Index count =
            run.rowCount - first < kAdjointRows ? run.rowCount - first : kAdjointRows;
        const Real* weights = run.numbers + first * columns;
        for (Offset column = 0; column < columns; column += kAdjointColumns<Real>) {
            const Offset left = columns - column,
                         atOnce = left < kAdjointColumns<Real> ? left : kAdjointColumns<Real>;
            const auto registers = static_cast<Index>((atOnce + lanes - 1) / lanes);
            forRegisters<kRegistersAtOnce<width, false>>(registers, [&]<int some>(Index r) {
                addRows<width, some>(
                    source, from, run.rows + first, count,
                    [&](Index i) { return WeightRow<Real>{weights + i * atOnce + r * lanes}; },
                    sums + (column / lanes + r) * sumStride, sumStride);
            });
            weights += count * atOnce;
        }
    }
    for (Offset column = 0; column < columns; ++column)
        for (int d = 0; d < width; ++d)
            result[column * source.length + from + d] =
                sums[column / lanes * sumStride + d * lanes + column % lanes];
}

/// Does the same for a group of outer products.
template <int width, class Real>
void sumProductRows(const AdjointRun<Real>& run, const RowValues<Real>& source, Offset from,
                    Real* result, Real* sums) {
    constexpr Offset lanes = kRegister<Real>, partStride = width * lanes,
                     sumStride = kProductParts<Real> * partStride;
    const Index(&size)[3] = run.size;
    const Offset numbersPerRow = size[0] + size[1] + size[2];
    for (Offset e = 0; e < size[2] * sumStride; ++e) sums[e] = 0;
    for (Index first = 0; first < run.rowCount; first += kAdjointRows) {
        const Index count =
            run.rowCount - first < kAdjointRows ? run.rowCount - first : kAdjointRows;
        const Real* const factors = run.numbers + first * numbersPerRow;
        const auto addPart = [&]<int part>() {
            forRegisters<kRegistersAtOnce<width, true>>(size[2], [&]<int some>(Index k) {
                addRows<width, some>(
                    source, from, run.rows + first, count,
                    [&](Index i) {
                        return ProductRow<part, Real>(factors + i * numbersPerRow, size, k);
                    },
                    sums + k * sumStride + part * partStride, sumStride);
            });
        };
        [&]<int... part>(std::integer_sequence<int, part...>) {
            (addPart.template operator()<part>(), ...);
        }
        (std::make_integer_sequence<int, kProductParts<Real>>());
    }
    for (Index k = 0; k < size[2]; ++k)
        for (Index j = 0; j < size[1]; ++j)
            for (Index i = 0; i < size[0]; ++i, result += source.length)
                for (int d = 0; d < width; ++d) {
                    const Offset place = 4 * j + i;
                    result[from + d] = sums[k * sumStride + place / lanes * partStride + d * lanes +
                                            place % lanes];
                }
}

template <class Real>
void evaluateAdjoint(const AdjointRun<Real>& run, const RowValues<Real>& source, Real* result,
                     Real* sums) {
    forComponents(source.length, [&]<int width>(Offset from) {
        if (run.size[0] == 0)
            sumWeightedRows<width>(run, source, from, result, sums);
        else
            sumProductRows<width>(run, source, from, result, sums);
    });
}

constexpr Kernels<float> kFloat = {evaluatePanels<float>, evaluateProducts<float>,
                                   evaluateRows<float>, evaluateAdjoint<float>,
                                   kAdjointColumns<float>};
constexpr Kernels<double> kDouble = {evaluatePanels<double>, evaluateProducts<double>,
                                     evaluateRows<double>, evaluateAdjoint<double>,
                                     kAdjointColumns<double>};
