// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/shapes/lattice.h>

namespace espalier {

/// Returns the options to refine a lattice or a mesh with its marks. Boundary mode, creasing and
/// triangle weights each come from `chosen` if set there, else from the tags of the lattice, else
/// from the defaults. Sharp edges and rules come from the arguments alone.
inline far::RefinerOptions refinerOptions(const Lattice& lattice, const RefinementTags& chosen = {},
                                          far::SharpEdges sharpEdges = far::SharpEdges::SingleCell,
                                          far::Rules rules = far::Rules::Siggraph96) {
    const auto choose = [](const auto& choice, const auto& tag, auto fallback) {
        return choice ? *choice : tag.value_or(fallback);
    };
    const RefinementTags& tags = lattice.tags;
    far::RefinerOptions options;
    options.rules = rules;
    options.boundary = choose(chosen.boundary, tags.boundary, options.boundary);
    options.creasing = choose(chosen.creasing, tags.creasing, options.creasing);
    options.triangles = choose(chosen.triangles, tags.triangles, options.triangles);
    options.sharpEdges = sharpEdges;
    options.marks = lattice.marks;
    return options;
}

}  // namespace espalier
