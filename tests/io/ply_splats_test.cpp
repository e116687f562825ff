// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/text_reader.h>
#include <espalier/io/model.h>
#include <io/gradient_samples.h>
#include <io/model_files.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "io/models/splats.h"

namespace espalier::io {
namespace {

using Names = std::vector<std::string>;
using Rows = std::vector<std::vector<double>>;  ///< per splat a number for each property

/// The properties of the authors' program.
Names propertiesOf(std::size_t harmonics) {
    Names names = {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"};
    for (std::size_t i = 0; i < harmonics; ++i) names.push_back("f_rest_" + std::to_string(i));
    for (const char* name :
         {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
        names.push_back(name);
    return names;
}

Rows randomRows(const Names& names, std::size_t count, bool isFloat) {
    Rows rows(count);
    for (std::size_t i = 0; i < count; ++i) {
        rows[i] = randomValues(names.size(), unsigned(7 + i));
        for (std::size_t k = 0; k < names.size(); ++k) {
            if (names[k][0] == 'n') rows[i][k] = 0;
            if (isFloat) rows[i][k] = float(rows[i][k]);
        }
    }
    return rows;
}

struct SplatFile {
    std::string format = "binary_little_endian";
    bool isFloat = true;

    std::endian order() const {
        return format == "binary_big_endian" ? std::endian::big : std::endian::little;
    }

    std::string header(const Names& names, std::size_t count) const {
        std::string text =
            "ply\nformat " + format + " 1.0\nelement vertex " + std::to_string(count) + "\n";
        for (const std::string& name : names)
            text += std::string("property ") + (isFloat ? "float " : "double ") + name + "\n";
        return text + "end_header\n";
    }

    std::string number(double value) const {
        if (format == "ascii")
            return (isFloat ? formatNumber(float(value)) : formatNumber(value)) + " ";
        return isFloat ? bytesOf(float(value), order()) : bytesOf(value, order());
    }

    std::string file(const Names& names, const Rows& rows) const {
        std::string text = header(names, rows.size());
        for (const auto& row : rows) {
            for (const double value : row) text += number(value);
            if (format == "ascii") text += "\n";
        }
        return text;
    }
};

const SplatFile kSplatFiles[] = {{"ascii", true},
                                 {"ascii", false},
                                 {"binary_little_endian", true},
                                 {"binary_little_endian", false},
                                 {"binary_big_endian", true},
                                 {"binary_big_endian", false}};

std::size_t columnOf(const Names& names, const std::string& name) {
    return std::ranges::find(names, name) - names.begin();
}

/// Returns the columns of the numbers of a splat, in the order of carrySplat().
std::vector<std::size_t> splatColumns(const Names& names) {
    std::vector<std::size_t> columns;
    for (const char* name : {"scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
        columns.push_back(columnOf(names, name));
    for (std::size_t i = 0; columnOf(names, "f_rest_" + std::to_string(i)) < names.size(); ++i)
        columns.push_back(columnOf(names, "f_rest_" + std::to_string(i)));
    return columns;
}

/// Returns the rows with carried splats.
Rows carriedRows(const Names& names, Rows rows, const std::vector<DeformationGradient>& gradients,
                 bool isFloat) {
    const auto columns = splatColumns(names);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        std::vector<double> numbers;
        numbers.reserve(columns.size());
        for (const std::size_t column : columns) numbers.push_back(rows[i][column]);
        carrySplat(gradients[i], numbers);
        for (std::size_t k = 0; k < columns.size(); ++k)
            rows[i][columns[k]] = isFloat ? float(numbers[k]) : numbers[k];
    }
    return rows;
}

std::vector<DeformationGradient> randomGradients(std::size_t count) {
    std::mt19937 random(11);
    std::vector<DeformationGradient> gradients;
    for (std::size_t i = 0; i < count; ++i) gradients.push_back(randomGradient(random));
    gradients[count / 2] = kIdentity;
    return gradients;
}

TEST(PlySplats, AreCarriedInAllFormats) {
    for (const SplatFile& sample : kSplatFiles) {
        for (const std::size_t harmonics : {0, 9, 24, 45}) {
            const Names names = propertiesOf(harmonics);
            const Rows rows = randomRows(names, 8, sample.isFloat);
            const std::string bytes = sample.file(names, rows);
            const auto model = readModel("a.ply", bytes);
            EXPECT_EQ(model->directions().splats, 8u);
            EXPECT_EQ(model->directions().normals, 0u);
            EXPECT_EQ(model->directions().keptHarmonics, 0u);
            EXPECT_TRUE(model->hasDirections());
            EXPECT_EQ(turned(*model, kIdentity), bytes);
            EXPECT_EQ(written(*model, model->positions()), bytes);
            const auto gradients = randomGradients(8);
            Rows wanted = carriedRows(names, rows, gradients, sample.isFloat);
            EXPECT_EQ(written(*model, model->positions(), gradients), sample.file(names, wanted));
            // Points and splats move at once.
            auto moved = copyOf(model->positions());
            moved[1] = {4, -5, 6.5};
            std::ranges::copy(moved[1], wanted[1].begin());
            EXPECT_EQ(written(*model, moved, gradients), sample.file(names, wanted));
        }
    }
}

TEST(PlySplats, MayHaveTheirPropertiesInAnyOrder) {
    std::mt19937 random(13);
    for (const SplatFile& sample : kSplatFiles) {
        Names names = propertiesOf(9);
        names.push_back("label");
        std::ranges::shuffle(names, random);
        const Rows rows = randomRows(names, 5, sample.isFloat);
        const auto model = readModel("a.ply", sample.file(names, rows));
        EXPECT_EQ(model->directions().splats, 5u);
        const auto gradients = randomGradients(5);
        EXPECT_EQ(written(*model, model->positions(), gradients),
                  sample.file(names, carriedRows(names, rows, gradients, sample.isFloat)));
    }
}

TEST(PlySplats, StandBesideOtherTypesAndElements) {
    const std::string text =
        "ply\r\nformat ascii 1.0\r\nelement camera 1\r\nproperty list uchar int ids\r\n"
        "element vertex 2\r\nproperty uchar red\r\nproperty float x\r\nproperty float y\r\n"
        "property float z\r\nproperty double rot_3\r\nproperty float rot_0\r\n"
        "property float rot_1\r\nproperty double rot_2\r\nproperty float scale_0\r\n"
        "property float scale_1\r\nproperty float scale_2\r\nelement face 1\r\n"
        "property list uchar int vertex_indices\r\nend_header\r\n2 7 8\r\n\r\n"
        " 7 1 2\t3 0 1.0 0 0 -1 -2 -3.0\r\n7 4 5 6 0 2 0.0 0 -1 -2 x\r\n3 0 1 0\r\n";
    const auto model = readModel("a.ply", text);
    EXPECT_EQ(model->directions().splats, 2u);
    EXPECT_EQ(turned(*model, kIdentity), text);
    // A quarter turn around z: w = z = √½, but for a rounding of the double. The second splat has a
    // word that is no number.
    const std::string half = formatNumber(float(std::sqrt(0.5)));
    std::string wanted = text;
    wanted.replace(wanted.find("3 0 1.0 0 0 -1"), 14, "3 0.7071067811865475 " + half + " 0 0 -1");
    EXPECT_EQ(turned(*model, kQuarterTurn), wanted);
}

TEST(PlySplats, RigidPosesAreExactInFloats) {
    const Names names = propertiesOf(45);
    const SplatFile sample{"ascii", true};
    const Rows rows = randomRows(names, 20, true);
    const auto model = readModel("a.ply", sample.file(names, rows));
    const DeformationGradient there = rotation({1, -2, 0.5}, 0.9);
    const DeformationGradient back = rotation({1, -2, 0.5}, -0.9);
    const auto posed = readModel("a.ply", turned(*model, there));
    std::istringstream words(turned(*posed, back).substr(sample.header(names, 20).size()));
    for (const auto& row : rows)
        for (std::size_t k = 0; k < names.size(); ++k) {
            double got = 0;
            words >> got;
            EXPECT_NEAR(got, row[k], 1e-6) << names[k];
        }
}

TEST(PlySplats, NeedAllScalesAndRotations) {
    const SplatFile sample{"ascii", true};
    const Names all = propertiesOf(9);
    for (const char* missing : {"scale_0", "scale_2", "rot_0", "rot_3"}) {
        for (const bool isRepeated : {false, true}) {
            Names names = all;
            names[columnOf(names, missing)] = isRepeated ? "rot_1" : "other";
            const std::string text = sample.file(names, randomRows(names, 3, true));
            const auto model = readModel("a.ply", text);
            EXPECT_EQ(model->directions().splats, 0u) << missing;
            // Without splats, 0 0 0 is a normal that stays.
            EXPECT_EQ(model->directions().normals, 3u);
            EXPECT_EQ(turned(*model, kQuarterTurn), text);
        }
    }
    // Vertices with lists are no splats.
    const std::string list = "property list uchar int ids\nend_header\n";
    const std::string text = sample.file(all, randomRows(all, 1, true));
    std::string with = text.substr(0, text.find("end_header\n")) + list +
                       text.substr(text.find("end_header\n") + 11);
    with.insert(with.size() - 1, "1 5");
    EXPECT_EQ(readModel("a.ply", with)->directions().splats, 0u);
    EXPECT_EQ(turned(*readModel("a.ply", with), kQuarterTurn), with);
}

TEST(PlySplats, HarmonicsOfNoDegreeStay) {
    const SplatFile sample{"binary_little_endian", true};
    for (const std::size_t harmonics : {1, 3, 10, 72}) {
        const Names names = propertiesOf(harmonics);
        const Rows rows = randomRows(names, 3, true);
        const auto model = readModel("a.ply", sample.file(names, rows));
        EXPECT_EQ(model->directions().splats, 3u);
        EXPECT_EQ(model->directions().keptHarmonics, harmonics);
        // All other numbers are carried as if there were no harmonics.
        Rows wanted = carriedRows(
            propertiesOf(0),
            [&] {
                Rows few = rows;
                for (auto& row : few) row.erase(row.begin() + 9, row.begin() + 9 + harmonics);
                return few;
            }(),
            std::vector<DeformationGradient>(3, kQuarterTurn), true);
        for (std::size_t i = 0; i < 3; ++i)
            wanted[i].insert(wanted[i].begin() + 9, rows[i].begin() + 9,
                             rows[i].begin() + 9 + harmonics);
        EXPECT_EQ(turned(*model, kQuarterTurn), sample.file(names, wanted));
    }
    // Nine harmonics, of which one has another name.
    Names names = propertiesOf(9);
    names[columnOf(names, "f_rest_4")] = "f_rest_9";
    const auto model = readModel("a.ply", sample.file(names, randomRows(names, 2, true)));
    EXPECT_EQ(model->directions().splats, 2u);
    EXPECT_EQ(model->directions().keptHarmonics, 9u);
}

TEST(PlySplats, NormalsThatAreNotZeroTurnToo) {
    const SplatFile sample{"binary_little_endian", true};
    const Names names = propertiesOf(0);
    Rows rows = randomRows(names, 2, true);
    rows[1][columnOf(names, "nx")] = 1;
    const auto model = readModel("a.ply", sample.file(names, rows));
    EXPECT_EQ(model->directions().splats, 2u);
    EXPECT_EQ(model->directions().normals, 2u);
    EXPECT_EQ(model->directions().count(), 4u);
    Rows wanted = carriedRows(names, rows, {kQuarterTurn, kQuarterTurn}, true);
    wanted[1][columnOf(names, "nx")] = 0;
    wanted[1][columnOf(names, "ny")] = 1;
    EXPECT_EQ(turned(*model, kQuarterTurn), sample.file(names, wanted));
}

TEST(PlySplats, AreNamedIfAFormatLacksThem) {
    const SplatFile sample{"ascii", true};
    const Names names = propertiesOf(9);
    const auto model = readModel("a.ply", sample.file(names, randomRows(names, 2, true)));
    EXPECT_EQ(model->checkTarget("b.obj"),
              "b.obj: the .ply has data that are not written: splats, properties of points "
              "'f_dc_0', 'f_dc_1', 'f_dc_2', 'opacity'");
}

// One splat is long along x, is turned to y by a quaternion of length 2, and is red and opaque.
TEST(PlySplats, AppearAsCovariancesAndColours) {
    const SplatFile sample{"ascii", false};
    const Names names = propertiesOf(9);
    Rows rows = randomRows(names, 2, false);
    const auto set = [&](const char* name, double value) {
        rows[1][columnOf(names, name)] = value;
    };
    const double third = std::log(3), half = std::sqrt(0.5);
    set("scale_0", third);
    set("scale_1", 0);
    set("scale_2", -third);
    for (const char* name : {"rot_1", "rot_2"}) set(name, 0);
    for (const char* name : {"rot_0", "rot_3"}) set(name, 2 * half);
    set("f_dc_0", 0.25 / 0.28209479177387814);
    set("f_dc_1", -9);
    set("f_dc_2", 9);
    set("opacity", std::log(4));
    const auto model = readModel("a.ply", sample.file(names, rows));
    ModelSurface surface = model->readSurface();
    readAppearance(*model, surface);
    ASSERT_EQ(surface.covariances.size(), 2u);
    const std::array<float, 6> wanted = {1, 0, 0, 9, 0, 1 / 9.0F};
    for (std::size_t i = 0; i < 6; ++i)
        EXPECT_NEAR(surface.covariances[1][i], wanted[i], 1e-6) << i;
    const std::array<float, 4> color = {0.75F, 0, 1, 0.8F};
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(surface.colors[1][i], color[i], 1e-6) << i;
    EXPECT_EQ(model->checkTarget("b.glb"),
              "b.glb: the .ply has data that are not written: splats; coordinates are rounded to "
              "single precision");
}

TEST(PlySplats, ManyAreCarriedByAllThreads) {
    for (const char* format : {"ascii", "binary_big_endian"}) {
        const SplatFile sample{format, true};
        const Names names = propertiesOf(9);
        const Rows rows = randomRows(names, 5000, true);
        const auto model = readModel("a.ply", sample.file(names, rows));
        const auto gradients = randomGradients(rows.size());
        EXPECT_EQ(written(*model, model->positions(), gradients),
                  sample.file(names, carriedRows(names, rows, gradients, true)));
    }
}

}  // namespace
}  // namespace espalier::io
