// SPDX-License-Identifier: Apache-2.0
//
// A program in another project: moves a lattice with a cube in it by (1, 2, 3). Exits with 0 if the
// points of the cube moved along, and a file was read as it was written.

#include <espalier/embed/local_binding.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/io/lattice_file.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/shapes/inventory.h>
#include <espalier/solve/validity.h>

#include <cmath>
#include <cstddef>
#include <cstdio>
#include <vector>

int main() {
    using namespace espalier;
    const Lattice lattice = shapes::box({.cells = {2, 2, 2}});
    const far::TopologyRefiner base(lattice.complex, {.marks = lattice.marks});
    const std::vector<Point3> points = {{0.1, 0.2, 0.3}, {0.5, 0.5, 0.5}, {0.9, 0.1, 0.7}};
    const auto bound = embed::bindPoints({base, lattice.positions}, points, {.level = 2});
    std::vector<Point3> pose = lattice.positions;
    for (Point3& position : pose)
        for (std::size_t c = 0; c < 3; ++c) position[c] += static_cast<double>(c + 1);

    const osd::CompiledTable<double> table(bound.table);
    std::vector<Point3> moved(points.size());
    const auto xyz = osd::BufferDescriptor::packed(3);
    table.evaluate({pose.front().data(), 3 * pose.size()}, xyz,
                   {moved.front().data(), 3 * moved.size()}, xyz, {0, 3});
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
            if (std::abs(moved[i][c] - points[i][c] - static_cast<double>(c + 1)) > 1e-12) {
                std::printf("point %zu is wrong\n", i);
                return 1;
            }

    io::writeLattice("lattice.ovm", lattice);
    if (io::readLattice("lattice.ovm").positions != lattice.positions) return 2;
    try {
        io::readLattice("none.ovm");
        return 3;
    } catch (const Error& error) {
        // The exception crosses the border of a library.
        std::printf("%s\n", error.what());
    }
    return solve::ValidityCheck(lattice.complex, lattice.positions).badAtRest().empty() ? 0 : 4;
}
