// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/cell_complex.h>
#include <espalier/far/standard_cells.h>
#include <espalier/far/volume_mesh.h>

#include <vector>

namespace espalier::test {

/// Returns the cells of a lattice as a volume mesh: standard cells as such, all others as
/// polyhedra.
///
/// \param arePolyhedra whether standard cells become polyhedra, too
inline far::VolumeMesh volumeMeshOf(const far::CellComplex& complex, bool arePolyhedra = false) {
    far::VolumeMeshBuilder builder(complex.count(0));
    for (Index cell = 0; cell < complex.count(3); ++cell) {
        const auto standard = far::asStandardCell(complex, CellId(cell));
        if (standard && !arePolyhedra)
            builder.addCell(standard->kind, standard->vertices);
        else
            builder.addCell(far::outwardLoops(complex, CellId(cell)));
    }
    return builder.build();
}

/// Returns the cells of a lattice as a mesh of faces with owners and neighbours, as OpenFOAM has
/// them: the loops turn to the outside of the owner, which is the lower cell, and faces between
/// cells come first.
inline far::VolumeMesh meshOfFaces(const far::CellComplex& complex) {
    far::Rows<Index> faces;
    std::vector<Index> owners, neighbours;
    for (const std::size_t sides : {2, 1})
        for (Index face = 0; face < complex.count(2); ++face) {
            const auto cells = complex.relation(2, 3)[face];
            if (cells.size() != sides) continue;
            const auto ofOwner = complex.relation(3, 2)[cells[0]];
            const std::size_t place =
                std::find(ofOwner.begin(), ofOwner.end(), face) - ofOwner.begin();
            const auto loop = far::outwardLoops(complex, CellId(cells[0]))[place];
            faces.values.insert(faces.values.end(), loop.begin(), loop.end());
            faces.offsets.push_back(Offset(faces.values.size()));
            owners.push_back(cells[0]);
            if (sides == 2) neighbours.push_back(cells[1]);
        }
    return {complex.count(0), complex.count(3), faces, owners, neighbours};
}

}  // namespace espalier::test
