// SPDX-License-Identifier: Apache-2.0
#include "fuzz_target.h"
#include "io/meshes/foam_file.h"

namespace espalier::fuzz {
namespace {

/// Reads the lists of OpenFOAM that are beside the points: faces and labels.
const Target kFoamLists("foam_lists", [](std::string_view bytes) {
    const std::filesystem::path name = "faces";
    const auto faces = readResult(name.string(), [&] {
        io::FoamFile file(name, bytes);
        auto read = file.faces();
        file.expectEnd();
        return read;
    });
    if (faces)
        require(faces->offsets.back() == static_cast<Offset>(faces->values.size()),
                "the last face ends at the last point");
    const auto labels = readResult(name.string(), [&] {
        io::FoamFile file(name, bytes);
        auto read = file.labels("a label", 1000, "faces");
        file.expectEnd();
        return read;
    });
    if (labels)
        for (const Index label : *labels) require(label >= 0, "labels are not negative");
});

}  // namespace
}  // namespace espalier::fuzz
