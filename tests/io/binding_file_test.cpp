// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/memory.h>
#include <espalier/io/binding_file.h>
#include <espalier/io/files/file.h>
#include <espalier/io/model.h>
#include <zlib.h>

#include <fstream>

#include "io/files/bytes.h"
#include "support/temporary_folder.h"
#include "support/test.h"

namespace espalier::io {
namespace {

/// Three points in a lattice of four vertices, with a triangle and a quadrilateral. The second
/// point is outside.
BoundModel sample(bool hasGradients = false) {
    BoundModel model;
    bind::Binding& binding = model.binding;
    binding.table = stencils::StencilTable<double>(4, {0, 2, 2, 3}, {1, 3, 0}, {1. / 3, 2. / 3, 1});
    binding.topologyHash = 0x0123456789abcdefu;
    binding.points = {{0.1 + 0.2, -1e-300, 1}, {1e300, 1. / 3, 0}, {7, 8, 9}};
    binding.rest = {{0.1, 0.2, 0.3}, {1, 0, 0}, {0, -1e-300, 0}, {0, 0, 7}};
    binding.statuses = {embed::PointStatus::Inside, embed::PointStatus::Outside,
                        embed::PointStatus::NotConverged};
    binding.largestResidual = 1e-15;
    if (hasGradients) {
        // A cell of the two vertices, without layers around it.
        embed::SplinePlaces::Patch patch;
        patch.fill(kMaxIndex);
        for (std::size_t corner = 0; corner < 8; ++corner)
            patch[21 + corner % 2 + 4 * (corner / 2 % 2) + 16 * (corner / 4)] = Index(corner % 2);
        // Two vertices of a level; rows of the third point, and a place of the second in a cell.
        binding.gradients = embed::Gradients{
            stencils::StencilTable<double>(4, {0, 2, 4}, {0, 3, 1, 2}, {-1. / 3, 1. / 3, 2, -2}),
            {2},
            stencils::StencilTable<double>(2, {0, 0, 1, 2}, {1, 0}, {1e300, -1e300}),
            {{{0, 1, 0, 1, 0, 1, 0, 1}}, {{1, 0, {0.125, 0.75, 1. / 7}}}},
            {0.125, {patch}, {{0, 0, {0.5, 0.25, 1. / 3}}}}};
        binding.weights = {{0.75, {1e-300, -2, 1. / 3}}, {0, {}}, {1, {}}};
    }
    model.faces = {{0, 1, 3, 3, 2, 1, 0}, {3, 7}};
    model.modelName = "bunny.obj";
    model.modelBytes = std::string("v 1 2 3\n\0\xff", 10);
    return model;
}

void expectEqual(const BoundModel& a, const BoundModel& b) {
    EXPECT_EQ(a.binding, b.binding);
    EXPECT_EQ(a.modelName, b.modelName);
    EXPECT_EQ(a.modelBytes, b.modelBytes);
    EXPECT_EQ(a.faces, b.faces);
}

/// Replaces the checksum at the end of the bytes by the right one.
std::string withChecksum(std::string bytes) {
    const std::size_t end = bytes.size() - sizeof(std::uint32_t);
    const auto checksum =
        std::uint32_t(::crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), end));
    storeNumber(bytes.data() + end, checksum, std::endian::little);
    return bytes;
}

// Places in the file of sample() without gradients.
constexpr std::size_t kSizesAt = 32, kTableAt = kSizesAt + 17 * 8, kWeightsAt = kTableAt + 4 * 8,
                      kPointsAt = kWeightsAt + 3 * 8 + 3 * 4, kRestAt = kPointsAt + 3 * 24,
                      kStatusesAt = kRestAt + 4 * 24, kEndsAt = kStatusesAt + 3,
                      kCornersAt = kEndsAt + 2 * 8, kNameAt = kCornersAt + 7 * 4,
                      kFileSize = kNameAt + 9 + 10 + 4;

TEST(BindingFile, RoundTripIsExact) {
    const TemporaryFolder folder;
    for (const bool hasGradients : {false, true}) {
        writeBoundModel(folder / "a.espb", sample(hasGradients));
        expectEqual(readBoundModel(folder / "a.espb"), sample(hasGradients));
        const std::string bytes = readFile(folder / "a.espb");
        EXPECT_EQ(bytes[8], 8) << "the version";
        EXPECT_EQ(bytes[12], hasGradients);
        // Tables with 3 and 4 offsets, 6 entries and a point; a cell and a place in it; a spacing,
        // a patch, a place, a basis, and three weights.
        constexpr std::size_t kTables = (3 + 4) * 8 + 6 * (8 + 4) + 4 + 8 * 4 + 2 * 4 + 3 * 8,
                              kSplines = 8 + 64 * 4 + 2 * 4 + 3 * 8 + 4 * 4 + 3 * 4 * 8;
        EXPECT_EQ(bytes.size(), kFileSize + (hasGradients ? kTables + kSplines : 0));
    }
}

