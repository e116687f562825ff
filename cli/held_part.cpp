// SPDX-License-Identifier: Apache-2.0
#include "held_part.h"

#include <espalier/base/error.h>
#include <espalier/base/printable.h>
#include <espalier/shapes/refiner_options.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "choice.h"
#include "pipeline.h"

namespace espalier::cli {
namespace {

using embed::Continuity;

const std::map<std::string, Continuity> kContinuities = {
    {"c0", Continuity::C0}, {"c1", Continuity::C1}, {"c2", Continuity::C2}};

bool isIn(const std::array<double, 6>& box, const Point3& point) {
    for (std::size_t c = 0; c < 3; ++c)
        if (!(point[c] >= box[c] && point[c] <= box[c + 3])) return false;
    return true;
}

/// The faces of the boundary that lie in a box with all their vertices.
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
        command
            .add_option("--hold", hold.box,
                        "What lies in this box stays: points of the model, and faces of the "
                        "lattice's boundary")
            ->type_name("X0 Y0 Z0 X1 Y1 Z1");
    addChoice<Continuity>(command, "--continuity", hold.continuity, kContinuities,
                          "How what is held meets what moves: in its place, with its tangent "
                          "planes, or with its curvatures; c1 and c2 hold the same vertices");
    CLI::Option* continuity = command.get_option("--continuity")->needs(box);
    for (CLI::Option* option : {box, continuity}) options.ofSubdivision.push_back(option);
}

HeldPart findHeldPart(const HoldOptions& hold, const BindOptions& options,
                      std::span<const Point3> points, const Lattice& lattice) {
    if (!hold.box) return {};
    const auto& box = *hold.box;
    for (std::size_t c = 0; c < 3; ++c)
        if (!(box[c] <= box[c + 3]))
            throw Error(fmt::format("--hold: the box runs from {} to {}; expected it to ascend",
                                    box[c], box[c + 3]));
    HeldPart part;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (isIn(box, points[i])) part.points.push_back(static_cast<Index>(i));
    // Without boundary control a level does not reach as far as its faces.
    const auto boundary = refinerOptions(lattice, options.common.refinement).boundary;
    if (boundary != far::Boundary::Open) part.faces = boundaryFacesIn(box, lattice);
    if (part.points.empty() && part.faces.empty())
        throw Error(
            fmt::format("--hold: no point of {} lies in the box, and no face of the "
                        "boundary of {}",
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
            fmt::format("--hold: point {} of {}, and what else lies in the box, is outside "
                        "the lattice {}, and stays anyway",
                        part.points.front(), printable(options.model), printable(options.rest)));
    return stages.run("holding", [&] {
        // What D says of its points needs no second look at the lattice.
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
            add(embed::verticesHoldingPoints(base, lattice.positions, options.level,
                                             options.common.rules, own, hold.continuity,
                                             options.common.embedding));
        }
        if (!part.faces.empty())
            add(embed::verticesHoldingFaces(base, options.common.rules, part.faces,
                                            hold.continuity));
        std::sort(held.begin(), held.end());
        held.erase(std::unique(held.begin(), held.end()), held.end());
        return held;
    });
}

}  // namespace espalier::cli
