// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/cell_complex.h>
#include <espalier/shapes/cell_selection.h>

#include <span>
#include <string>
#include <vector>

// Sections of lattices; not installed.
namespace espalier::shapes {

/// Throws unless a complex is a lattice with cells, and there is one finite position per vertex.
void requireCells(const std::string& function, const far::CellComplex& complex,
                  std::span<const Point3> positions);

/// Returns the faces between cells that are marked and cells that are not.
std::vector<Index> facesBetween(const far::CellComplex& complex, std::span<const char> isMarked);

/// Returns the section of some faces.
/// \throws Error if the faces have no area, or the area overflows
Section sectionOf(const far::CellComplex& complex, std::span<const Point3> positions,
                  std::vector<Index> faces);

}  // namespace espalier::shapes
