// SPDX-License-Identifier: Apache-2.0
#include "spline_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "spline_weights.h"

namespace espalier::osd::device {
namespace {

using kernels::kLanes;

/// Positions of columns along one axis.
using Positions = std::array<Index, 4>;

/// A cell that has its columns among those of an axis: column k of the cell is positions[k].
struct Piece {
    Index size;
    Positions positions;
};

/// The cells that may share the columns of an axis with `size` columns. The rows of a cell inside
/// have all 4. The cell before or after it may be at a boundary; its rows have 3 of them.
std::span<const Piece> piecesOf(Index size) {
    static constexpr Piece kFour[] = {{4, {0, 1, 2, 3}}, {3, {0, 1, 2}}, {3, {3, 2, 1}}};
    static constexpr Piece kThree[] = {{3, {0, 1, 2}}, {3, {2, 1, 0}}};
    static constexpr Piece kTwo[] = {{2, {0, 1}}};
    switch (size) {
        case 4:
            return kFour;
        case 3:
            return kThree;
        case 2:
            return kTwo;
        default:
            return {};
    }
}

/// The factors of one axis of a row, as weights of a spline.
template <class Real>
struct Fit {
    std::uint8_t piece;  ///< number of the piece in piecesOf()
    Real t;
    double difference;  ///< Σ |w − w'|
};

template <class Real>
constexpr double kBound = kSplineBound* std::numeric_limits<Real>::epsilon();

/// Returns the cell and the parameter that have the factors of one axis as weights, if there are
/// any.
/// \param order the order of the columns: column k of the axis is factor order[k]
template <class Real>
std::optional<Fit<Real>> fitAxis(std::span<const Real> factors, Index spline,
                                 const Positions& order) {
    const double all = std::accumulate(factors.begin(), factors.end(), 0.0);
    const std::span<const Piece> pieces = piecesOf(static_cast<Index>(factors.size()));
    for (std::size_t p = 0; p < pieces.size(); ++p) {
        const Piece& piece = pieces[p];
        const auto factor = [&](Index k) {
            return static_cast<double>(factors[order[piece.positions[k]]]);
        };
        double sum = 0, moment = 0;
        for (Index k = 0; k < piece.size; ++k) {
            sum += factor(k);
            moment += k * factor(k);
        }
        // The cell starts at column 1 inside, and at column 0 at a boundary. The quotient is not a
        // number if the sum is 0, as in rows of derivatives.
        const double start = piece.size == 4 ? 1.5 : 0.5;
        const auto t = static_cast<Real>(std::clamp(moment / sum - start, -0.5, 0.5));
        Real weights[4];
        splineWeights(spline, piece.size, t, weights);
        double difference = std::abs(all - sum);
        for (Index k = 0; k < piece.size; ++k)
            difference += std::abs(factor(k) / sum - static_cast<double>(weights[k]));
        if (difference <= kBound<Real>)
            return Fit<Real>{static_cast<std::uint8_t>(p), t, difference};
    }
    return std::nullopt;
}

/// Returns the order of the columns in which all factors of an axis are weights of a spline, if
/// there is one.
/// \param rows the factors of one axis of some rows
template <class Real>
std::optional<Positions> findOrder(std::span<const std::span<const Real>> rows, Index spline) {
    Positions order = {};
    const auto last = order.begin() + static_cast<std::ptrdiff_t>(rows[0].size());
    std::iota(order.begin(), last, 0);
    do {
        if (std::all_of(rows.begin(), rows.end(), [&](std::span<const Real> factors) {
                return fitAxis(factors, spline, order).has_value();
            }))
            return order;
    } while (std::next_permutation(order.begin(), last));
    return std::nullopt;
}

template <class Real>
class SplineFinder {
public:
    using Group = typename CompiledRows<Real>::Group;

    explicit SplineFinder(CompiledRows<Real>& rows) : old_(rows) {}

