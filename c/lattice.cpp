// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/complex_builder.h>
#include <espalier/far/topology_match.h>
#include <espalier/io/lattice_file.h>

#include <algorithm>
#include <utility>

#include "handles.h"

namespace espalier::c {
namespace {

/// Returns one row of a relation that is given by offsets and values.
std::span<const Index> row(std::span<const std::int64_t> offsets, const Index* values,
                           std::size_t index) {
    return {values + offsets[index], values + offsets[index + 1]};
}

/// Throws if there are more vertices than the cells can name, before anything is read or allocated
/// for each vertex.
/// \param named number of vertices that the cells name, with repetitions
void checkVertexCount(Index vertexCount, std::int64_t named) {
    if (vertexCount < 0)
        throw Error(concat("the count of vertices is ", vertexCount, "; expected 0 or more"));
    if (vertexCount > named)
        throw Error(concat("there are ", vertexCount, " vertices, and the cells name ", named,
                           " at most; expected each vertex to be in a cell"));
}

far::CellComplex buildCells(const espalier_cells& cells) {
    const auto cellOffsets = checkedOffsets(cells.cell_offsets, cells.cell_count, "cell_offsets");
    const auto faceOffsets = checkedOffsets(cells.face_offsets, cells.face_count, "face_offsets");
    // A face belongs to at most two cells, so a larger offset is wrong, and nothing is read up to
    // it.
    if (const auto maxOffset = 2 * std::int64_t{cells.face_count};
        cells.cell_faces != nullptr && cellOffsets.back() > maxOffset)
        throw Error(concat("cell_offsets[", cells.cell_count, "] is ", cellOffsets.back(),
                           "; expected ", maxOffset,
                           " at most, since a face is in two cells at most"));
    array(cells.face_vertices, faceOffsets.back(), "face_vertices");
    checkVertexCount(cells.vertex_count, faceOffsets.back());

    far::ComplexBuilder builder(3, cells.vertex_count);
    std::vector<std::vector<Index>> loops;
    std::vector<bool> isUsed(cells.face_count);
    for (std::size_t cell = 0; cell + 1 < cellOffsets.size(); ++cell) {
        loops.clear();
        for (std::int64_t i = cellOffsets[cell]; i < cellOffsets[cell + 1]; ++i) {
            const std::int64_t face = cells.cell_faces != nullptr ? cells.cell_faces[i] : i;
            if (face < 0 || face >= cells.face_count)
                throw Error(concat("cell ", cell, " names face ", face, "; the number of faces is ",
                                   cells.face_count));
            isUsed[face] = true;
            const auto loop = row(faceOffsets, cells.face_vertices, face);
            if (std::ssize(loop) > cells.vertex_count)
                throw Error(concat("face ", face, " has ", loop.size(),
                                   " vertices; the lattice has ", cells.vertex_count));
            loops.emplace_back(loop.begin(), loop.end());
        }
        builder.addCell(loops);
    }
    if (const auto unused = std::find(isUsed.begin(), isUsed.end(), false); unused != isUsed.end())
        throw Error(concat("face ", unused - isUsed.begin(), " is in no cell"));
    return builder.build();
}

far::CellComplex buildHexahedra(Index vertexCount, std::span<const Index> vertices) {
    far::ComplexBuilder builder(3, vertexCount);
    for (std::size_t i = 0; i < vertices.size(); i += 8)
        builder.addCell(far::StandardCell::Hexahedron, vertices.subspan(i, 8));
    return builder.build();
}

/// Adds marks if all of them are valid.
template <class AddTo>
void addMarks(Lattice& lattice, const AddTo& addTo) {
    far::Marks marks = lattice.marks;
    addTo(marks);
    far::readMarks(lattice.complex, marks);
    lattice.marks = std::move(marks);
}

}  // namespace
}  // namespace espalier::c

using namespace espalier;

espalier_status espalier_lattice_create(const espalier_cells* cells, const double* positions,
                                        espalier_lattice** lattice) {
    return c::result(lattice, "lattice", [&] {
        const auto& given = c::deref(cells, "cells");
        auto complex = c::buildCells(given);
        auto points = c::finitePositions(positions, given.vertex_count, "positions");
        return new espalier_lattice{{std::move(complex), std::move(points), {}, {}}};
    });
}

espalier_status espalier_lattice_create_hexahedra(int32_t vertex_count, const double* positions,
                                                  int32_t cell_count, const int32_t* vertices,
                                                  espalier_lattice** lattice) {
    return c::result(lattice, "lattice", [&] {
        const auto corners = c::array(vertices, cell_count, "vertices", 8);
        c::checkVertexCount(vertex_count, std::ssize(corners));
        auto points = c::finitePositions(positions, vertex_count, "positions");
        return new espalier_lattice{
            {c::buildHexahedra(vertex_count, corners), std::move(points), {}, {}}};
    });
}

espalier_status espalier_lattice_read(const char* path, espalier_lattice** lattice) {
    return c::result(lattice, "lattice", [&] {
        return new espalier_lattice{io::readLattice(&c::deref(path, "path"))};
    });
}

