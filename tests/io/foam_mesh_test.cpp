// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <io/mesh_samples.h>
#include <io/replaced.h>

#include <filesystem>

#include "support/test.h"

// Decomposed meshes of OpenFOAM. The sample has a cube (cell 0), a pyramid on it (1), a wedge at
// its side (2) and a tetrahedron on the wedge (3).

namespace espalier::io {
namespace {

using Files = std::map<std::string, std::string>;
using Path = std::filesystem::path;

/// Writes the parts of the sample to folders processor0, processor1, …
void putParts(const Path& root, const std::vector<Files>& parts,
              const std::string& inner = "constant") {
    for (std::size_t i = 0; i < parts.size(); ++i)
        putFoam(root / concat("processor", i) / inner / "polyMesh", parts[i]);
}

std::vector<Point3> sorted(std::vector<Point3> points) {
    std::ranges::sort(points);
    return points;
}

/// The cells that a mesh has, by the corners of each in any order, with the name of its kind.
std::vector<std::pair<int, std::vector<Point3>>> cellsOf(const Model& model) {
    const ModelCells cells = model.readCells();
    std::vector<std::pair<int, std::vector<Point3>>> result;
    for (Index cell = 0; cell < cells.volume.cellCount(); ++cell) {
        std::vector<Point3> corners;
        for (const Index face : cells.volume.faces(cell))
            for (const Index point : cells.volume.face(face))
                corners.push_back(model.positions()[point]);
        std::ranges::sort(corners);
        const auto kind = cells.volume.kind(cell);
        result.emplace_back(kind ? int(*kind) : -1, corners);
    }
    std::ranges::sort(result);
    return result;
}

TEST(FoamMesh, PartsAreOneModel) {
    for (const std::vector<int>& processes :
         {std::vector<int>{0, 0, 1, 1}, {1, 0, 0, 1}, {0, 1, 2, 3}, {3, 2, 1, 0}, {0, 0, 0, 0}}) {
        const TemporaryFolder folder;
        putParts(folder / "parts", decomposedFoam(processes));
        Files sample = sampleFoam();
        sample["boundary"] = foamHeader("polyBoundaryMesh", "boundary") +
                             "1(walls {type wall; nFaces 15; startFace 3;})";
        putFoam(folder / "whole/constant/polyMesh", sample);
        const auto parts = readModel(folder / "parts"), whole = readModel(folder / "whole");
        EXPECT_THAT(parts->notes(), IsEmpty());
        EXPECT_EQ(sorted(copyOf(parts->positions())), sorted(samplePoints()));
        EXPECT_EQ(cellsOf(*parts), cellsOf(*whole));
        const ModelCells cells = parts->readCells();
        EXPECT_TRUE(cells.isOpenFoam);
        EXPECT_EQ(cells.facesApart, 0);
        EXPECT_EQ(cells.volume.internalFaceCount(), 3);
        EXPECT_EQ(cells.volume.faceCount(), 18);
        ASSERT_EQ(cells.patches.size(), 1u);
        EXPECT_EQ(cells.patches[0].name, "walls");
        EXPECT_EQ(cells.patches[0].type, "wall");
        EXPECT_EQ(cells.patches[0].faceCount(), 15);
        EXPECT_EQ(cells.patches[0].points.size(), 12u);
        EXPECT_EQ(parts->readSurface().faces.count(), 15u);
        EXPECT_EQ(parts->groups().size(), 1u);
        EXPECT_EQ(readLattice(folder / "parts").complex.count(3), 4);
        EXPECT_EQ(readLattice(folder / "parts").complex.count(2), 18);
    }
}

TEST(FoamMesh, CellsAreNamedByTheirPart) {
    const TemporaryFolder folder;
    putParts(folder / "parts", decomposedFoam({1, 0, 1, 0}));
    const ModelCells cells = readModel(folder / "parts")->readCells();
    ASSERT_EQ(cells.parts.size(), 2u);
    EXPECT_EQ(cells.volume.kind(0), far::StandardCell::Pyramid);
    EXPECT_EQ(cells.cellText(0), "0 (0 of processor0)");
    EXPECT_EQ(cells.cellText(1), "1 (1 of processor0)");
    EXPECT_EQ(cells.volume.kind(2), far::StandardCell::Hexahedron);
    EXPECT_EQ(cells.cellText(2), "2 (0 of processor1)");
    putFoam(folder / "whole/constant/polyMesh", sampleFoam());
    EXPECT_EQ(readModel(folder / "whole")->readCells().cellText(2), "2");
}

TEST(FoamMesh, PartsAreWrittenTogether) {
    for (const bool isCollated : {false, true})
        for (const bool hasWhole : {false, true}) {
            SCOPED_TRACE(concat(isCollated, hasWhole));
            const TemporaryFolder folder;
            const Path root = folder / "case", copy = folder / "copy";
            const auto parts = decomposedFoam({0, 1, 2, 1});
            if (isCollated)
                putFoam(root / "processors3/constant/polyMesh", collatedFoam(parts));
            else
                putParts(root, parts);
            if (hasWhole) putFoam(root / "constant/polyMesh", sampleFoam());
            std::filesystem::copy(root, copy, std::filesystem::copy_options::recursive);
            const auto model = readModel(root);
            EXPECT_EQ(modelFiles(root).size(), (isCollated ? 1u : 3u) + (hasWhole ? 1u : 0u));
            // At rest each file has the bytes that were read.
            for (const Path& file : modelTargets(copy)) putFile(file, "");
            model->write(copy, model->positions());
            for (std::size_t i = 0; i < modelFiles(root).size(); ++i)
                EXPECT_TRUE(readFile(modelFiles(root)[i]) == readFile(modelFiles(copy)[i]));
            // A point of three parts moves in all of them: (2, 0, 2).
            auto moved = copyOf(model->positions());
            const auto point = std::ranges::find(moved, Point3{2, 0, 2});
            ASSERT_NE(point, moved.end());
            *point = {2.5, -1.0 / 3, 2};
            const auto expected = copyOf(moved);
            model->write(copy, moved);
            EXPECT_EQ(copyOf(readModel(copy)->positions()), expected);
            EXPECT_EQ(cellsOf(*readModel(copy)).size(), 4u);
            for (const Path& file : modelFiles(copy)) {
                const std::string text = readFile(file);
                std::size_t count = 0;
                for (std::size_t at = 0;
                     (at = text.find("(2.5 -0.3333333333333333 2)", at)) != std::string::npos; ++at)
                    ++count;
                EXPECT_EQ(
                    count,
                    isCollated && file.string().find("processors3") != std::string::npos ? 3u : 1u);
                // The unusual texts of point 1 stay.
                if (text.find("2.00") != std::string::npos)
                    EXPECT_NE(text.find("(2.00 +0e0 -0.0)"), std::string::npos);
                EXPECT_EQ(text.find("(2 0 2)"), std::string::npos);
            }
        }
}

TEST(FoamMesh, CollatedFilesMayHaveTheClassOfTheirBlocksInTheHead) {
    const TemporaryFolder folder;
    Files files = collatedFoam(decomposedFoam({0, 1, 1, 0}));
    const std::string head = foamHeader("vectorField", "points");
    // The size of a block changes with its head.
    const std::size_t begin = files["points"].find("Processor0\n\n") + 12;
    const std::size_t end = files["points"].find("\n(", begin);
    const int size = std::stoi(files["points"].substr(begin, end - begin));
    files["points"].replace(begin, end - begin, std::to_string(size - int(head.size())));
    files["points"] = replaced(replaced(files["points"], head, ""), "class decomposedBlockData;",
                               "class decomposedBlockData; data.format ascii; "
                               "data.class vectorField;");
    const auto points = putFoam(folder / "processors2/constant/polyMesh", files);
    EXPECT_EQ(readModel(folder / ".")->readCells().volume.cellCount(), 4);
    // A collated file has all parts, so that it may be named itself.
    const auto model = readModel(points);
    EXPECT_THAT(model->notes(), IsEmpty());
    EXPECT_EQ(model->readCells().volume.cellCount(), 4);
    EXPECT_EQ(model->readCells().cellText(2), "2 (0 of processor1)");
    model->write(points, model->positions());
    EXPECT_TRUE(readFile(points) == files["points"]);
}

TEST(FoamMesh, BinaryAndCompressedPartsAreRead) {
    const TemporaryFolder folder;
    auto parts = decomposedFoam({0, 1, 1, 0});
    for (Files& files : parts) {
        const auto points = copyOf(readModel("points", files["points"])->positions());
        std::string text = foamHeader("vectorField", "points", true) + concat(points.size(), "\n(");
        for (const Point3& point : points) text += bytesOfPoint(point, std::endian::little);
        files["points"] = text + ")\n";
    }
    putParts(folder / "case", parts);
    const auto model = readModel(folder / "case");
    EXPECT_EQ(model->storage(), CoordinateStorage::Double);
    auto moved = copyOf(model->positions());
    for (Point3& point : moved) point[0] += 1.0 / 3;
    model->write(folder / "case", moved);
    EXPECT_EQ(copyOf(readModel(folder / "case")->positions()), moved);
    EXPECT_EQ(readModel(folder / "case")->readCells().volume.cellCount(), 4);
}

// A mesh of a moving case is in the folders of times of the processes alone.
TEST(FoamMesh, TimesOfADecomposedCaseAreModels) {
    const TemporaryFolder folder;
    const Path root = folder / "case";
    const auto parts = decomposedFoam({0, 0, 1, 1});
    putParts(root, parts);
    for (int i = 0; i < 2; ++i)
        putFoam(root / concat("processor", i) / "0.5/polyMesh",
                {{"points", replaced(parts[std::size_t(i)].at("points"), "(2 0 2)", "(2 0 2.5)")}});
    const auto model = readModel(root / "0.5");
    EXPECT_EQ(model->readCells().volume.cellCount(), 4);
    EXPECT_EQ(std::ranges::count(model->positions(), Point3{2, 0, 2.5}), 1);
    auto moved = copyOf(model->positions());
    for (Point3& point : moved) point[1] += 7;
    model->write(root / "0.5", moved);
    EXPECT_EQ(copyOf(readModel(root / "0.5")->positions()), moved);
    EXPECT_EQ(sorted(copyOf(readModel(root)->positions())), sorted(samplePoints()));
}

TEST(FoamMesh, AWholeMeshThatIsAnotherOneStays) {
    const TemporaryFolder folder;
    const Path root = folder / "case";
    putParts(root, decomposedFoam({0, 0, 1, 1}));
    Files other = sampleFoam();
    other["points"] = replaced(other["points"], "(1 1 4)", "(1 1 4.0000001)");
    const auto points = putFoam(root / "constant/polyMesh", other);
    const auto model = readModel(root);
    EXPECT_THAT(
        model->notes(),
        ElementsAre("has a whole mesh in constant/polyMesh, which stays, because 1 points of "
                    "the parts are not among its points; name this folder to move it"));
    auto moved = copyOf(model->positions());
    for (Point3& point : moved) point[1] += 7;
    model->write(root, moved);
    EXPECT_EQ(copyOf(readModel(root)->positions()), moved);
    EXPECT_TRUE(readFile(points) == other["points"]);
    EXPECT_EQ(model->readCells().parts.size(), 2u);
}

TEST(FoamMesh, FacesWithOtherPointsInTwoPartsAreApart) {
    const TemporaryFolder folder;
    auto parts = decomposedFoam({0, 0, 1, 1});
    parts[1]["points"] = replaced(parts[1]["points"], "(2 0 2)", "(2 0 2.0001)");
    putParts(folder / "case", parts);
    const auto model = readModel(folder / "case");
    EXPECT_EQ(model->positions().size(), 13u);
    const ModelCells cells = model->readCells();
    EXPECT_EQ(cells.facesApart, 1);
    EXPECT_EQ(cells.volume.internalFaceCount(), 2);
    EXPECT_EQ(cells.volume.faceCount(), 19);
    EXPECT_EQ(cells.volume.cellCount(), 4);
    ASSERT_EQ(uncheckedElements(cells).size(), 1u);
    EXPECT_EQ(uncheckedElements(cells)[0].count, 1);
}

/// Two cubes in a row, each in a process of its own; the ends of the row are cyclic patches. So the
/// decomposition cuts the pair: each process has a part of one patch as processorCyclic.
std::vector<Files> cyclicParts() {
    std::vector<Files> parts;
    for (int process = 0; process < 2; ++process) {
        std::string points;
        for (const char* yz : {"0 0", "1 0", "1 1", "0 1"})
            for (int x = process; x < process + 2; ++x) points += concat("(", x, " ", yz, ")");
        // Points 0 2 4 6 are at the low x, points 1 3 5 7 at the high x.
        const std::string low = "4(0 6 4 2)", high = "4(1 3 5 7)";
        const std::string sides = "4(0 1 7 6) 4(2 4 5 3) 4(0 2 3 1) 4(4 6 7 5)";
        const std::string inner = process == 0 ? high : low, outer = process == 0 ? low : high;
        const int other = 1 - process;
        const std::string to = concat("procBoundary", process, "to", other);
        const char* end = process == 0 ? "left" : "right";
        const auto cyclic = [](const char* name, const char* partner) {
            return concat(name, " {type cyclic; neighbourPatch ", partner,
                          "; nFaces 0; startFace 4;}");
        };
        parts.push_back(
            {{"points", foamHeader("vectorField", "points") + "8(" + points + ")"},
             {"faces",
              foamHeader("faceList", "faces") + "6(" + sides + " " + inner + " " + outer + ")"},
             {"owner", foamHeader("labelList", "owner") + "6{0}"},
             {"neighbour", foamHeader("labelList", "neighbour") + "0()"},
             {"boundary", foamHeader("polyBoundaryMesh", "boundary") +
                              "5(walls {type wall; nFaces 4; startFace 0;}" +
                              cyclic("left", "right") + cyclic("right", "left") + to +
                              " {type processor; nFaces 1; startFace 4; myProcNo " +
                              std::to_string(process) + "; neighbProcNo " + std::to_string(other) +
                              ";}" + to + "through" + end +
                              " {type processorCyclic; nFaces 1; startFace 5; myProcNo " +
                              std::to_string(process) + "; neighbProcNo " + std::to_string(other) +
                              "; referPatch " + end + ";})"}});
    }
    return parts;
}

TEST(FoamMesh, CyclicPatchesThatADecompositionCutsAreWhole) {
    const TemporaryFolder folder;
    putParts(folder / "case", cyclicParts());
    const auto model = readModel(folder / "case");
    EXPECT_EQ(model->positions().size(), 12u);
    const ModelCells cells = model->readCells();
    EXPECT_EQ(cells.volume.cellCount(), 2);
    EXPECT_EQ(cells.volume.internalFaceCount(), 1);
    EXPECT_EQ(cells.volume.kind(1), far::StandardCell::Hexahedron);
    ASSERT_EQ(cells.patches.size(), 3u);
    EXPECT_EQ(cells.patches[0].faceCount(), 8);
    for (const std::size_t i : {1u, 2u}) {
        const far::MeshPatch& patch = cells.patches[i];
        EXPECT_EQ(patch.name, i == 1 ? "left" : "right");
        EXPECT_EQ(patch.partner, i == 1 ? "right" : "left");
        EXPECT_EQ(patch.type, "cyclic");
        ASSERT_EQ(patch.faceCount(), 1);
        for (const Index point : patch.points)
            EXPECT_EQ(model->positions()[point][0], i == 1 ? 0 : 2);
    }
}

TEST(FoamMesh, PartsThatDoNotFitAreRefused) {
    const auto expectRefused = [](const std::vector<Files>& parts, const std::string& message) {
        const TemporaryFolder folder;
        putParts(folder / "case", parts);
        EXPECT_REFUSED(Error, message, readModel(folder / "case")->readCells());
    };
    const auto good = decomposedFoam({0, 0, 1, 1});
    const auto changed = [&](std::size_t part, const std::string& name, const std::string& before,
                             const std::string& after) {
        auto parts = good;
        parts[part][name] = replaced(parts[part][name], before, after);
        return parts;
    };
    expectRefused(changed(0, "boundary", "neighbProcNo 1", "neighbProcNo 5"),
                  "the patch 'procBoundary0to1' of processor0 leads to process 5, but there are 2");
    expectRefused(changed(0, "boundary", "neighbProcNo 1;", ""),
                  "of processor0 does not name the other process");
    expectRefused(changed(1, "boundary", "type processor", "type wall"),
                  "the patch 'procBoundary0to1' of processor0 leads to processor1, which has no "
                  "patch back; decompose the case again");
    expectRefused(changed(1, "boundary", "nFaces 1;", "nFaces 0;"),
                  "has 7 faces of processor1 in its patches, but 8 faces have no neighbour");
    expectRefused(changed(1, "faces", "3(2 4 5)", "3(2 4 9)"),
                  "face 0 of processor1 names point 9; there are 7");
    auto parts = decomposedFoam({0, 1, 0, 1});
    parts[0] = good[0];
    expectRefused(parts, "has 1 faces, but 'procBoundary1to0' of processor1 has 2");
    parts = good;
    parts[1].erase("boundary");
    expectRefused(parts, "processor1/constant/polyMesh/boundary: cannot open");
    const TemporaryFolder folder;
    Files collated = collatedFoam(good);
    putFoam(folder / "a/processors3/constant/polyMesh", collated);
    EXPECT_REFUSED(FileError, "has the points of 2 processes; its folder is of 3",
                   readModel(folder / "a"));
    for (const char* name : {"faces", "owner", "neighbour", "boundary"}) {
        collated = collatedFoam(good);
        collated[name] = collatedFoam({good[0]})[name];
        putFoam(folder / "b/processors2/constant/polyMesh", collated);
        EXPECT_REFUSED(FileError, name, readModel(folder / "b")->readCells());
    }
    collated = collatedFoam(good);
    collated["points"].resize(collated["points"].size() - 3);
    putFoam(folder / "b/processors2/constant/polyMesh", collated);
    EXPECT_REFUSED(FileError, "but only", readModel(folder / "b"));
}

TEST(FoamMesh, PartsAreWrittenToACopyOfTheCaseOnly) {
    const TemporaryFolder folder;
    putParts(folder / "case", decomposedFoam({0, 0, 1, 1}));
    putParts(folder / "three", decomposedFoam({0, 1, 2, 2}));
    putParts(folder / "other", decomposedFoam({0, 1, 1, 1}));
    putFoam(folder / "whole/constant/polyMesh", sampleFoam());
    putFile(folder / "points", "");
    const auto parts = readModel(folder / "case"), whole = readModel(folder / "whole");
    EXPECT_REFUSED(FileError, "three: is no copy of the decomposed case",
                   parts->checkTarget(folder / "three"));
    EXPECT_REFUSED(FileError, "whole/constant/polyMesh/points: cannot hold the 2 files of a",
                   parts->checkTarget(folder / "whole"));
    EXPECT_REFUSED(FileError, "processor0/constant/polyMesh/points: belongs to another mesh",
                   parts->checkTarget(folder / "other"));
    EXPECT_REFUSED(FileError, "points: cannot hold the 2 files of a decomposed case",
                   parts->checkTarget(folder / "points"));
    EXPECT_REFUSED(FileError,
                   "is a decomposed case, but the model has the points of one mesh alone",
                   whole->checkTarget(folder / "case"));
    EXPECT_EQ(whole->checkTarget(folder / "whole"), "");
    EXPECT_EQ(parts->checkTarget(folder / "case"), "");
}

// A binding has the bytes of the model, and no folders.
TEST(FoamMesh, AModelOfBytesKnowsItsParts) {
    const TemporaryFolder folder;
    putParts(folder / "case", decomposedFoam({0, 0, 1, 1}));
    const Path file = modelFile(folder / "case");
    EXPECT_EQ(modelName(file), "points");
    const auto model = readModel(modelName(file), readModelBytes(file));
    auto moved = copyOf(model->positions());
    EXPECT_EQ(moved, copyOf(readModel(folder / "case")->positions()));
    for (Point3& point : moved) point[2] += 0.25;
    model->write(folder / "case", moved);
    EXPECT_EQ(copyOf(readModel(folder / "case")->positions()), moved);
    putParts(folder / "three", decomposedFoam({0, 1, 2, 2}));
    putParts(folder / "other", decomposedFoam({0, 1, 1, 1}));
    EXPECT_REFUSED(FileError, "is no copy", model->checkTarget(folder / "three"));
    EXPECT_REFUSED(FileError, "belongs to another mesh, which has 8 points, and not 9",
                   model->checkTarget(folder / "other"));
}

}  // namespace
}  // namespace espalier::io
