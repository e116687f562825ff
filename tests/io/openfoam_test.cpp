// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/formats.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <io/mesh_samples.h>
#include <io/replaced.h>
#include <sys/stat.h>

#include "support/test.h"

namespace espalier::io {
namespace {

using Files = std::map<std::string, std::string>;

/// Returns a file of gzip without compression (RFC 1951 and 1952): a head, one stored block, the
/// checksum and the size.
std::string compressed(const std::string& bytes) {
    const auto order = std::endian::little;
    const auto size = std::uint16_t(bytes.size());
    std::uint32_t crc = ~0u;
    for (const char c : bytes) {
        crc ^= static_cast<unsigned char>(c);
        for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return std::string("\x1f\x8b\x08\0\0\0\0\0\0\xff\x01", 11) + bytesOf(size, order) +
           bytesOf(std::uint16_t(~size), order) + bytes + bytesOf(~crc, order) +
           bytesOf(std::uint32_t(size), order);
}

TEST(OpenFoam, PointsAreAModelAsTextAndInBinary) {
    for (const bool isBinary : {false, true}) {
        const std::string bytes = sampleFoam(isBinary)["points"];
        const auto model = readModel("points", bytes);
        EXPECT_EQ(copyOf(model->positions()), samplePoints());
        EXPECT_EQ(model->extension(), "points");
        EXPECT_EQ(model->storage(), isBinary ? CoordinateStorage::Double : CoordinateStorage::Text);
        const TemporaryFolder folder;
        model->write(folder / "points", model->positions());
        EXPECT_TRUE(readFile(folder / "points") == bytes);
        auto moved = copyOf(model->positions());
        moved[1][2] = 0.5;
        moved[11] = {0.1, -7, 3};
        model->write(folder / "points", moved);
        const std::endian order = std::endian::little;
        const std::string expected =
            isBinary ? replaced(replaced(bytes, bytesOfPoint({2, 0, 0}, order),
                                         bytesOfPoint({2, 0, 0.5}, order)),
                                bytesOfPoint({3, 1, 3}, order), bytesOfPoint({0.1, -7, 3}, order))
                     : replaced(replaced(bytes, "(2.00 +0e0 -0.0)", "(2.00 +0e0 0.5)"), "(3 1 3)",
                                "(0.1 -7 3)");
        EXPECT_TRUE(readFile(folder / "points") == expected);
    }
}

TEST(OpenFoam, SinglePrecisionAndOtherByteOrdersAreRead) {
    for (const std::endian order : {std::endian::little, std::endian::big}) {
        std::string text = replaced(
            foamHeader("vectorField", "points", true), "LSB;label=32;scalar=64",
            order == std::endian::big ? "MSB;label=64;scalar=32" : "LSB;label=64;scalar=32");
        text += "2\n(";
        for (const float value : {0.f, 0.5f, 1.f, 2.f, 3.f, 4.f}) text += bytesOf(value, order);
        text += ")";
        const auto model = readModel("points", text);
        EXPECT_EQ(model->storage(), CoordinateStorage::Float);
        EXPECT_THAT(copyOf(model->positions()), ElementsAre(Point3{0, 0.5, 1}, Point3{2, 3, 4}));
    }
}

TEST(OpenFoam, TheVolumeIsBesideThePoints) {
    for (const bool isBinary : {false, true}) {
        const TemporaryFolder folder;
        const auto points = putFoam(folder / "constant/polyMesh", sampleFoam(isBinary));
        for (const auto& path :
             {folder / ".", points, folder / "constant/polyMesh", folder / "any.foam"}) {
            EXPECT_EQ(std::filesystem::canonical(modelFile(path)),
                      std::filesystem::canonical(points));
            EXPECT_TRUE(isFileOf(FileContent::Model, path));
            const auto model = readModel(path);
            const ModelCells cells = model->readCells();
            ASSERT_EQ(cells.volume.cellCount(), 4);
            EXPECT_EQ(cells.volume.internalFaceCount(), 3);
            EXPECT_EQ(cells.volume.kind(0), far::StandardCell::Hexahedron);
            EXPECT_EQ(cells.volume.kind(1), far::StandardCell::Pyramid);
            EXPECT_EQ(cells.volume.kind(2), std::nullopt);
            EXPECT_EQ(cells.volume.kind(3), far::StandardCell::Tetrahedron);
            EXPECT_EQ(model->readSurface().faces.count(), 15u);  // The boundary.
            ReadNotes notes;
            const Lattice lattice = readLattice(path, &notes);
            EXPECT_EQ(lattice.complex.count(3), 4);
            EXPECT_EQ(lattice.complex.count(2), 18);
            EXPECT_EQ(lattice.positions, samplePoints());
            EXPECT_EQ(describe(path, notes), "");
        }
    }
}

// A moving mesh has points of their own in the folder of a time.
TEST(OpenFoam, AFolderOfATimeHasTheFacesOfItsCase) {
    const TemporaryFolder folder;
    putFoam(folder / "constant/polyMesh", sampleFoam());
    const std::string points = replaced(sampleFoam()["points"], "(3 1 3)", "(3 1 3.5)");
    putFoam(folder / "0.5/polyMesh", {{"points", points}});
    EXPECT_EQ(modelFile(folder / "0.5"), folder / "0.5/polyMesh/points");
    EXPECT_EQ(readModel(folder / "0.5")->readCells().volume.cellCount(), 4);
    EXPECT_EQ(readLattice(folder / "0.5").positions[11], (Point3{3, 1, 3.5}));
    // Points without a mesh are a model without cells.
    putFoam(folder / "alone/x", {{"points", points}});
    EXPECT_EQ(readModel(folder / "alone/x/points")->readCells().volume.cellCount(), 0);
    EXPECT_EQ(readModel(folder / "alone/x/points")->readSurface().faces.count(), 0u);
    EXPECT_REFUSED(FileError, "has no file 'faces' beside it, nor in constant/polyMesh of its case",
                   readLattice(folder / "alone/x/points"));
}

TEST(OpenFoam, IsWrittenToPointsOrIntoACopyOfTheCase) {
    const TemporaryFolder folder;
    putFoam(folder / "case/constant/polyMesh", sampleFoam());
    std::filesystem::copy(folder / "case", folder / "copy",
                          std::filesystem::copy_options::recursive);
    const auto model = readModel(folder / "case");
    auto moved = copyOf(model->positions());
    moved[11][2] = 3.5;
    model->write(folder / "copy", moved);
    EXPECT_EQ(readModel(folder / "copy")->positions()[11], (Point3{3, 1, 3.5}));
    EXPECT_EQ(readModel(folder / "case")->positions()[11], (Point3{3, 1, 3}));
    std::filesystem::create_directories(folder / "none");
    EXPECT_REFUSED(FileError, "is a folder without a mesh of OpenFOAM; copy the case first",
                   model->write(folder / "none", moved));
    EXPECT_REFUSED(FileError,
                   "written to a file of the name 'points', or into a folder with a copy",
                   model->write(folder / "new", moved));
    EXPECT_REFUSED(FileError, "a file of the name 'points'", model->write(folder / "a.vtu", moved));
    EXPECT_NO_THROW(model->checkTarget("/dev/stdout"));
    EXPECT_REFUSED(FileError, "is a folder without a mesh of OpenFOAM (constant/polyMesh)",
                   readModel(folder / "none"));
    EXPECT_REFUSED(FileError, "is a folder without a mesh", readLattice(folder / "none"));
    std::filesystem::remove(folder / "case/constant/polyMesh/points");
    EXPECT_REFUSED(FileError, "has a folder polyMesh without a file of points",
                   readModel(folder / "case"));
}

TEST(OpenFoam, CompressedFilesAreReadAndWritten) {
    const TemporaryFolder folder;
    const auto plain = putFoam(folder / "plain/constant/polyMesh", sampleFoam());
    Files files;
    for (const auto& [name, bytes] : sampleFoam()) files[name + ".gz"] = compressed(bytes);
    putFoam(folder / "case/constant/polyMesh", files);
    const auto points = folder / "case/constant/polyMesh/points.gz";
    for (const auto& path : {folder / "case", points}) {
        EXPECT_EQ(modelFile(path), points);
        const auto model = readModel(path);
        EXPECT_EQ(model->readCells().volume.cellCount(), 4);
        EXPECT_EQ(copyOf(model->positions()), samplePoints());
        EXPECT_EQ(readLattice(path).complex.count(3), 4);
        // At rest the compressed bytes are the same, which another program has made.
        putFile(points, files["faces.gz"]);
        model->write(path, model->positions());
        EXPECT_TRUE(readFile(points) == files["points.gz"]);
        auto moved = copyOf(model->positions());
        moved[11][2] = 3.5;
        model->write(path, moved);
        EXPECT_TRUE(readFile(points).starts_with("\x1f\x8b"));
        EXPECT_EQ(copyOf(readModel(points)->positions()), moved);
        // The name of the output tells its form.
        model->write(folder / "plain", moved);
        EXPECT_TRUE(readFile(plain) == replaced(sampleFoam()["points"], "(3 1 3)", "(3 1 3.5)"));
        model->write(folder / "plain", model->positions());
        EXPECT_TRUE(readFile(plain) == sampleFoam()["points"]);
        readModel(plain)->write(path, moved);
        EXPECT_EQ(copyOf(readModel(points)->positions()), moved);
        putFile(points, files["points.gz"]);
    }
    std::string damaged = files["points.gz"];
    damaged.resize(damaged.size() - 9);
    putFile(points, damaged);
    EXPECT_REFUSED(FileError, "points.gz: is damaged: it ends too early", readModel(points));
    putFile(points, files["points.gz"]);
    putFile(folder / "case/constant/polyMesh/owner.gz", damaged);
    EXPECT_REFUSED(FileError, "owner.gz: is damaged", readModel(points)->readCells());
}

TEST(OpenFoam, IsNotWrittenOverTheMeshOfAnotherCase) {
    const TemporaryFolder folder;
    for (const char* name : {"case/constant/polyMesh", "other/constant/polyMesh", "points"})
        putFoam(folder / name, sampleFoam());
    const auto refused = [&](const std::filesystem::path& target) {
        const auto model = readModel(folder / "case");
        EXPECT_REFUSED(FileError, "belongs to another mesh, whose faces, owner and neighbour",
                       model->checkTarget(target));
        EXPECT_REFUSED(FileError, "belongs to another mesh",
                       model->write(target, model->positions()));
    };
    const auto model = readModel(folder / "case");
    const auto target = folder / "other/constant/polyMesh";
    for (const char* name : {"faces", "owner", "neighbour"}) {
        Files files = sampleFoam();
        files["faces"] = replaced(files["faces"], "4(4 5 6 7)", "4(5 6 7 4)");
        files["owner"] = replaced(files["owner"], "\n3\n)", "\n2\n)");
        files["neighbour"] = replaced(files["neighbour"], "\n3\n)", "\n1\n)");
        putFoam(target, sampleFoam());
        putFile(target / name, files[name]);
        refused(folder / "other");
        refused(target / "points");
    }
    // The same mesh in binary has other bytes.
    putFoam(target, sampleFoam(true));
    EXPECT_EQ(model->checkTarget(folder / "other/"), "");
    model->write(folder / "other/", model->positions());
    EXPECT_EQ(copyOf(readModel(target / "points")->positions()), samplePoints());
    // A file "points" that belongs to no mesh is written like any other.
    std::filesystem::remove(folder / "points/faces");
    putFile(folder / "points/points", "");
    EXPECT_NO_THROW(model->write(folder / "points/points", model->positions()));
}

TEST(OpenFoam, FilesOfTheCaseAreRegularFiles) {
    for (const char* name : {"points", "faces", "owner", "neighbour"}) {
        const TemporaryFolder folder;
        const auto points = putFoam(folder / "constant/polyMesh", sampleFoam());
        const auto pipe = folder / "constant/polyMesh" / name;
        std::filesystem::remove(pipe);
        ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
        const std::string message = concat(name, ": is not a regular file");
        EXPECT_REFUSED(FileError, message, readModel(folder / ".")->readCells());
        EXPECT_REFUSED(FileError, message, readLattice(folder / "."));
    }
}

TEST(OpenFoam, ListsOfEqualLabelsAreRead) {
    const TemporaryFolder folder;
    Files files = sampleFoam();
    // A tetrahedron alone.
    files["points"] = foamHeader("vectorField", "points") + "4((0 0 0)(1 0 0)(0 1 0)(0 0 1))";
    files["faces"] = foamHeader("faceList", "faces") + "4(3(0 2 1) 3(0 1 3) 3(1 2 3) 3(2 0 3))";
    files["owner"] = foamHeader("labelList", "owner") + "4{0}";
    for (const char* empty : {"0", "0()", "\n0\n(\n)\n"}) {
        files["neighbour"] = foamHeader("labelList", "neighbour") + empty;
        putFoam(folder / "m", files);
        EXPECT_EQ(readModel(folder / "m/points")->readCells().volume.kind(0),
                  far::StandardCell::Tetrahedron);
    }
}

// The tutorials of OpenFOAM 2.1 have such meshes.
TEST(OpenFoam, OldMeshesHaveANeighbourForEachFace) {
    const TemporaryFolder folder;
    Files files = sampleFoam();
    files["neighbour"] = foamHeader("labelList", "neighbour") + "18(1 2 3" +
                         test::words(std::vector<int>(15, -1)) + ")";
    const auto points = putFoam(folder / "m", files);
    const ModelCells cells = readModel(points)->readCells();
    EXPECT_EQ(cells.volume.cellCount(), 4);
    EXPECT_EQ(cells.volume.internalFaceCount(), 3);
    EXPECT_EQ(readLattice(points).complex.count(3), 4);
    putFile(folder / "m/neighbour", replaced(files["neighbour"], "1 2 3", "1 -1 3"));
    EXPECT_REFUSED(FileError,
                   "neighbour: face 1 has no neighbour (-1), but a face after it has one",
                   readModel(points)->readCells());
}

TEST(OpenFoam, MalformedFilesAreRefusedWithTheLine) {
    const Files good = sampleFoam();
    const auto expectRefused = [](const Files& files, const std::string& message) {
        const TemporaryFolder folder;
        const auto points = putFoam(folder / "m", files);
        EXPECT_REFUSED(Error, message, readModel(points)->readCells());
        EXPECT_THROW(readLattice(points), Error);
    };
    const auto changed = [&](const std::string& name, const std::string& before,
                             const std::string& after) {
        Files files = good;
        files[name] = replaced(files[name], before, after);
        return files;
    };
    expectRefused(changed("points", "FoamFile", "Foam"),
                  "points:4: the file does not begin with FoamFile");
    expectRefused(changed("points", "format ascii", "format xml"), "the format is 'xml'; expected");
    expectRefused(changed("points", "\\*---*/", ""), "a comment /* does not end");
    expectRefused(changed("points", "12\n(", "13\n("), "points:29: expected (, got ')'");
    expectRefused(changed("points", "12\n(", "12{"), "all points are the same");
    expectRefused(changed("points", "12\n(", "120000\n("),
                  "points:15: the number of points is 120000, but only");
    expectRefused(changed("points", "(2.00", "(two"), "points:18: 'two' is not a number");
    expectRefused(changed("points", "(3 1 3)\n)", "(3 1 3)\n) more"),
                  "expected the end of the file after the list");
    expectRefused(changed("faces", "4(4 5 6 7)", "4(4 5 6 12)"),
                  "m/faces: face 0 names point 12; there are 12");
    expectRefused(changed("faces", "4(4 5 6 7)", "5(4 5 6 7)"), "')' is not a number");
    expectRefused(changed("faces", "4(4 5 6 7)", "2(4 5)"), "face 0 has fewer than 3 points");
    expectRefused(changed("owner", "18\n(", "17\n("), "expected ), got '3'");
    expectRefused(changed("owner", "18\n(", "999999999999\n("),
                  "owner:14: has 999999999999 labels, but there are 18 faces");
    expectRefused(changed("owner", "\n3\n)", "\n-1\n)"), "the number of a cell is -1");
    expectRefused(changed("owner", "\n3\n)", "\n99\n)"), "names cell 99, but there are 18 faces");
    expectRefused(changed("neighbour", "\n3\n)", "\n-2\n)"),
                  "the number of a cell is -2; expected -1 to");
    expectRefused(changed("neighbour", "\n3\n)", "\n3 3\n)"), "expected ), got '3'");
    Files files = good;
    files["owner"] = foamHeader("labelList", "owner") + "17{0}";
    expectRefused(files, "owner: has 17 labels, but there are 18 faces");
    files = good;
    files["neighbour"] = foamHeader("labelList", "neighbour") + "19{0}";
    expectRefused(files, "neighbour:14: has 19 labels, but there are 18 faces");
    files = good;
    files["neighbour"] = foamHeader("labelList", "neighbour") + "1{0}";
    expectRefused(files, "neighbour: face 0 has cell 0 as its owner and as its neighbour");
    files = good;
    files.erase("owner");
    expectRefused(files, "owner: cannot open");
    files = sampleFoam(true);
    files["faces"] = replaced(files["faces"], "faceCompactList", "faceList");
    expectRefused(files, "the class is 'faceList', which cannot be read in binary");
    files = sampleFoam(true);
    files["faces"] = replaced(files["faces"], "19\n(" + bytesOf(0, std::endian::little),
                              "19\n(" + bytesOf(1, std::endian::little));
    expectRefused(files, "the faces have the points 1 to");
    for (const bool isBinary : {false, true}) {
        const std::string bytes = sampleFoam(isBinary)["points"];
        expectPartsRefused("points", bytes, bytes.find("// ***") - 4);
    }
}

}  // namespace
}  // namespace espalier::io
