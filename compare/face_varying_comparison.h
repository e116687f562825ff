// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/face_varying.h>

#include <span>
#include <vector>

namespace espalier::compare {

/// Refines the face-varying values of a mesh with OpenSubdiv and with far::refineFaceVarying(), and
/// compares the two stencils at every corner of every face. Faces and corners are matched by
/// topology. Under Boundary::Open, only the faces that OpenSubdiv keeps are compared.
///
/// \param refiner of a mesh, refined uniformly to level 1 or more
/// \param cornerValues, linear as far::refineFaceVarying() takes them
/// \return for each level from 1 on, the largest difference of a weight (see Bounds::weight)
/// \throws Error as far::refineFaceVarying(); if OpenSubdiv refuses the mesh, or a corner has no
///         match
ESPALIER_API std::vector<double> faceVaryingDifferences(const far::TopologyRefiner& refiner,
                                                        std::span<const Index> cornerValues,
                                                        far::FaceVaryingLinear linear);

}  // namespace espalier::compare
