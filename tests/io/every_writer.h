// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/binding_file.h>
#include <espalier/io/formats.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/matrices/matrix_file.h>
#include <espalier/io/model.h>
#include <espalier/io/pose_file.h>
#include <io/lattice_samples.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "support/temporary_folder.h"

// One writer of each format, for tests of behaviour that all writers share.

namespace espalier::test {

struct Writer {
    std::string name;  ///< name of the file
    std::function<void(const std::filesystem::path&)> write;
};

/// Returns a band matrix of `rowCount` rows.
inline stencils::StencilTable<double> bandTable(Index rowCount) {
    Array<Offset> offsets = {0};
    Array<Index> columns;
    Array<double> weights;
    for (Index row = 0; row < rowCount; ++row) {
        for (const Index k : {0, 1, 2}) {
            columns.push_back(row + k);
            weights.push_back(1.0 / 3);
        }
        offsets.push_back(Offset(columns.size()));
    }
    return {rowCount + 2, std::move(offsets), std::move(columns), std::move(weights)};
}

/// Returns a row of `count` hexahedra, with marks and attributes.
inline Lattice rowOfCells(Index count) {
    far::ComplexBuilder builder(3, 4 * (count + 1));
    for (Index i = 0; i < count; ++i) {
        const Index v = 4 * i;
        builder.addCell(far::StandardCell::Hexahedron,
                        {v, v + 1, v + 2, v + 3, v + 4, v + 5, v + 6, v + 7});
    }
    return withMarksAndAttributes(withAwkwardPositions(builder.build()));
}

/// Returns the extensions of the formats in which new models are written.
inline std::vector<std::string> modelExtensions() {
    return io::extensionsOf(io::FileContent::Model, io::FileUse::Write);
}

/// Returns a triangle with a normal for every three points.
inline std::string facesOfObj(int pointCount) {
    std::string faces = "vn 0 0 1\n";
    for (int i = 1; i <= pointCount; i += 3)
        faces += "f " + std::to_string(i) + "//1 " + std::to_string(i + 1) + "//1 " +
                 std::to_string(i + 2) + "//1\n";
    return faces;
}

/// Returns a model of `pointCount` points, as the text of a file.
inline std::string modelText(const std::string& extension, int pointCount) {
    std::string points, facets;
    for (int i = 0; i < pointCount; ++i) {
        const std::string point = std::to_string(i) + " 0.5 0.25\n";
        points += (extension == ".obj" ? "v " : "") + point;
        if (i % 3 == 0) facets += "facet normal 0 0 1\nouter loop\n";
        facets += "vertex " + point;
        if (i % 3 == 2) facets += "endloop\nendfacet\n";
    }
    const std::string count = std::to_string(pointCount);
    if (extension == ".obj") return points;
    if (extension == ".stl") return "solid s\n" + facets + "endsolid s\n";
    if (extension == ".vtk")
        return "# vtk DataFile Version 3.0\nm\nASCII\nDATASET POLYDATA\nPOINTS " + count +
               " double\n" + points;
    if (extension == ".ply")
        return "ply\nformat ascii 1.0\nelement vertex " + count +
               "\nproperty double x\nproperty double y\nproperty double z\nend_header\n" + points;
    if (extension != ".vtu" && extension != ".vtp") {
        // A later format: what its own writer writes.
        const TemporaryFolder folder;
        const auto obj =
            io::readModel("a.obj", modelText(".obj", pointCount) + facesOfObj(pointCount));
        obj->write(folder / ("a" + extension), obj->positions());
        return io::readFile(folder / ("a" + extension));
    }
    const std::string type = extension == ".vtp" ? "PolyData" : "UnstructuredGrid";
    return "<VTKFile type='" + type + "' version='1.0' byte_order='LittleEndian'>\n<" + type +
           "><Piece NumberOfPoints='" + count +
           "' NumberOfCells='0'>\n<Points><DataArray type='Float64' NumberOfComponents='3' "
           "format='ascii'>\n" +
           points + "</DataArray></Points><Cells/></Piece></" + type + "></VTKFile>\n";
}

/// Meshes of simulations. OpenFOAM's has a name instead of an extension.
inline constexpr const char* kMeshExtensions[] = {".su2", ".msh", ".mesh", ".bdf",  ".inp",
                                                  ".unv", ".cas", ".xyz",  "points"};

/// Returns the name of a file with such an extension.
inline std::string fileOfMesh(const std::string& extension) {
    return (extension == "points" ? "" : "m") + extension;
}

/// Returns a mesh of `pointCount` points without cells, as the text of a file.
inline std::string meshText(const std::string& extension, int pointCount) {
    const std::string number = std::to_string(pointCount);
    if (extension == ".xyz") {
        std::string text = number + " 1 1\n";
        for (int i = 0; i < pointCount; ++i) text += std::to_string(i) + " ";
        for (int i = 0; i < 2 * pointCount; ++i) text += "0.5 ";
        return text;
    }
    if (extension == ".bdf" || extension == ".inp") {
        std::string text = extension == ".inp" ? "*NODE\n" : "";
        for (int i = 0; i < pointCount; ++i)
            text += (extension == ".inp" ? "" : "GRID,") + std::to_string(i + 1) +
                    (extension == ".inp" ? ", " : ",,") + std::to_string(i) + ",0.5,0.25\n";
        return text;
    }
    if (extension == ".unv") {
        std::string text = "    -1\n  2411\n";
        for (int i = 0; i < pointCount; ++i)
            text += std::to_string(i + 1) + " 1 1 11\n" + std::to_string(i) + " 0.5 0.25\n";
        return text + "    -1\n";
    }
    if (extension == ".cas") {
        std::ostringstream text;
        text << "(2 3)\n(10 (1 1 " << std::hex << pointCount << std::dec << " 1 3)(\n";
        for (int i = 0; i < pointCount; ++i) text << i << " 0.5 0.25\n";
        return text.str() + "))\n";
    }
    std::string text = extension == ".su2" ? "NDIME= 3\nNPOIN= " + number + "\n"
                       : extension == ".msh"
                           ? "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + number + "\n"
                       : extension == ".mesh"
                           ? "MeshVersionFormatted 2\nDimension 3\nVertices " + number + "\n"
                           : "FoamFile { format ascii; class vectorField; }\n" + number + "\n(\n";
    for (int i = 0; i < pointCount; ++i) {
        const std::string point = std::to_string(i) + " 0.5 0.25";
        text += (extension == ".msh"     ? std::to_string(i + 1) + " " + point
                 : extension == ".mesh"  ? point + " 0"
                 : extension == "points" ? "(" + point + ")"
                                         : point) +
                "\n";
    }
    return text + (extension == ".msh"     ? "$EndNodes\n$Elements\n0\n$EndElements\n"
                   : extension == "points" ? ")\n"
                                           : "");
}

/// \param size number of rows, cells and points that they write; a multiple of 3
inline std::vector<Writer> everyWriter(int size) {
    std::vector<Writer> writers;
    const auto lattice = std::make_shared<const Lattice>(rowOfCells(size));
    for (const std::string& each : io::extensionsOf(io::FileContent::Lattice, io::FileUse::Write))
        writers.push_back(
            {"a" + each, [=](const auto& path) { io::writeLattice(path, *lattice); }});
    for (const std::string& each :
         io::extensionsOf(io::FileContent::EditorMesh, io::FileUse::Write))
        writers.push_back(
            {"editor" + each, [=](const auto& path) { io::writeEditorMesh(path, *lattice); }});
    const std::shared_ptr<const io::Model> stl = io::readModel("a.stl", modelText(".stl", size));
    const std::shared_ptr<const io::Model> obj =
        io::readModel("a.obj", modelText(".obj", size) + facesOfObj(size));
    for (const std::string& extension : modelExtensions()) {
        const std::shared_ptr<const io::Model> model =
            io::readModel("a" + extension, modelText(extension, size));
        std::vector<Point3> moved(model->positions().begin(), model->positions().end());
        for (Point3& point : moved) point[2] += 0.5;
        writers.push_back({"m" + extension, [=](const auto& path) { model->write(path, moved); }});
        // The same points, from a model in another format.
        writers.push_back({"other" + extension, [=](const auto& path) {
                               (extension == ".obj" ? stl : obj)->write(path, moved);
                           }});
    }
    for (const std::string extension : kMeshExtensions) {
        const std::string name = fileOfMesh(extension);
        const std::shared_ptr<const io::Model> model =
            io::readModel(name, meshText(extension, size));
        std::vector<Point3> moved(model->positions().begin(), model->positions().end());
        for (Point3& point : moved) point[2] += 0.5;
        writers.push_back({name, [=](const auto& path) { model->write(path, moved); }});
    }
    const auto table = std::make_shared<const stencils::StencilTable<double>>(bandTable(size));
    for (const std::string& extension :
         io::extensionsOf(io::FileContent::Matrix, io::FileUse::Write))
        writers.push_back(
            {"D" + extension, [=](const auto& path) { io::writeMatrix(path, *table); }});
    const auto bound = std::make_shared<io::BoundModel>();
    bound->binding.table = *table;
    bound->binding.points.resize(table->rowCount());
    bound->binding.statuses.resize(table->rowCount());
    bound->binding.rest.resize(table->columnCount());
    bound->modelName = "a.obj";
    bound->modelBytes = modelText(".obj", size);
    writers.push_back({"a.espb", [=](const auto& path) { io::writeBoundModel(path, *bound); }});
    return writers;
}

}  // namespace espalier::test