    std::vector<Index> run() {
        std::unordered_map<Offset, Index> uses;
        for (const Group& group : old_.groups)
            if (lengthOf(group) > 0) ++uses[group.firstNumber];
        // Kernels add the number of a lane to the address, even if there are no numbers.
        numbers_.reserve(std::max(old_.groupNumbers.size(), std::size_t{kLanes<Real>}));
        left_.resize(old_.groups.size());
        isSplit_.resize(old_.groups.size());
        for (std::size_t g = 0; g < old_.groups.size(); ++g)
            if (uses[old_.groups[g].firstNumber] == 1) findCells(g);
        for (const auto& [key, rows] : cells_) {
            if (std::ssize(rows) >= kMinRows)
                addCell(key, rows);
            else
                for (const SplineRow& row : rows) left_[row.group].push_back(row.row);
        }
        for (std::size_t g = 0; g < old_.groups.size(); ++g) addLeft(g);
        old_.groups = std::move(groups_);
        old_.groupColumns = std::move(columns_);
        old_.groupNumbers = std::move(numbers_);
        old_.groupRows = std::move(rows_);
        return std::move(splines_);
    }

private:
    /// Minimum number of rows of a cell: fewer would take more memory than their factors.
    static constexpr std::ptrdiff_t kMinRows = kLanes<Real>;

    /// The factors of a row, axis after axis.
    using Factors = std::array<Real, 12>;

    /// A cell: Group::spline, and the size and the columns of the product.
    struct Cell {
        Index spline;
        std::array<Index, 3> size;
        std::vector<Index> columns;

        // Not a default <=>: the standard library of WebAssembly's compiler has none for vectors.
        friend bool operator<(const Cell& a, const Cell& b) {
            return std::tie(a.spline, a.size, a.columns) < std::tie(b.spline, b.size, b.columns);
        }
    };

    struct SplineRow {
        std::size_t group;
        Index row;
        std::array<Real, 3> parameters;
    };

    static std::size_t lengthOf(const Group& group) {
        return group.size[0] == 0 ? group.columnCount
                                  : group.size[0] + group.size[1] + group.size[2];
    }

    Factors factorsOf(const Group& group, Index row) const {
        constexpr Index lanes = kLanes<Real>;
        const std::size_t length = lengthOf(group);
        const Real* next = old_.groupNumbers.data() + group.firstNumber +
                           Offset{row / lanes} * lanes * static_cast<Offset>(length) + row % lanes;
        Factors factors;
        for (std::size_t k = 0; k < length; ++k, next += lanes) factors[k] = *next;
        return factors;
    }

    static std::span<const Real> axisOf(const Factors& factors, const Group& group,
                                        std::size_t axis) {
        const std::size_t first =
            std::accumulate(group.size.begin(), group.size.begin() + axis, Index{0});
        return std::span(factors).subspan(first, group.size[axis]);
    }

    std::span<const Index> columnsOf(const Group& group) const {
        return std::span(old_.groupColumns).subspan(group.firstColumn, group.columnCount);
    }

    /// Copies a group as it is. Groups that share their numbers still do.
    void keep(const Group& group) {
        const auto oldRows = std::span(old_.groupRows).subspan(group.firstRow, group.rowCount);
        const std::vector<Index> rows(oldRows.begin(), oldRows.end());
        if (lengthOf(group) == 0) {  // Its slot is the slot of the next group.
            add(group.size, columnsOf(group), rows, kNoSpline, std::ssize(numbers_));
            return;
        }
        const auto [entry, isNew] = slots_.try_emplace(group.firstNumber, std::ssize(numbers_));
        if (isNew) {
            const std::size_t panels = (group.rowCount + kLanes<Real> - 1) / kLanes<Real>;
            const Real* first = old_.groupNumbers.data() + group.firstNumber;
            numbers_.insert(numbers_.end(), first, first + panels * kLanes<Real> * lengthOf(group));
        }
        add(group.size, columnsOf(group), rows, kNoSpline, entry->second);
    }

