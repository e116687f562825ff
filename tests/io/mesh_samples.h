// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <espalier/io/files/text_reader.h>

#include "io/model_files.h"

// One mesh in all formats of simulations: a cube of side 2 with a pyramid on top, a wedge at its
// side x = 2 and a tetrahedron on the wedge. The texts are written here by hand, from the
// descriptions of the formats; scripts/test --hosts also reads meshes that the programs themselves
// write.

namespace espalier::test {

/// The points: 0 to 7 the cube in VTK's order, 8 the apex, 9 and 10 the edge of the wedge, 11 the
/// tip of the tetrahedron.
inline std::vector<Point3> samplePoints() {
    return {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0},      {0, 0, 2},    {2, 0, 2},
            {2, 2, 2}, {0, 2, 2}, {1, 1, 4}, {4, 0.5, 0.25}, {4, 2, 0.25}, {3, 1, 3}};
}

/// The cells by VTK's orders, except that the wedge is in the order of all others: its first
/// triangle (1, 5, 9) is anticlockwise seen from the second (2, 6, 10).
inline const std::vector<std::vector<int>>& sampleCells() {
    static const std::vector<std::vector<int>> kCells = {
        {0, 1, 2, 3, 4, 5, 6, 7}, {4, 5, 6, 7, 8}, {1, 5, 9, 2, 6, 10}, {5, 9, 10, 11}};
    return kCells;
}

inline std::string words(const std::vector<int>& numbers, int base = 0) {
    std::string text;
    for (const int number : numbers) text += " " + std::to_string(number + base);
    return text;
}

/// The coordinates of a point as text. Point 1 has unusual texts of its numbers.
inline std::string coordinates(std::size_t point) {
    if (point == 1) return "2.00 +0e0 -0.0";
    const Point3 p = samplePoints()[point];
    std::string text;
    for (std::size_t axis = 0; axis < 3; ++axis)
        text += (axis > 0 ? " " : "") + io::formatNumber(p[axis]);
    return text;
}

inline std::string sampleSu2() {
    std::string text = "% a mesh\nNDIME = 3\nNELEM= 4\n";
    const int types[] = {12, 14, 13, 10};
    for (std::size_t i = 0; i < 4; ++i)
        text += std::to_string(types[i]) + words(sampleCells()[i]) + " " + std::to_string(i) + "\n";
    text += "NPOIN= 12 12 % with a number of its own\n";
    for (std::size_t i = 0; i < 12; ++i)
        text += "  " + coordinates(i) + " " + std::to_string(i) + (i == 3 ? " % third" : "") + "\n";
    return text +
           "\nNMARK= 1\nMARKER_TAG= wall 1\nMARKER_ELEMS= 2\n9 0 3 2 1\n5 4 5 8\n"
           "FFD_NBOX= 1\nFFD_LEVEL= 0\n";
}

inline std::string sampleMedit() {
    std::string text = "MeshVersionFormatted 2\nDimension\n3\n# points\nVertices 12\n";
    for (std::size_t i = 0; i < 12; ++i) text += coordinates(i) + " 7\n";
    const auto section = [&](const char* keyword, std::size_t cell) {
        text += concat("\n", keyword, "\n1\n", words(sampleCells()[cell], 1), " 3\n");
    };
    text += "Corners 2\n1\n2\nRequiredVertices 1\n3\nUnknown 2 5 1.5 6 2.5\n";
    text += "Triangles 1\n5 6 9 1\nQuadrilaterals 1\n1 4 3 2 1\n";
    section("Hexahedra", 0);
    section("Pyramids", 1);
    section("Prisms", 2);
    section("Tetrahedra", 3);
    return text + "End\n";
}

/// \param firstTag tag of the first node; the others follow in steps of `step`
inline std::string sampleGmsh2(int firstTag = 1, int step = 1) {
    std::string text =
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"fluid\"\n"
        "$EndPhysicalNames\n$Nodes\n12\n";
    const auto tags = [&](const std::vector<int>& points) {
        std::string list;
        for (const int point : points) list += " " + std::to_string(firstTag + step * point);
        return list;
    };
    for (int i = 0; i < 12; ++i)
        text += std::to_string(firstTag + step * i) + " " + coordinates(std::size_t(i)) + "\n";
    text += "$EndNodes\n$Elements\n8\n1 15 2 0 1" + tags({0}) + "\n2 1 2 0 1" + tags({0, 1}) +
            "\n3 2 2 0 1" + tags({4, 5, 8}) + "\n4 3 2 0 1" + tags({0, 3, 2, 1}) + "\n";
    const int types[] = {5, 7, 6, 4};
    for (std::size_t i = 0; i < 4; ++i)
        text += concat(i + 5, " ", types[i], " 2 0 1", tags(sampleCells()[i]), "\n");
    return text + "$EndElements\n$NodeData\nanything\n$EndNodeData\n";
}