TEST(BindingFile, PartsThatDoNotFitAreNotWritten) {
    const TemporaryFolder folder;
    const auto expectRefused = [&](const std::string& why, auto change) {
        BoundModel model = sample(true);
        change(model);
        EXPECT_REFUSED(Error, why, writeBoundModel(folder / "a.espb", model));
    };
    expectRefused("of 3 points and 4 lattice vertices has gradients of 0 vertices",
                  [](BoundModel& model) { *model.binding.gradients = {}; });
    expectRefused("has 2 weights", [](BoundModel& model) { model.binding.weights.pop_back(); });
    expectRefused("point 0 is in patch 1 of 1",
                  [](BoundModel& model) { model.binding.gradients->splines.places[0].patch = 1; });
    expectRefused("has 3 vertices at rest",
                  [](BoundModel& model) { model.binding.rest.pop_back(); });
    expectRefused("has 2 points at rest",
                  [](BoundModel& model) { model.binding.points.pop_back(); });
    expectRefused("has point 1 that is not finite",
                  [](BoundModel& model) { model.binding.points[1][2] = kNan; });
    expectRefused("has vertex 3 that is not finite",
                  [](BoundModel& model) { model.binding.rest[3][0] = kInfinity; });
    expectRefused("has 4 statuses",
                  [](BoundModel& model) { model.binding.statuses.push_back({}); });
    expectRefused("has a largest residual that is not a length",
                  [](BoundModel& model) { model.binding.largestResidual = -1; });
    expectRefused("has faces that do not divide their corners",
                  [](BoundModel& model) { model.faces.ends[1] = 6; });
    expectRefused("has a face of vertex 4", [](BoundModel& model) { model.faces.corners[2] = 4; });
    EXPECT_FALSE(std::filesystem::exists(folder / "a.espb"));
}

// Points of no file are a model of their own, with all their digits.
TEST(BindingFile, PointsBecomeAModel) {
    BoundModel model = sample();
    model.modelName.clear();
    const auto points = modelOf(model, "a.espb");
    EXPECT_THAT(points->positions(), ::testing::ElementsAreArray(model.binding.points));
    model.modelName = "bunny.obj";
    model.modelBytes = "v 1 2 3\nv 0 0 0\nv 1 1 1\n";
    EXPECT_EQ(modelOf(model, "a.espb")->positions()[0], (Point3{1, 2, 3}));
    model.modelBytes = "v 1 2 3\n";
    EXPECT_REFUSED(
        FileError,
        "a.espb: is damaged: the number of points of its model is 1, and 3 points were bound",
        modelOf(model, "a.espb"));
    EXPECT_REFUSED(FileError, "the model has no points", modelOf(BoundModel(), "a.espb"));
}

TEST(BindingFile, MemoryThatAModelLacksIsNoFaultOfTheFile) {
    const TemporaryFolder folder;
    BoundModel model = sample();
    readModel("a.obj", "v 1 2 3\nv 4 5 6\nv 7 8 9\n")
        ->write(folder / "a.vtu", std::vector<Point3>(3));
    model.modelName = "a.vtu";
    model.modelBytes = readFile(folder / "a.vtu");
    EXPECT_EQ(modelOf(model, "a.espb")->positions().size(), 3U);
    const MemoryLimit limit(1);
    EXPECT_THROW(modelOf(model, "a.espb"), MemoryError);
}

TEST(BindingFile, RoundTripKeepsEmptyParts) {
    const TemporaryFolder folder;
    BoundModel model = sample();
    model.modelName.clear();
    model.modelBytes.clear();
    model.faces = {};
    writeBoundModel(folder / "a.espb", model);
    expectEqual(readBoundModel(folder / "a.espb"), model);
    writeBoundModel(folder / "b.espb", {});
    expectEqual(readBoundModel(folder / "b.espb"), {});
}

/// Without gradients and with them.
class DamagedBindingFile : public ::testing::TestWithParam<bool> {
protected:
    DamagedBindingFile() {
        writeBoundModel(path, sample(GetParam()));
        bytes = readFile(path);
    }
    void expectRefused(const std::string& damaged, const std::string& why) {
        std::ofstream(path, std::ios::binary) << damaged;
        EXPECT_THAT(messageOf<FileError>([&] { readBoundModel(path); }),
                    AllOf(HasSubstr(path.string() + ": "), HasSubstr(why)));
    }
    const TemporaryFolder folder;
    const std::filesystem::path path = folder / "a.espb";
    std::string bytes;
};

