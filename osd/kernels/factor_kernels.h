// SPDX-License-Identifier: Apache-2.0
// Kernels of compilation: rows side by side, and their factors. Part of kernels_body.h.

/// Puts numbers k to k + 3 of four rows side by side. They are 16 bytes, which every processor has
/// a register for.
inline void interleaveBlock(const float* const* rows, Offset k, float* to) {
    using V = Vector<float, 4>::Type;
    const V a = load<V>(rows[0] + k), b = load<V>(rows[1] + k);
    const V c = load<V>(rows[2] + k), d = load<V>(rows[3] + k);
    const V ab01 = __builtin_shufflevector(a, b, 0, 4, 1, 5);
    const V ab23 = __builtin_shufflevector(a, b, 2, 6, 3, 7);
    const V cd01 = __builtin_shufflevector(c, d, 0, 4, 1, 5);
    const V cd23 = __builtin_shufflevector(c, d, 2, 6, 3, 7);
    const auto store = [&](int i, V numbers) {
        *reinterpret_cast<V*>(to + i * kLanes<float>) = numbers;
    };
    store(0, __builtin_shufflevector(ab01, cd01, 0, 1, 4, 5));
    store(1, __builtin_shufflevector(ab01, cd01, 2, 3, 6, 7));
    store(2, __builtin_shufflevector(ab23, cd23, 0, 1, 4, 5));
    store(3, __builtin_shufflevector(ab23, cd23, 2, 3, 6, 7));
}

/// Puts numbers k and k + 1 of two rows side by side.
inline void interleaveBlock(const double* const* rows, Offset k, double* to) {
    using V = Vector<double, 2>::Type;
    const V a = load<V>(rows[0] + k), b = load<V>(rows[1] + k);
    *reinterpret_cast<V*>(to) = __builtin_shufflevector(a, b, 0, 2);
    *reinterpret_cast<V*>(to + kLanes<double>) = __builtin_shufflevector(a, b, 1, 3);
}

template <class Real>
void interleave(const Real* const* rows, Offset length, Real* to) {
    constexpr Offset kBlock = 16 / sizeof(Real);
    Offset k = 0;
    for (; k + kBlock <= length; k += kBlock)
        for (Index lane = 0; lane < kLanes<Real>; lane += kBlock)
            interleaveBlock(rows + lane, k, to + k * kLanes<Real> + lane);
    for (; k < length; ++k)
        for (Index lane = 0; lane < kLanes<Real>; ++lane)
            to[k * kLanes<Real> + lane] = rows[lane][k];
}

/// Defines vectors with one row in each lane. Weights are added up in a type with more digits,
/// `Wide`. For float this is double, which all processors compute with. For double it is long
/// double, of which there are no vectors, and which is emulated on ARM and in WebAssembly.
template <class Real>
struct RowLanes;

template <>
struct RowLanes<float> {
    // Eight rows in a register of AVX-512 take longer (Zen 4).
    static constexpr int count = kRegister<double> < 4 ? kRegister<double> : 4;
    using Wide = double;
    using Doubles = Vector<double, count>::Type;
    using Wides = Doubles;
    using Floats = Vector<float, count>::Type;
    using Bits = Vector<long long, count>::Type;

    static Doubles loaded(const float* weights) {
        return converted(weights, std::make_integer_sequence<int, count>());
    }
    static Wides widened(const Doubles& numbers) { return numbers; }
    /// Rounds numbers and stores them.
    static void store(const Wides& numbers, float* to) {
        const auto floats = __builtin_convertvector(numbers, Floats);
        __builtin_memcpy(to, &floats, sizeof floats);
    }
    static Doubles size(const Doubles& numbers) {
        constexpr long long kSign = 1LL << 63;
        return reinterpret_cast<Doubles>(reinterpret_cast<Bits>(numbers) & ~kSign);
    }

private:
    /// GCC would convert a vector in two halves.
    template <int... lane>
    static Doubles converted(const float* weights, std::integer_sequence<int, lane...>) {
        return Doubles{static_cast<double>(weights[lane])...};
    }
};

template <>
struct RowLanes<double> {
    static constexpr int count = 1;
    using Wide = long double;
    using Doubles = double;
    using Wides = long double;

    static Doubles loaded(const double* weights) { return *weights; }
    static Wides widened(double number) { return number; }
    static void store(Wides number, double* to) { *to = static_cast<double>(number); }
    static double size(double number) { return __builtin_fabs(number); }
    static Wides size(Wides number) { return __builtin_fabsl(number); }
};