inline std::string sampleGmsh4() {
    std::string text =
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 0\n$EndEntities\n"
        "$Nodes\n2 12 1 12\n3 1 0 8\n";
    for (int i = 1; i <= 8; ++i) text += std::to_string(i) + "\n";
    for (std::size_t i = 0; i < 8; ++i) text += coordinates(i) + "\n";
    text += "2 5 1 4\n";  // With two parameters.
    for (int i = 9; i <= 12; ++i) text += std::to_string(i) + "\n";
    for (std::size_t i = 8; i < 12; ++i) text += coordinates(i) + " 0.5 0.25\n";
    text += "$EndNodes\n$Elements\n6 6 1 6\n2 1 2 1\n1 5 6 9\n2 1 3 1\n2 1 4 3 2\n";
    const int types[] = {5, 7, 6, 4};
    for (std::size_t i = 0; i < 4; ++i)
        text += concat("3 1 ", types[i], " 1\n", i + 3, words(sampleCells()[i], 1), "\n");
    return text + "$EndElements\n";
}

inline std::string bytesOfPoint(const Point3& point, std::endian order) {
    return bytesOf(point[0], order) + bytesOf(point[1], order) + bytesOf(point[2], order);
}

inline std::string sampleBinaryGmsh2(std::endian order) {
    const auto number = [&](std::int32_t value) { return bytesOf(value, order); };
    std::string text = "$MeshFormat\n2.2 1 8\n" + number(1) + "\n$EndMeshFormat\n$Nodes\n12\n";
    for (int i = 0; i < 12; ++i)
        text += number(i + 1) + bytesOfPoint(samplePoints()[std::size_t(i)], order);
    text += "\n$EndNodes\n$Elements\n6\n";
    text += number(2) + number(1) + number(2) + number(1) + number(0) + number(1) + number(5) +
            number(6) + number(9);
    text += number(3) + number(1) + number(2) + number(2) + number(0) + number(1) + number(1) +
            number(4) + number(3) + number(2);
    const int types[] = {5, 7, 6, 4};
    for (std::size_t i = 0; i < 4; ++i) {
        text +=
            number(types[i]) + number(1) + number(2) + number(int(i) + 3) + number(0) + number(1);
        for (const int point : sampleCells()[i]) text += number(point + 1);
    }
    return text + "\n$EndElements\n";
}

inline std::string sampleBinaryGmsh4(std::endian order) {
    const auto number = [&](std::int32_t value) { return bytesOf(value, order); };
    const auto size = [&](std::uint64_t value) { return bytesOf(value, order); };
    std::string text = "$MeshFormat\n4.1 1 8\n" + number(1) + "\n$EndMeshFormat\n$Entities\n" +
                       size(0) + size(0) + size(0) + size(0) + "\n$EndEntities\n$Nodes\n" +
                       size(2) + size(12) + size(1) + size(12);
    text += number(3) + number(1) + number(0) + size(8);
    for (std::uint64_t i = 1; i <= 8; ++i) text += size(i);
    for (std::size_t i = 0; i < 8; ++i) text += bytesOfPoint(samplePoints()[i], order);
    text += number(2) + number(5) + number(1) + size(4);
    for (std::uint64_t i = 9; i <= 12; ++i) text += size(i);
    for (std::size_t i = 8; i < 12; ++i)
        text += bytesOfPoint(samplePoints()[i], order) + bytesOf(0.5, order) + bytesOf(0.25, order);
    text += "\n$EndNodes\n$Elements\n" + size(6) + size(6) + size(1) + size(6);
    text += number(2) + number(1) + number(2) + size(1) + size(1) + size(5) + size(6) + size(9);
    text += number(2) + number(1) + number(3) + size(1) + size(2) + size(1) + size(4) + size(3) +
            size(2);
    const int types[] = {5, 7, 6, 4};
    for (std::size_t i = 0; i < 4; ++i) {
        text += number(3) + number(1) + number(types[i]) + size(1) + size(i + 3);
        for (const int point : sampleCells()[i]) text += size(std::uint64_t(point) + 1);
    }
    return text + "\n$EndElements\n";
}

/// The header of a file of OpenFOAM.
inline std::string foamHeader(const std::string& className, const std::string& object,
                              bool isBinary = false) {
    return "/*--- C++ ---*\\\n| // no comment |\n\\*---*/\nFoamFile\n{\n    version 2.0;\n    "
           "format " +
           std::string(isBinary ? "binary" : "ascii") + ";\n    class " + className + ";\n" +
           (isBinary ? "    arch \"LSB;label=32;scalar=64\";\n" : "") +
           "    location \"constant/polyMesh\";\n    object " + object + ";\n}\n// * * * //\n\n";
}

