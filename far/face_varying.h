// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/base/word.h>
#include <espalier/far/topology_refiner.h>

#include <span>
#include <vector>

/// \file
/// Refines the topology of face-varying values of a mesh, such as texture coordinates. Each corner
/// of a face names a value. An edge is a seam if its two faces name different values at one end or
/// at both ends. docs/rules.md has the formulas.

namespace espalier::far {

/// Where face-varying values are interpolated linearly: OpenSubdiv's FVarLinearInterpolation. A
/// fixed value does not change from level to level. All other values along a seam or a boundary
/// follow the crease rule. Each mode fixes the values that the previous mode fixes, and more.
enum class FaceVaryingLinear {
    None,          ///< fixes a value where its vertex is a corner, where three or more sharp edges
                   ///< and seams of its faces meet, and where its faces do not form one fan
    CornersOnly,   ///< also fixes a value that only one face has at the vertex
    CornersPlus1,  ///< also fixes all values of a vertex that has three or more values. If sharp
                   ///< edges fix one of the two values of a vertex, wholly or in part, they fix the
                   ///< other one equally
    CornersPlus2,  ///< also fixes both values of a vertex if only one face has one of them, and the
                   ///< value of a vertex inside the mesh where a seam ends
    Boundaries,    ///< also fixes all values on seams and boundaries, which are thus linear
    All            ///< fixes all values: they are bilinear in each face
};
inline constexpr Word<FaceVaryingLinear> kFaceVaryingLinearWords[] = {
    {"none", FaceVaryingLinear::None},
    {"corners-only", FaceVaryingLinear::CornersOnly},
    {"corners-plus1", FaceVaryingLinear::CornersPlus1},
    {"corners-plus2", FaceVaryingLinear::CornersPlus2},
    {"boundaries", FaceVaryingLinear::Boundaries},
    {"all", FaceVaryingLinear::All}};

/// The refined topology of the face-varying values of a mesh: the mesh, cut along the seams.
struct FaceVaryingTopology {
    /// Refines the cut mesh to the level of the mesh's own refiner. On each level, the faces and
    /// their corners have the numbers and the order of the mesh's own faces and corners. So a loop
    /// of this refiner gives the value at each corner of the same face of the mesh. The tables of
    /// stencils/ and the evaluators of osd/ take it as any other refiner.
    TopologyRefiner refiner;

    /// Per vertex of level 0 of `refiner`: the number of its value, ascending. If corners of
    /// several vertices name one value, each of these vertices has it. If each value belongs to
    /// exactly one vertex, vertex i has value i.
    std::vector<Index> values;
};

/// Cuts a mesh along the seams of face-varying values, and refines it to the same level.
///
/// On each level, edges that are no seam have the sharpness of the mesh, and seams are infinitely
/// sharp. The result differs from OpenSubdiv's in three cases:
///
/// - At a vertex where the faces with one value do not form one fan, the value is fixed here.
/// - Under CornersPlus1 and CornersPlus2, where semi-sharp edges meet a seam.
/// - With Creasing::Chaikin, where semi-sharp edges end on a seam.
///
/// \param refiner refiner of a mesh, refined uniformly
/// \param cornerValues per corner of the faces of level 0, face by face and in the order of the
///        loops: the number of its value, 0 or more
/// \throws Error if `refiner` is not one of a mesh, or was refined around some cells only; if there
///         is not one value per corner, or a number is negative
/// \cost as TopologyRefiner::refineUniform()
/// \cite OpenSubdiv 3.5, Sdc::Options::FVarLinearInterpolation; the rules agree with its
///       Far::PrimvarRefiner::InterpolateFaceVarying()
///       (tests/compare/face_varying_comparison_test.cpp)
ESPALIER_API FaceVaryingTopology refineFaceVarying(const TopologyRefiner& refiner,
                                                   std::span<const Index> cornerValues,
                                                   FaceVaryingLinear linear);

}  // namespace espalier::far
