// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/embedding.h>
#include <espalier/far/complex_builder.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/shapes/inventory.h>
#include <espalier/stencils/composition.h>

#include "osd/compile/outer_product.h"
#include "support/mesh_shapes.h"
#include "support/tables.h"
#include "support/test.h"
#include "support/zoo.h"

namespace espalier::osd {
namespace {

/// Returns D of random points between `low` and `high`, bound to level 3 of a lattice.
template <class Real>
StencilTable<Real> tableOfPointsBetween(const Lattice& lattice, std::size_t count,
                                        const Point3& low, const Point3& high) {
    TopologyRefiner refiner = refined(lattice.complex, 3);
    const auto rest = stencils::refinePositions(refiner, 3, lattice.positions);
    const auto values = randomValues(3 * count, 5);
    std::vector<Point3> points(count);
    for (std::size_t i = 0; i < 3 * count; ++i)
        points[i / 3][i % 3] =
            (low[i % 3] + high[i % 3]) / 2 + (high[i % 3] - low[i % 3]) / 2 * values[i];
    const auto embedding = embed::embedPoints(refiner.level(3).complex, rest, points);
    return convertTable<Real>(embed::buildDeformationTable(refiner, 3, embedding));
}

template <class Real>
double bytesOfCsr(const StencilTable<Real>& table) {
    return double(table.entryCount()) * (sizeof(Real) + sizeof(Index));
}

/// Checks that results are within `ulp` ulp of the sums, relative to Σ |w · x|.
template <class Real>
void expectWithinUlp(const StencilTable<Real>& table, Real ulp) {
    const CompiledTable<Real> compiled(table);
    const auto random = randomValues(3 * std::size_t(table.columnCount()), 6);
    const std::vector<Real> source(random.begin(), random.end());
    std::vector<Real> result(3 * std::size_t(table.rowCount()));
    const auto layout = BufferDescriptor::packed(3);
    compiled.evaluate(source, layout, result, layout, {0, table.rowCount()});
    for (Index row = 0; row < table.rowCount(); ++row)
        for (std::size_t c = 0; c < 3; ++c) {
            long double sum = 0, size = 0;
            for (std::size_t k = 0; k < table.columns(row).size(); ++k) {
                const long double product = static_cast<long double>(table.weights(row)[k]) *
                                            source[3 * std::size_t(table.columns(row)[k]) + c];
                sum += product;
                size += std::abs(product);
            }
            ASSERT_LE(std::abs(result[3 * std::size_t(row) + c] - sum),
                      ulp * std::numeric_limits<Real>::epsilon() * size)
                << row;
        }
}

/// The bound that CompiledTable promises for rows of up to 64 entries.
template <class Real>
void expectWithinFourUlp(const StencilTable<Real>& table) {
    expectWithinUlp(table, Real{4});
}

template <class Real>
class CompiledTableTest : public ::testing::Test {};
TYPED_TEST_SUITE(CompiledTableTest, Reals);

// Between the planes of the base vertices, points at level 3 depend on 4 × 4 × 4 base vertices.
TYPED_TEST(CompiledTableTest, RegularCellsAreOuterProducts) {
    const Lattice box = shapes::box({.cells = {3, 3, 3}});
    const auto table =
        tableOfPointsBetween<TypeParam>(box, 4000, {0.38, 0.38, 0.38}, {0.62, 0.62, 0.62});
    const CompiledTable<TypeParam> compiled(table);
    EXPECT_EQ(table.entryCount(), 64 * Offset{table.rowCount()});
    EXPECT_GE(compiled.panelRowCount(), table.rowCount() - 8);
    // In double, some weights are themselves off by more than three roundings.
    const bool isFloat = sizeof(TypeParam) == sizeof(float);
    EXPECT_GT(compiled.productRowCount(), table.rowCount() * (isFloat ? 99 : 90) / 100);
    // In float, a row stores 12 numbers instead of 64, and its row number; columns are stored once
    // for each cell.
    EXPECT_LT(double(compiled.byteCount()), (isFloat ? 0.13 : 0.25) * bytesOfCsr(table));
    expectWithinFourUlp(table);
}

TYPED_TEST(CompiledTableTest, IrregularCellsArePanels) {
    const Lattice lattice = shapes::cylinder({.sectors = 5});
    const auto table =
        tableOfPointsBetween<TypeParam>(lattice, 3000, {-0.4, -0.4, 0.1}, {0.4, 0.4, 0.9});
    const CompiledTable<TypeParam> compiled(table);
    EXPECT_GT(compiled.panelRowCount(), table.rowCount() * 9 / 10);
    EXPECT_LT(compiled.productRowCount(), compiled.panelRowCount());
    expectWithinFourUlp(table);
}

TYPED_TEST(CompiledTableTest, Surfaces) {
    const Lattice torus = surfaceOf(shapes::torus());
    TopologyRefiner refiner = refined(torus.complex, 4);
    const auto table = stencils::convertTable<TypeParam>(stencils::buildStencils(refiner, 4));
    const CompiledTable<TypeParam> compiled(table);
    EXPECT_LT(double(compiled.byteCount()), 0.55 * bytesOfCsr(table));
    expectWithinFourUlp(table);
    for (const auto& [name, lattice] : test::zoo()) {
        SCOPED_TRACE(name);
        TopologyRefiner zoo = refined(lattice.complex, 2, {.marks = lattice.marks});
        expectWithinFourUlp(stencils::convertTable<TypeParam>(stencils::buildStencils(zoo, 2)));
    }
}

// The rows of all regular faces have the same weights, which are stored once, however the vertices
// are numbered and the faces and their corners are ordered. Sizes are relative to CSR, which has
// two numbers for each entry.
TYPED_TEST(CompiledTableTest, RegularFacesShareTheirNumbers) {
    constexpr Index kSide = 24;
    std::mt19937 random(2);
    std::vector<Index> numbers(kSide * kSide);
    std::iota(numbers.begin(), numbers.end(), Index{0});
    for (const bool isShuffled : {false, true}) {
        std::vector<std::vector<Index>> loops;
        const auto number = [&](Index i, Index j) {
            return numbers[j % kSide * kSide + i % kSide];
        };
        for (Index j = 0; j < kSide; ++j)
            for (Index i = 0; i < kSide; ++i) {
                loops.push_back(
                    {number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)});
                if (isShuffled)
                    std::rotate(loops.back().begin(), loops.back().begin() + random() % 4,
                                loops.back().end());
            }
        if (isShuffled) std::shuffle(loops.begin(), loops.end(), random);
        TopologyRefiner refiner = refined(far::buildMesh(kSide * kSide, loops), 3);
        const auto table = stencils::convertTable<TypeParam>(stencils::buildStencils(refiner, 3));
        const CompiledTable<TypeParam> compiled(table);
        // Faces at the seams of the numbering have their columns in another order.
        EXPECT_LT(double(compiled.byteCount()), (isShuffled ? 0.25 : 0.1) * bytesOfCsr(table));
        expectWithinFourUlp(table);
        std::shuffle(numbers.begin(), numbers.end(), random);
    }
}

// Most rows of a level table belong to a few masks. Only columns and row numbers are stored for
// each row.
TYPED_TEST(CompiledTableTest, RowsOfTheSameMaskShareTheirWeights) {
    const Lattice torus = surfaceOf(shapes::torus());
    TopologyRefiner refiner = refined(torus.complex, 4);
    const auto table = convertTable<TypeParam>(stencils::buildLevelTable(refiner, 4));
    const double own = sizeof(Index) / double{sizeof(Index) + sizeof(TypeParam)};
    const double rowNumber = sizeof(Index) / (6.25 * (sizeof(Index) + sizeof(TypeParam)));
    EXPECT_LT(double(CompiledTable<TypeParam>(table).byteCount()),
              (own + rowNumber + 0.02) * bytesOfCsr(table));
    expectWithinFourUlp(table);
}

// A lattice of one cell gives many rows with the same columns, which are divided among threads.
TYPED_TEST(CompiledTableTest, OneCell) {
    const auto table = tableOfPointsBetween<TypeParam>(shapes::box({}), 5000, {0.01, 0.01, 0.01},
                                                       {0.99, 0.99, 0.99});
    const CompiledTable<TypeParam> compiled(table);
    EXPECT_EQ(compiled.panelRowCount(), table.rowCount());
    expectWithinFourUlp(table);
}

// A row at a pole has columns for all of its edges, and rows beside the pole have a few of these
// columns. The short rows are not padded with zeros.
TYPED_TEST(CompiledTableTest, PolesAreNotPaddedWithZeros) {
    const Lattice pole = test::pole(500, false);
    TopologyRefiner refiner = refined(pole.complex, 1);
    const auto table = stencils::convertTable<TypeParam>(stencils::buildStencils(refiner, 1));
    EXPECT_LT(double(CompiledTable<TypeParam>(table).byteCount()), 1.2 * bytesOfCsr(table));

    // One row has all columns, and many rows have two.
    Array<Offset> offsets = {0, 1000};
    Array<Index> columns(1000);
    std::iota(columns.begin(), columns.end(), Index{0});
    for (Index i = 0; i + 1 < 1000; ++i) {
        columns.insert(columns.end(), {i, i + 1});
        offsets.push_back(Offset(columns.size()));
    }
    const StencilTable<TypeParam> arrow(1000, offsets, columns,
                                        Array<TypeParam>(columns.size(), TypeParam(0.5)));
    // Rows of two entries form runs, in which each row stores its number.
    EXPECT_LT(double(CompiledTable<TypeParam>(arrow).byteCount()), 1.3 * bytesOfCsr(arrow));
}

// The bound for long rows is 4 ulp, plus one for each 32 entries.
TYPED_TEST(CompiledTableTest, LongRows) {
    constexpr Index kLength = 2000;
    constexpr Index kRows = 60;
    const auto weights = randomValues(std::size_t{kRows} * kLength, 9);
    const auto table = tableOfLongRows<TypeParam>(
        kRows, kLength, [&](std::size_t entry) { return weights[entry]; });
    expectWithinUlp(table, TypeParam{4 + kLength / 32});
}

// Sets of columns are found in blocks of 16,384 rows. All rows but the first share their columns.
TYPED_TEST(CompiledTableTest, RowsOfSeveralBlocksShareTheirColumns) {
    constexpr Index kRows = 40'000, kLength = 4;
    const auto random = randomValues(std::size_t{kRows} * kLength, 9);
    Array<Offset> offsets = {0};
    Array<Index> columns;
    for (Index row = 0; row < kRows; ++row) {
        for (Index k = 0; k < kLength; ++k) columns.push_back(row == 0 ? kLength + k : k);
        offsets.push_back(Offset(columns.size()));
    }
    const StencilTable<TypeParam> table(2 * kLength, offsets, columns,
                                        {random.begin(), random.end()});
    EXPECT_EQ(CompiledTable<TypeParam>(table).panelRowCount(), kRows - 1);
    expectWithinUlp(table, TypeParam{4});
}

TYPED_TEST(CompiledTableTest, EmptyTables) {
    const CompiledTable<TypeParam> none{StencilTable<TypeParam>()};
    EXPECT_EQ(none.rowCount(), 0);
    const auto layout = BufferDescriptor::packed(3);
    none.evaluate({}, layout, {}, layout, {0, 0});
    // Rows without entries give 0, even if there are enough such rows to form panels.
    const CompiledTable<TypeParam> zeros{StencilTable<TypeParam>(2, Array<Offset>(41, 0), {}, {})};
    std::vector<TypeParam> result(40, 9);
    zeros.evaluate(std::vector<TypeParam>(2, 1), {0, 1, 1}, result, {0, 1, 1}, {0, 40});
    EXPECT_EQ(result, std::vector<TypeParam>(40, 0));
}

// Some rows without entries fill no panel. They come before rows of the same weight.
TYPED_TEST(CompiledTableTest, EmptyRowsBesideRowsOfOneMask) {
    constexpr Index kRows = 43;
    Array<Offset> offsets(kRows + 1, 0);
    Array<Index> columns;
    for (Index i = 0; i < kRows; ++i) {
        columns.push_back(i);
        offsets.push_back(Offset(columns.size()));
    }
    const StencilTable<TypeParam> table(kRows, offsets, columns,
                                        Array<TypeParam>(kRows, TypeParam(0.75)));
    expectWithinFourUlp(table);
}

/// Rows of outer products, rows × columns, with the columns in a random order; and the slot of
/// each column in the box.
struct Products {
    std::vector<std::vector<double>> rows;
    std::vector<std::size_t> slots;
};

Products randomProducts(const std::array<std::size_t, 3>& sides, std::size_t rowCount) {
    std::mt19937 random(8);
    std::uniform_real_distribution<double> weight(0.05, 1);
    Products products;
    products.slots.resize(sides[0] * sides[1] * sides[2]);
    std::iota(products.slots.begin(), products.slots.end(), std::size_t{0});
    std::shuffle(products.slots.begin(), products.slots.end(), random);
    for (std::size_t row = 0; row < rowCount; ++row) {
        std::array<std::vector<double>, 3> factors;
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (std::size_t k = 0; k < sides[axis]; ++k) factors[axis].push_back(weight(random));
        products.rows.emplace_back();
        for (const std::size_t p : products.slots)
            products.rows.back().push_back(factors[0][p % sides[0]] *
                                           factors[1][p / sides[0] % sides[1]] *
                                           factors[2][p / sides[0] / sides[1]]);
    }
    return products;
}

template <class Real>
std::vector<const Real*> weightsOf(const std::vector<std::vector<Real>>& rows) {
    std::vector<const Real*> all;
    for (const auto& row : rows) all.push_back(row.data());
    return all;
}

std::optional<OuterProduct> find(const std::vector<std::vector<double>>& rows) {
    const auto weights = weightsOf(rows);
    return findOuterProduct<double>(weights, rows.empty() ? 0 : rows.front().size());
}

/// Returns the factors of each row; nothing for a row that is not an outer product. All instruction
/// sets must give the same bits.
/// \param positions for each weight of a row, its position among the columns of the product
template <class Real>
std::vector<std::vector<Real>> factorsOf(const OuterProduct& product,
                                         std::span<const Index> positions,
                                         const std::vector<std::vector<Real>>& rows) {
    const auto length =
        static_cast<std::size_t>(product.size[0] + product.size[1] + product.size[2]);
    std::optional<std::vector<std::vector<Real>>> result;
    for (const Simd simd : {Simd::Baseline, Simd::Avx2, Simd::Avx512}) {
        if (!hasSimd(simd)) continue;
        Array<Real> factors = {Real(7)};  // the factors are appended
        std::vector<char> isProduct;
        factorizeRows<Real>(kernels::kernelsFor<Real>(simd), product, positions, weightsOf(rows),
                            factors, isProduct);
        EXPECT_EQ(isProduct.size(), rows.size());
        std::vector<std::vector<Real>> own;
        auto next = factors.begin() + 1;
        for (const char is : isProduct) {
            own.emplace_back(next, next + (is ? std::ptrdiff_t(length) : 0));
            next += std::ssize(own.back());
        }
        EXPECT_EQ(next, factors.end());
        EXPECT_EQ(own, result.value_or(own));
        result = own;
    }
    return *result;
}

template <class Real>
std::vector<std::vector<Real>> factorsOf(const OuterProduct& product,
                                         const std::vector<std::vector<Real>>& rows) {
    std::vector<Index> positions(product.order.size());
    std::iota(positions.begin(), positions.end(), Index{0});
    return factorsOf<Real>(product, positions, rows);
}

template <class Real>
bool isProduct(const OuterProduct& product, const std::vector<Real>& row) {
    const auto factors = factorsOf<Real>(product, {row});
    EXPECT_EQ(factors.size(), 1u);
    return !factors.front().empty();
}

TEST(OuterProduct, IsFoundInAnyOrderOfTheColumns) {
    for (const auto& sides : std::vector<std::array<std::size_t, 3>>{
             {4, 4, 4}, {4, 4, 3}, {3, 3, 3}, {2, 2, 2}, {5, 2, 1}, {4, 4, 1}}) {
        const Products products = randomProducts(sides, 10);
        const auto found = find(products.rows);
        ASSERT_TRUE(found) << sides[0] << sides[1] << sides[2];
        EXPECT_TRUE(std::equal(sides.begin(), sides.end(), found->size.begin()));
        for (const auto& row : products.rows) EXPECT_TRUE(isProduct(*found, row));
    }
}

// Derivatives have factors of either sign, whose sum may be 0.
TEST(OuterProduct, HasFactorsOfEitherSign) {
    Products products = randomProducts({4, 4, 3}, 10);
    const auto arrangement = find(products.rows);
    ASSERT_TRUE(arrangement);
    for (std::size_t r = 0; r < products.rows.size(); r += 2)
        for (std::size_t i = 0; i < arrangement->order.size(); ++i) {
            // The first two factors of axis 0 and the last factor of axis 2 are negative. The
            // position of column i along these axes is i % 4 and i / 16.
            const bool isNegative = (i % 4 < 2) != (i / 16 == 2);
            products.rows[r][arrangement->order[i]] *= isNegative ? -1 : 1;
        }
    const auto found = find(products.rows);
    ASSERT_TRUE(found);
    for (const auto& row : products.rows) EXPECT_TRUE(isProduct(*found, row));
    EXPECT_TRUE(isProduct({{2, 2, 1}, {0, 1, 2, 3}}, std::vector{-0.5, 0.5, 0.5, -0.5}));
    // A row with one changed sign is not an outer product.
    auto wrong = products.rows[0];
    wrong[7] *= -1;
    EXPECT_FALSE(isProduct(*found, wrong));
}

TEST(OuterProduct, IsNotFoundInOtherRows) {
    Products products = randomProducts({4, 4, 4}, 10);
    EXPECT_FALSE(find({}));
    EXPECT_FALSE(find(randomProducts({7, 1, 1}, 10).rows));  // a single axis
    const auto found = find(products.rows);
    ASSERT_TRUE(found);
    // One row is not an outer product, though the others are.
    auto wrong = products.rows[3];
    wrong[17] *= 1 + 1e-14;
    EXPECT_FALSE(isProduct(*found, wrong));
    for (auto& row : products.rows) row[17] *= 1.001;
    EXPECT_FALSE(find(products.rows));
    products = randomProducts({4, 4, 4}, 10);
    // A row with a zero is skipped; the other rows are enough.
    products.rows[0][5] = 0;
    const auto others = find(products.rows);
    ASSERT_TRUE(others);
    EXPECT_FALSE(isProduct(*others, products.rows[0]));
    for (auto& row : products.rows) row[5] = 0;
    EXPECT_FALSE(find(products.rows));
    for (auto& row : products.rows) row[5] = -1;
    EXPECT_FALSE(find(products.rows));
    // If two columns are the same in all rows, their order is unknown.
    products = randomProducts({4, 4, 4}, 10);
    for (auto& row : products.rows) row[7] = row[6];
    EXPECT_FALSE(find(products.rows));
    EXPECT_FALSE(find(std::vector<std::vector<double>>(3, std::vector<double>(400, 0.0025))));
}

// Several rows are factorized at once. Each row must have the factors that it has alone, beside
// rows of either sign, rows that are not products, and rows that lack columns.
template <class Real>
void expectRowsAlone() {
    const Products products = randomProducts({4, 3, 2}, 21);
    std::vector<std::vector<double>> samples = products.rows;
    const auto found = find(samples);
    ASSERT_TRUE(found);
    std::vector<std::vector<Real>> rows;
    for (const auto& row : products.rows) rows.emplace_back(row.begin(), row.end());
    for (Real& weight : rows[2]) weight *= -1;
    rows[5][3] *= Real(1.5);
    rows[7][0] = std::numeric_limits<Real>::quiet_NaN();
    rows[8][0] = std::numeric_limits<Real>::infinity();
    const auto factors = factorsOf<Real>(*found, rows);
    ASSERT_EQ(factors.size(), rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
        EXPECT_EQ(factors[i], factorsOf<Real>(*found, {rows[i]}).front()) << i;
        EXPECT_EQ(factors[i].empty(), i == 5 || i == 7 || i == 8) << i;
        if (factors[i].empty()) continue;
        // Each product of factors is within 3 ulp of its weight: see factorizeRows().
        for (std::size_t at = 0; at < 24; ++at) {
            const Real weight = rows[i][std::size_t(found->order[at])];
            const Real expected =
                factors[i][at % 4] * factors[i][4 + at / 4 % 3] * factors[i][7 + at / 12];
            EXPECT_NEAR(expected, weight,
                        5 * std::numeric_limits<Real>::epsilon() * std::abs(weight));
        }
    }
    // Rows without the columns of the last plane: the rest has the same factors, and a 0.
    std::vector<Index> positions(found->order.begin(), found->order.begin() + 12);
    std::vector<std::vector<Real>> parts;
    for (const auto& row : rows) {
        parts.emplace_back();
        for (const Index position : positions) parts.back().push_back(row[std::size_t(position)]);
    }
    for (const auto& own : factorsOf<Real>(*found, positions, parts)) {
        if (own.empty()) continue;
        EXPECT_EQ(own[7], 1);
        EXPECT_EQ(own[8], 0);
    }
}

TEST(OuterProduct, HasTheSameFactorsBesideOtherRows) {
    expectRowsAlone<float>();
    expectRowsAlone<double>();
}

// If nearly all weights are 0, products of factors have no accuracy, so the row is rejected.
TEST(OuterProduct, RejectsRowsOfTinyWeights) {
    const OuterProduct product{{2, 2, 1}, {0, 1, 2, 3}};
    const std::vector<float> tiny = {1e-38F, 3e-39F, 2e-39F, 1.1e-38F};
    EXPECT_FALSE(isProduct(product, tiny));
    const std::vector<float> one = {0.5F, 0.5F, 1e-39F, 1e-39F};
    EXPECT_TRUE(isProduct(product, one));
}

TEST(Simd, BestAndBaselineAreSupported) {
    EXPECT_TRUE(hasSimd(bestSimd()));
    EXPECT_TRUE(hasSimd(Simd::Baseline));
    for (const Simd simd : {Simd::Avx2, Simd::Avx512})
        if (!hasSimd(simd)) {
            EXPECT_THROW(CompiledTable<float>(StencilTable<float>(), simd), Error);
        }
}

}  // namespace
}  // namespace espalier::osd
