// SPDX-License-Identifier: Apache-2.0
// Wraps a model by CGAL's 3D alpha wrapping with about a wanted number of vertices, and prints the
// number and the volume inside the wrap.
//
//     alpha_wrap MODEL.obj VERTICES
//
// scripts/alpha-wrap compiles this program. It is no part of the build: CGAL is under the GPL, and
// a program that includes it is, too.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    std::ifstream file(argv[1]);
    std::vector<Kernel::Point_3> points;
    std::vector<std::array<std::size_t, 3>> triangles;
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string word;
        words >> word;
        if (word == "v") {
            double x, y, z;
            words >> x >> y >> z;
            points.emplace_back(x, y, z);
        } else if (word == "f") {
            std::vector<std::size_t> loop;
            while (words >> word) loop.push_back(std::stoul(word) - 1);
            for (std::size_t i = 1; i + 1 < loop.size(); ++i)
                triangles.push_back({loop[0], loop[i], loop[i + 1]});
        }
    }
    const CGAL::Bbox_3 box = CGAL::bbox_3(points.begin(), points.end());
    const double diagonal = std::hypot(box.x_span(), box.y_span(), box.z_span());
    const double wanted = std::atof(argv[2]);
    // The offset is a thirtieth of alpha, CGAL's default. The number of vertices grows about as the
    // square of 1 / alpha.
    double alpha = diagonal / 10;
    Mesh wrap;
    for (int round = 0; round < 12; ++round) {
        wrap.clear();
        CGAL::alpha_wrap_3(points, triangles, alpha, alpha / 30, wrap);
        const double ratio = wrap.number_of_vertices() / wanted;
        if (ratio > 0.95 && ratio < 1.05) break;
        alpha *= std::pow(ratio, 0.45);
    }
    std::cout << wrap.number_of_vertices() << " vertices, volume "
              << CGAL::Polygon_mesh_processing::volume(wrap) << "\n";
}