    void add(const std::array<Index, 3>& size, std::span<const Index> columns,
             const std::vector<Index>& rows, Index spline, Offset firstNumber) {
        const auto [lowest, highest] = std::minmax_element(rows.begin(), rows.end());
        groups_.push_back({std::ssize(columns_), static_cast<Index>(columns.size()), firstNumber,
                           std::ssize(rows_), static_cast<Index>(rows.size()), *lowest, *highest,
                           size});
        columns_.insert(columns_.end(), columns.begin(), columns.end());
        rows_.insert(rows_.end(), rows.begin(), rows.end());
        splines_.push_back(spline);
    }

    /// Appends `length` numbers for each row, in panels.
    /// \return the slot of the first
    template <std::size_t size>
    Offset append(const std::vector<std::array<Real, size>>& rows, std::size_t length) {
        constexpr std::size_t lanes = kLanes<Real>;
        const std::size_t first = numbers_.size();
        numbers_.resize(first + (rows.size() + lanes - 1) / lanes * lanes * length, Real{0});
        for (std::size_t row = 0; row < rows.size(); ++row)
            for (std::size_t k = 0; k < length; ++k)
                numbers_[first + (row / lanes * length + k) * lanes + row % lanes] = rows[row][k];
        return static_cast<Offset>(first);
    }

    /// Adds the rows of a group to their cells. Cells may have rows of several groups. Rows that
    /// are no spline, and are to stay in the group, go to left_; if none is a spline, or the group
    /// is no outer product, all stay.
    void findCells(std::size_t number) {
        const Group& group = old_.groups[number];
        // Cells with 2 columns along each axis would gain little, and need another kernel.
        if (group.size[0] == 2 || std::any_of(group.size.begin(), group.size.end(),
                                              [](Index size) { return piecesOf(size).empty(); }))
            return;
        std::array<Positions, 3> orders;
        const std::optional<Index> spline = findSpline(group, orders);
        if (!spline) return;
        std::map<std::array<std::uint8_t, 3>, AxesAndRows> found;  // by their pieces
        for (Index row = 0; row < group.rowCount; ++row) {
            const Factors factors = factorsOf(group, row);
            double difference = std::abs(1 - sumOf(factors, group));
            std::array<Real, 3> t = {};
            std::array<std::uint8_t, 3> pieces = {};
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto fit = fitAxis(axisOf(factors, group, axis), *spline, orders[axis]);
                difference += fit ? fit->difference : 1;
                if (!fit) break;
                t[axis] = fit->t;
                pieces[axis] = fit->piece;
            }
            if (!(difference <= kBound<Real>)) {
                left_[number].push_back(row);
                continue;
            }
            auto entry = found.find(pieces);
            if (entry == found.end())
                entry = found.emplace(pieces, cellOf(group, *spline, orders, pieces)).first;
            const auto& axes = entry->second.axes;
            entry->second.rows->push_back({number, row, {t[axes[0]], t[axes[1]], t[axes[2]]}});
        }
        isSplit_[number] = !found.empty();
    }

    struct AxesAndRows {
        std::array<std::size_t, 3> axes;  ///< axis k of the cell is axis axes[k] of the group
        std::vector<SplineRow>* rows;
    };

    /// Returns the cell of some pieces. Its axes are sorted by size, as in every outer product.
    AxesAndRows cellOf(const Group& group, Index spline, const std::array<Positions, 3>& orders,
                       const std::array<std::uint8_t, 3>& pieces) {
        std::array<Piece, 3> all;
        for (std::size_t axis = 0; axis < 3; ++axis)
            all[axis] = piecesOf(group.size[axis])[pieces[axis]];
        std::array<std::size_t, 3> axes = {0, 1, 2};
        std::stable_sort(axes.begin(), axes.end(),
                         [&](std::size_t a, std::size_t b) { return all[a].size > all[b].size; });
        Cell cell = {spline, {all[axes[0]].size, all[axes[1]].size, all[axes[2]].size}, {}};
        const std::span<const Index> columns = columnsOf(group);
        for (Index k = 0; k < cell.size[2]; ++k)
            for (Index j = 0; j < cell.size[1]; ++j)
                for (Index i = 0; i < cell.size[0]; ++i) {
                    const std::array<Index, 3> slot = {i, j, k};
                    std::array<Index, 3> at;  // along the axes of the group
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        at[axes[axis]] = orders[axes[axis]][all[axes[axis]].positions[slot[axis]]];
                    cell.columns.push_back(
                        columns[(at[2] * group.size[1] + at[1]) * group.size[0] + at[0]]);
                }
        return {axes, &cells_[std::move(cell)]};
    }

