// SPDX-License-Identifier: Apache-2.0
// tests/hosts reads these files by Blender and three.js.
#include <espalier/io/animations/animation_file.h>
#include <espalier/io/formats.h>
#include <io/model_files.h>

#include <cstring>

#include "support/test.h"

namespace espalier::io {
namespace {

const std::string kSquare = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 1\nf 1 2 3 4\n";

std::vector<Point3> framePoints(std::size_t frame) {
    const double f = double(frame);
    return {{0, 0, f}, {2, 0.1 * f, 0}, {2, 2, 0}, {0, 2, 1}};
}

std::string animationBytes(const std::string& name, const std::string& model = kSquare,
                           std::size_t frames = 3, double rate = 24) {
    const TemporaryFolder folder;
    writeAnimation(folder / name, *readModel("a.obj", model), {framePoints, frames, rate});
    return readFile(folder / name);
}

std::string floats(const std::vector<Point3>& points, std::endian order) {
    std::string bytes;
    for (const Point3& point : points)
        for (const double coordinate : point) bytes += bytesOf(float(coordinate), order);
    return bytes;
}

TEST(Animation, Pc2HasAHeaderOf32BytesAndAllFrames) {
    const std::endian order = std::endian::little;
    const auto number = [&](std::int32_t value) { return bytesOf(value, order); };
    std::string expected = std::string("POINTCACHE2\0", 12) + number(1) + number(4) +
                           bytesOf(0.0F, order) + bytesOf(1.0F, order) + number(3);
    ASSERT_EQ(expected.size(), 32u);
    for (std::size_t frame = 0; frame < 3; ++frame) expected += floats(framePoints(frame), order);
    EXPECT_TRUE(animationBytes("a.PC2") == expected);
}

TEST(Animation, MddHasTimesAndIsBigEndian) {
    const std::endian order = std::endian::big;
    std::string expected = bytesOf(std::int32_t{3}, order) + bytesOf(std::int32_t{4}, order);
    for (const float time : {0.0F, 0.1F, 0.2F}) expected += bytesOf(time, order);
    for (std::size_t frame = 0; frame < 3; ++frame) expected += floats(framePoints(frame), order);
    EXPECT_TRUE(animationBytes("a.mdd", kSquare, 3, 10) == expected);
}

TEST(Animation, GlbHasTheMovementsAsMorphTargets) {
    const std::string bytes = animationBytes("a.glb", kSquare, 2, 10);
    const std::endian order = std::endian::little;
    const auto number = [&](std::size_t at) {
        std::uint32_t value;
        std::memcpy(&value, bytes.data() + at, sizeof value);
        return value;
    };
    EXPECT_EQ(bytes.substr(0, 4), "glTF");
    EXPECT_EQ(number(4), 2u);
    EXPECT_EQ(number(8), bytes.size());
    const std::size_t jsonSize = number(12);
    EXPECT_EQ(jsonSize % 4, 0u);
    EXPECT_EQ(bytes.substr(16, 4), "JSON");
    const std::string json = bytes.substr(20, jsonSize);
    EXPECT_EQ(bytes.substr(20 + jsonSize + 4, 4), std::string("BIN\0", 4));
    // Two triangles, the points, two targets, two times, and the weights.
    std::string data;
    for (const std::uint32_t corner : {0, 1, 2, 0, 2, 3}) data += bytesOf(corner, order);
    data += floats({{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 1}}, order);
    data += floats({{}, {}, {}, {}}, order);
    data += floats({{0, 0, 1}, {0, 0.1F, 0}, {}, {}}, order);
    for (const float value : {0.0F, 0.1F, 1.0F, 0.0F, 0.0F, 1.0F}) data += bytesOf(value, order);
    EXPECT_TRUE(bytes.substr(20 + jsonSize + 8) == data);
    for (const char* part :
         {"\"targets\":[{\"POSITION\":2},{\"POSITION\":3}]", "\"indices\":0", "\"weights\":[0,0]",
          "\"targetNames\":[\"pose 0\",\"pose 1\"]", "\"min\":[0.0,0.0,0.0],\"max\":[2.0,2.0,1.0]",
          "\"min\":[0.0],\"max\":[0.10000000149011612]", "\"path\":\"weights\""})
        EXPECT_THAT(json, HasSubstr(part));
}

TEST(Animation, StoredPointsAreTheSumsThatProgramsCompute) {
    const auto model = readModel("a.obj", "v 1000.1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const std::vector<Point3> points = {{1e-5, 0.1, 0}, {1, 0, 0}, {0, 1, 0}};
    auto expected = points;
    for (const char* name : {"a.pc2", "a.mdd"}) {
        expected[0] = {double{1e-5F}, double{0.1F}, 0};
        EXPECT_EQ(storedInAnimation(name, *model, points), expected);
    }
    expected[0][0] = double{1000.1F + (1e-5F - 1000.1F)};
    EXPECT_NE(expected[0][0], double{1e-5F});
    EXPECT_EQ(storedInAnimation("a.glb", *model, points), expected);
}

TEST(Animation, WrongFramesAndFilesAreRefused) {
    const TemporaryFolder folder;
    const auto model = readModel("a.obj", kSquare);
    const auto expectRefused = [&](const std::string& name, const Animation& animation,
                                   const std::string& message) {
        EXPECT_REFUSED(Error, message, writeAnimation(folder / name, *model, animation));
        EXPECT_FALSE(std::filesystem::exists(folder / name));
    };
    for (const char* name : {"a.pc2", "a.mdd", "a.glb"}) {
        EXPECT_TRUE(isFileOf(FileContent::Animation, name, FileUse::Write));
        expectRefused(name, {framePoints, 0, 24}, "an animation of 0 frames of 4 points");
        expectRefused(name, {framePoints, 2, 0}, "frames per second is not a number above 0");
        expectRefused(name, {[](std::size_t) { return std::vector<Point3>(3); }, 2, 24},
                      "frame 0 has 3 points; the model has 4");
        expectRefused(name,
                      {[](std::size_t) {
                           return std::vector<Point3>(4, {0, 0, 1e39});
                       },
                       2, 24},
                      "in frame 0, point 0 has the coordinate 1e+39, which a float cannot hold");
        expectRefused(name,
                      {[](std::size_t) {
                           return std::vector<Point3>(4, {0, 0, kNan});
                       },
                       2, 24},
                      "which a float cannot hold");
    }
    for (const char* name : {"a.mdd", "a.glb"})
        for (const double rate : {1e-39, 1e300})
            expectRefused(name, {framePoints, 2, rate}, "frames per second, frame 1 is at ");
    const auto far = readModel("a.obj", "v 3e38 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 1\nf 1 2 3 4\n");
    const Animation opposite = {[](std::size_t) {
                                    return std::vector<Point3>(4, {-3e38, 0, 0});
                                },
                                1, 24};
    EXPECT_REFUSED(Error, "in frame 0, point 0 moves from",
                   writeAnimation(folder / "a.glb", *far, opposite));
    // The size is known before the frames are.
    const Animation large = {
        [](std::size_t) -> std::vector<Point3> { throw std::logic_error("asked"); },
        std::size_t{1} << 20, 24};
    EXPECT_REFUSED(FileError, "a glTF file of 1048576 poses would have",
                   writeAnimation(folder / "a.glb", *model, large));
    EXPECT_FALSE(isFileOf(FileContent::Animation, "a.abc", FileUse::Write));
    expectRefused("a.abc", {framePoints, 2, 24}, "expected .pc2, .mdd, .glb or .gltf");
}

TEST(Animation, ASinglePoseInGlbIsAModel) {
    for (const char* name : {"a.pc2", "a.mdd"}) EXPECT_TRUE(isAnimation(name, 1));
    for (const char* name : {"a.glb", "a.GLTF"}) {
        EXPECT_FALSE(isAnimation(name, 1));
        EXPECT_TRUE(isAnimation(name, 2));
    }
    EXPECT_FALSE(isAnimation("a%04d.glb", 2));
    EXPECT_FALSE(isAnimation("a.obj", 2));
}

TEST(Animation, GlbHasTheNormalsOfEachPose) {
    const auto model =
        readModel("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n");
    // The pose turns z to x.
    const Animation animation = {
        [&](std::size_t) {
            return std::vector<Point3>{{}, {0, 0, -1}, {0, 1, 0}};
        },
        1, 24,
        [](std::size_t) {
            return std::vector<DeformationGradient>(3, {0, 0, 1, 0, 1, 0, -1, 0, 0});
        }};
    const TemporaryFolder folder;
    writeAnimation(folder / "a.glb", *model, animation);
    const std::string bytes = readFile(folder / "a.glb");
    EXPECT_THAT(bytes, HasSubstr("\"targets\":[{\"POSITION\":3,\"NORMAL\":4}]"));
    EXPECT_THAT(bytes,
                HasSubstr(floats({{1, 0, -1}, {1, 0, -1}, {1, 0, -1}}, std::endian::little)));
    EXPECT_TRUE(animationHoldsNormals("a.glb"));
    EXPECT_FALSE(animationHoldsNormals("a.mdd"));
    EXPECT_EQ(lossesInAnimation("a.mdd", *model), "");
}

}  // namespace
}  // namespace espalier::io
