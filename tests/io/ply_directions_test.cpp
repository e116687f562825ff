// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/text_reader.h>
#include <espalier/io/model.h>
#include <io/gradient_samples.h>
#include <io/model_files.h>

#include <cstdint>
#include <sstream>

namespace espalier::io {
namespace {

/// Vertices with normals in floats, out of order among the coordinates, and tangents in doubles.
std::string headerOf(const std::string& format, int count) {
    return "ply\nformat " + format + " 1.0\nelement vertex " + std::to_string(count) +
           "\nproperty double tx\nproperty float x\nproperty float nz\nproperty float ny\n"
           "property double ty\nproperty list uchar short tags\nproperty float y\n"
           "property float nx\nproperty double tz\nproperty float z\nend_header\n";
}

/// Returns the row of a vertex with this z.
std::string row(std::endian order, const Point3& normal, const Point3& tangent, float z) {
    const auto number = [&](auto value) { return bytesOf(value, order); };
    const auto real = [&](double value) { return number(float(value)); };
    return number(tangent[0]) + real(7) + real(normal[2]) + real(normal[1]) + number(tangent[1]) +
           number(std::uint8_t{1}) + number(std::int16_t{-3}) + real(8) + real(normal[0]) +
           number(tangent[2]) + number(z);
}

TEST(PlyDirections, AreCarriedInBothByteOrders) {
    for (const std::endian order : {std::endian::little, std::endian::big}) {
        const std::string header =
            headerOf(order == std::endian::big ? "binary_big_endian" : "binary_little_endian", 2);
        const std::string second = row(order, {0.6, 0, 0.8}, {0.1, 0.2, 0.3}, 5);
        const std::string bytes = header + row(order, {1, 2, 3}, {0.1, 0.2, 0.3}, 9) + second;
        const auto model = readModel("a.ply", bytes);
        EXPECT_TRUE(model->hasDirections());
        EXPECT_EQ(turned(*model, kIdentity), bytes);
        auto moved = copyOf(model->positions());
        moved[0][2] = 4;
        EXPECT_EQ(written(*model, moved, std::vector<DeformationGradient>{kQuarterTurn, kIdentity}),
                  header + row(order, {-2, 1, 3}, {-0.2, 0.1, 0.3}, 4) + second);
        EXPECT_EQ(written(*model, moved),
                  header + row(order, {1, 2, 3}, {0.1, 0.2, 0.3}, 4) + second);
    }
}

TEST(PlyDirections, AreCarriedInAscii) {
    const std::string header = headerOf("ascii", 1);
    const std::string text = header + ".10 7  3.0 2.0\t0.2 1 -3 8 1 0.3 9\r\n";
    const auto model = readModel("a.ply", text);
    EXPECT_TRUE(model->hasDirections());
    EXPECT_EQ(turned(*model, kIdentity), text);
    EXPECT_EQ(turned(*model, kQuarterTurn), header + "-0.2 7  3.0 1\t0.1 1 -3 8 -2 0.3 9\r\n");
    EXPECT_EQ(written(*model, std::vector<Point3>{{7, 8, 4}},
                      std::vector<DeformationGradient>{kQuarterTurn}),
              header + "-0.2 7  3.0 1\t0.1 1 -3 8 -2 0.3 4\r\n");
}

TEST(PlyDirections, NormalsUseCofactorsAndTangentsTheGradient) {
    // A stretch by 2 along x turns a normal away from x, and a tangent towards x.
    const DeformationGradient stretch = {2, 0, 0, 0, 1, 0, 0, 0, 1};
    const std::string header = headerOf("ascii", 1);
    const auto model = readModel("a.ply", header + "3 7 1 0 0 0 8 2 4 9\n");
    // cof(F) = diag(1, 2, 2): (2, 0, 1) becomes (2, 0, 2), of length √5. F (3, 0, 4) = (6, 0, 4),
    // of length 5.
    const std::string got = turned(*model, stretch);
    const auto number = [](double value) { return formatNumber(float(value)); };
    const std::string side = number(std::sqrt(2.5));
    std::vector<double> numbers;
    std::istringstream words(got.substr(header.size()));
    for (double value = 0; words >> value;) numbers.push_back(value);
    ASSERT_EQ(numbers.size(), 10u);
    EXPECT_EQ(number(numbers[2]), side);
    EXPECT_EQ(number(numbers[7]), side);
    // The tolerance is a few rounding errors of doubles.
    EXPECT_NEAR(numbers[0], 30 / std::sqrt(52), 1e-14);
    EXPECT_NEAR(numbers[8], 20 / std::sqrt(52), 1e-14);
}

TEST(PlyDirections, VectorsThatAreNoDirectionStay) {
    const std::string header = headerOf("ascii", 4);
    const std::string text = header +
                             "0 7 nan 2 0 0 8 1 0 9\n"
                             "-0 7 1 x2 0 0 8 1 0 9\n"
                             "inf 7 0 -0.0 0 0 8 0 0 9\n"
                             "0 7 3e38 3e38 0 0 8 3e38 0 9\n";
    const auto model = readModel("a.ply", text);
    EXPECT_EQ(turned(*model, kQuarterTurn), text);
    for (const std::endian order : {std::endian::little, std::endian::big}) {
        const std::string bytes =
            headerOf(order == std::endian::big ? "binary_big_endian" : "binary_little_endian", 2) +
            row(order, {1, kNan, 0}, {kInfinity, 0, 0}, 9) +
            row(order, {kInfinity, 0, 1}, {1e308, 1e308, 1e308}, 9);
        EXPECT_EQ(turned(*readModel("a.ply", bytes), kQuarterTurn), bytes);
    }
}

TEST(PlyDirections, NeedThreePropertiesOfRealNumbers) {
    const auto model = [](const std::string& properties) {
        std::string text = "ply\nformat ascii 1.0\nelement vertex 1\n";
        for (const char* name : {"x", "y", "z"})
            text += std::string("property float ") + name + "\n";
        return readModel("a.ply", text + properties + "end_header\n1 2 3 1 0 0 0\n");
    };
    const std::string two = "property float nx\nproperty float ny\n";
    for (const std::string& other :
         {std::string("property char nz\n"), std::string("property list uchar float nz\n"),
          std::string("property float Nz\n")}) {
        const auto none = model(two + other +
                                (other.find("list") == std::string::npos ? "property float w\n"
                                                                         : "property uchar w\n"));
        EXPECT_FALSE(none->hasDirections()) << other;
        EXPECT_EQ(turned(*none, kQuarterTurn), turned(*none, kIdentity)) << other;
    }
    EXPECT_FALSE(model(two + "property float nz\nproperty float nx\n")->hasDirections());
    EXPECT_TRUE(model(two + "property double nz\nproperty float w\n")->hasDirections());
}

TEST(PlyDirections, MixedTypesKeepTheirBytes) {
    const std::string text =
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
        "property float z\nproperty double nx\nproperty float ny\nproperty double nz\n"
        "end_header\n0 0 0 0.1 0.2 0.3\n";
    EXPECT_EQ(turned(*readModel("a.ply", text), kIdentity), text);
}

}  // namespace
}  // namespace espalier::io