/// The faces of the sample: loops, owners and neighbours. Internal faces first.
struct FoamFaces {
    std::vector<std::vector<int>> loops = {
        // cube | pyramid, cube | wedge, wedge | tetrahedron: the wedge has the triangle as two
        // triangles of its quadrilateral, so that they can share one.
        {4, 5, 6, 7}, {1, 2, 6, 5},  {5, 9, 10}, {0, 3, 2, 1}, {0, 4, 7, 3}, {0, 1, 5, 4},
        {3, 7, 6, 2}, {4, 5, 8},     {5, 6, 8},  {6, 7, 8},    {7, 4, 8},    {1, 9, 5},
        {2, 6, 10},   {1, 2, 10, 9}, {5, 10, 6}, {5, 9, 11},   {9, 10, 11},  {10, 5, 11}};
    std::vector<int> owners = {0, 0, 2, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3};
    std::vector<int> neighbours = {1, 2, 3};
};

/// The files of a polyMesh, by their names.
inline std::map<std::string, std::string> sampleFoam(bool isBinary = false) {
    const FoamFaces faces;
    const auto order = std::endian::little;
    std::map<std::string, std::string> files;
    const auto labels = [&](const std::vector<int>& values) {
        std::string text = std::to_string(values.size()) + "\n(";
        for (const int value : values)
            text += isBinary ? bytesOf(std::int32_t(value), order) : "\n" + std::to_string(value);
        return text + (isBinary ? ")\n" : "\n)\n");
    };
    std::string points = "\n12\n(";
    for (std::size_t i = 0; i < 12; ++i)
        points += isBinary ? bytesOfPoint(samplePoints()[i], order) : "\n(" + coordinates(i) + ")";
    files["points"] = foamHeader("vectorField", "points", isBinary) + points +
                      (isBinary ? ")\n" : "\n)\n") + "\n// *** //\n";
    if (isBinary) {
        std::vector<int> begins = {0}, corners;
        for (const auto& loop : faces.loops) {
            corners.insert(corners.end(), loop.begin(), loop.end());
            begins.push_back(int(corners.size()));
        }
        files["faces"] = foamHeader("faceCompactList", "faces", true) + "\n" + labels(begins) +
                         "\n" + labels(corners);
    } else {
        std::string text = std::to_string(faces.loops.size()) + "\n(\n";
        for (const auto& loop : faces.loops)
            text += std::to_string(loop.size()) + "(" + words(loop).substr(1) + ")\n";
        files["faces"] = foamHeader("faceList", "faces") + text + ")\n";
    }
    files["owner"] = foamHeader("labelList", "owner", isBinary) + labels(faces.owners);
    files["neighbour"] = foamHeader("labelList", "neighbour", isBinary) + labels(faces.neighbours);
    return files;
}

/// Writes the files of a mesh to a folder, and returns its file of points.
inline std::filesystem::path putFoam(const std::filesystem::path& folder,
                                     const std::map<std::string, std::string>& files) {
    std::filesystem::create_directories(folder);
    for (const auto& [name, bytes] : files) putFile(folder / name, bytes);
    return folder / "points";
}

