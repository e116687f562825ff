// SPDX-License-Identifier: Apache-2.0
// All formats of meshes hold the same mesh (mesh_samples.h): what they share is tested here, and
// each format in its own file.
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <io/mesh_samples.h>
#include <io/model_files.h>

#include "support/test.h"

namespace espalier::io {
namespace {

struct Sample {
    std::string name;
    std::string bytes;
    bool isBinary = false;
};

std::vector<Sample> samples() {
    std::vector<Sample> all = {{"a.su2", sampleSu2()},
                               {"a.mesh", sampleMedit()},
                               {"a.msh", sampleGmsh2()},
                               {"b.msh", sampleGmsh2(17, 3)},
                               {"c.msh", sampleGmsh4()}};
    for (const std::endian order : {std::endian::little, std::endian::big}) {
        all.push_back({"d.msh", sampleBinaryGmsh2(order), true});
        all.push_back({"e.msh", sampleBinaryGmsh4(order), true});
    }
    return all;
}

TEST(MeshModel, HasThePointsOfTheFile) {
    for (const Sample& sample : samples()) {
        const auto model = readModel(sample.name, sample.bytes);
        EXPECT_EQ(copyOf(model->positions()), samplePoints()) << sample.name;
        EXPECT_EQ(model->storage(),
                  sample.isBinary ? CoordinateStorage::Double : CoordinateStorage::Text);
        EXPECT_FALSE(model->hasDirections());
        EXPECT_EQ("x" + std::string(model->extension()), "x" + sample.name.substr(1));
    }
}

TEST(MeshModel, OnlyChangedCoordinatesAreReplaced) {
    for (const Sample& sample : samples()) {
        const auto model = readModel(sample.name, sample.bytes);
        EXPECT_TRUE(written(*model, model->positions()) == sample.bytes) << sample.name;
        auto moved = copyOf(model->positions());
        moved[1][0] = 2.5;
        moved[11] = {0.1, -7, 3};
        std::string expected = sample.bytes;
        const auto replace = [&](const std::string& before, const std::string& after) {
            const std::size_t at = expected.find(before);
            ASSERT_NE(at, std::string::npos) << sample.name;
            expected.replace(at, before.size(), after);
        };
        if (sample.isBinary) {
            const std::endian order = sample.bytes.find(std::string("\0\0\0\1", 4)) < 30
                                          ? std::endian::big
                                          : std::endian::little;
            replace(bytesOfPoint({2, 0, 0}, order), bytesOfPoint({2.5, 0, 0}, order));
            replace(bytesOfPoint({3, 1, 3}, order), bytesOfPoint({0.1, -7, 3}, order));
        } else {
            replace("2.00 +0e0 -0.0", "2.5 +0e0 -0.0");
            replace("3 1 3", "0.1 -7 3");
        }
        EXPECT_TRUE(written(*model, moved) == expected) << sample.name;
        EXPECT_EQ(copyOf(readModel(sample.name, expected)->positions()), moved);
    }
}

TEST(MeshModel, HasTheFacesOfSurfaces) {
    for (const Sample& sample : samples()) {
        const ModelFaces faces = readModel(sample.name, sample.bytes)->readSurface().faces;
        std::set<std::vector<Index>> loops;
        for (std::size_t i = 0; i < faces.count(); ++i)
            loops.emplace(faces[i].begin(), faces[i].end());
        EXPECT_EQ(loops, (std::set<std::vector<Index>>{{0, 3, 2, 1}, {4, 5, 8}})) << sample.name;
    }
}

/// Returns six times the volume of a cell.
double volumeOf(const far::VolumeMesh& mesh, Index cell) {
    double volume = 0;
    const auto points = samplePoints();
    for (const Index face : mesh.faces(cell)) {
        const auto loop = mesh.face(face);
        double part = 0;
        for (std::size_t i = 2; i < loop.size(); ++i) {
            const Point3 &a = points[loop[0]], &b = points[loop[i - 1]], &c = points[loop[i]];
            part += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                    a[2] * (b[0] * c[1] - b[1] * c[0]);
        }
        volume += mesh.owner(face) == cell ? part : -part;
    }
    return volume;
}

TEST(MeshModel, HasTheCellsOfTheVolume) {
    for (const Sample& sample : samples()) {
        const ModelCells cells = readModel(sample.name, sample.bytes)->readCells();
        ASSERT_EQ(cells.volume.cellCount(), 4) << sample.name;
        EXPECT_EQ(cells.curvedCells, 0);
        EXPECT_EQ(cells.volume.pointCount(), 12);
        std::set<std::vector<Index>> corners;
        for (Index cell = 0; cell < 4; ++cell) {
            const auto ofCell = cells.volume.corners(cell);
            corners.emplace(ofCell.begin(), ofCell.end());
            EXPECT_GT(volumeOf(cells.volume, cell), 0) << sample.name << " " << cell;
        }
        // In VTK's order, the first triangle of a wedge is clockwise seen from the other one. It
        // may be either triangle, since a wedge is turned as a whole.
        EXPECT_TRUE(corners.contains({0, 1, 2, 3, 4, 5, 6, 7}));
        EXPECT_TRUE(corners.contains({4, 5, 6, 7, 8}));
        EXPECT_TRUE(corners.contains({1, 9, 5, 2, 10, 6}) || corners.contains({2, 6, 10, 1, 5, 9}));
        EXPECT_TRUE(corners.contains({5, 9, 10, 11}));
        // The pyramid and the wedge share a quadrilateral with the cube.
        EXPECT_EQ(cells.volume.internalFaceCount(), 2);
    }
}

/// The four cells without the tetrahedron, whose face is on a half of a quadrilateral of the wedge,
/// as a lattice.
TEST(MeshModel, IsALattice) {
    for (const Sample& sample : samples()) {
        ReadNotes notes;
        const Lattice lattice = readLattice(sample.name, sample.bytes, &notes);
        EXPECT_EQ(lattice.complex.count(3), 4) << sample.name;
        EXPECT_EQ(lattice.positions, samplePoints());
        EXPECT_EQ(notes.skippedCells[2], 2);
        EXPECT_THAT(notes.droppedVertices, IsEmpty());
    }
    ReadNotes notes;
    readLattice("a.msh", sampleGmsh2(), &notes);
    EXPECT_EQ(describe("a.msh", notes),
              "a.msh: skipped 1 vertex cell, 1 line and 2 surface cells, which are not cells of a "
              "lattice");
}

TEST(MeshModel, OnlySurfacesAreConverted) {
    for (const Sample& sample : samples()) {
        const auto model = readModel(sample.name, sample.bytes);
        EXPECT_REFUSED(FileError, "b.stl: a .stl cannot hold 4 cells of a volume of the model",
                       model->checkTarget("b.stl"));
    }
    const auto triangle = readModel(
        "a.msh",
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n"
        "$Elements\n1\n1 2 2 0 1 1 2 3\n$EndElements\n");
    EXPECT_EQ(triangle->checkTarget("b.obj"), "");
    for (const std::string name : {"b.su2", "b.mesh", "b.xyz"})
        EXPECT_REFUSED(FileError,
                       name + ": a model that was read as .msh cannot be written as " +
                           name.substr(1) + ", because this is a format of meshes with cells",
                       triangle->checkTarget(name));
}

TEST(MeshModel, CannotBeWrittenAsALattice) {
    const Lattice lattice = readLattice("a.su2", sampleSu2());
    for (const char* name :
         {"a.su2", "a.msh", "a.mesh", "a.xyz", "a.p3d", "a.fmt", "points", "/tmp"}) {
        EXPECT_REFUSED(FileError, "which is only read; expected .ovm, .vtu or .vtk",
                       writeLattice(name, lattice));
        EXPECT_REFUSED(FileError, "expected .ovm, .vtu or .vtk", writeRefinable(name, lattice));
    }
}

TEST(MeshModel, CutFilesAreRefused) {
    for (const Sample& sample : samples()) {
        const std::size_t end = sample.name == "a.su2"    ? sample.bytes.find("3 1 3 11")
                                : sample.name == "a.mesh" ? sample.bytes.find("3 1 3 7")
                                                          : sample.bytes.find("$EndNodes");
        expectPartsRefused(sample.name, sample.bytes, end);
        // Cells are read later.
        const std::string cut =
            sample.bytes.substr(0, sample.name == "a.su2" ? sample.bytes.find("MARKER_ELEMS") + 18
                                   : sample.name == "a.mesh" ? sample.bytes.find("Prisms") + 12
                                                             : sample.bytes.size() - 40);
        const std::string kept = cut.substr(0, cut.find("$NodeData"));
        if (kept.find("$EndElements") != std::string::npos) continue;
        EXPECT_THROW(readModel(sample.name, kept)->readCells(), FileError) << sample.name;
    }
}

// A polyhedron may have faces of any direction in VTK's files, and the whole mesh may be mirrored.
TEST(MeshModel, CellsAreTurnedRightHanded) {
    const std::string points = "0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1";
    const std::string mirrored = "0 0 0 -1 0 0 -1 1 0 0 1 0 0 0 1 -1 0 1 -1 1 1 0 1 1";
    for (const std::string& positions : {points, mirrored}) {
        const auto grid = [&](const std::string& cells, const std::string& types) {
            return readModel("a.vtk",
                             "# vtk DataFile Version 2.0\na\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                             "POINTS 8 double\n" +
                                 positions + "\n" + cells + "\n" + types + "\n")
                ->readCells();
        };
        const auto volume = [&](const far::VolumeMesh& mesh) {
            double sum = 0;
            const bool isMirrored = positions == mirrored;
            const auto unit = std::vector<Point3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                                  {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
            for (Index face = 0; face < mesh.faceCount(); ++face) {
                const auto loop = mesh.face(face);
                for (std::size_t i = 2; i < loop.size(); ++i) {
                    const Point3 &a = unit[loop[0]], &b = unit[loop[i - 1]], &c = unit[loop[i]];
                    sum +=
                        (isMirrored ? -1 : 1) *
                        (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                         a[2] * (b[0] * c[1] - b[1] * c[0])) /
                        6;
                }
            }
            return sum;
        };
        EXPECT_NEAR(volume(grid("CELLS 1 9\n8 0 1 2 3 4 5 6 7", "CELL_TYPES 1\n12").volume), 1,
                    1e-15);
        // The faces of a polyhedron in mixed directions.
        EXPECT_NEAR(
            volume(grid("CELLS 1 32\n31 6 4 0 1 2 3 4 4 5 6 7 4 0 1 5 4 4 2 1 5 6 4 2 3 7 6 4 "
                        "0 3 7 4",
                        "CELL_TYPES 1\n42")
                       .volume),
            1, 1e-15);
    }
}

// tests/hosts/second_order_test.py compares the orders of the points with VTK and Gmsh.
TEST(MeshModel, UnstructuredGridsHaveCellsOfSecondOrder) {
    for (const auto& [type, size] :
         {std::pair(24, 10), {71, 10}, {27, 13}, {26, 15}, {32, 18}, {25, 20}, {29, 27}}) {
        std::string coordinates, connectivity;
        for (int i = 0; i < size; ++i) {
            coordinates += concat(i, " ", i * i, " ", i * i * i, " ");
            connectivity += concat(i, " ");
        }
        const std::string text = concat(
            "<VTKFile type='UnstructuredGrid' version='1.0'><UnstructuredGrid>"
            "<Piece NumberOfPoints='",
            size,
            "' NumberOfCells='1'><Points><DataArray type='Float64' "
            "NumberOfComponents='3' format='ascii'>",
            coordinates,
            "</DataArray></Points><Cells><DataArray type='Int32' Name='connectivity' "
            "format='ascii'>",
            connectivity, "</DataArray><DataArray type='Int32' Name='offsets' format='ascii'>",
            size, "</DataArray><DataArray type='UInt8' Name='types' format='ascii'>", type,
            "</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>");
        const ModelCells cells = readModel("a.vtu", text)->readCells();
        EXPECT_EQ(cells.curvedCells, 0) << type;
        ASSERT_EQ(cells.volume.cellCount(), 1) << type;
        EXPECT_EQ(cells.volume.points(0).size(), std::size_t(size));
        EXPECT_TRUE(cells.volume.isSecondOrder(0));
    }
}

TEST(MeshModel, UnstructuredGridsOfFacesAreSurfaces) {
    const auto grid = [](int type, int size) {
        std::string connectivity;
        for (int i = 0; i < size; ++i) connectivity += concat(i, " ");
        return concat(
            "# vtk DataFile Version 3.0\na\nASCII\nDATASET UNSTRUCTURED_GRID\n"
            "POINTS 9 float\n0 0 0 1 0 0 0 1 0 1 1 0 2 0 0 2 1 0 3 0 0 3 1 0 4 0 0\n"
            "CELLS 1 ",
            size + 1, "\n", size, " ", connectivity, "\nCELL_TYPES 1\n", type, "\n");
    };
    for (const auto& [type, size] : {std::pair(5, 3),
                                     {7, 3},
                                     {7, 4},
                                     {8, 4},
                                     {9, 4},
                                     {22, 6},
                                     {23, 8},
                                     {28, 9},
                                     {69, 6},
                                     {70, 9}}) {
        const ModelCells cells = readModel("a.vtk", grid(type, size))->readCells();
        ASSERT_EQ(cells.surface.faceCount(), 1) << type;
        EXPECT_EQ(cells.surface.points(0).size(), std::size_t(size));
        EXPECT_THAT(uncheckedElements(cells), IsEmpty());
    }
    // A pixel goes by rows, and a strip of five points has three triangles.
    EXPECT_THAT(readModel("a.vtk", grid(8, 4))->readCells().surface.points(0),
                ElementsAre(0, 1, 3, 2));
    EXPECT_EQ(readModel("a.vtk", grid(6, 5))->readCells().surface.faceCount(), 3);
    EXPECT_EQ(readModel("a.vtk", grid(7, 5))->readCells().polygons, 1);
    EXPECT_EQ(readModel("a.vtk", grid(34, 7))->readCells().curvedFaces, 1);
    EXPECT_EQ(readModel("a.vtk", grid(22, 5))->readCells().curvedFaces, 1);
}

TEST(MeshModel, UnstructuredGridsHaveVolumes) {
    const std::string text =
        "<VTKFile type='UnstructuredGrid' version='1.0' byte_order='LittleEndian'>\n"
        "<UnstructuredGrid><Piece NumberOfPoints='5' NumberOfCells='3'>\n"
        "<Points><DataArray type='Float32' NumberOfComponents='3' format='ascii'>\n"
        "0 0 0 1 0 0 0 1 0 0 0 1 0 0 -1</DataArray></Points><Cells>"
        "<DataArray type='Int32' Name='connectivity' format='ascii'>0 1 2 3 0 1 2 0 2 1 4"
        "</DataArray><DataArray type='Int32' Name='offsets' format='ascii'>4 7 11</DataArray>"
        "<DataArray type='UInt8' Name='types' format='ascii'>10 5 10</DataArray>"
        "</Cells></Piece></UnstructuredGrid></VTKFile>\n";
    const ModelCells cells = readModel("a.vtu", text)->readCells();
    EXPECT_EQ(cells.volume.cellCount(), 2);
    EXPECT_EQ(cells.volume.internalFaceCount(), 1);
    EXPECT_EQ(cells.facesBeside, 0);
    // A quadratic cell with the wrong number of points, and a cubic one, are counted only.
    for (const char* types : {"10 5 24", "10 5 73"}) {
        std::string curved = text;
        curved.replace(curved.find("10 5 10"), 7, types);
        EXPECT_EQ(readModel("a.vtu", curved)->readCells().curvedCells, 1);
        EXPECT_EQ(readModel("a.vtu", curved)->readCells().volume.cellCount(), 1);
    }
    // A triangle that is no face of a cell is counted.
    std::string beside = text;
    beside.replace(beside.find(" 0 1 2 0 2 1 4"), 14, " 0 1 4 0 2 1 3");
    EXPECT_EQ(readModel("a.vtu", beside)->readCells().facesBeside, 1);
    // Surfaces have no volume.
    EXPECT_EQ(
        readModel("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")->readCells().volume.cellCount(),
        0);
}

}  // namespace
}  // namespace espalier::io
