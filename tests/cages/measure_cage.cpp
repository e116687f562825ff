// SPDX-License-Identifier: Apache-2.0
// Makes a cage of a model, measures it, and prints one line of JSON. cage_models_test.py runs it.
//
//     measure_cage MODEL VERTICES [keep-apart]
#include <espalier/cages/cage.h>
#include <espalier/io/model.h>

#include <chrono>
#include <cstdlib>
#include <iostream>
#include <numeric>
#include <string_view>

#include "cages/cage_energy.h"
#include "cages/model_surface.h"
#include "lattice_measures.h"

namespace espalier::cages {
namespace {

/// Returns the points, the middles of the edges and the middles of the faces of a model; 30,000 of
/// them if there are more.
std::vector<Point3> placesOf(std::span<const Point3> points, const io::ModelFaces& faces) {
    std::vector<Point3> places(points.begin(), points.end()), corners;
    for (std::size_t f = 0; f < faces.count(); ++f) {
        corners.clear();
        for (const Index corner : faces[f]) corners.push_back(points[corner]);
        places.push_back(mean(corners));
        for (std::size_t i = 0; i < corners.size(); ++i)
            places.push_back(between(corners[i], corners[(i + 1) % corners.size()], 0.5));
    }
    std::vector<Point3> some;
    const std::size_t step = places.size() / 30000 + 1;
    for (std::size_t i = 0; i < places.size(); i += step) some.push_back(places[i]);
    return some;
}

/// Returns the number of interior edges, and of those without four cells.
std::pair<Index, Index> interiorEdges(const far::CellComplex& complex) {
    Index count = 0, irregular = 0;
    for (Index edge = 0; edge < complex.count(1); ++edge) {
        bool isInterior = true;
        for (const Index face : complex.relation(1, 2)[edge])
            isInterior = isInterior && complex.relation(2, 3)[face].size() == 2;
        if (!isInterior) continue;
        ++count;
        irregular += complex.relation(1, 2)[edge].size() != 4;
    }
    return {count, irregular};
}

void measure(const char* path, const CageOptions& options) {
    const auto model = io::readModel(path);
    const io::ModelFaces faces = model->readSurface().faces;
    const SurfaceModel surface{model->positions(), faces.corners, faces.ends};
    const auto start = std::chrono::steady_clock::now();
    const Lattice made = cage(surface, options);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    const auto topology = test::topologyOf(made.complex);
    const auto places = placesOf(model->positions(), faces);
    far::TopologyRefiner refiner(made.complex);
    refiner.refineUniform(CellShapes::kLevel);
    const auto shapes = CellShapes(refiner).leastJacobians(made.positions);
    double volume = 0;
    const ModelSurface pieces(surface);
    for (const auto& piece : pieces.closedPieces())
        volume += piece.winding < 0 ? -piece.volume : piece.volume;
    const auto [interior, irregular] = interiorEdges(made.complex);
    std::cout << "{\"vertices\": " << made.complex.count(0)
              << ", \"cells\": " << made.complex.count(3)
              << ", \"components\": " << topology.components
              << ", \"handles\": " << topology.handles << ", \"cavities\": " << topology.cavities
              << ", \"manifold\": " << topology.isManifold
              << ", \"outside_level\": " << test::outsideLevel(made, places)
              << ", \"outside_limit\": " << test::outsideLimit(made, places)
              << ", \"bad_cells\": " << test::badCells(made).size()
              << ", \"limit_volume\": " << test::limitVolume(made)
              << ", \"model_volume\": " << volume
              << ", \"scaled_jacobian\": " << *std::min_element(shapes.begin(), shapes.end())
              << ", \"interior_edges\": " << interior << ", \"irregular_edges\": " << irregular
              << ", \"seconds\": " << seconds.count() << "}\n";
}

}  // namespace
}  // namespace espalier::cages

int main(int argc, char** argv) {
    if (argc < 3) return 2;
    try {
        espalier::cages::measure(
            argv[1], {.vertices = std::atoi(argv[2]),
                      .keepApart = argc > 3 && argv[3] == std::string_view("keep-apart")});
    } catch (const std::exception& error) {
        std::cout << error.what() << "\n";
        return 1;
    }
}