    void addCell(const Cell& cell, std::span<const SplineRow> rows) {
        for (; !rows.empty(); rows = rows.subspan(std::min(rows.size(), kMaxRowsPerGroup))) {
            std::vector<std::array<Real, 3>> parameters;
            std::vector<Index> numbers;
            for (const SplineRow& row : rows.first(std::min(rows.size(), kMaxRowsPerGroup))) {
                parameters.push_back(row.parameters);
                numbers.push_back(old_.groupRows[old_.groups[row.group].firstRow + row.row]);
            }
            add(cell.size, cell.columns, numbers, cell.spline, append(parameters, 3));
        }
    }

    /// Adds the rows of a group that keep their factors or weights.
    void addLeft(std::size_t number) {
        const Group& group = old_.groups[number];
        std::vector<Index>& left = left_[number];
        if (!isSplit_[number] || std::ssize(left) == group.rowCount) return keep(group);
        if (left.empty()) return;
        std::sort(left.begin(), left.end());
        std::vector<Factors> factors;
        std::vector<Index> rows;
        for (const Index row : left) {
            factors.push_back(factorsOf(group, row));
            rows.push_back(old_.groupRows[group.firstRow + row]);
        }
        add(group.size, columnsOf(group), rows, kNoSpline, append(factors, lengthOf(group)));
    }

    /// Returns the sum of the weights of a row.
    static double sumOf(const Factors& factors, const Group& group) {
        double product = 1;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto own = axisOf(factors, group, axis);
            product *= std::accumulate(own.begin(), own.end(), 0.0);
        }
        return product;
    }

    /// Finds the spline of a group by some of its rows: Group::spline, and the order of the columns
    /// along each axis.
    std::optional<Index> findSpline(const Group& group, std::array<Positions, 3>& orders) {
        constexpr Index kSamples = 6;
        std::array<Factors, kSamples> samples;
        for (Index s = 0; s < kSamples; ++s)
            samples[s] = factorsOf(
                group, static_cast<Index>(Offset{s} * (group.rowCount - 1) / (kSamples - 1)));
        const auto fits = [&](Index spline) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                std::array<std::span<const Real>, kSamples> factors;
                for (std::size_t s = 0; s < kSamples; ++s)
                    factors[s] = axisOf(samples[s], group, axis);
                const auto order = findOrder<Real>(factors, spline);
                if (!order) return false;
                orders[axis] = *order;
            }
            return true;
        };
        // Most groups of a table have the same.
        if (fits(last_)) return last_;
        for (Index spline = kLimitSpline; spline <= kMaxSplineLevel; ++spline)
            if (fits(spline)) return last_ = spline;
        return std::nullopt;
    }

    CompiledRows<Real>& old_;
    std::vector<Group> groups_;
    std::vector<Index> columns_, rows_, splines_;
    AlignedVector<Real> numbers_;
    std::map<Cell, std::vector<SplineRow>> cells_;
    std::vector<std::vector<Index>> left_;      ///< rows of each group that stay in it
    std::vector<bool> isSplit_;                 ///< whether each group has rows of cells
    std::unordered_map<Offset, Offset> slots_;  ///< old slot of kept numbers → new slot
    Index last_ = kLimitSpline;                 ///< the spline that was found last
};

}  // namespace

template <class Real>
std::vector<Index> storeSplineParameters(CompiledRows<Real>& rows) {
    return SplineFinder<Real>(rows).run();
}

template std::vector<Index> storeSplineParameters(CompiledRows<float>&);
template std::vector<Index> storeSplineParameters(CompiledRows<double>&);

}  // namespace espalier::osd::device
