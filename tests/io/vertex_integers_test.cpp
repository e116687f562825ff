// SPDX-License-Identifier: Apache-2.0
#include "lattice_samples.h"
#include "support/test.h"

#include <espalier/far/topology_refiner.h>
#include <espalier/shapes/level_lattice.h>
#include <espalier/shapes/merge.h>
#include <espalier/shapes/refiner_options.h>

// Tests integers on vertices: files keep them with their type, and new lattices copy but never
// average them.

namespace espalier::test {
namespace {

using Integers = std::vector<std::int64_t>;

constexpr std::int64_t kBeyondDouble = (std::int64_t{1} << 53) + 1;

/// Returns integers of one type with its smallest and its largest number; UInt64 by their bits.
VertexIntegers extremes(IntegerType type, int bits, bool isSigned, std::size_t vertexCount,
                        int components = 1) {
    const auto ones = ~std::uint64_t{0} >> (64 - bits);
    const auto most = std::int64_t(isSigned ? ones >> 1 : ones);
    VertexIntegers integers{std::string("an ") + integerTypeName(type), components, type, {}};
    integers.values.resize(vertexCount * std::size_t(components), 7);
    integers.values[0] = most;
    integers.values[1] = isSigned ? -most - 1 : 0;
    return integers;
}

Lattice withIntegers(int components) {
    Lattice lattice = withMarksAndAttributes(boxLattice());
    const std::size_t count = lattice.positions.size();
    for (int type = 0; type < 8; ++type)
        lattice.integers.push_back(extremes(static_cast<IntegerType>(type), 8 << type / 2,
                                            type % 2 == 0, count, components));
    lattice.integers.push_back({"gid", 1, IntegerType::Int64, Integers(count, kBeyondDouble)});
    return lattice;
}

TEST(VertexIntegers, VtkFilesKeepAllTypes) {
    for (const int components : {1, 3}) {
        const Lattice lattice = withIntegers(components);
        for (const auto encoding :
             {io::VtuEncoding::Ascii, io::VtuEncoding::Binary, io::VtuEncoding::Compressed})
            expectSameLattice(latticeOf("a.vtu", writtenLattice("a.vtu", lattice, {encoding})),
                              lattice);
        expectSameLattice(latticeOf("a.vtk", writtenLattice("a.vtk", lattice)), lattice);
    }
}

TEST(VertexIntegers, OvmKeepsValuesOfOneComponent) {
    const Lattice lattice = withIntegers(1);
    const Lattice got = latticeOf("a.ovm", writtenLattice("a.ovm", lattice));
    ASSERT_EQ(got.integers.size(), lattice.integers.size());
    for (std::size_t i = 0; i < got.integers.size(); ++i) {
        EXPECT_EQ(got.integers[i].name, lattice.integers[i].name);
        EXPECT_EQ(got.integers[i].values, lattice.integers[i].values);
    }
    EXPECT_EQ(got.integers.back().type, IntegerType::Int64);
    EXPECT_REFUSED(io::FileError, "'an Int8' has 3 integers for each vertex",
                   writtenLattice("a.ovm", withIntegers(3)));
}

TEST(VertexIntegers, MalformedIntegersAreRefused) {
    const std::string text = writtenLattice("a.vtk", withIntegers(1));
    const auto refusalWith = [&](const std::string& number) {
        std::string changed = text;
        const std::string first = "an%20UInt8 1 12 unsigned_char\n255";
        const std::size_t at = changed.find(first);
        EXPECT_NE(at, std::string::npos);
        changed.replace(at + first.size() - 3, 3, number);
        return refusalOf("a.vtk", changed);
    };
    EXPECT_EQ(refusalWith("254"), "");
    EXPECT_THAT(refusalWith("256"), HasSubstr("256 is out of the range of UInt8"));
    EXPECT_THAT(refusalWith("-1"), HasSubstr("-1 is out of the range of UInt8"));
    EXPECT_THAT(refusalWith("0.5"), HasSubstr("0.5"));
}

TEST(VertexIntegers, OutOfRangeValuesAreNotWritten) {
    Lattice lattice = boxLattice();
    lattice.integers = {{"small", 1, IntegerType::UInt8, Integers(12, 256)}};
    for (const char* name : {"a.vtu", "a.vtk", "a.ovm"}) {
        EXPECT_REFUSED(io::FileError, "'small' has 256, which is out of the range of UInt8",
                       writtenLattice(name, lattice));
    }
}

TEST(VertexIntegers, VtkGhostTypeIsSkipped) {
    Lattice lattice = boxLattice();
    lattice.integers = {{"vtkGhostType", 1, IntegerType::UInt8, Integers(12)}};
    for (const char* name : {"a.vtu", "a.vtk"})
        EXPECT_TRUE(latticeOf(name, writtenLattice(name, lattice)).integers.empty()) << name;
}

TEST(VertexIntegers, AreCopiedToVertexPointsOnly) {
    const Lattice lattice = withIntegers(2);
    TopologyRefiner refiner = refined(lattice.complex, 2, refinerOptions(lattice));
    for (const int level : {0, 1, 2}) {
        const auto count = std::size_t(refiner.level(level).complex.count(0));
        const auto carried = levelIntegers(refiner, level, lattice.integers);
        ASSERT_EQ(carried.size(), lattice.integers.size());
        for (std::size_t i = 0; i < carried.size(); ++i) {
            Integers expected = lattice.integers[i].values;
            expected.resize(count * std::size_t(carried[i].components), noInteger(carried[i].type));
            EXPECT_EQ(carried[i].values, expected);
            EXPECT_EQ(carried[i].type, lattice.integers[i].type);
        }
    }
    EXPECT_EQ(noInteger(IntegerType::Int16), -1);
    EXPECT_EQ(noInteger(IntegerType::UInt8), 255);
    EXPECT_EQ(noInteger(IntegerType::UInt32), 4294967295);
    EXPECT_EQ(std::uint64_t(noInteger(IntegerType::UInt64)), ~std::uint64_t{0});
    auto tooFew = lattice.integers;
    tooFew[0].values.pop_back();
    EXPECT_THROW(levelIntegers(refiner, 1, tooFew), Error);
}

TEST(VertexIntegers, MergeRequiresTheSameType) {
    Lattice left = boxLattice();
    for (std::size_t i = 0; i < 12; ++i)
        left.positions[i] = {double(i % 3), double(i / 3 % 2), double(i / 6)};
    left.integers = {{"gid", 1, IntegerType::Int64, Integers(12, kBeyondDouble)}};
    Lattice right = left;
    for (Point3& position : right.positions) position[0] += 2;
    right.integers[0].values = Integers(12, 5);
    const Lattice merged = shapes::merge(left, right);
    ASSERT_EQ(merged.integers.size(), 1u);
    Integers expected(12, kBeyondDouble);
    expected.resize(20, 5);
    EXPECT_EQ(merged.integers[0].values, expected);
    right.integers[0].type = IntegerType::Int32;
    EXPECT_REFUSED(Error, "lattice 1 lacks attribute of Int64 'gid'", shapes::merge(left, right));
}

}  // namespace
}  // namespace espalier::test