/// Returns the larger number in each lane; `a` if one is not a number.
template <class Numbers>
Numbers larger(const Numbers& a, const Numbers& b) {
    return a < b ? b : a;
}

/// Computes the factors of some rows, one row in each lane. Rows side by side do not wait for the
/// additions of one row. The result of a row does not depend on the other rows.
template <class Real>
class RowFactors {
public:
    explicit RowFactors(const FactorRun<Real>& run)
        : sources_(run.sources), n_(run.size[0]), m_(run.size[1]), l_(run.size[2]) {}

    /// Computes the factors.
    /// \param given the weights: number k of each row from given[k · kLanes] on
    /// \param hasSign true if any weight is negative or −0
    /// \param factors gets the factors: number k of each row from factors[k · kLanes] on
    void compute(const Real* given, bool hasSign, Real* factors) {
        // Cubic splines have four factors along an axis.
        if (n_ == 4)
            compute<4>(given, hasSign, factors);
        else
            compute<0>(given, hasSign, factors);
    }

    /// Returns true if a row is an outer product.
    bool isProduct(int row) const {
        // Tiny weights have fewer digits, or are rounded to 0: they may be off by kTiny, which must
        // be far below the largest weight. The total is not finite if a weight is not.
        return of(largest_, row) * kEpsilon >= kTiny && of(total_, row) - of(total_, row) == 0 &&
               of(excess_, row) <= kTiny;
    }

private:
    using Lanes = RowLanes<Real>;
    using Doubles = typename Lanes::Doubles;
    using Wide = typename Lanes::Wide;
    using Wides = typename Lanes::Wides;
    static constexpr Wide kEpsilon = std::numeric_limits<Real>::epsilon();
    static constexpr Wide kTiny = std::numeric_limits<Real>::min();

    /// Returns the number of a row.
    static double of(const Doubles& numbers, int row) {
        return reinterpret_cast<const double*>(&numbers)[row];
    }
    static long double of(const long double& number, int) { return number; }

    /// \tparam fixed the size along axis 0, if it is known, so that sums stay in registers; or 0
    template <int fixed>
    void compute(const Real* given, bool hasSign, Real* factors) {
        addUp<fixed>(given);
        const Index count = n_ + m_ + l_;
        for (Index f = 0; f < count; ++f)
            Lanes::store(f < n_ ? sums_[f] : sums_[f] / total_, factors + f * kLanes<Real>);
        if (hasSign)
            for (int row = 0; row < Lanes::count; ++row) setSigns(row, factors + row);
        for (Index f = 0; f < count; ++f)
            sums_[f] = Lanes::widened(Lanes::loaded(factors + f * kLanes<Real>));
        check<fixed>();
    }

    /// Adds up the absolute weights over two axes, for each slot of the third.
    template <int fixed>
    void addUp(const Real* given) {
        // The factors follow from these sums. Each weight is rounded. The relative error of a sum
        // is smaller than the relative errors of its weights, if the sum itself is not rounded.
        const Index n = fixed == 0 ? n_ : fixed, m = m_, l = l_;
        Wides first[fixed == 0 ? kMaxProductColumns : fixed];
        for (Index i = 0; i < n; ++i) first[i] = Wides{};
        Wides *const second = sums_ + n, *const third = second + m;
        for (Index j = 0; j < m; ++j) second[j] = Wides{};
        Wides total{};
        Doubles largest{};
        const Index* source = sources_;
        Doubles* weight = weights_;
        for (Index k = 0; k < l; ++k) {
            Wides plane{};
            for (Index j = 0; j < m; ++j) {
                Wides line{};
                for (Index i = 0; i < n; ++i) {
                    const Doubles own = Lanes::loaded(given + Offset{*source++} * kLanes<Real>);
                    *weight++ = own;
                    const Doubles size = Lanes::size(own);
                    largest = larger(size, largest);
                    first[i] += Lanes::widened(size);
                    line += Lanes::widened(size);
                }
                second[j] += line;
                plane += line;
            }
            third[k] = plane;
            total += plane;
        }
        for (Index i = 0; i < n; ++i) sums_[i] = first[i];
        total_ = total;
        largest_ = largest;
    }

