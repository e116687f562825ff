// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>
#include <espalier/io/matrices/matrix_file.h>
#include <espalier/io/matrices/numpy_matrix.h>

#include <sstream>

#include "io/files/zip.h"
#include "io/matrices/npy.h"
#include "support/test.h"

namespace espalier::test {
namespace {

/// Returns an archive of a 1 × 1 matrix of one entry, with `indexCount` column indices.
std::string archiveWith(std::size_t indexCount) {
    std::ostringstream stream;
    io::ZipWriter zip(stream);
    const auto add = [&](const char* name, std::vector<std::int64_t> numbers) {
        zip.add(name, [=](io::ByteOutput& out) {
            io::writeNpy<std::int64_t>(out, std::span<const std::int64_t>(numbers));
        });
    };
    zip.add("format.npy", [](io::ByteOutput& out) {
        io::writeNpyHead(out, "|S3", {});
        out.bytes("csr");
    });
    add("shape.npy", {1, 1});
    add("indptr.npy", {0, 1});
    add("indices.npy", std::vector<std::int64_t>(indexCount, 0));
    add("data.npy", {1});
    zip.finish();
    return stream.str();
}

TEST(ArchiveClaims, ArrayLongerThanTheNumberOfEntriesIsRefusedBeforeInflating) {
    EXPECT_EQ(io::readMatrix("m.npz", archiveWith(1)).entryCount(), 1);
    EXPECT_REFUSED(io::FileError, "indices.npy: claims 800128 bytes for at most 1 numbers",
                   io::readMatrix("m.npz", archiveWith(100000)));
}

}  // namespace
}  // namespace espalier::test
