// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/io/files/file.h>

#include <algorithm>
#include <string>

#include "vtu_cells.h"

namespace espalier::io {
namespace {

/// Reads cells in the layout since VTK 9.4: faces are listed once, and polyhedra list faces.
template <class AddStandard>
void addWithFaceLists(const VtkXmlFile& file, const VtkSection& section,
                      const std::vector<std::int64_t>& types, AddStandard addStandard,
                      VtkCellReader& cells) {
    const VtkRows faces(file, section, "polyhedron_to_faces", "polyhedron_offsets", types.size(),
                        kOneACell);
    std::int64_t lastFace = -1;
    for (std::size_t cell = 0; cell < types.size(); ++cell)
        for (const std::int64_t face : faces[cell]) {
            if (face < 0)
                file.fail(section.line, concat("cell ", cell, " of the piece names face ", face,
                                               "; expected 0 or more"));
            lastFace = std::max(lastFace, face);
        }
    const VtkRows loops(file, section, "face_connectivity", "face_offsets",
                        static_cast<std::size_t>(lastFace) + 1,
                        concat("as the last face that a polyhedron names is ", lastFace));
    std::vector<std::span<const std::int64_t>> cellLoops;
    for (std::size_t cell = 0; cell < types.size(); ++cell) {
        if (types[cell] != kVtkPolyhedron) {
            addStandard(cell);
            continue;
        }
        cellLoops.clear();
        for (const std::int64_t face : faces[cell]) cellLoops.push_back(loops[face]);
        cells.addPolyhedron(cellLoops);
    }
}

/// Reads cells in the older layout: each polyhedron has a face stream; the offset of any other
/// cell is −1.
template <class AddStandard>
void addWithFaceStreams(const VtkXmlFile& file, const VtkSection& section,
                        const std::vector<std::int64_t>& types, AddStandard addStandard,
                        VtkCellReader& cells) {
    const VtkDataArray& offsets = file.array(section, "faceoffsets");
    const auto ends = file.list(offsets, types.size(), kOneACell);
    std::int64_t before = 0;
    for (std::size_t cell = 0; cell < types.size(); ++cell) {
        if (types[cell] != kVtkPolyhedron) continue;
        if (ends[cell] < before)
            file.fail(offsets.line, concat("the faces of cell ", cell, " of the piece run from ",
                                           before, " to ", ends[cell]));
        before = ends[cell];
    }
    const auto faces = file.list(file.array(section, "faces"), before, "the last of 'faceoffsets'");
    std::size_t begin = 0;
    for (std::size_t cell = 0; cell < types.size(); ++cell) {
        if (types[cell] != kVtkPolyhedron) {
            addStandard(cell);
            continue;
        }
        const std::size_t end = ends[cell];
        cells.addPolyhedron(std::span(faces).subspan(begin, end - begin));
        begin = end;
    }
}

void readPieceCells(const VtkXmlFile& file, const VtkPiece& piece, VtkCellReader& cells) {
    const std::size_t count = file.count(piece, "NumberOfCells");
    if (count == 0) return;
    const VtkSection& section = file.section(piece, "Cells");
    const auto types = file.list(file.array(section, "types"), count, kOneACell);
    const VtkRows vertices(file, section, "connectivity", "offsets", count, kOneACell);
    const bool havePolyhedra = std::find(types.begin(), types.end(), kVtkPolyhedron) != types.end();
    const auto addStandard = [&](std::size_t cell) { cells.add(types[cell], vertices[cell]); };
    if (!havePolyhedra)
        for (std::size_t cell = 0; cell < count; ++cell) addStandard(cell);
    else if (section.find("polyhedron_offsets"))
        addWithFaceLists(file, section, types, addStandard, cells);
    else
        addWithFaceStreams(file, section, types, addStandard, cells);
}

}  // namespace

void readVtuCells(const VtkXmlFile& file, VtkCellReader& cells) {
    Index firstVertex = 0;
    for (const VtkPiece& piece : file.pieces()) {
        const auto count = static_cast<Index>(file.count(piece, "NumberOfPoints"));
        cells.beginPiece(firstVertex, count);
        readPieceCells(file, piece, cells);
        firstVertex += count;
    }
}

}  // namespace espalier::io