/// The files of the sample for each process, as decomposePar writes them: with the points that its
/// cells use, its internal faces, its faces of the patch "walls", and those to each other process,
/// which the process with the larger number has the other way round.
/// \param processes the process of each cell
inline std::vector<std::map<std::string, std::string>> decomposedFoam(
    const std::vector<int>& processes) {
    const FoamFaces faces;
    std::vector<std::map<std::string, std::string>> result;
    const int count = 1 + *std::max_element(processes.begin(), processes.end());
    for (int process = 0; process < count; ++process) {
        std::vector<int> cells(processes.size(), -1);  // their numbers in the process
        for (std::size_t cell = 0, next = 0; cell < cells.size(); ++cell)
            if (processes[cell] == process) cells[cell] = int(next++);
        // Lists of faces: inside, on the wall, and to each process.
        std::vector<std::vector<int>> loops;
        std::vector<int> owners, neighbours;
        const auto add = [&](const std::vector<int>& loop, int cell) {
            loops.push_back(loop);
            owners.push_back(cells[std::size_t(cell)]);
        };
        const auto isInside = [&](std::size_t face) { return face < faces.neighbours.size(); };
        for (std::size_t face = 0; isInside(face); ++face)
            if (const int from = faces.owners[face], to = faces.neighbours[face];
                cells[std::size_t(from)] >= 0 && cells[std::size_t(to)] >= 0) {
                add(faces.loops[face], from);
                neighbours.push_back(cells[std::size_t(to)]);
            }
        std::string boundary;
        std::size_t begin = loops.size(), patches = 1;
        for (std::size_t face = faces.neighbours.size(); face < faces.loops.size(); ++face)
            if (cells[std::size_t(faces.owners[face])] >= 0)
                add(faces.loops[face], faces.owners[face]);
        const auto patch = [&](const std::string& head) {
            boundary += head + " nFaces " + std::to_string(loops.size() - begin) + "; startFace " +
                        std::to_string(begin) + ";}\n";
            begin = loops.size();
        };
        patch("walls {type wall;");
        for (int other = 0; other < count; ++other) {
            for (std::size_t face = 0; other != process && isInside(face); ++face) {
                const int from = faces.owners[face], to = faces.neighbours[face];
                const int own = processes[std::size_t(from)], next = processes[std::size_t(to)];
                std::vector<int> loop = faces.loops[face];
                if (own == process && next == other) add(loop, from);
                std::reverse(loop.begin() + 1, loop.end());
                if (own == other && next == process) add(loop, to);
            }
            if (loops.size() == begin) continue;
            ++patches;
            patch("procBoundary" + std::to_string(process) + "to" + std::to_string(other) +
                  " {type processor; myProcNo " + std::to_string(process) + "; neighbProcNo " +
                  std::to_string(other) + ";");
        }
        std::map<int, int> numbers;  // of the points
        for (const auto& loop : loops)
            for (const int point : loop) numbers[point] = 0;
        std::string points, faceText, ownerText, neighbourText;
        for (auto& [point, number] : numbers) {
            number = int(std::distance(numbers.begin(), numbers.find(point)));
            points += "(" + coordinates(std::size_t(point)) + ")\n";
        }
        for (auto& loop : loops) {
            for (int& point : loop) point = numbers[point];
            faceText += std::to_string(loop.size()) + "(" + words(loop).substr(1) + ")\n";
        }
        const auto list = [](std::size_t size, const std::string& text) {
            return std::to_string(size) + "\n(\n" + text + ")\n";
        };
        result.push_back(
            {{"points", foamHeader("vectorField", "points") + list(numbers.size(), points)},
             {"faces", foamHeader("faceList", "faces") + list(loops.size(), faceText)},
             {"owner", foamHeader("labelList", "owner") + list(owners.size(), words(owners))},
             {"neighbour",
              foamHeader("labelList", "neighbour") + list(neighbours.size(), words(neighbours))},
             {"boundary", foamHeader("polyBoundaryMesh", "boundary") + list(patches, boundary)}});
    }
    return result;
}

/// Puts files of processes together, as OpenFOAM's fileHandler collated does: only the first one
/// has a header.
inline std::map<std::string, std::string> collatedFoam(
    const std::vector<std::map<std::string, std::string>>& processes) {
    std::map<std::string, std::string> result;
    for (const auto& [name, first] : processes[0]) {
        std::string text = foamHeader("decomposedBlockData", name, true);
        for (std::size_t process = 0; process < processes.size(); ++process) {
            std::string bytes = processes[process].at(name);
            if (process > 0) bytes.erase(0, bytes.find("// * * * //") + 11);
            text += "\n// Processor" + std::to_string(process) + "\n\n" +
                    std::to_string(bytes.size()) + "\n(" + bytes + ")\n";
        }
        result[name] = text;
    }
    return result;
}

/// A PLOT3D grid in text of the given blocks, by their extents, with x = i, y = 2j, z = 3k and an
/// offset per block.
inline std::string sampleGrid(const std::vector<std::array<int, 3>>& blocks,
                              const std::vector<Point3>& offsets, bool hasBlank = false) {
    std::string text = std::to_string(blocks.size()) + "\n";
    for (const auto& extent : blocks)
        text += concat(extent[0], " ", extent[1], " ", extent[2], "\n");
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        const auto& [ni, nj, nk] = blocks[b];
        for (int axis = 0; axis < 3; ++axis)
            for (int k = 0; k < nk; ++k)
                for (int j = 0; j < nj; ++j)
                    for (int i = 0; i < ni; ++i)
                        text += io::formatNumber(offsets[b][std::size_t(axis)] + (axis == 0 ? i
                                                                                  : axis == 1
                                                                                      ? 2 * j
                                                                                      : 3 * k)) +
                                (i + 1 < ni ? " " : "\n");
        for (int i = 0; hasBlank && i < ni * nj * nk; ++i) text += "1 ";
    }
    return text;
}

}  // namespace espalier::test
