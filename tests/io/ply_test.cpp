// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/model.h>
#include <io/model_files.h>
#include <io/replaced.h>

#include <cstdint>

namespace espalier::io {
namespace {

/// Returns the header of all samples. The vertices are between two other elements; their
/// coordinates are out of order among other properties, one of which is a list.
std::string headerOf(const std::string& format, const std::string& xType,
                     const std::string& yType) {
    return "ply\n"
           "format " +
           format +
           " 1.0\n"
           "comment element vertex 7\n"
           "obj_info anything\n"
           "element nothing 3\n"
           "element material 2\n"
           "property list uint8 int16 shades\n"
           "property double gloss\n"
           "element vertex 2\n"
           "property uchar red\n"
           "property " +
           yType +
           " y\n"
           "property list ushort float tags\n"
           "property " +
           xType +
           " x\n"
           "property float32 z\n"
           "property int32 id\n"
           "element face 1\n"
           "property list uchar int vertex_indices\n"
           "end_header\n";
}

struct Numbers {
    std::endian order;
    std::string bytes;
    template <class Number>
    Numbers& operator<<(Number number) {
        bytes += bytesOf(number, order);
        return *this;
    }
};

/// Returns a binary file with these numbers in the first point.
std::string binarySample(std::endian order, double x0, float y0, float z0) {
    const bool isBig = order == std::endian::big;
    Numbers rows{order, {}};
    using U8 = std::uint8_t;
    rows << U8{2} << std::int16_t{10} << std::int16_t{-11} << 0.5;
    rows << U8{0} << 0.25;
    rows << U8{255} << y0 << std::uint16_t{1} << 9.5f << x0 << z0 << std::int32_t{7};
    rows << U8{0} << 5.0f << std::uint16_t{0} << 4.0 << 6.0f << std::int32_t{-8};
    rows << U8{3} << std::int32_t{0} << std::int32_t{1} << std::int32_t{0};
    return headerOf(isBig ? "binary_big_endian" : "binary_little_endian", "float64", "float") +
           rows.bytes;
}

TEST(Ply, ReadsAndRewritesBothBinaryOrders) {
    for (const std::endian order : {std::endian::little, std::endian::big}) {
        const std::string bytes = binarySample(order, 1.1, 2.5f, 3.5f);
        const auto model = readModel("a.ply", bytes);
        EXPECT_THAT(model->positions(), ElementsAre(Point3{1.1, 2.5, 3.5}, Point3{4, 5, 6}));
        EXPECT_EQ(written(*model, model->positions()), bytes);
        // x is a double and keeps all of 1/3; y and z are floats.
        const std::vector<Point3> moved = {{1.0 / 3, 0.1, -1e-3}, {4, 5, 6}};
        EXPECT_EQ(written(*model, moved), binarySample(order, 1.0 / 3, 0.1f, -1e-3f));
    }
}

TEST(Ply, RefusesTruncatedBinaryFiles) {
    for (const std::endian order : {std::endian::little, std::endian::big}) {
        const std::string bytes = binarySample(order, 1, 2, 3);
        expectPartsRefused("a.ply", bytes, bytes.size());
    }
}

/// The rows of binarySample() as text, with "\n" as line end.
const std::string kAsciiRows =
    "2 10 -11 0.5\n"
    "0 0.25\n"
    "255  2.50 1 9.5 1.10\t3.5 7 \n"
    "\n"
    "0 5 0 4 6 -8\n"
    "3 0 1 0";

TEST(Ply, ReadsAndRewritesAscii) {
    for (const std::string end : {"\n", "\r\n"}) {
        const std::string text =
            withLineEnds(headerOf("ascii", "double", "float") + kAsciiRows, end);
        const auto model = readModel("a.PLY", text);
        EXPECT_THAT(model->positions(), ElementsAre(Point3{1.1, 2.5, 3.5}, Point3{4, 5, 6}));
        EXPECT_EQ(written(*model, model->positions()), text);
        // The first x does not change and keeps its text. 1/3 needs 9 digits as a float and 16 as a
        // double.
        const std::vector<Point3> moved = {{1.1, 1.0 / 3, 0.1}, {1.0 / 3, 5, 1e10}};
        std::string expected = text;
        const auto replace = [&](const std::string& from, const std::string& to) {
            expected.replace(expected.find(from), from.size(), to);
        };
        replace("255  2.50 1 9.5 1.10\t3.5 7 ", "255  0.33333334 1 9.5 1.10\t0.1 7 ");
        replace("0 5 0 4 6 -8", "0 5 0 0.3333333333333333 1e+10 -8");
        EXPECT_EQ(written(*model, moved), expected);
    }
}

TEST(Ply, AsciiFloatsAreReadAsFloats) {
    const std::string text =
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float32 x\n"
        "property float y\nproperty float z\nend_header\n"
        "0.1 0.123456789012 1e-60\n";
    const auto model = readModel("a.ply", text);
    EXPECT_THAT(model->positions(), ElementsAre(Point3{0.1f, 0.123456789012f, 0}));
    // A number that rounds to the same float has not changed, and keeps its text.
    EXPECT_EQ(written(*model, std::vector<Point3>{{0.1, 0.123456789, 0}}), text);
}

TEST(Ply, RefusesTruncatedAsciiFiles) {
    const std::string text = headerOf("ascii", "double", "float") + kAsciiRows;
    // A file that is cut within the last number is still valid.
    expectPartsRefused("a.ply", text, text.size() - 1);
}

TEST(Ply, RefusesMoreRowsThanTheHeaderClaims) {
    const std::string ascii = headerOf("ascii", "float", "float") + kAsciiRows + "\n\n3 0 1 1\n";
    EXPECT_REFUSED(FileError,
                   "expected the end of the file after all rows that the header "
                   "claims, got '3'",
                   readModel("a.ply", ascii));
    const std::string binary = binarySample(std::endian::little, 1, 2, 3);
    for (const std::string more : {"more", "\n\n", " "})
        EXPECT_THAT([&] { readModel("a.ply", binary + more); },
                    ThrowsMessage<FileError>(
                        AllOf(HasSubstr("byte " + std::to_string(binary.size()) + ":"),
                              HasSubstr("got " + std::to_string(more.size()) + " more bytes"))));
}

TEST(Ply, KeepsLineEndsAfterTheLastRow) {
    const std::string ascii = headerOf("ascii", "float", "float") + kAsciiRows + "\n \n\r\n";
    const std::string binary = binarySample(std::endian::little, 1, 2, 3) + "\n";
    for (const std::string& bytes : {ascii, binary}) {
        const auto model = readModel("a.ply", bytes);
        EXPECT_EQ(written(*model, model->positions()), bytes);
    }
}

TEST(Ply, RefusesPositionsTooLargeForAFloat) {
    const auto model = readModel("a.ply", binarySample(std::endian::little, 1, 2, 3));
    EXPECT_NO_THROW(written(*model, std::vector<Point3>{{1e300, 2, 3}, {4, 5, 6}}));
    EXPECT_THAT(
        [&] {
            written(*model, std::vector<Point3>{{1, 2, 3}, {4, 5, 1e300}});
        },
        ThrowsMessage<Error>(AllOf(HasSubstr("point 1"), HasSubstr("1e+300"))));
}

/// -1 ends a strip; every second triangle of a strip is wound the other way.
TEST(Ply, StripsOfTrianglesAreFaces) {
    const std::string head =
        "element vertex 5\nproperty float x\nproperty float y\n"
        "property float z\nelement tristrips 1\n"
        "property list int int vertex_indices\nend_header\n";
    const std::string text = "ply\nformat ascii 1.0\n" + head +
                             "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n9 0 1 2 3 -1 2 3 4 -1\n";
    std::string bytes = "ply\nformat binary_little_endian 1.0\n" + head;
    for (const int number : {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0})
        bytes += bytesOf(float(number), std::endian::little);
    for (const std::int32_t number : {9, 0, 1, 2, 3, -1, 2, 3, 4, -1})
        bytes += bytesOf(number, std::endian::little);
    for (const std::string& file : {text, bytes}) {
        const auto model = readModel("a.ply", file);
        const ModelSurface surface = model->readSurface();
        EXPECT_THAT(surface.faces.corners, ElementsAre(0, 1, 2, 2, 1, 3, 2, 3, 4));
        EXPECT_THAT(surface.faces.ends, ElementsAre(3, 6, 9));
        EXPECT_TRUE(surface.otherShapes.empty());
        EXPECT_EQ(written(*model, model->positions()), file);
        EXPECT_EQ(model->checkTarget("a.obj"), "");
    }
    EXPECT_REFUSED(
        FileError, "a.ply:15: a face has the corner '5'",
        readModel("a.ply", text.substr(0, text.find("9 0 1")) + "3 0 1 5\n")->readSurface());
    // -1 is no corner of a face.
    EXPECT_REFUSED(FileError, "a face has the corner '-1'",
                   readModel("a.ply", replaced(text, "tristrips", "face"))->readSurface());
}

/// Old versions of MeshLab write the colours of corners without naming them in the header.
TEST(Ply, KeepsFurtherWordsOfFaces) {
    const std::string text =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 9 1 1 1 1 1 1 1 1 1\n";
    const auto model = readModel("a.ply", text);
    EXPECT_THAT(model->notes(), ElementsAre("kept 1 line with more words than the header has "
                                            "properties for ('9' in line 13)"));
    EXPECT_EQ(model->readSurface().faces.count(), 1u);
    EXPECT_EQ(written(*model, model->positions()), text);
    // A row of points with further words would be a row of another table.
    EXPECT_REFUSED(FileError, "expected the end of a row of the element 'vertex', got '7'",
                   readModel("a.ply", replaced(text, "1 0 0\n", "1 0 0 7\n")));
}

/// The stamp of an exporter is no comment, and yet no reason to refuse the file.
TEST(Ply, KeepsHeaderLinesThatItDoesNotKnow) {
    const std::string head = "ply\nformat ascii 1.0\n";
    const std::string rest =
        "element vertex 1\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n0 0 0\n";
    const std::string text = head + "exported by Some Tool v2\n" + rest;
    const auto model = readModel("a.ply", text);
    EXPECT_THAT(model->notes(), ElementsAre("kept 1 line whose first word no header of a PLY has "
                                            "('exported' in line 3)"));
    EXPECT_EQ(written(*model, std::vector<Point3>{{0, 0, 2}}),
              replaced(text, "0 0 0\n", "0 0 2\n"));
    for (const std::string line : {"Property float w", "0 0 0", "a\1", "\xFF"})
        EXPECT_REFUSED(FileError, "does not begin a line of a PLY header",
                       readModel("a.ply", head + line + "\n" + rest));
}

TEST(Ply, RefusesPositionsThatAreNotFinite) {
    const float inf = std::numeric_limits<float>::infinity();
    const std::string bytes = binarySample(std::endian::big, 1, inf, 3);
    // The message must give the place of y. The sample has the bytes of infinity nowhere else.
    const std::size_t place = bytes.find(bytesOf(inf, std::endian::big));
    EXPECT_THAT([&] { readModel("a.ply", bytes); },
                ThrowsMessage<FileError>(AllOf(HasSubstr("byte " + std::to_string(place) + ":"),
                                               HasSubstr("y of point 0 is not finite"))));
    const std::string header = headerOf("ascii", "double", "float");
    const std::string nan = header + "0 1\n0 1\n0 1 0 nan 1 1\n";
    EXPECT_THAT([&] { readModel("a.ply", nan + "0 1 0 1 1 1\n2 0 1\n"); },
                ThrowsMessage<FileError>(AllOf(HasSubstr("a.ply:21:"), HasSubstr("not finite"))));
}

TEST(Ply, RefusesMalformedRowsWithTheirLine) {
    // The header has 18 lines.
    const auto refused = [](const std::string& rows, int line, const std::string& why) {
        const std::string text = headerOf("ascii", "double", "float") + rows;
        EXPECT_THAT([&] { readModel("a.ply", text); },
                    ThrowsMessage<FileError>(
                        AllOf(HasSubstr("a.ply:" + std::to_string(line) + ":"), HasSubstr(why))))
            << rows;
    };
    refused("3 1 2 0.5\n0 1\n0 1 0 1 1 1\n0 1 0 1 1 1\n0\n", 19,
            "the line ends; expected the property 'gloss'");
    refused("0 1\n0 1\n0 1 0 1 1\n0 1 0 1 1 1\n0\n", 21, "expected the property 'id'");
    refused("0 1\n0 1\n0 1 0 1 1 1 9\n0 1 0 1 1 1\n0\n", 21, "got '9'");
    refused("0 1\n0 1\n0 1 0 x 1 1\n0 1 0 1 1 1\n0\n", 21, "'x' is not a number; expected x");
    refused("0 1\n0 1\n0 1 0 1 1e39 1\n0 1 0 1 1 1\n0\n", 21,
            "'1e39' is too large for single precision");
    refused("0 1\n0 1\n0 1 -1 1 1 1\n0 1 0 1 1 1\n0\n", 21, "'-1' is not a length");
    refused("0 1\n0 1\n0 1 0 1 1 1\n0 1 0 1 1 1\n\n\n", 24, "1 rows of the element 'face', got 0");
}

TEST(Ply, ChecksClaimedSizesBeforeAllocating) {
    for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"})
        for (const char* count : {"1000000000", "18446744073709551615"})
            EXPECT_REFUSED(FileError, count,
                           readModel("a.ply", std::string("ply\nformat ") + format +
                                                  " 1.0\nelement vertex " + count +
                                                  "\nproperty float x\nproperty float y\n"
                                                  "property float z\nend_header\n0 0 0\n0 0 0\n"));
    std::string list =
        "ply\nformat binary_little_endian 1.0\nelement face 1\n"
        "property list int double v\nelement vertex 0\nproperty float x\n"
        "property float y\nproperty float z\nend_header\n";
    const std::size_t size = list.size();
    EXPECT_REFUSED(FileError, "byte " + std::to_string(size + 4),
                   readModel("a.ply", list + bytesOf(2147483647, std::endian::little)));
    EXPECT_REFUSED(FileError, "length -1",
                   readModel("a.ply", list + bytesOf(-1, std::endian::little)));
}

TEST(Ply, RefusesMalformedHeadersWithTheirLine) {
    const auto refused = [](const std::string& header, const std::string& why) {
        EXPECT_REFUSED(FileError, why, readModel("a.ply", header)) << header;
    };
    const std::string begin = "ply\nformat ascii 1.0\n";
    const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
    const std::string vertex = "element vertex 1\n" + xyz;
    const std::string end = "end_header\n0 0 0\n";
    refused("solid\n", ":1: not a PLY file");
    refused("ply\n" + vertex + end, "no line 'format'");
    refused("ply\nformat binary 1.0\n", ":2: 'binary' is not a format");
    refused("ply\nformat ascii 2.0\n", ":2: version '2.0' is not known");
    refused(begin + "format ascii 1.0\n", ":3: a second line 'format'");
    refused(begin + "1 vertex\n", ":3: '1' does not begin");
    refused(begin + "Element vertex 1\n", ":3: 'Element' does not begin");
    refused(begin + "element\n", ":3: the line ends");
    refused(begin + "element vertex -1\n", ":3: '-1' is not a number of rows");
    refused(begin + "element vertex 1 2\n", ":3: expected the end of the line, got '2'");
    refused(begin + "property float x\n", ":3: a property before the first element");
    refused(begin + "element vertex 1\nproperty real x\n", ":4: 'real' is not a type");
    refused(begin + "element vertex 1\nproperty float\n", ":4: the line ends");
    refused(begin + "element face 1\nproperty list float int v\n", ":4: the length of a list");
    refused(begin + end, "no element 'vertex'");
    refused(begin + vertex + vertex + end, "several elements 'vertex'");
    refused(begin + vertex + "property float y\n" + end, "several properties 'y'");
    refused(begin + "element vertex 1\nproperty float x\nproperty float y\n" + end,
            "no property 'z'");
    refused(begin + "element vertex 1\nproperty int x\nproperty float y\nproperty float z\n" + end,
            "'x' of the vertices is an integer");
    refused(begin + "element vertex 1\nproperty list int float x\n" + end, "is a list");
    refused(begin + vertex, "the file ends in its header");
}

}  // namespace
}  // namespace espalier::io
