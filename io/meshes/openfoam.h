// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "foam_case.h"

// Models and lattices of meshes of OpenFOAM (polyMesh), ASCII and binary, compressed or not. Labels
// have 32 or 64 bits; scalars have single or double precision.
//
// The points are in the file "points". The faces and cells are in the files "faces", "owner" and
// "neighbour" beside it; or in constant/polyMesh of the case, if "points" is in TIME/polyMesh.
// Files that the user has not named must be regular ones.
//
// A decomposed case is one model. Its parts, one for each process, repeat the points on their
// borders; points of two parts with equal coordinates are one point of the model, and so move
// alike. If the case has the whole mesh, too, and all points of the parts are among its points,
// then the cells are those of the whole mesh, and the parts move with it. Otherwise the cells of
// the parts are put together (foam_mesh.h), and the whole mesh stays. Collated files have the parts
// of several processes.
//
// The faces of a model are the boundary faces of the mesh; it has no cells if there is no file
// "faces". Only coordinates are replaced on writing, in files that have the same faces, owner and
// neighbour beside them, or none; points without such files beside them replace the points of a
// mesh with the same number of points. A file whose name ends in ".gz" is written compressed. If no
// point moves, it gets the bytes that were read.
//
// The cells of a lattice may be any polyhedra. Points that no cell uses are dropped. Two boundary
// faces with the same points (a baffle) become one face.

namespace espalier::io {

/// Returns the files of a decomposed case as one archive, from which readModel() makes its model:
/// a ZIP file of the files of points, with their paths in the case.
std::string archiveOf(const FoamCase& files);

}  // namespace espalier::io
