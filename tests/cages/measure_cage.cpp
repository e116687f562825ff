// SPDX-License-Identifier: Apache-2.0
// Makes a cage of a model, measures it, and prints one line of JSON. cage_models_test.py runs it.
//
//     measure_cage MODEL VERTICES [keep-apart]
#include <espalier/cages/cage.h>
#include <espalier/io/model.h>

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <string_view>
#include <utility>
#include <vector>

#include "cages/cage_energy.h"
#include "cages/left_side.h"
#include "cages/model_surface.h"
#include "cages/model_voxels.h"
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

/// Returns the volume of the solid of the closed pieces of a model. Parts that intersect count
/// once. Rays along z through the middles of 1,000 × 1,000 rectangles are cut by the triangles; the
/// error is below a thousandth for the models of the table.
double solidVolume(const ModelSurface& surface) {
    constexpr Index kRays = 1000;
    const std::vector<Point3>& points = surface.points();
    Point3 low = points.front(), high = low;
    for (const Point3& point : points)
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], point[axis]);
            high[axis] = std::max(high[axis], point[axis]);
        }
    const double width = (high[0] - low[0]) / kRays, depth = (high[1] - low[1]) / kRays;
    const std::vector<int> signs =
        ModelVoxels(surface, points, {.size = length(difference(high, low)) / 100}).signs();
    std::vector<std::vector<std::pair<double, int>>> crossings(std::size_t{kRays} * kRays);
    for (std::size_t piece = 0; piece < signs.size(); ++piece)
        for (const Triangle& t : surface.closedPieces()[piece].triangles) {
            const Point3 &a = points[t[0]], &b = points[t[1]], &c = points[t[2]];
            const auto first = [](double least, double step) {
                return std::max(0, static_cast<Index>(std::ceil(least / step - 0.5)));
            };
            const Point3 normal = cross(difference(b, a), difference(c, a));
            const double right = std::max({a[0], b[0], c[0]}) - low[0];
            const double back = std::max({a[1], b[1], c[1]}) - low[1];
            const Index fromX = first(std::min({a[0], b[0], c[0]}) - low[0], width);
            const Index fromY = first(std::min({a[1], b[1], c[1]}) - low[1], depth);
            for (Index y = fromY; y < kRays && (y + 0.5) * depth <= back; ++y)
                for (Index x = fromX; x < kRays && (x + 0.5) * width <= right; ++x) {
                    const Point3 p = {low[0] + (x + 0.5) * width, low[1] + (y + 0.5) * depth, 0};
                    const bool side = isLeft(a, b, p);
                    if (isLeft(b, c, p) != side || isLeft(c, a, p) != side || normal[2] == 0)
                        continue;
                    const double z =
                        a[2] - (normal[0] * (p[0] - a[0]) + normal[1] * (p[1] - a[1])) / normal[2];
                    crossings[std::size_t{kRays} * y + x].emplace_back(
                        z, side ? signs[piece] : -signs[piece]);
                }
        }
    double total = 0;
    for (auto& ofRay : crossings) {
        std::sort(ofRay.begin(), ofRay.end());
        int winding = 0;
        for (std::size_t i = 0; i + 1 < ofRay.size(); ++i) {
            winding += ofRay[i].second;
            if (winding != 0) total += ofRay[i + 1].first - ofRay[i].first;
        }
    }
    return total * width * depth;
}

/// Returns the CPU time of this process, of all threads, in seconds.
double cpuSeconds() {
    rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& time) {
        return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Returns the largest memory of this process so far, in megabytes.
long peakMemory() {
    rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss / 1000;
}

void measure(const char* path, const CageOptions& options) {
    const auto model = io::readModel(path);
    const io::ModelFaces faces = model->readSurface().faces;
    const SurfaceModel surface{model->positions(), faces.corners, faces.ends};
    const double start = cpuSeconds();
    const Lattice made = cage(surface, options);
    const double seconds = cpuSeconds() - start;
    const long megabytes = peakMemory();
    const auto topology = test::topologyOf(made.complex);
    const auto places = placesOf(model->positions(), faces);
    far::TopologyRefiner refiner(made.complex);
    refiner.refineUniform(CellShapes::kLevel);
    const auto shapes = CellShapes(refiner).leastJacobians(made.positions);
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
              << ", \"model_volume\": " << solidVolume(ModelSurface(surface))
              << ", \"scaled_jacobian\": " << *std::min_element(shapes.begin(), shapes.end())
              << ", \"interior_edges\": " << interior << ", \"irregular_edges\": " << irregular
              << ", \"seconds\": " << seconds << ", \"megabytes\": " << megabytes << "}\n";
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
