// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/model.h>
#include <io/cgns_samples.h>

#include "support/test.h"

namespace espalier::io {
namespace {

using test::CgnsFile;

/// Adds a boundary condition. Returns its number.
int condition(CgnsFile& file, int zone, const char* name, CGNS_ENUMT(BCType_t) type,
              CGNS_ENUMT(PointSetType_t) set, cgsize_t count, const std::vector<cgsize_t>& numbers,
              CGNS_ENUMT(GridLocation_t) location, const char* family = nullptr) {
    int number = 0;
    CgnsFile::check(
        cg_boco_write(file.file, file.base, zone, name, type, set, count, numbers.data(), &number));
    CgnsFile::check(cg_boco_gridlocation_write(file.file, file.base, zone, number, location));
    if (family != nullptr) {
        CgnsFile::check(
            cg_goto(file.file, file.base, "Zone_t", zone, "ZoneBC_t", 1, "BC_t", number, "end"));
        CgnsFile::check(cg_famname_write(family));
    }
    return number;
}

/// A cube with six quadrilaterals: cells 1, faces 2 to 7 (down, up, low y, high x, high y, low x).
int cube(CgnsFile& file, const char* name, double x) {
    const int zone = file.unstructured(name, 8, 1);
    file.coordinates<double>(zone, "CoordinateX", {x, x + 1, x + 1, x, x, x + 1, x + 1, x});
    file.coordinates<double>(zone, "CoordinateY", {0, 0, 1, 1, 0, 0, 1, 1});
    file.coordinates<double>(zone, "CoordinateZ", {0, 0, 0, 0, 1, 1, 1, 1});
    file.section(zone, "Cells", CGNS_ENUMV(HEXA_8), 1, 1, {1, 2, 3, 4, 5, 6, 7, 8});
    file.section(zone, "Skin", CGNS_ENUMV(QUAD_4), 2, 7,
                 {1, 4, 3, 2, 5, 6, 7, 8, 1, 2, 6, 5, 2, 3, 7, 6, 3, 4, 8, 7, 4, 1, 5, 8});
    return zone;
}

const far::MeshPatch* find(const ModelCells& cells, const std::string& name) {
    const auto found = std::ranges::find(cells.patches, name, &far::MeshPatch::name);
    return found == cells.patches.end() ? nullptr : &*found;
}

ModelCells cellsIn(const std::filesystem::path& path) {
    return readModel(path)->readCells();
}

TEST(CgnsConditions, ElementsAndVerticesArePatches) {
    for (const int storage : {CG_FILE_HDF5, CG_FILE_ADF}) {
        const TemporaryFolder folder;
        {
            CgnsFile file(folder / "a.cgns", storage);
            const int zone = cube(file, "Cube", 0);
            condition(file, zone, "bottom", CGNS_ENUMV(BCWall), CGNS_ENUMV(PointList), 1, {2},
                      CGNS_ENUMV(FaceCenter));
            condition(file, zone, "sides", CGNS_ENUMV(BCInflow), CGNS_ENUMV(PointRange), 2, {4, 6},
                      CGNS_ENUMV(FaceCenter));
            condition(file, zone, "top", CGNS_ENUMV(BCSymmetryPlane), CGNS_ENUMV(PointList), 4,
                      {8, 5, 6, 7}, CGNS_ENUMV(Vertex));
            condition(file, zone, "low", CGNS_ENUMV(BCTypeNull), CGNS_ENUMV(PointRange), 2, {4, 1},
                      CGNS_ENUMV(Vertex));
            // Two conditions of one element, and an element that does not exist.
            condition(file, zone, "odd", CGNS_ENUMV(BCGeneral), CGNS_ENUMV(PointList), 4,
                      {7, 2, 99, 2}, CGNS_ENUMV(FaceCenter));
        }
        const ModelCells cells = cellsIn(folder / "a.cgns");
        ASSERT_EQ(cells.volume.cellCount(), 1);
        EXPECT_EQ(cells.missingElements, 1);
        EXPECT_EQ(uncheckedElements(cells).size(), 1u);
        const auto check = [&](const char* name, const char* type, Index faces,
                               const std::vector<Index>& points) {
            const far::MeshPatch* patch = find(cells, name);
            ASSERT_NE(patch, nullptr) << name;
            EXPECT_EQ(patch->type, type) << name;
            EXPECT_EQ(patch->faceCount(), faces) << name;
            EXPECT_EQ(patch->points, points) << name;
            EXPECT_EQ(patch->dimension, 2) << name;
        };
        check("bottom", "BCWall", 1, {0, 1, 2, 3});
        EXPECT_THAT(find(cells, "bottom")->faces[0], ElementsAre(0, 3, 2, 1));
        check("sides", "BCInflow", 3, {0, 1, 2, 3, 4, 5, 6, 7});
        check("top", "BCSymmetryPlane", 0, {4, 5, 6, 7});
        check("low", "", 0, {0, 1, 2, 3});
        check("odd", "BCGeneral", 2, {0, 1, 2, 3, 4, 7});
        check("Skin", "", 6, {0, 1, 2, 3, 4, 5, 6, 7});
    }
}

TEST(CgnsConditions, AFamilyIsOnePatchOfAllZones) {
    const TemporaryFolder folder;
    {
        CgnsFile file(folder / "a.cgns", CG_FILE_HDF5);
        int family = 0, number = 0;
        CgnsFile::check(cg_family_write(file.file, file.base, "Body", &family));
        CgnsFile::check(cg_fambc_write(file.file, file.base, family, "FamBC",
                                       CGNS_ENUMV(BCWallViscous), &number));
        for (const int i : {0, 1}) {
            const int zone = cube(file, i == 0 ? "A" : "B", 2 * i);
            condition(file, zone, "wall", CGNS_ENUMV(FamilySpecified), CGNS_ENUMV(PointList), 1,
                      {cgsize_t(2 + i)}, CGNS_ENUMV(FaceCenter), "Body");
            // A section of the same name as a condition of any zone is no patch of its own.
            condition(file, zone, i == 0 ? "Skin" : "other", CGNS_ENUMV(BCFarfield),
                      CGNS_ENUMV(PointList), 1, {7}, CGNS_ENUMV(FaceCenter));
        }
    }
    const ModelCells cells = cellsIn(folder / "a.cgns");
    std::vector<std::string> names;
    for (const far::MeshPatch& patch : cells.patches) names.push_back(patch.name);
    EXPECT_THAT(names, ElementsAre("Cells", "Body", "Skin", "other"));
    EXPECT_EQ(find(cells, "Body")->type, "BCWallViscous");
    EXPECT_THAT(find(cells, "Body")->points, ElementsAre(0, 1, 2, 3, 12, 13, 14, 15));
    EXPECT_EQ(find(cells, "Body")->faceCount(), 2);
    EXPECT_THAT(find(cells, "Skin")->points, ElementsAre(0, 3, 4, 7));
    EXPECT_EQ(cells.missingElements, 0);
}

TEST(CgnsConditions, FacesOfPolyhedraAreNamedByTheirNumbers) {
    const TemporaryFolder folder;
    {
        CgnsFile file(folder / "a.cgns", CG_FILE_HDF5);
        const int zone = file.unstructured("Tetrahedron", 4, 1);
        file.coordinates<double>(zone, "CoordinateX", {0, 1, 0, 0});
        file.coordinates<double>(zone, "CoordinateY", {0, 0, 1, 0});
        file.coordinates<double>(zone, "CoordinateZ", {0, 0, 0, 1});
        file.section(zone, "Faces", CGNS_ENUMV(NGON_n), 1, 4, {1, 3, 2, 1, 2, 4, 2, 3, 4, 3, 1, 4},
                     {0, 3, 6, 9, 12});
        file.section(zone, "Cells", CGNS_ENUMV(NFACE_n), 5, 5, {1, 2, 3, 4}, {0, 4});
        condition(file, zone, "slope", CGNS_ENUMV(BCWall), CGNS_ENUMV(PointList), 1, {3},
                  CGNS_ENUMV(FaceCenter));
    }
    const ModelCells cells = cellsIn(folder / "a.cgns");
    EXPECT_EQ(cells.volume.cellCount(), 1);
    const far::MeshPatch* patch = find(cells, "slope");
    ASSERT_NE(patch, nullptr);
    EXPECT_EQ(patch->faceCount(), 1);
    EXPECT_THAT(patch->points, ElementsAre(1, 2, 3));
    EXPECT_EQ(find(cells, "Faces"), nullptr);
    EXPECT_EQ(cells.facesBeside, 0);
}

/// A grid of 2 x 3 x 4 points.
int grid(CgnsFile& file) {
    cgsize_t sizes[9] = {2, 3, 4, 1, 2, 3, 0, 0, 0};
    int zone = 0;
    CgnsFile::check(
        cg_zone_write(file.file, file.base, "Grid", sizes, CGNS_ENUMV(Structured), &zone));
    std::vector<double> x, y, z;
    for (int k = 0; k < 4; ++k)
        for (int j = 0; j < 3; ++j)
            for (int i = 0; i < 2; ++i) {
                x.push_back(i);
                y.push_back(j);
                z.push_back(k);
            }
    file.coordinates(zone, "CoordinateX", x);
    file.coordinates(zone, "CoordinateY", y);
    file.coordinates(zone, "CoordinateZ", z);
    return zone;
}

TEST(CgnsConditions, RangesOfGridsAreFaces) {
    const TemporaryFolder folder;
    {
        CgnsFile file(folder / "a.cgns", CG_FILE_HDF5);
        const int zone = grid(file);
        // All points at x = 1; the upper two layers of faces at y = 0; the faces at z = 3, by their
        // numbers; two points; and a range of cells.
        condition(file, zone, "right", CGNS_ENUMV(BCWall), CGNS_ENUMV(PointRange), 2,
                  {2, 1, 1, 2, 3, 4}, CGNS_ENUMV(Vertex));
        condition(file, zone, "front", CGNS_ENUMV(BCSymmetryPlane), CGNS_ENUMV(PointRange), 2,
                  {1, 1, 2, 1, 1, 3}, CGNS_ENUMV(JFaceCenter));
        condition(file, zone, "top", CGNS_ENUMV(BCInflow), CGNS_ENUMV(PointList), 2,
                  {1, 1, 4, 1, 2, 4}, CGNS_ENUMV(KFaceCenter));
        condition(file, zone, "two", CGNS_ENUMV(BCGeneral), CGNS_ENUMV(PointList), 2,
                  {1, 1, 1, 2, 3, 4}, CGNS_ENUMV(Vertex));
        condition(file, zone, "cells", CGNS_ENUMV(BCGeneral), CGNS_ENUMV(PointRange), 2,
                  {1, 1, 1, 1, 1, 1}, CGNS_ENUMV(CellCenter));
    }
    const auto model = readModel(folder / "a.cgns");
    const ModelCells cells = model->readCells();
    EXPECT_EQ(cells.volume.cellCount(), 6);
    ASSERT_EQ(cells.patches.size(), 4u);
    const auto check = [&](const char* name, Index faces, std::size_t points, std::size_t axis,
                           double value) {
        const far::MeshPatch* patch = find(cells, name);
        ASSERT_NE(patch, nullptr) << name;
        EXPECT_EQ(patch->faceCount(), faces) << name;
        EXPECT_EQ(patch->points.size(), points) << name;
        for (const Index point : patch->points)
            EXPECT_EQ(model->positions()[point][axis], value) << name;
    };
    check("right", 6, 12, 0, 1);
    check("front", 2, 6, 1, 0);
    check("top", 2, 6, 2, 3);
    for (const Index point : find(cells, "front")->points)
        EXPECT_GE(model->positions()[point][2], 1);
    EXPECT_THAT(find(cells, "two")->points, ElementsAre(0, 23));
    EXPECT_EQ(find(cells, "front")->type, "BCSymmetryPlane");
    EXPECT_EQ(model->groups().size(), 4u);
}

TEST(CgnsConditions, SidesOfPlanesAreLines) {
    const TemporaryFolder folder;
    {
        CgnsFile file(folder / "a.cgns", CG_FILE_HDF5, 2);
        cgsize_t sizes[6] = {3, 2, 2, 1, 0, 0};
        int zone = 0;
        CgnsFile::check(
            cg_zone_write(file.file, file.base, "Plane", sizes, CGNS_ENUMV(Structured), &zone));
        file.coordinates<double>(zone, "CoordinateX", {0, 1, 2, 0, 1, 2});
        file.coordinates<double>(zone, "CoordinateY", {0, 0, 0, 1, 1, 1});
        condition(file, zone, "wall", CGNS_ENUMV(BCWall), CGNS_ENUMV(PointRange), 2, {1, 1, 3, 1},
                  CGNS_ENUMV(Vertex));
        condition(file, zone, "half", CGNS_ENUMV(BCWall), CGNS_ENUMV(PointRange), 2, {2, 2, 2, 2},
                  CGNS_ENUMV(EdgeCenter));
        condition(file, zone, "ends", CGNS_ENUMV(BCWall), CGNS_ENUMV(PointList), 2, {1, 1, 3, 1},
                  CGNS_ENUMV(EdgeCenter));
    }
    const ModelCells cells = cellsIn(folder / "a.cgns");
    EXPECT_EQ(cells.surface.faceCount(), 2);
    EXPECT_THAT(find(cells, "wall")->points, ElementsAre(0, 1, 2));
    EXPECT_EQ(find(cells, "wall")->dimension, 1);
    EXPECT_THAT(find(cells, "half")->points, ElementsAre(4, 5));
    EXPECT_THAT(find(cells, "ends")->points, ElementsAre(0, 2, 3, 5));
}

TEST(CgnsConditions, PointsOutsideAreRefused) {
    const auto refused = [](const std::string& message, auto write) {
        const TemporaryFolder folder;
        {
            CgnsFile file(folder / "a.cgns", CG_FILE_HDF5);
            write(file);
        }
        EXPECT_REFUSED(FileError, message, cellsIn(folder / "a.cgns"));
    };
    refused("an element names point 9; there are 8", [](CgnsFile& file) {
        condition(file, cube(file, "A", 0), "wall", CGNS_ENUMV(BCWall), CGNS_ENUMV(PointList), 1,
                  {9}, CGNS_ENUMV(Vertex));
    });
    refused("'wall' names point 3 along an axis of 2 points", [](CgnsFile& file) {
        condition(file, grid(file), "wall", CGNS_ENUMV(BCWall), CGNS_ENUMV(PointList), 1, {3, 1, 1},
                  CGNS_ENUMV(Vertex));
    });
    refused("'wall' names point or element 0; expected 1 or more", [](CgnsFile& file) {
        condition(file, grid(file), "wall", CGNS_ENUMV(BCWall), CGNS_ENUMV(PointList), 1, {0, 1, 1},
                  CGNS_ENUMV(Vertex));
    });
    refused("element 2 has more than 100 boundary conditions", [](CgnsFile& file) {
        const int zone = cube(file, "A", 0);
        for (int i = 0; i < 101; ++i)
            condition(file, zone, concat("wall", i).c_str(), CGNS_ENUMV(BCWall),
                      CGNS_ENUMV(PointList), 1, {2}, CGNS_ENUMV(FaceCenter));
    });
}

}  // namespace
}  // namespace espalier::io
