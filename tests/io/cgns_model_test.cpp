// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/cgns/cgns_model.h>
#include <io/cgns_samples.h>
#include <io/model_files.h>
#include <io/replaced.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdlib>

#include "support/test.h"

namespace espalier::io {
namespace {

TEST(CgnsModel, CoordinatesAreReplacedInPlace) {
    addCgnsModels();
    addCgnsModels();  // A second call changes nothing.
    for (const int storage : {CG_FILE_HDF5, CG_FILE_ADF}) {
        const TemporaryFolder folder;
        writeSample(folder / "a.cgns", storage);
        const std::string before = readFile(folder / "a.cgns");
        const auto model = readModel(folder / "a.cgns");
        ASSERT_EQ(model->positions().size(), 12u + 8 + 4);
        EXPECT_EQ(model->positions()[11], (Point3{1, 4, 3.1}));
        EXPECT_EQ(model->positions()[17], (Point3{0, 2, double{0.1f}}));
        EXPECT_EQ(model->positions()[23], (Point3{0, 0, 1}));
        EXPECT_EQ(model->extension(), ".cgns");
        EXPECT_EQ(model->storage(), CoordinateStorage::Float);
        EXPECT_TRUE(written(*model, model->positions()) == before);

        auto moved = copyOf(model->positions());
        moved[11] = {1.5, 4.25, 3.1};
        moved[17][2] = 0.7;
        const std::string after = written(*model, moved);
        // The bytes that differ are those of three numbers.
        ASSERT_EQ(after.size(), before.size());
        std::size_t changed = 0;
        for (std::size_t i = 0; i < after.size(); ++i) changed += after[i] != before[i] ? 1 : 0;
        EXPECT_GT(changed, 0u);
        EXPECT_LE(changed, 2 * sizeof(double) + sizeof(float));
        const auto again = readModel("b.cgns", after);
        moved[17][2] = double{0.7f};
        EXPECT_EQ(copyOf(again->positions()), moved);
        // A binding keeps the bytes, and not the file.
        EXPECT_EQ(copyOf(readModel("none/a.cgns", before)->positions()),
                  copyOf(model->positions()));
    }
}

TEST(CgnsModel, HasTheCellsAndFacesOfAllZones) {
    for (const int storage : {CG_FILE_HDF5, CG_FILE_ADF}) {
        const TemporaryFolder folder;
        writeSample(folder / "a.cgns", storage);
        const auto model = readModel(folder / "a.cgns", readFile(folder / "a.cgns"));
        const ModelCells cells = model->readCells();
        EXPECT_EQ(cells.curvedCells, 0);
        ASSERT_EQ(cells.volume.cellCount(), 2 + 2 + 1 + 1);
        EXPECT_EQ(cells.volume.kind(0), far::StandardCell::Hexahedron);
        EXPECT_EQ(cells.volume.kind(2), far::StandardCell::Pyramid);
        EXPECT_EQ(cells.volume.kind(3), far::StandardCell::Tetrahedron);
        EXPECT_TRUE(cells.volume.isSecondOrder(4));
        EXPECT_EQ(cells.volume.kind(5), std::nullopt);
        EXPECT_EQ(cells.volume.faces(5).size(), 4u);
        EXPECT_EQ(cells.volume.internalFaceCount(), 1);  // In the grid.
        // The sections are groups; the zone of the grid and the faces of polyhedra are in none.
        std::vector<std::string> names;
        for (const far::MeshPatch& patch : cells.patches) names.push_back(patch.name);
        EXPECT_THAT(names, ElementsAre("Cells", "Wall", "Curved"));
        const ModelFaces faces = model->readSurface().faces;
        ASSERT_EQ(faces.count(), 1u);
        EXPECT_THAT(faces[0], ElementsAre(12, 14, 13));
    }
}

TEST(CgnsModel, PlanesHaveNoZ) {
    const TemporaryFolder folder;
    {
        CgnsFile file(folder / "a.cgns", CG_FILE_HDF5, 2);
        cgsize_t sizes[6] = {2, 2, 1, 1, 0, 0};
        int zone = 0;
        CgnsFile::check(
            cg_zone_write(file.file, file.base, "Plane", sizes, CGNS_ENUMV(Structured), &zone));
        file.coordinates<double>(zone, "CoordinateX", {0, 1, 0, 1});
        file.coordinates<double>(zone, "CoordinateY", {0, 0, 1, 1});
    }
    const auto model = readModel("a.cgns", readFile(folder / "a.cgns"));
    EXPECT_EQ(model->readSurface().faces.count(), 1u);
    EXPECT_EQ(model->readCells().volume.cellCount(), 0);
    auto moved = copyOf(model->positions());
    moved[3] = {2, 2, 0};
    EXPECT_EQ(copyOf(readModel("b.cgns", written(*model, moved))->positions()), moved);
    moved[3][2] = 1;
    EXPECT_REFUSED(Error, "point 3 has a z other than 0", written(*model, moved));
}

TEST(CgnsModel, BadFilesAreRefused) {
    EXPECT_REFUSED(FileError, "a.cgns: is neither an HDF5 file nor an ADF file",
                   readModel("a.cgns", "no CGNS file"));
    const TemporaryFolder folder;
    {
        CgnsFile file(folder / "a.cgns", CG_FILE_HDF5);
        const int zone = file.unstructured("Polar", 2, 1);
        file.coordinates<double>(zone, "CoordinateR", {0, 1});
    }
    EXPECT_REFUSED(FileError, "the zone 'Polar' has no coordinates CoordinateX and CoordinateY",
                   readModel("a.cgns", readFile(folder / "a.cgns")));
    {
        CgnsFile file(folder / "b.cgns", CG_FILE_HDF5);
        const int zone = file.unstructured("Z", 4, 1);
        for (const char* name : {"CoordinateX", "CoordinateY", "CoordinateZ"})
            file.coordinates<double>(zone, name, {0, 1, 2, kNan});
        file.section(zone, "Cells", CGNS_ENUMV(TETRA_4), 1, 1, {1, 2, 3, 5});
    }
    EXPECT_REFUSED(FileError, "x of point 3 is not finite",
                   readModel("b.cgns", readFile(folder / "b.cgns")));
    {
        CgnsFile file(folder / "c.cgns", CG_FILE_HDF5);
        const int zone = file.unstructured("Z", 4, 1);
        for (const char* name : {"CoordinateX", "CoordinateY", "CoordinateZ"})
            file.coordinates<double>(zone, name, {0, 1, 2, 3});
        file.section(zone, "Cells", CGNS_ENUMV(TETRA_4), 1, 1, {1, 2, 3, 5});
    }
    EXPECT_REFUSED(FileError, "an element names point 5; there are 4, counted from 1",
                   readModel("c.cgns", readFile(folder / "c.cgns"))->readCells());
}

// The library does not check the types of the elements in a MIXED section.
TEST(CgnsModel, ElementsOfUnknownTypesAreRefused) {
    const TemporaryFolder folder;
    {
        CgnsFile file(folder / "a.cgns", CG_FILE_HDF5);
        const int zone = file.unstructured("Z", 4, 1);
        for (const char* name : {"CoordinateX", "CoordinateY", "CoordinateZ"})
            file.coordinates<double>(zone, name, {0, 1, 2, 3});
        file.section(zone, "Cells", CGNS_ENUMV(MIXED), 1, 1, {CGNS_ENUMV(TETRA_4), 1, 2, 3, 4},
                     {0, 5});
    }
    const std::string good = readFile(folder / "a.cgns");
    const auto bytesOfType = [](cgsize_t type) {
        const cgsize_t row[] = {type, 1, 2, 3, 4};
        return std::string(reinterpret_cast<const char*>(row), sizeof row);
    };
    const auto volumeOf = [&](cgsize_t type) {
        return readModel("a.cgns",
                         replaced(good, bytesOfType(CGNS_ENUMV(TETRA_4)), bytesOfType(type)))
            ->readCells();
    };
    EXPECT_EQ(volumeOf(CGNS_ENUMV(TETRA_4)).volume.cellCount(), 1);
    for (const cgsize_t type : {9999, 2147483647, -5, NofValidElementTypes})
        EXPECT_REFUSED(FileError,
                       concat("an element of a MIXED section has the type ", type,
                              "; the types of CGNS are 0 to ", NofValidElementTypes - 1),
                       volumeOf(type));
    for (const auto type : {CGNS_ENUMV(ElementTypeNull), CGNS_ENUMV(ElementTypeUserDefined),
                            CGNS_ENUMV(MIXED), CGNS_ENUMV(NGON_n), CGNS_ENUMV(NFACE_n)})
        EXPECT_REFUSED(
            FileError,
            concat("an element has the type ", ElementTypeName[type], ", whose points are not"),
            volumeOf(type));
    EXPECT_EQ(volumeOf(CGNS_ENUMV(NODE)).curvedCells, 0);
    EXPECT_REFUSED(FileError, "a cell has 4 points; expected 10", volumeOf(CGNS_ENUMV(TETRA_10)));
}

TEST(CgnsModel, EachArrayRoundsByItsOwnPrecision) {
    const TemporaryFolder folder;
    {
        CgnsFile file(folder / "a.cgns", CG_FILE_HDF5);
        const int zone = file.unstructured("Z", 2, 1);
        file.coordinates<double>(zone, "CoordinateX", {0, 1});
        file.coordinates<float>(zone, "CoordinateY", {0, 1});
        file.coordinates<double>(zone, "CoordinateZ", {0, 1});
    }
    const auto model = readModel("a.cgns", readFile(folder / "a.cgns"));
    const std::vector<Point3> moved = {{0.1, 0.1, 0.1}, {0.7, 0.7, 0.7}};
    const std::vector<Point3> stored = {{0.1, double{0.1F}, 0.1}, {0.7, double{0.7F}, 0.7}};
    EXPECT_EQ(model->stored(moved), stored);
    EXPECT_EQ(copyOf(readModel("a.cgns", written(*model, moved))->positions()), stored);
}

TEST(CgnsModel, ErrorsOfTheTemporaryFileNameIt) {
    const TemporaryFolder folder;
    writeSample(folder / "a.cgns", CG_FILE_HDF5);
    const std::string bytes = readFile(folder / "a.cgns");
    const char* before = std::getenv("TMPDIR");
    const std::string old = before ? before : "";
    const auto expectRefused = [&](const std::string& message) {
        try {
            readModel("a.cgns", bytes);
            ADD_FAILURE();
        } catch (const FileError& error) {
            EXPECT_THAT(error.what(), HasSubstr(message));
            EXPECT_THAT(error.what(), HasSubstr("the variable TMPDIR names another folder"));
            EXPECT_THAT(error.what(), Not(HasSubstr("a.cgns")));
        }
    };
    ::setenv("TMPDIR", (folder / "none").c_str(), 1);
    expectRefused("the folder of temporary files cannot be found");
    std::filesystem::create_directories(folder / "small");
    ::setenv("TMPDIR", (folder / "small").c_str(), 1);
    rlimit limit{};
    ::getrlimit(RLIMIT_FSIZE, &limit);
    const rlimit small{1000, limit.rlim_max};
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    ::setrlimit(RLIMIT_FSIZE, &small);
    expectRefused("a temporary file cannot be written: File too large");
    ::setrlimit(RLIMIT_FSIZE, &limit);
    std::signal(SIGXFSZ, handler);
    EXPECT_TRUE(std::filesystem::is_empty(folder / "small"));
    if (before)
        ::setenv("TMPDIR", old.c_str(), 1);
    else
        ::unsetenv("TMPDIR");
}

}  // namespace
}  // namespace espalier::io