    /// Sets the signs of the factors of a row. They follow from the three lines through the largest
    /// weight. The sign of that weight itself goes to the factor of axis 0.
    void setSigns(int row, Real* factors) const {
        const Index count = n_ * m_ * l_;
        Index at = 0;
        while (at < count && of(Lanes::size(weights_[at]), row) != of(largest_, row)) ++at;
        if (at == count) return;  // no weight is a number
        const Index i0 = at % n_, j0 = at / n_ % m_, k0 = at / n_ / m_;
        const auto isNegative = [&](Index i, Index j, Index k) {
            return __builtin_signbit(of(weights_[(k * m_ + j) * n_ + i], row)) != 0;
        };
        const bool isLargestNegative = isNegative(i0, j0, k0);
        const auto negateIf = [&](bool isNegated, Index factor) {
            if (isNegated) factors[factor * kLanes<Real>] *= -1;
        };
        for (Index i = 0; i < n_; ++i) negateIf(isNegative(i, j0, k0), i);
        for (Index j = 0; j < m_; ++j) negateIf(isNegative(i0, j, k0) != isLargestNegative, n_ + j);
        for (Index k = 0; k < l_; ++k)
            negateIf(isNegative(i0, j0, k) != isLargestNegative, n_ + m_ + k);
    }

    /// Compares the products of the factors with the weights.
    template <int fixed>
    void check() {
        constexpr Wide kBound = 3 * kEpsilon;
        const Index n = fixed == 0 ? n_ : fixed, m = m_, l = l_;
        const Wides *const first = sums_, *const second = first + n, *const third = second + m;
        Wides excess = Wides{} - 1;
        const Doubles* weight = weights_;
        for (Index k = 0; k < l; ++k)
            for (Index j = 0; j < m; ++j) {
                const Wides other = second[j] * third[k];
                for (Index i = 0; i < n; ++i, ++weight) {
                    const Wides own = Lanes::widened(*weight);
                    const Wides distance = Lanes::size(first[i] * other - own);
                    excess = larger(excess, distance - kBound * Lanes::size(own));
                }
            }
        excess_ = excess;
    }

    const Index* sources_;
    Index n_, m_, l_;
    // The sum of three factors of kMaxProductColumns is largest if two of them are 1.
    Wides sums_[kMaxProductColumns + 2];   ///< later the factors
    Doubles weights_[kMaxProductColumns];  ///< weights in the order of the product
    Wides total_;
    Doubles largest_;
    Wides excess_;  ///< larger than kTiny if a product is farther from its weight than allowed
};

/// Returns true if any number is negative or −0.
/// \param numbers, count whole registers, aligned
template <class Real>
bool hasSign(const Real* numbers, Offset count) {
    using V = typename Vector<long long, kRegister<long long>>::Type;
    V bits{};
    for (Offset k = 0; k < count; k += kRegister<Real>)
        bits |= *reinterpret_cast<const V*>(numbers + k);
    long long all = 0;
    for (int k = 0; k < kRegister<long long>; ++k) all |= bits[k];
    constexpr unsigned long long kSigns = sizeof(Real) == 4 ? 0x8000000080000000 : 1ULL << 63;
    return (static_cast<unsigned long long>(all) & kSigns) != 0;
}

template <class Real>
void factorize(const FactorRun<Real>& run, Real* factors, char* isProduct) {
    constexpr Index lanes = kLanes<Real>, atOnce = RowLanes<Real>::count;
    const Index length = run.size[0] + run.size[1] + run.size[2];
    Real* const given = run.memory;
    Real* const zeros = given + Offset{run.weightCount} * lanes;
    Real* const results = zeros + lanes;
    for (Index lane = 0; lane < lanes; ++lane) zeros[lane] = 0;
    RowFactors<Real> rows(run);
    for (Index first = 0; first < run.rowCount; first += lanes) {
        // If fewer rows are left, the last one is repeated.
        const Index count = run.rowCount - first < lanes ? run.rowCount - first : lanes;
        const Real* own[lanes];
        for (Index lane = 0; lane < lanes; ++lane)
            own[lane] = run.weights[first + (lane < count ? lane : count - 1)];
        interleave(own, run.weightCount, given);
        const bool anySign = hasSign(given, Offset{run.weightCount} * lanes);
        for (Index part = 0; part < count; part += atOnce) {
            for (Index later = first + lanes + part;
                 later < first + lanes + part + atOnce && later < run.rowCount; ++later)
                for (Index k = 0; k < run.weightCount; k += 64 / sizeof(Real))
                    __builtin_prefetch(run.weights[later] + k);
            rows.compute(given + part, anySign, results + part);
            for (Index row = part; row < count && row < part + atOnce; ++row) {
                isProduct[first + row] = rows.isProduct(static_cast<int>(row - part));
                if (!isProduct[first + row]) continue;
                for (Index f = 0; f < length; ++f) *factors++ = results[f * lanes + row];
            }
        }
    }
}
