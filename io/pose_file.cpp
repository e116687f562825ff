// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/cancellable_sort.h>
#include <espalier/base/error.h>
#include <espalier/far/topology_match.h>
#include <espalier/io/files/file.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <espalier/io/pose_file.h>

#include <algorithm>
#include <ostream>
#include <span>
#include <utility>

#include "format.h"
#include "lattices/lattice_parts.h"
#include "models/surface_writers.h"

namespace espalier::io {
namespace {

using Path = std::filesystem::path;
using LoopView = std::span<const Index>;

[[noreturn]] void refuse(const Path& path, const std::string& name, const std::string& cause) {
    throw FileError(path, "is not a pose of " + name + cause);
}

/// Returns the rotation of a loop that is lowest in lexicographic order.
///
/// Compares the rotations that begin at `one` and at `other`. If they differ first at their
/// vertices number `same`, then the higher one, and the `same` rotations after it, are not the
/// lowest.
///
/// \cost O(n)
std::vector<Index> lowestRotation(LoopView loop) {
    const std::size_t size = loop.size();
    std::size_t one = 0, other = 1, same = 0;
    while (one < size && other < size && same < size) {
        const Index a = loop[(one + same) % size], b = loop[(other + same) % size];
        if (a == b) {
            ++same;
            continue;
        }
        (a > b ? one : other) += same + 1;
        if (one == other) ++other;
        same = 0;
    }
    std::vector<Index> rotation(loop.begin(), loop.end());
    if (size > 0)
        std::rotate(rotation.begin(),
                    rotation.begin() + static_cast<std::ptrdiff_t>(std::min(one, other)),
                    rotation.end());
    return rotation;
}

/// Returns the same loop, begun and directed so that equal loops become equal lists.
std::vector<Index> canonical(LoopView loop) {
    const std::vector<Index> reversed(loop.rbegin(), loop.rend());
    return std::min(lowestRotation(loop), lowestRotation(reversed));
}

/// Returns the vertices of a face for a message: all, unless there are many.
std::string verticesOf(LoopView loop) {
    constexpr std::size_t kMaxListed = 8;
    return listed(loop, kMaxListed);
}

bool isPartOf(LoopView part, LoopView whole) {
    return std::ranges::all_of(part,
                               [&](Index vertex) { return std::ranges::count(whole, vertex) > 0; });
}

void checkPointCount(const Path& path, const std::string& name, std::size_t got, Index expected) {
    if (std::cmp_not_equal(got, expected))
        refuse(path, name,
               concat(": it has ", got, " points; expected one for each of the ", expected,
                      " vertices of the lattice, in their order. Export the mesh without removing, "
                      "merging or splitting vertices"));
}

/// Returns true if a mesh has the faces of the lattice in their order, and its vertices are
/// numbered in the order in which the faces use them: what the importer of Blender 2 and 3 that is
/// called "legacy" makes of an OBJ.
bool isNumberedByFirstUse(const ModelFaces& mesh, const ModelFaces& lattice) {
    if (mesh.ends != lattice.ends) return false;
    std::vector<Index> numbers;  // in the mesh, of the vertices of the lattice; or -1
    Index count = 0;
    for (std::size_t corner = 0; corner < lattice.corners.size(); ++corner) {
        const Index vertex = lattice.corners[corner];
        if (vertex >= std::ssize(numbers)) numbers.resize(Offset{vertex} + 1, -1);
        Index& number = numbers[vertex];
        if (number < 0) number = count++;
        if (mesh.corners[corner] != number) return false;
    }
    return true;
}

/// Throws unless each face of an editor mesh is a face of the lattice.
void checkFaces(const Path& path, const std::string& name, const ModelFaces& mesh,
                const ModelFaces& lattice) {
    std::vector<std::vector<Index>> known;
    known.reserve(lattice.count());
    for (std::size_t face = 0; face < lattice.count(); ++face)
        known.push_back(canonical(lattice[face]));
    sortCancellably(known.begin(), known.end());
    for (std::size_t face = 0; face < mesh.count(); ++face) {
        const LoopView loop = mesh[face];
        if (loop.empty())
            refuse(path, name,
                   concat(": face ", face,
                          " of the file has no vertices. Export the mesh with the faces of the "
                          "lattice"));
        if (std::ranges::binary_search(known, canonical(loop))) continue;
        const std::string what =
            concat(": face ", face, " of the file, of vertices ", verticesOf(loop), ", ");
        for (std::size_t whole = 0; whole < lattice.count(); ++whole)
            if (loop.size() < lattice[whole].size() && isPartOf(loop, lattice[whole]))
                refuse(path, name,
                       concat(what, "is a part of face ", whole, " of the lattice, of vertices ",
                              verticesOf(lattice[whole]),
                              ". Export the mesh without splitting faces into triangles"));
        if (isNumberedByFirstUse(mesh, lattice))
            refuse(path, name,
                   what +
                       "is not a face of the lattice, since the vertices are numbered in the order "
                       "in which the faces use them. Blender's legacy importer of OBJ does so: "
                       "import the mesh by File, Import, Wavefront (.obj), or choose Keep Vert "
                       "Order in the legacy importer");
        refuse(path, name,
               what +
                   "is not a face of the lattice. The vertices may have another order: begin "
                   "with an editor mesh written by 'espalier refine LATTICE -n 0 -o editor.obj', "
                   "and keep "
                   "the order of its vertices");
    }
}

/// Reads an editor mesh with this number of vertices.
/// \param notes receives the notes of the reader; may be null
/// \param check called with the faces
template <class Check>
std::vector<Point3> readMesh(const Path& path, const std::string& name, Index vertexCount,
                             ReadNotes* notes, Check check) {
    const auto model = readModel(path);
    refuseHeldPoints(path, *model);
    if (notes) notes->others = model->notes();
    checkPointCount(path, name, model->positions().size(), vertexCount);
    check(model->readSurface().faces);
    return {model->positions().begin(), model->positions().end()};
}

}  // namespace

std::vector<Point3> readPose(const Path& path, const Lattice& rest, const std::string& restName,
                             ReadNotes* notes) {
    const far::CellComplex& complex = rest.complex;
    if (complex.dimension() < 2)
        throw Error("a pose needs a lattice or a mesh at rest, got a curve or nothing");
    if (isFileOf(FileContent::EditorMesh, path))
        return readMesh(path, restName, complex.count(0), notes, [&](const ModelFaces& faces) {
            checkFaces(path, restName, faces, facesOf(complex));
        });
    Lattice pose = readLattice(path, notes);
    if (const auto difference = far::topologyDifference(complex, pose.complex))
        refuse(path, restName, " (called the first, this file the second): " + *difference);
    return std::move(pose.positions);
}

std::vector<Point3> readPose(const Path& path, const BoundModel& bound,
                             const std::string& bindingName, ReadNotes* notes) {
    const std::string name = "the lattice of " + bindingName;
    const Index vertexCount = bound.binding.table.columnCount();
    if (isFileOf(FileContent::EditorMesh, path))
        return readMesh(path, name, vertexCount, notes, [&](const ModelFaces& faces) {
            checkFaces(path, name, faces, bound.faces);
        });
    Lattice pose = readLattice(path, notes);
    if (far::topologyHash(pose.complex) != bound.binding.topologyHash)
        refuse(path, name,
               concat(": the bound lattice has ", vertexCount, " vertices, the pose ",
                      pose.complex.count(0), "; or their cells differ"));
    return std::move(pose.positions);
}

ModelFaces facesOf(const far::CellComplex& complex) {
    ModelFaces faces;
    if (complex.count(2) == 0) return faces;
    const far::Incidence& loops = complex.relation(2, 0);
    faces.corners.assign(loops.values().begin(), loops.values().end());
    for (Index face = 0; face < complex.count(2); ++face)
        faces.ends.push_back(loops.offset(face + 1));
    return faces;
}

void writeEditorMesh(const Path& path, const Lattice& lattice) {
    const Format* format = findFormat(path, FileContent::EditorMesh, FileUse::Write);
    if (!format)
        throw FileError(path, "an editor mesh cannot be written in this format; expected " +
                                  listOfFormats(FileContent::EditorMesh, FileUse::Write));
    checkedForWriting(path, lattice);
    const ModelFaces faces = facesOf(lattice.complex);
    const SurfaceView surface{lattice.positions, faces};
    writeFile(path, [&](std::ostream& out) { format->writeSurface(out, surface); });
}

}  // namespace espalier::io
