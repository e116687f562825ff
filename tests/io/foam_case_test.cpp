// SPDX-License-Identifier: Apache-2.0
#include "io/meshes/foam_case.h"
#include <io/mesh_samples.h>
#include "support/test.h"

namespace espalier::io {
namespace {

using Path = std::filesystem::path;
using std::filesystem::create_directories;
using std::filesystem::remove_all;

TEST(FoamCase, FoldersOfProcessesAreKnownByTheirNames) {
    const auto check = [](const char* name, std::uint64_t first, std::uint64_t count,
                          bool isCollated) {
        const auto processes = processesOf(name);
        ASSERT_TRUE(processes) << name;
        EXPECT_EQ(processes->first, first) << name;
        EXPECT_EQ(processes->count, count) << name;
        EXPECT_EQ(processes->isCollated, isCollated) << name;
    };
    check("processor0", 0, 1, false);
    check("processor17", 17, 1, false);
    check("processors4", 0, 4, true);
    check("processors8_4-7", 4, 4, true);
    for (const char* name : {"", "processor", "processors", "processor-1", "processorA", "process1",
                             "processors8_", "processors8_4", "processors8_7-4", "processor1.old"})
        EXPECT_FALSE(processesOf(name)) << name;
    EXPECT_EQ(partOf("processor3/constant/polyMesh/points"), "processor3");
    EXPECT_EQ(partOf("constant/polyMesh/points"), std::nullopt);
}

void put(const Path& path) {
    create_directories(path.parent_path());
    test::putFile(path, "text");
}

TEST(FoamCase, ADecomposedCaseHasTheFilesOfAllParts) {
    const TemporaryFolder folder;
    const Path root = folder / "case";
    for (int process = 0; process < 11; ++process)
        put(root / concat("processor", process) / "constant/polyMesh/points");
    const FoamCase parts = foamCaseOf(root);
    EXPECT_TRUE(parts.isDecomposed);
    EXPECT_EQ(parts.root, root);
    ASSERT_EQ(parts.files.size(), 11u);
    EXPECT_EQ(parts.files[2], "processor2/constant/polyMesh/points");
    EXPECT_EQ(parts.files[10], "processor10/constant/polyMesh/points");
    // The whole mesh comes first.
    put(root / "constant/polyMesh/points.gz");
    EXPECT_EQ(foamCaseOf(root).files.size(), 12u);
    EXPECT_EQ(foamCaseOf(root).files[0], "constant/polyMesh/points.gz");
    EXPECT_EQ(foamCaseOf(root / "").files.size(), 12u);
    EXPECT_EQ(foamCaseOf(root / "case.foam").root, root);
    EXPECT_EQ(foamCaseOf(root / "constant").files.size(), 12u);
    // These are single meshes.
    for (const Path& path : {root / "constant/polyMesh", root / "processor3",
                             root / "processor3/constant/polyMesh/points"})
        EXPECT_FALSE(foamCaseOf(path).isDecomposed) << path;
    EXPECT_EQ(foamCaseOf(root / "constant/polyMesh").files[0], "points.gz");
}

TEST(FoamCase, TimesAndRegionsMayBeInThePartsAlone) {
    const TemporaryFolder folder;
    const Path root = folder / "case";
    for (const char* process : {"processor0", "processor1"})
        for (const char* inner : {"constant", "0.5", "constant/fluid", "0.5/fluid"})
            put(root / process / inner / "polyMesh/points");
    for (const char* inner : {"0.5", "constant/fluid", "0.5/fluid"}) {
        EXPECT_TRUE(isFoamPath(root / inner));
        const FoamCase parts = foamCaseOf(root / inner);
        EXPECT_TRUE(parts.isDecomposed);
        EXPECT_EQ(parts.root, root);
        ASSERT_EQ(parts.files.size(), 2u) << inner;
        EXPECT_EQ(parts.files[1], Path("processor1") / inner / "polyMesh/points");
    }
    EXPECT_FALSE(isFoamPath(root / "0.6"));
    EXPECT_FALSE(isFoamPath(folder / "other/0.5"));
}

TEST(FoamCase, CollatedFoldersAreParts) {
    const TemporaryFolder folder;
    put(folder / "case/processors4_0-1/constant/polyMesh/points");
    put(folder / "case/processors4_2-3/constant/polyMesh/points");
    EXPECT_THAT(foamCaseOf(folder / "case").files,
                ElementsAre("processors4_0-1/constant/polyMesh/points",
                            "processors4_2-3/constant/polyMesh/points"));
}

TEST(FoamCase, PartsThatAreMissingAreNamed) {
    const TemporaryFolder folder;
    const Path root = folder / "case";
    for (const char* process : {"processor0", "processor1", "processor2"})
        put(root / process / "constant/polyMesh/points");
    remove_all(root / "processor1/constant/polyMesh/points");
    EXPECT_REFUSED(FileError, "processor1/constant/polyMesh: is a folder polyMesh without a file",
                   foamCaseOf(root));
    EXPECT_EQ(foamTargetOf(root).files[1], "processor1/constant/polyMesh/points");
    remove_all(root / "processor1/constant");
    EXPECT_REFUSED(FileError,
                   "whose folder processor1 has no constant/polyMesh; decompose it again",
                   foamCaseOf(root));
    remove_all(root / "processor1");
    EXPECT_REFUSED(FileError, "is a decomposed case without a folder of process 1; decompose",
                   foamCaseOf(root));
    put(root / "processors3/constant/polyMesh/points");
    EXPECT_REFUSED(FileError, "is decomposed twice, in processor0 and in processors3; remove one",
                   foamCaseOf(root));
    for (const char* process : {"processor0", "processor2"}) remove_all(root / process);
    put(root / "processors2/constant/polyMesh/points");
    EXPECT_REFUSED(FileError, "is decomposed twice: the processes of processors3 are also in",
                   foamCaseOf(root));
}

TEST(FoamCase, AFileOfADecomposedCaseThatIsNamedItselfHasANote) {
    const TemporaryFolder folder;
    const Path root = folder / "case";
    for (const char* mesh : {"constant", "processor0/constant", "processor0/constant/fluid",
                             "constant/fluid", "constant/solid"})
        put(root / mesh / "polyMesh/points");
    put(folder / "processors2/constant/polyMesh/points");
    const auto note = [&](const char* mesh) {
        return noteOnDecomposed(root / mesh / "polyMesh/points").value_or("");
    };
    EXPECT_THAT(note("constant"), HasSubstr("is the whole mesh of a decomposed case: its parts in "
                                            "processor0 … stay"));
    EXPECT_THAT(note("constant/fluid"), HasSubstr("is the whole mesh"));
    EXPECT_THAT(note("processor0/constant"), HasSubstr("is one part of a decomposed mesh "
                                                       "(processor0)"));
    EXPECT_THAT(note("processor0/constant/fluid"), HasSubstr("is one part"));
    EXPECT_EQ(note("constant/solid"), "");
    EXPECT_EQ(noteOnDecomposed(folder / "processors2/constant/polyMesh/points"), std::nullopt);
    EXPECT_EQ(noteOnDecomposed("points"), std::nullopt);
}

TEST(FoamCase, ATargetIsCompressedAsItsFaces) {
    const TemporaryFolder folder;
    put(folder / "polyMesh/faces.gz");
    EXPECT_EQ(foamTargetOf(folder / ".").files[0], "points.gz");
    put(folder / "polyMesh/faces");
    EXPECT_EQ(foamTargetOf(folder / ".").files[0], "points");
    put(folder / "polyMesh/points.gz");
    EXPECT_EQ(foamTargetOf(folder / ".").files[0], "points.gz");
    // OpenFOAM reads the file without ".gz", too, if there are both.
    put(folder / "polyMesh/points");
    EXPECT_EQ(foamTargetOf(folder / ".").files[0], "points");
}

}  // namespace
}  // namespace espalier::io
