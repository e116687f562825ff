// SPDX-License-Identifier: Apache-2.0
#include "hold.h"

#include <espalier/base/error.h>
#include <espalier/base/printable.h>
#include <espalier/base/sort_unique.h>
#include <espalier/shapes/refiner_options.h>
#include <fmt/format.h>

#include <algorithm>

#include "run.h"

namespace espalier::cli {
namespace {

using embed::Continuity;

bool isIn(const std::array<double, 6>& box, const Point3& point) {
    for (std::size_t c = 0; c < 3; ++c)
        if (!(point[c] >= box[c] && point[c] <= box[c + 3])) return false;
    return true;
}

/// Returns the boundary faces whose vertices all lie in a box.
std::vector<Index> boundaryFacesIn(const std::array<double, 6>& box, const Lattice& lattice) {
    std::vector<Index> faces;
    for (Index face = 0; face < lattice.complex.count(2); ++face) {
        if (lattice.complex.relation(2, 3)[face].size() != 1) continue;
        const auto vertices = lattice.complex.relation(2, 0)[face];
        if (std::all_of(vertices.begin(), vertices.end(),
                        [&](Index vertex) { return isIn(box, lattice.positions[vertex]); }))
            faces.push_back(face);
    }
    return faces;
}

}  // namespace

void addHoldOptions(CLI::App& command, HoldOptions& hold, BindOptions& options) {
    CLI::Option* box =
        addNumbers(command, "--hold", hold.box, "X0 Y0 Z0 X1 Y1 Z1",
                   "Keep points of the model and boundary faces of the lattice that lie in the box "
                   "from corner X0 Y0 Z0 to corner X1 Y1 Z1 where they are");
    addChoice<Continuity>(
        command, "--continuity", hold.continuity, embed::kContinuityWords,
        "How the part in the box of --hold meets the rest. c0: without a gap; c1: "
        "with its tangent planes; c2: with its curvatures. c1 and c2 hold the same "
        "vertices");
    CLI::Option* continuity = command.get_option("--continuity")->needs(box);
    for (CLI::Option* option : {box, continuity}) options.ofSubdivision.push_back(option);
}

HeldPart findHeldPart(const HoldOptions& hold, const BindOptions& options,
                      std::span<const Point3> points, const Lattice& lattice) {
    if (!hold.box) return {};
    const auto& box = *hold.box;
    for (std::size_t c = 0; c < 3; ++c)
        if (!(box[c] <= box[c + 3]))
            throw CLI::ValidationError(
                "--hold", fmt::format("the box runs from {} down to {}; expected the lower corner "
                                      "first",
                                      box[c], box[c + 3]));
    HeldPart part;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (isIn(box, points[i])) part.points.push_back(static_cast<Index>(i));
    // With the boundary mode `open` no level reaches the boundary faces.
    const auto boundary = refinerOptions(lattice, options.common.refinement).boundary;
    if (boundary != far::Boundary::Open) part.faces = boundaryFacesIn(box, lattice);
    if (part.points.empty() && part.faces.empty())
        throw Error(
            fmt::format("--hold: the box contains no point of {} and no boundary face of {}",
                        printable(options.model), printable(options.rest)));
    return part;
}

std::vector<Index> heldVertices(const HeldPart& part, const HoldOptions& hold,
                                const BindOptions& options, std::span<const Point3> points,
                                const stencils::StencilTable<double>& rows, const Lattice& lattice,
                                Stages& stages) {
    if (part.points.empty() && part.faces.empty()) return {};
    if (rows.entryCount() == 0 && part.faces.empty())
        throw Error(
            fmt::format("--hold: all points in the box, such as point {} of {}, are outside the "
                        "lattice {} and stay without --hold",
                        part.points.front(), printable(options.model), printable(options.rest)));
    return stages.run("holding", [&] {
        // The columns of the rows of D are the vertices that move the points, so C⁰ needs no
        // search.
        auto held = embed::verticesHoldingRows(rows);
        const bool isBeyondPlaces = hold.continuity != Continuity::C0 && rows.entryCount() > 0;
        if (part.faces.empty() && !isBeyondPlaces) return held;
        const auto base = refineLattice(options.rest, lattice, options.common, 0);
        const auto add = [&](const std::vector<Index>& vertices) {
            held.insert(held.end(), vertices.begin(), vertices.end());
        };
        if (isBeyondPlaces) {
            std::vector<Point3> own;
            for (const Index point : part.points) own.push_back(points[point]);
            add(embed::verticesHoldingPoints(
                {base, lattice.positions}, own, hold.continuity,
                {.level = options.level, .embedding = options.common.embedding}));
        }
        if (!part.faces.empty())
            add(embed::verticesHoldingFaces(base, part.faces, hold.continuity));
        sortUnique(held);
        return held;
    });
}

}  // namespace espalier::cli
