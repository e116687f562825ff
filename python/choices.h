// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/topology_refiner.h>
#include <espalier/stencils/masks.h>

#include "words.h"

// The words of how a lattice is refined.
namespace espalier::python {

inline const Words<far::Boundary> kBoundaries = {{"sharp", far::Boundary::Sharp},
                                                 {"edge-only", far::Boundary::EdgeOnly},
                                                 {"open", far::Boundary::Open}};
inline const Words<far::SharpEdges> kSharpEdges = {{"single-cell", far::SharpEdges::SingleCell},
                                                   {"literal", far::SharpEdges::Literal}};
inline const Words<far::Creasing> kCreasings = {{"uniform", far::Creasing::Uniform},
                                                {"chaikin", far::Creasing::Chaikin}};
inline const Words<far::TriangleSubdivision> kTriangles = {
    {"catmark", far::TriangleSubdivision::Catmark}, {"smooth", far::TriangleSubdivision::Smooth}};
inline const Words<stencils::Rules> kRules = {{"siggraph96", stencils::Rules::Siggraph96},
                                              {"cse96", stencils::Rules::Cse96},
                                              {"mlca", stencils::Rules::Mlca},
                                              {"rats", stencils::Rules::Rats}};

}  // namespace espalier::python
