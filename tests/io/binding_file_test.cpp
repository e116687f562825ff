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

BoundModel sample() {
    BoundModel model;
    model.binding.table =
        stencils::StencilTable<double>(4, {0, 2, 2, 3}, {1, 3, 0}, {1. / 3, 2. / 3, 1});
    model.binding.kept = {1};
    model.binding.keptAt = {{0.1, -2.5, 1e300}};
    model.binding.topologyHash = 0x0123456789abcdefu;
    model.modelName = "bunny.obj";
    model.modelBytes = std::string("v 1 2 3\n\0\xff", 10);
    return model;
}

BoundModel sampleWithRest() {
    BoundModel model = sample();
    model.binding.rest = {{0.1, 0.2, 0.3}, {1, 0, 0}, {0, -1e-300, 0}, {0, 0, 7}};
    return model;
}

BoundModel sampleWithGradients() {
    BoundModel model = sample();
    model.binding.gradients = {
        stencils::StencilTable<double>(4, {0, 2, 2, 4}, {0, 3, 1, 2}, {-1. / 3, 1. / 3, 2, -2}),
        stencils::StencilTable<double>(4, {0, 0, 0, 2}, {1, 3}, {1e300, -1e300}),
        stencils::StencilTable<double>(4, {0, 0, 0, 0}, {}, {})};
    model.binding.rest = sampleWithRest().binding.rest;
    return model;
}

