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
/// at both.

namespace espalier::far {

/// Where face-varying values are interpolated linearly: OpenSubdiv's FVarLinearInterpolation. A
/// "fixed" value does not change from level to level; all other values along a seam or a boundary
/// follow the crease rule. Each mode fixes the values that the previous mode fixes, and more.
enum class FaceVaryingLinear {
    None,          ///< fixes a value only where its vertex is a corner, where three or more sharp
                   ///< edges and seams meet in it, or where its faces do not form one fan
    CornersOnly,   ///< also fixes values of one face
    CornersPlus1,  ///< also fixes all values of a vertex that has three or more values; and of the
                   ///< two values of a vertex, one is as sharp as sharp edges make the other
    CornersPlus2,  ///< also fixes both values of a vertex if one of the two is of one face, and the
                   ///< value where a seam ends inside the mesh
    Boundaries,    ///< also fixes all values along seams and boundaries, which are linear then
    All            ///< fixes everything: values are bilinear in each face
};
inline constexpr Word<FaceVaryingLinear> kFaceVaryingLinearWords[] = {
    {"none", FaceVaryingLinear::None},
    {"corners-only", FaceVaryingLinear::CornersOnly},
    {"corners-plus1", FaceVaryingLinear::CornersPlus1},
    {"corners-plus2", FaceVaryingLinear::CornersPlus2},
    {"boundaries", FaceVaryingLinear::Boundaries},
    {"all", FaceVaryingLinear::All}};

/// The refined topology of the face-varying values of a mesh: a mesh that is cut along the seams.
struct FaceVaryingTopology {
    /// Refines the cut mesh to the level of the mesh's own refiner. On each level, the faces and
    /// their corners have the numbers and the order of the mesh's own faces and corners. So a loop
    /// of this refiner gives the value at each corner of the same face of the mesh. The tables of
    /// stencils/ and the evaluators of osd/ take it as any other refiner.
    TopologyRefiner refiner;

    /// The number of the value at each vertex of level 0 of `refiner`; ascending. A value that
    /// corners of several vertices name is here once for each of these vertices. If each value
    /// belongs to exactly one vertex, vertex i has value i.
    std::vector<Index> values;
};

/// Cuts a mesh along the seams of face-varying values, and refines it to the same level.
///
/// Inside the charts, sharpness is the sharpness of the mesh, level by level; seams are infinitely
/// sharp. The result differs from OpenSubdiv's in three cases: at vertices where faces with the
/// same value do not form one fan, the value is fixed here; with semi-sharp edges at a seam, under
/// CornersPlus1 and CornersPlus2; and with Creasing::Chaikin, where semi-sharp edges end on a seam.
///
/// \param refiner of a mesh, refined uniformly
/// \param cornerValues number of the value (0 or more) at each corner of each face of level 0: face
///        by face, in the order of the loops
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
