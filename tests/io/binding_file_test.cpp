// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/binding_file.h>
#include <espalier/io/file.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "support/temporary_folder.h"

namespace espalier::io {
namespace {

using ::testing::HasSubstr;

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

void expectEqual(const BoundModel& a, const BoundModel& b) {
    EXPECT_EQ(a.binding, b.binding);
    EXPECT_EQ(a.modelName, b.modelName);
    EXPECT_EQ(a.modelBytes, b.modelBytes);
}

TEST(BindingFile, ComesBackToTheLastBit) {
    const test::TemporaryFolder folder;
    writeBoundModel(folder / "a.espb", sample());
    expectEqual(readBoundModel(folder / "a.espb"), sample());
}

// Parts that are empty: nothing kept, no name, no model.
TEST(BindingFile, EmptyPartsComeBackToo) {
    const test::TemporaryFolder folder;
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

class DamagedBindingFile : public ::testing::Test {
protected:
    DamagedBindingFile() {
        writeBoundModel(path, sample());
        bytes = readFile(path);
    }
    void expectRefused(const std::string& damaged, const std::string& why) {
        std::ofstream(path, std::ios::binary) << damaged;
        try {
            readBoundModel(path);
            ADD_FAILURE() << "accepted; expected: " << why;
        } catch (const FileError& error) {
            EXPECT_THAT(error.what(), HasSubstr(path.string() + ": "));
            EXPECT_THAT(error.what(), HasSubstr(why));
        }
    }
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder / "a.espb";
    std::string bytes;
};

TEST_F(DamagedBindingFile, CutAnywhereIsRefused) {
    for (std::size_t size = 0; size < bytes.size(); ++size)
        expectRefused(bytes.substr(0, size), size < 8 ? "is not a bound model" : "truncated");
    expectRefused(bytes + "x", "its size is not what its header says");
}

TEST_F(DamagedBindingFile, AnyFlippedBitIsRefused) {
    for (std::size_t at = 0; at < bytes.size(); ++at) {
        std::string damaged = bytes;
        damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
        expectRefused(damaged, "");
    }
}

TEST_F(DamagedBindingFile, OtherKindsAndVersionsAreNamed) {
    expectRefused("# OBJ file\nv 1 2 3\n", "is not a bound model");
    std::string newer = bytes;
    newer[8] = 2;
    expectRefused(newer, "has version 2; expected 1");
}

// A header that claims 10¹⁸ entries is refused before memory is taken for them.
TEST_F(DamagedBindingFile, HugeClaimsAreRefused) {
    for (std::size_t field = 0; field < 6; ++field) {
        if (field == 1) continue;  // The number of columns takes no room in the file.
        std::string damaged = bytes;
        damaged[24 + 8 * field + 7] = 0x0d;
        expectRefused(damaged, "its size is not what its header says");
        damaged[24 + 8 * field + 7] = static_cast<char>(0xff);
        expectRefused(damaged, "its size is not what its header says");
    }
}

TEST(BindingFile, MissingFileIsNamed) {
    const test::TemporaryFolder folder;
    EXPECT_THROW(readBoundModel(folder / "none.espb"), FileError);
}

}  // namespace
}  // namespace espalier::io