/// The faces of the lattice: a triangle and a quadrilateral.
BoundModel sampleWithFaces(BoundModel model) {
    model.binding.rest = sampleWithRest().binding.rest;
    model.faces = {{0, 1, 3, 3, 2, 1, 0}, {3, 7}};
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

TEST(BindingFile, RoundTripIsExact) {
    const TemporaryFolder folder;
    writeBoundModel(folder / "a.espb", sample());
    expectEqual(readBoundModel(folder / "a.espb"), sample());
    writeBoundModel(folder / "g.espb", sampleWithGradients());
    expectEqual(readBoundModel(folder / "g.espb"), sampleWithGradients());
    writeBoundModel(folder / "r.espb", sampleWithRest());
    expectEqual(readBoundModel(folder / "r.espb"), sampleWithRest());
    for (const BoundModel& model : {sample(), sampleWithGradients()}) {
        writeBoundModel(folder / "f.espb", sampleWithFaces(model));
        expectEqual(readBoundModel(folder / "f.espb"), sampleWithFaces(model));
    }
}

TEST(BindingFile, TheVersionSaysWhichPartsThereAre) {
    const TemporaryFolder folder;
    writeBoundModel(folder / "a.espb", sample());
    writeBoundModel(folder / "g.espb", sampleWithGradients());
    writeBoundModel(folder / "r.espb", sampleWithRest());
    writeBoundModel(folder / "f.espb", sampleWithFaces(sample()));
    writeBoundModel(folder / "fg.espb", sampleWithFaces(sampleWithGradients()));
    const std::string old = readFile(folder / "a.espb"), with = readFile(folder / "g.espb");
    const std::string withRest = readFile(folder / "r.espb");
    EXPECT_EQ(old[8], 1);
    EXPECT_EQ(with[8], 2);
    EXPECT_EQ(withRest[8], 3);
    const std::string withFaces = readFile(folder / "f.espb"),
                      withAll = readFile(folder / "fg.espb");
    EXPECT_EQ(withFaces[8], 4);
    EXPECT_EQ(withFaces[12], 0);
    EXPECT_EQ(withAll[8], 4);
    EXPECT_EQ(withAll[12], 1);
    // Two numbers, the ends of 2 faces, and 7 corners.
    EXPECT_EQ(withFaces.size(), withRest.size() + 2 * 8 + 2 * 8 + 7 * 4);
    EXPECT_EQ(withAll.size(), with.size() + 2 * 8 + 2 * 8 + 7 * 4);
    EXPECT_EQ(withRest.size(), old.size() + 4 * 24);
    // The header, 3 offsets + 1, 3 weights, a point, 3 columns, a kept point; model and checksum.
    EXPECT_EQ(old.size(), 72u + 4 * 8 + 3 * 8 + 24 + 3 * 4 + 4 + 9 + 10 + 4);
    EXPECT_EQ(with.size(), old.size() + 3 * 8 + 3 * 4 * 8 + 6 * (8 + 4) + 4 * 24);
}

TEST(BindingFile, GradientsOfAnotherShapeAreNotWritten) {
    const TemporaryFolder folder;
    BoundModel model = sampleWithGradients();
    model.binding.rest.pop_back();
    EXPECT_THROW(writeBoundModel(folder / "a.espb", model), Error);
    model = sampleWithGradients();
    (*model.binding.gradients)[1] = {};
    EXPECT_THROW(writeBoundModel(folder / "a.espb", model), Error);
    model = sampleWithFaces(sample());
    model.binding.rest.clear();
    EXPECT_THROW(writeBoundModel(folder / "a.espb", model), Error);
    model = sampleWithFaces(sample());
    model.faces.corners[2] = 4;
    EXPECT_REFUSED(Error, "has a face of vertex 4", writeBoundModel(folder / "a.espb", model));
    EXPECT_FALSE(std::filesystem::exists(folder / "a.espb"));
}

// Without the file of a model, the points are stored as one, with all their digits.
TEST(BindingFile, PointsBecomeAModel) {
    const TemporaryFolder folder;
    BoundModel model = sample();
    const std::vector<Point3> points = {{0.1 + 0.2, -1e-300, 1}, {1e300, 1. / 3, 0}, {7, 8, 9}};
    model.binding.points = points;
    writeBoundModel(folder / "a.espb", model);
    EXPECT_EQ(readBoundModel(folder / "a.espb").modelName, "bunny.obj");
    model.modelName.clear();
    model.modelBytes.clear();
    EXPECT_EQ(pointsAtRest(model), std::nullopt);
    writeBoundModel(folder / "a.espb", model);
    const BoundModel back = readBoundModel(folder / "a.espb");
    EXPECT_EQ(back.modelName, "points.obj");
    EXPECT_EQ(pointsAtRest(back), points);
    model.binding.points.pop_back();
    EXPECT_REFUSED(Error, "is to be written with 2 points at rest",
                   writeBoundModel(folder / "a.espb", model));
    model.binding.points = points;
    model.binding.points[1][2] = kNan;
    EXPECT_REFUSED(Error, "point 1 is not finite", writeBoundModel(folder / "a.espb", model));
    BoundModel other = back;
    other.modelBytes = "v 1 2 3\n";
    EXPECT_REFUSED(Error, "binds 3 points, but its model has 1", pointsAtRest(other));
    EXPECT_EQ(pointsAtRest(BoundModel()), std::vector<Point3>());
    EXPECT_REFUSED(FileError, "a.espb: binds 3 points, but its model has 1",
                   pointsAtRest(other, folder / "a.espb"));
}

TEST(BindingFile, MemoryThatAModelLacksIsNoFaultOfTheFile) {
    const TemporaryFolder folder;
    BoundModel model = sample();
    readModel("a.obj", "v 1 2 3\nv 4 5 6\nv 7 8 9\n")
        ->write(folder / "a.vtu", std::vector<Point3>(3));
    model.modelName = "a.vtu";
    model.modelBytes = readFile(folder / "a.vtu");
    EXPECT_EQ(pointsAtRest(model, "a.espb"), std::vector<Point3>(3));
    const MemoryLimit limit(1);
    EXPECT_THROW(pointsAtRest(model, "a.espb"), MemoryError);
}

// The empty parts are: kept points, name and model.
TEST(BindingFile, RoundTripKeepsEmptyParts) {
    const TemporaryFolder folder;
    BoundModel model = sample();
    model.binding.kept.clear();
    model.binding.keptAt.clear();
    model.modelName.clear();
    model.modelBytes.clear();
    writeBoundModel(folder / "a.espb", model);
    expectEqual(readBoundModel(folder / "a.espb"), model);
    writeBoundModel(folder / "b.espb", {});
    expectEqual(readBoundModel(folder / "b.espb"), {});
}

/// Without gradients and with them.
class DamagedBindingFile : public ::testing::TestWithParam<bool> {
protected:
    DamagedBindingFile() {
        writeBoundModel(path, GetParam() ? sampleWithGradients() : sample());
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
    std::string newer = bytes;
    newer[8] = 5;
    expectRefused(newer, "has version 5; expected 1 to 4");
}

// A header that claims 10¹⁸ entries is refused before memory is allocated for them.
TEST_P(DamagedBindingFile, HugeClaimedSizesAreRefused) {
    for (std::size_t field = 0; field < (GetParam() ? 9 : 6); ++field) {
        // In a file without the lattice at rest, the number of columns needs no bytes.
        if (field == 1 && !GetParam()) continue;
        std::string damaged = bytes;
        damaged[24 + 8 * field + 7] = 0x0d;
        expectRefused(damaged, "its size is not what its header says");
        damaged[24 + 8 * field + 7] = char(0xff);
        expectRefused(damaged, "its size is not what its header says");
    }
}

// Changes the version, so that the sizes belong to the other version.
TEST_P(DamagedBindingFile, WrongVersionNumberIsRefused) {
    std::string other = bytes;
    other[8] = GetParam() ? 1 : 2;
    expectRefused(withChecksum(other), "its size is not what its header says");
}

TEST_P(DamagedBindingFile, NumbersThatAreNotFiniteAreRefused) {
    const auto refused = [&](std::size_t at, const std::string& why) {
        for (const double number : {kNan, -kInfinity}) {
            std::string damaged = bytes;
            storeNumber(damaged.data() + at, number, std::endian::little);
            expectRefused(withChecksum(damaged), why);
        }
    };
    const std::size_t header = GetParam() ? 96 : 72, weights = header + 4 * 8;
    refused(weights + 8, "has a weight that is not finite: number 1 of its table");
    refused(weights + 3 * 8 + 16, "has a position that is not finite: kept point 0");
    if (!GetParam()) return;
    const std::size_t gradients = weights + 3 * 8 + 24 + 3 * 4 + 4;
    refused(gradients + 4 * 8, "has a weight that is not finite: number 0 of its table");
    const std::size_t rest = bytes.size() - 4 - 10 - 9 - 4 * 24;
    refused(rest + 24, "has a position that is not finite: vertex of the lattice at rest 1");
}

INSTANTIATE_TEST_SUITE_P(Versions, DamagedBindingFile, ::testing::Bool(), [](const auto& test) {
    return test.param ? "WithGradients" : "WithoutGradients";
});

TEST(BindingFile, DamagedFacesAreRefused) {
    const TemporaryFolder folder;
    const auto path = folder / "f.espb";
    writeBoundModel(path, sampleWithFaces(sample()));
    const std::string bytes = readFile(path);
    const auto expectRefused = [&](const std::string& damaged, const std::string& why) {
        std::ofstream(path, std::ios::binary) << damaged;
        EXPECT_THAT(messageOf<FileError>([&] { readBoundModel(path); }), HasSubstr(why));
    };
    for (std::size_t size = 8; size < bytes.size(); ++size)
        expectRefused(bytes.substr(0, size), "truncated");
    const auto with = [&](std::size_t at, auto number) {
        std::string damaged = bytes;
        storeNumber(damaged.data() + at, number, std::endian::little);
        return withChecksum(damaged);
    };
    expectRefused(with(12, std::uint32_t{2}), "has the flag 2 for gradients");
    // The numbers of faces and of corners follow the header.
    for (const std::size_t at : {std::size_t{72}, std::size_t{80}})
        for (const std::int64_t number : {std::int64_t{-1}, std::int64_t{1} << 60})
            expectRefused(with(at, number), "its size is not what its header says");
    const std::size_t corners = bytes.size() - 4 - 10 - 9 - 7 * 4, ends = corners - 2 * 8;
    expectRefused(with(ends, std::int64_t{-1}), "ends face 0 of the lattice at corner -1");
    expectRefused(with(ends, std::int64_t{8}), "ends face 0 of the lattice at corner 8");
    expectRefused(with(ends + 8, std::int64_t{2}), "ends face 1 of the lattice at corner 2");
    expectRefused(with(ends + 8, std::int64_t{6}), "has 7 corners of faces; the faces use 6");
    expectRefused(with(corners, Index{4}), "has a face of the lattice with vertex 4");
    expectRefused(with(corners, Index{-1}), "has a face of the lattice with vertex -1");
}

TEST(BindingFile, MissingFileIsNamed) {
    const TemporaryFolder folder;
    EXPECT_THROW(readBoundModel(folder / "none.espb"), FileError);
}

}  // namespace
}  // namespace espalier::io
