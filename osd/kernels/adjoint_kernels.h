// SPDX-License-Identifier: Apache-2.0
// Kernels of the adjoint. Part of kernels_body.h.

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
    return load<typename Vector<Real, kRegister<Real>>::Type>(numbers);
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
            for (int d = 0; d < width; ++d) addProduct(all[r * width + d], own, values[d]);
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
                    const Offset slot = 4 * j + i;
                    result[from + d] =
                        sums[k * sumStride + slot / lanes * partStride + d * lanes + slot % lanes];
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
