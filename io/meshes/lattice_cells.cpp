// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/far/complex_builder.h>
#include <espalier/far/topology_error.h>
#include <espalier/io/files/file.h>

#include <utility>

#include "../lattices/lattice_parts.h"
#include "lattice_cells.h"
#include "mesh_format.h"

namespace espalier::io {

LatticeCells::LatticeCells(std::filesystem::path path, Index pointCount)
    : path_(std::move(path)), builder_(3, pointCount) {}

void LatticeCells::cell(far::StandardCell kind, std::span<const Index> points) {
    withPathInErrors(path_, [&] { return builder_.addCell(kind, points); });
    ++cellCount_;
}

void LatticeCells::polyhedron(std::span<const std::vector<Index>> loops) {
    withPathInErrors(path_, [&] { return builder_.addCell(loops); });
    ++cellCount_;
}

void LatticeCells::curvedCell(int dimension, std::span<const Index>) {
    if (dimension == 3)
        throw FileError(path_, concat("cell ", cellCount_,
                                      " of the volume has curved edges (it is quadratic or of "
                                      "higher order); a lattice needs straight ones: write the "
                                      "mesh with elements of first order"));
    ++skipped_[dimension];
}

void LatticeCells::unknownElement(std::size_t line, const std::string& cause) {
    throw FileError(path_, line, cause);
}

far::ComplexBuilder LatticeCells::takeBuilder() {
    if (cellCount_ == 0 && skipped_ != std::array<Index, 3>{})
        throw far::TopologyError(
            far::TopologyCause::EmptyComplex, {3, 0},
            concat(shownPath(path_), ": there is no cell of a volume; the file has ", skipped_[0],
                   " vertex cells, ", skipped_[1], " lines and ", skipped_[2],
                   " surface cells, which are not cells of a lattice"));
    return std::move(builder_);
}

Lattice readLatticeOfMesh(const MeshFormat& format, const std::filesystem::path& path,
                          std::string_view bytes, ReadNotes* notes) {
    Lattice parts;
    {
        const FileNumbers numbers = format.readPoints(path, bytes);
        parts.positions.assign(numbers.points.values.begin(), numbers.points.values.end());
    }
    const Index count = checkedIndex(path, parts.positions.size(), "points");
    LatticeCells cells(path, count);
    format.readCells(path, bytes, count, cells);
    if (notes) notes->skippedCells = cells.skipped();
    return finishLattice(path, cells.takeBuilder(), std::move(parts), notes);
}

}  // namespace espalier::io