TEST_P(DamagedBindingFile, TruncatedFileIsRefused) {
    for (std::size_t size = 0; size < bytes.size(); ++size)
        expectRefused(bytes.substr(0, size), size < 8 ? "is not a bound model" : "truncated");
    expectRefused(bytes + "x", "its size is not what its header says");
}

TEST_P(DamagedBindingFile, AnyFlippedBitIsRefused) {
    for (std::size_t at = 0; at < bytes.size(); ++at) {
        std::string damaged = bytes;
        damaged[at] = char(damaged[at] ^ 0x10);
        expectRefused(damaged, "");
    }
}

TEST_P(DamagedBindingFile, OtherKindsAndVersionsAreRefusedByName) {
    expectRefused("# OBJ file\nv 1 2 3\n", "is not a bound model");
    for (const int version : {1, 7, 9}) {
        std::string other = bytes;
        other[8] = char(version);
        expectRefused(other,
                      concat("is a bound model of version ", version,
                             ", and this program reads version 8 only: bind the model again"));
    }
}

// A header that claims 10¹⁸ entries is refused before memory is allocated for them.
TEST_P(DamagedBindingFile, HugeClaimedSizesAreRefused) {
    for (std::size_t field = 0; field < 16; ++field) {
        std::string damaged = bytes;
        damaged[kSizesAt + 8 * field + 7] = 0x0d;
        expectRefused(damaged, "its size is not what its header says");
        damaged[kSizesAt + 8 * field + 7] = char(0xff);
        expectRefused(damaged, "its size is not what its header says");
    }
}

TEST_P(DamagedBindingFile, AWrongFlagIsRefused) {
    std::string other = bytes;
    other[12] = char(!GetParam());
    expectRefused(withChecksum(other), "its size is not what its header says");
    other[12] = 2;
    expectRefused(withChecksum(other), "has the flag 2 for gradients");
}

TEST_P(DamagedBindingFile, NumbersThatAreNotFiniteAreRefused) {
    const auto refused = [&](std::size_t at, const std::string& why) {
        for (const double number : {kNan, -kInfinity}) {
            std::string damaged = bytes;
            storeNumber(damaged.data() + at, number, std::endian::little);
            expectRefused(withChecksum(damaged), why);
        }
    };
    const std::size_t more = bytes.size() - kFileSize;
    refused(kSizesAt - 8, "has a largest residual that is not a length");
    refused(kWeightsAt + 8, "has a weight that is not finite: number 1 of its table");
    refused(kPointsAt + more + 24 + 8, "has a position that is not finite: point 1");
    refused(kRestAt + more + 24,
            "has a position that is not finite: vertex of the lattice at rest 1");
    if (GetParam())
        refused(kPointsAt + 3 * 8, "has a weight that is not finite: number 0 of its table");
}

TEST(BindingFile, DamagedPlacesAreRefused) {
    const TemporaryFolder folder;
    const auto path = folder / "p.espb";
    writeBoundModel(path, sample(true));
    const std::string bytes = readFile(path);
    // The weights end before the points; the place, the patch and the spacing are before them.
    constexpr std::size_t kEnd = kPointsAt + (3 + 4) * 8 + 6 * (8 + 4) + 4 + 8 * 4 + 2 * 4 + 3 * 8 +
                                 8 + 64 * 4 + 2 * 4 + 3 * 8 + 4 * 4 + 3 * 4 * 8,
                          kWeights = kEnd - 3 * 4 * 8, kPlace = kWeights - 4 * 4 - 2 * 4 - 3 * 8,
                          kPatch = kPlace - 64 * 4;
    const auto expectRefused = [&](std::size_t at, auto number, const std::string& why) {
        std::string damaged = bytes;
        storeNumber(damaged.data() + at, number, std::endian::little);
        std::ofstream(path, std::ios::binary) << withChecksum(damaged);
        EXPECT_THAT(messageOf<FileError>([&] { readBoundModel(path); }),
                    AllOf(HasSubstr("is damaged"), HasSubstr(why)));
    };
    expectRefused(kPlace + 4, std::int32_t{7}, "the gradient of point 0 is in patch 7 of 1");
    expectRefused(kPlace + 16, kNan, "the place of point 0 in its cell is not finite");
    expectRefused(kPatch + 4 * 21, std::int32_t{4}, "has vertex 4 at its control point 21");
    expectRefused(kPatch, std::int32_t{0}, "has vertex 0 at its control point 0; expected none");
    expectRefused(kPatch - 8, -1.0, "a spacing of -1");
    expectRefused(kPatch - 16, kNan, "the place of point 1 in its cell is not finite");
    expectRefused(kPatch - 36, std::int32_t{1}, "the gradient of point 1 is in cell 1 of 1");
    expectRefused(kPatch - 40, std::int32_t{2}, "the point 2 has gradients twice");
    expectRefused(kPatch - 44, std::int32_t{2}, "a cell of the gradients has vertex 2");
    expectRefused(kWeights, 1.5, "the weight 1.5 with the slope");
    expectRefused(kWeights + 5 * 8, kNan, "the weight 0 with the slope nan 0 0 at point 1");
}

