// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/model.h>
#include <io/model_files.h>

#include <cstdint>

namespace espalier::io {
namespace {

using Facet = std::array<std::array<float, 3>, 4>;  ///< normal and corners

constexpr Facet kFlat = {{{0, 0, 1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
/// A facet whose normal is not the normal of its corners, as some programs write it.
constexpr Facet kOdd = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}};

std::string binarySample(const std::vector<Facet>& facets, std::string header = "solid sample") {
    header.resize(80, ' ');
    std::string bytes = header + bytesOf(std::uint32_t(facets.size()), std::endian::little);
    for (const Facet& facet : facets) {
        for (const auto& vector : facet)
            for (const float number : vector) bytes += bytesOf(number, std::endian::little);
        bytes += "\x12\x34";
    }
    return bytes;
}

TEST(Stl, ReadsABinaryFileWhoseHeaderSaysSolid) {
    const std::string bytes = binarySample({kFlat, kOdd});
    const auto model = readModel("a.stl", bytes);
    EXPECT_THAT(model->positions(), ElementsAre(Point3{0, 0, 0}, Point3{1, 0, 0}, Point3{0, 1, 0},
                                                Point3{1, 0, 0}, Point3{1, 1, 0}, Point3{0, 1, 0}));
    EXPECT_EQ(written(*model, model->positions()), bytes);
}

TEST(Stl, MovedBinaryFacetsGetANewNormal) {
    const auto model = readModel("a.stl", binarySample({kFlat, kOdd}));
    auto moved = copyOf(model->positions());
    moved[1] = {0, 0, -2};  // x becomes -z, so the normal z becomes x.
    const Facet turned = {{{1, 0, 0}, {0, 0, 0}, {0, 0, -2}, {0, 1, 0}}};
    EXPECT_EQ(written(*model, moved), binarySample({turned, kOdd}));

    moved = copyOf(model->positions());
    moved[4] = {1.0 / 3, 2.0 / 3, 0};  // on the line from (1, 0, 0) to (0, 1, 0)
    const Facet line = {{{0, 0, 0}, {1, 0, 0}, {1.0f / 3, 2.0f / 3, 0}, {0, 1, 0}}};
    EXPECT_EQ(written(*model, moved), binarySample({kFlat, line}));
}

TEST(Stl, NormalsFollowThePointsWhateverTheGradients) {
    const std::string bytes = binarySample({kFlat, kOdd});
    const auto model = readModel("a.stl", bytes);
    EXPECT_FALSE(model->hasDirections());
    EXPECT_EQ(test::turned(*model, {0, -1, 0, 1, 0, 0, 0, 0, 1}), bytes);
}

TEST(Stl, BinaryPositionsRoundToFloats) {
    const auto model = readModel("a.stl", binarySample({kOdd}));
    auto moved = copyOf(model->positions());
    moved[0][0] = 1 + 1e-9;  // the float 1, so that the facet does not move
    EXPECT_EQ(written(*model, moved), binarySample({kOdd}));
    moved[1][1] = 1e39;
    EXPECT_THAT([&] { written(*model, moved); },
                ThrowsMessage<Error>(AllOf(HasSubstr("point 1"), HasSubstr("1e+39"))));
}

TEST(Stl, NormalsOfTinyAndHugeFacetsAreUnitVectors) {
    for (const float size : {1e-30f, 1e30f}) {
        const auto model = readModel("a.stl", binarySample({kFlat}));
        const std::vector<Point3> moved = {{0, 0, 0}, {0, size, 0}, {0, 0, size}};
        const Facet facet = {{{1, 0, 0}, {0, 0, 0}, {0, size, 0}, {0, 0, size}}};
        EXPECT_EQ(written(*model, moved), binarySample({facet}));
    }
}

TEST(Stl, RefusesABinaryFileOfWrongSize) {
    // 84 + 50 · 2 bytes.
    for (const char* header : {"solid", "header"}) {
        const std::string bytes = binarySample({kFlat, kOdd}, header);
        EXPECT_THAT([&] { readModel("a.stl", bytes.substr(0, 170)); },
                    ThrowsMessage<FileError>(AllOf(HasSubstr("184 bytes"), HasSubstr("got 170"))));
        expectPartsRefused("a.stl", bytes, bytes.size());
    }
    // A head that claims no facet, and more bytes, are no binary STL.
    EXPECT_REFUSED(FileError, "got 88", readModel("a.stl", binarySample({}) + "more"));
}

/// Some programs write further data after the last facet.
TEST(Stl, KeepsBytesAfterTheLastFacet) {
    for (const char* header : {"solid", "header"}) {
        const std::string bytes = binarySample({kFlat, kOdd}, header);
        const auto model = readModel("a.stl", bytes + "more");
        EXPECT_THAT(model->notes(), ElementsAre("kept 4 bytes after the last facet"));
        EXPECT_EQ(model->positions().size(), 6u);
        EXPECT_EQ(written(*model, model->positions()), bytes + "more");
        std::vector<Point3> moved = copyOf(model->positions());
        for (Point3& point : moved) point[0] += 8;
        const auto again = readModel("b.stl", written(*model, moved));
        EXPECT_THAT(again->positions(), testing::ElementsAreArray(moved));
        EXPECT_THAT(again->notes(), ElementsAre("kept 4 bytes after the last facet"));
    }
    EXPECT_THAT(readModel("a.stl", binarySample({kFlat}) + "1")->notes(),
                ElementsAre("kept 1 byte after the last facet"));
}

TEST(Stl, RefusesABinaryPositionThatIsNotFinite) {
    Facet facet = kFlat;
    facet[2][1] = std::numeric_limits<float>::infinity();
    // The offset is 84 + 50, plus a normal and a corner of 12 bytes each, plus x of the second
    // corner.
    EXPECT_THAT(
        [&] {
            readModel("a.stl", binarySample({kFlat, facet}));
        },
        ThrowsMessage<FileError>(
            AllOf(HasSubstr("byte 162:"), HasSubstr("y of point 4 is not finite"))));
    facet = kFlat;
    facet[0][1] = std::numeric_limits<float>::quiet_NaN();  // A NaN in a normal is accepted.
    EXPECT_NO_THROW(readModel("a.stl", binarySample({facet})));
}

const std::string kAscii =
    "solid two words\n"
    "  facet normal 0.0 0.0 1.0\n"
    "    outer loop\n"
    "      vertex 0 0 0\n"
    "      vertex 1.00 0\t0\n"
    "      vertex 0 1 0\n"
    "    endloop\n"
    "  endfacet\n"
    "endsolid two words\n"
    "SOLID\n"
    "FACET NORMAL -1.#IND nan nan\n"
    "OUTER LOOP VERTEX 1 0 0 VERTEX 1 1 0 VERTEX 0 1e0 0 ENDLOOP\n"
    "ENDFACET\n"
    "ENDSOLID";

TEST(Stl, ReadsANameThatIsJoinedToItsKeyword) {
    const std::string text =
        "solidpart\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
        "endloop\nendfacet\nEndSolidpart\n";
    const auto model = readModel("a.stl", text);
    EXPECT_EQ(model->positions().size(), 3u);
    EXPECT_THAT(model->notes(), ElementsAre("read 2 lines as solid or endsolid and a name "
                                            "('solidpart' in line 1)"));
    EXPECT_EQ(written(*model, model->positions()), text);
}

TEST(Stl, ReadsAscii) {
    const auto model = readModel("a.stl", kAscii);
    EXPECT_THAT(model->positions(), ElementsAre(Point3{0, 0, 0}, Point3{1, 0, 0}, Point3{0, 1, 0},
                                                Point3{1, 0, 0}, Point3{1, 1, 0}, Point3{0, 1, 0}));
    EXPECT_EQ(written(*model, model->positions()), kAscii);
}

TEST(Stl, MovedAsciiFacetsGetANewNormal) {
    const auto model = readModel("a.stl", kAscii);
    auto moved = copyOf(model->positions());
    moved[1] = {0, 0, -2};
    moved[4] = {1, 1, 1.0 / 3};
    const auto replaced = [](std::string text, const std::string& from, const std::string& to) {
        return text.replace(text.find(from), from.size(), to);
    };
    const std::string text = written(*model, moved);
    std::string expected = replaced(kAscii, "0.0 0.0 1.0", "1 0 0");
    expected = replaced(expected, "1.00 0\t0", "0 0\t-2");
    expected = replaced(expected, "1 1 0", "1 1 0.3333333333333333");
    // The second normal is (0, 1, 1/3) × (-1, 1, 0) = (-1/3, -1/3, 1), of length √11 / 3.
    const std::size_t begin = text.find("NORMAL ") + 7;
    const std::size_t end = text.find('\n', begin);
    const std::string normal = text.substr(begin, end - begin);
    EXPECT_EQ(text, replaced(expected, "-1.#IND nan nan", normal));
    Point3 numbers{};
    ASSERT_EQ(std::sscanf(normal.c_str(), "%lf %lf %lf", &numbers[0], &numbers[1], &numbers[2]), 3);
    // The tolerance is a few rounding errors of numbers up to 1.
    EXPECT_NEAR(numbers[0], -1 / std::sqrt(11.0), 1e-15);
    EXPECT_NEAR(numbers[1], -1 / std::sqrt(11.0), 1e-15);
    EXPECT_NEAR(numbers[2], 3 / std::sqrt(11.0), 1e-15);
}

TEST(Stl, RefusesTruncatedAsciiFiles) {
    expectPartsRefused("a.stl", kAscii,
                       kAscii.find("\nSOLID") - std::string("two words").size() - 1);
    // From there on, the first solid alone is a valid file, until the second begins.
    for (std::size_t size = kAscii.find("SOLID") + 1; size < kAscii.size(); ++size)
        EXPECT_THROW(readModel("a.stl", kAscii.substr(0, size)), FileError) << size;
}

TEST(Stl, RefusesMalformedAsciiWithItsLine) {
    const auto refused = [](const std::string& from, const std::string& to, int line,
                            const std::string& why) {
        std::string text = kAscii;
        text.replace(text.find(from), from.size(), to);
        EXPECT_THAT([&] { readModel("a.stl", text); },
                    ThrowsMessage<FileError>(
                        AllOf(HasSubstr("a.stl:" + std::to_string(line) + ":"), HasSubstr(why))));
    };
    refused("facet normal", "facet", 2, "expected 'normal', got '0.0'");
    refused("vertex 0 0 0", "vertex 0 zero 0", 4, "'zero' is not a number; expected y");
    refused("vertex 0 0 0", "vertex 0 0 inf", 4, "'inf' is not finite; expected z");
    refused("vertex 0 1 0\n", "", 6, "expected 'vertex', got 'endloop'");
    refused("vertex 0 1 0\n", "vertex 0 1 0\nvertex 0 1 0\n", 7, "expected 'endloop'");
    refused("endsolid two", "end two", 9, "'end'; expected 'facet' or 'endsolid'");
    refused("ENDSOLID", "", 14, "the file ends");
    EXPECT_REFUSED(FileError, "not an ASCII STL", readModel("a.stl", "v 1 2 3\n"));
}

}  // namespace
}  // namespace espalier::io