espalier_status espalier_lattice_write(const espalier_lattice* lattice, const char* path) {
    return c::guarded(
        [&] { io::writeLattice(&c::deref(path, "path"), c::deref(lattice, "lattice").lattice); });
}

void espalier_lattice_destroy(espalier_lattice* lattice) {
    delete lattice;
}

espalier_status espalier_lattice_counts(const espalier_lattice* lattice, int32_t counts[4]) {
    return c::guarded([&] {
        const auto& complex = c::deref(lattice, "lattice").lattice.complex;
        c::deref(counts, "counts");
        for (int d = 0; d <= kMaxDimension; ++d) counts[d] = complex.count(d);
    });
}

espalier_status espalier_lattice_positions(const espalier_lattice* lattice, int32_t* vertex_count,
                                           const double** positions) {
    return c::guarded([&] {
        const auto& own = c::deref(lattice, "lattice").lattice.positions;
        auto& count = c::deref(vertex_count, "vertex_count");
        c::deref(positions, "positions") = c::numbers(own);
        count = static_cast<int32_t>(own.size());
    });
}

espalier_status espalier_lattice_set_positions(espalier_lattice* lattice, int32_t vertex_count,
                                               const double* positions) {
    return c::guarded([&] {
        auto& own = c::deref(lattice, "lattice").lattice.positions;
        c::checkCount(vertex_count, std::ssize(own), "positions of vertices");
        // Assigns in place, so that pointers that the caller has stay valid.
        const auto given = c::finitePositions(positions, vertex_count, "positions");
        std::copy(given.begin(), given.end(), own.begin());
    });
}

espalier_status espalier_lattice_mark_edges(espalier_lattice* lattice, int64_t count,
                                            const int32_t* vertices, const double* sharpness) {
    return c::guarded([&] {
        auto& own = c::deref(lattice, "lattice").lattice;
        const auto values = c::array(sharpness, count, "sharpness");
        const auto ends = c::array(vertices, count, "vertices", 2);
        c::addMarks(own, [&](far::Marks& marks) {
            for (std::size_t i = 0; i < values.size(); ++i)
                marks.edges.push_back({{ends[2 * i], ends[2 * i + 1]}, values[i]});
        });
    });
}

espalier_status espalier_lattice_mark_vertices(espalier_lattice* lattice, int64_t count,
                                               const int32_t* vertices, const double* sharpness) {
    return c::guarded([&] {
        auto& own = c::deref(lattice, "lattice").lattice;
        const auto values = c::array(sharpness, count, "sharpness");
        c::array(vertices, count, "vertices");
        c::addMarks(own, [&](far::Marks& marks) {
            for (std::size_t i = 0; i < values.size(); ++i)
                marks.vertices.push_back({vertices[i], values[i]});
        });
    });
}

espalier_status espalier_lattice_mark_counts(const espalier_lattice* lattice, int64_t* edge_count,
                                             int64_t* vertex_count) {
    return c::guarded([&] {
        const far::Marks& marks = c::deref(lattice, "lattice").lattice.marks;
        auto& edges = c::deref(edge_count, "edge_count");
        auto& vertices = c::deref(vertex_count, "vertex_count");
        edges = std::ssize(marks.edges);
        vertices = std::ssize(marks.vertices);
    });
}

espalier_status espalier_lattice_marks(const espalier_lattice* lattice, int64_t edge_count,
                                       int32_t* edge_ends, double* edge_sharpness,
                                       int64_t vertex_count, int32_t* vertices,
                                       double* vertex_sharpness) {
    return c::guarded([&] {
        const far::Marks& marks = c::deref(lattice, "lattice").lattice.marks;
        c::checkCount(edge_count, std::ssize(marks.edges), "edges in the arrays for the result");
        c::checkCount(vertex_count, std::ssize(marks.vertices),
                      "vertices in the arrays for the result");
        const auto ends = c::array(edge_ends, edge_count, "edge_ends", 2);
        const auto ofEdges = c::array(edge_sharpness, edge_count, "edge_sharpness");
        const auto marked = c::array(vertices, vertex_count, "vertices");
        const auto ofVertices = c::array(vertex_sharpness, vertex_count, "vertex_sharpness");
        const auto finite = [](double sharpness) { return std::min(sharpness, ESPALIER_SHARP); };
        for (std::size_t i = 0; i < marks.edges.size(); ++i) {
            ends[2 * i] = marks.edges[i].vertices[0];
            ends[2 * i + 1] = marks.edges[i].vertices[1];
            ofEdges[i] = finite(marks.edges[i].sharpness);
        }
        for (std::size_t i = 0; i < marks.vertices.size(); ++i) {
            marked[i] = marks.vertices[i].vertex;
            ofVertices[i] = finite(marks.vertices[i].sharpness);
        }
    });
}

espalier_status espalier_lattice_clear_marks(espalier_lattice* lattice) {
    return c::guarded([&] { c::deref(lattice, "lattice").lattice.marks = {}; });
}

espalier_status espalier_lattice_topology_hash(const espalier_lattice* lattice, uint64_t* hash) {
    return c::result(hash, "hash", [&] {
        return far::topologyHash(c::deref(lattice, "lattice").lattice.complex);
    });
}