INSTANTIATE_TEST_SUITE_P(BindingFile, DamagedBindingFile, ::testing::Bool(), [](const auto& test) {
    return test.param ? "WithGradients" : "WithoutGradients";
});

// A cube with a Bézier basis, and a point in it.
TEST(BindingFile, PlacesInABasisAreKept) {
    BoundModel model;
    bind::Binding& binding = model.binding;
    const stencils::StencilTable<double> corners(
        8, {0, 1, 2, 3, 4, 5, 6, 7, 8}, {7, 6, 5, 4, 3, 2, 1, 0}, {1, 1, 1, 1, 1, 1, 1, 1});
    binding.table = stencils::StencilTable<double>(8, {0, 1}, {0}, {1});
    binding.points = {{0.5, 0.5, 0.5}};
    for (const double z : {0.0, 1.0})
        for (const double y : {0.0, 1.0})
            for (const double x : {0.0, 1.0}) binding.rest.push_back({x, y, z});
    binding.statuses = {embed::PointStatus::Inside};
    binding.gradients = embed::Gradients{corners, {}, {8, {0}, {}, {}}};
    binding.gradients->basis = {embed::Basis::Bezier, {1, 1, 1}, {{0, {0.25, 0.5, 1. / 3}}}};
    const TemporaryFolder folder;
    writeBoundModel(folder / "b.espb", model);
    expectEqual(readBoundModel(folder / "b.espb"), model);
    const std::string bytes = readFile(folder / "b.espb");
    const auto expectRefused = [&](std::size_t at, auto number, const std::string& why) {
        std::string damaged = bytes;
        storeNumber(damaged.data() + at, number, std::endian::little);
        std::ofstream(folder / "b.espb", std::ios::binary) << withChecksum(damaged);
        EXPECT_REFUSED(FileError, why, readBoundModel(folder / "b.espb"));
    };
    // At the end are the place, the point and the vertices at rest, the status, and the checksum.
    const std::size_t at = bytes.size() - 4 - 1 - 9 * 24 - 24;
    expectRefused(at, 1.5, "in the lattice is 1.5 along axis 0; expected 0 to 1");
    expectRefused(at - 4, std::int32_t{1}, "gradients of the point 1; there are 1");
    expectRefused(at - 8, std::int32_t{2}, "in a lattice of 1 × 1 × 2 cells have 8 vertices");
    expectRefused(at - 20, std::int32_t{2}, "has the basis 2; expected 0 or 1");
}

TEST(BindingFile, DamagedFacesAndStatusesAreRefused) {
    const TemporaryFolder folder;
    const auto path = folder / "f.espb";
    writeBoundModel(path, sample());
    const std::string bytes = readFile(path);
    const auto expectRefused = [&](std::size_t at, auto number, const std::string& why) {
        std::string damaged = bytes;
        storeNumber(damaged.data() + at, number, std::endian::little);
        std::ofstream(path, std::ios::binary) << withChecksum(damaged);
        EXPECT_THAT(messageOf<FileError>([&] { readBoundModel(path); }), HasSubstr(why));
    };
    expectRefused(kStatusesAt + 1, std::uint8_t{4}, "has the status 4 for point 1");
    expectRefused(kEndsAt, std::int64_t{-1}, "ends face 0 of the lattice at corner -1");
    expectRefused(kEndsAt, std::int64_t{8}, "ends face 0 of the lattice at corner 8");
    expectRefused(kEndsAt + 8, std::int64_t{2}, "ends face 1 of the lattice at corner 2");
    expectRefused(kEndsAt + 8, std::int64_t{6}, "has 7 corners of faces; the faces use 6");
    expectRefused(kCornersAt, Index{4}, "has a face of the lattice with vertex 4");
    expectRefused(kCornersAt, Index{-1}, "has a face of the lattice with vertex -1");
}

TEST(BindingFile, MissingFileIsNamed) {
    const TemporaryFolder folder;
    EXPECT_THROW(readBoundModel(folder / "none.espb"), FileError);
}

}  // namespace
}  // namespace espalier::io
