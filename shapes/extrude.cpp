// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/vector3.h>
#include <espalier/far/complex_builder.h>
#include <espalier/shapes/extrude.h>

#include <algorithm>
#include <string>
#include <utility>

#include "cell_loops.h"
#include "checks.h"

namespace espalier::shapes {
namespace {

/// Makes the topology, attributes and marks of a sweep; positions play no part.
class Sweep {
public:
    Sweep(const Lattice& mesh, std::size_t layerCount, SweepEnds ends)
        : mesh_(mesh),
          layerCount_(static_cast<Index>(layerCount)),
          rowCount_(static_cast<Index>(layerCount) - (ends == SweepEnds::Open ? 1 : 0)),
          ends_(ends) {}

    /// \param reversed per face of the mesh: true if it runs clockwise seen from the next layer
    far::CellComplex complex(const std::vector<bool>& reversed) const {
        far::ComplexBuilder builder(3, layerCount_ * mesh_.complex.count(0));
        // A face of n corners becomes a prism: two faces of n corners and n of four.
        builder.reserve(mesh_.complex.relation(2, 0).values().size() * 6 * rowCount_);
        std::vector<Loop> loops;
        for (Index row = 0; row < rowCount_; ++row)
            for (Index face = 0; face < mesh_.complex.count(2); ++face) {
                const auto base = mesh_.complex.relation(2, 0)[face];
                Loop loop(base.begin(), base.end());
                if (reversed[face]) std::reverse(loop.begin() + 1, loop.end());
                prism(loop, row, loops);
                builder.addCell(loops);
            }
        return builder.build();
    }

    far::Marks marks() const {
        far::Marks marks;
        if (ends_ == SweepEnds::Open) {
            copyTo(0, marks);
            copyTo(layerCount_ - 1, marks);
        }
        for (const far::Marks::Vertex& mark : mesh_.marks.vertices)
            for (Index row = 0; row < rowCount_; ++row)
                marks.edges.push_back(
                    {{vertex(row, mark.vertex), vertex(row + 1, mark.vertex)}, mark.sharpness});
        return marks;
    }

    /// Copies the values of the mesh to each layer.
    /// \tparam Attribute VertexAttribute or VertexIntegers
    template <class Attribute>
    std::vector<Attribute> onLayers(std::vector<Attribute> attributes) const {
        for (Attribute& attribute : attributes) {
            const auto values = attribute.values;
            for (Index layer = 1; layer < layerCount_; ++layer)
                attribute.values.insert(attribute.values.end(), values.begin(), values.end());
        }
        return attributes;
    }

    std::vector<VertexAttribute> attributes() const { return onLayers(mesh_.attributes); }
    std::vector<VertexIntegers> integers() const { return onLayers(mesh_.integers); }

private:
    Index vertex(Index layer, Index meshVertex) const {
        return layer % layerCount_ * mesh_.complex.count(0) + meshVertex;
    }

    void prism(const Loop& loop, Index row, std::vector<Loop>& loops) const {
        const std::size_t n = loop.size();
        loops.resize(n + 2);
        for (Loop& each : loops) each.clear();
        for (std::size_t i = 0; i < n; ++i) {
            const Index a = loop[i];
            const Index b = loop[(i + 1) % n];
            loops[0].push_back(vertex(row, loop[(n - i) % n]));
            loops[1].push_back(vertex(row + 1, a));
            loops[i + 2] = {vertex(row, a), vertex(row, b), vertex(row + 1, b), vertex(row + 1, a)};
        }
    }

    void copyTo(Index layer, far::Marks& marks) const {
        for (far::Marks::Edge mark : mesh_.marks.edges) {
            for (Index& end : mark.vertices) end = vertex(layer, end);
            marks.edges.push_back(mark);
        }
        for (far::Marks::Vertex mark : mesh_.marks.vertices) {
            mark.vertex = vertex(layer, mark.vertex);
            marks.vertices.push_back(mark);
        }
    }

    const Lattice& mesh_;
    Index layerCount_;
    Index rowCount_;  ///< number of rows of cells between layers
    SweepEnds ends_;
};

/// Throws unless each edge of the mesh has at most two faces, because a face has at most two cells.
void requireManifold(const std::string& who, const far::CellComplex& mesh) {
    for (Index edge = 0; edge < mesh.count(1); ++edge) {
        const std::size_t faceCount = mesh.relation(1, 2)[edge].size();
        if (faceCount <= 2) continue;
        const auto ends = mesh.relation(1, 0)[edge];
        throw Error(concat(who, ": edge (", ends[0], ", ", ends[1], ") of the mesh lies in ",
                           faceCount, " faces; expected 1 or 2"));
    }
}

/// Throws if there are too many entries. A corner of the mesh gives 6 corners of loops in each row
/// of cells.
void requireCountableRows(const std::string& who, const far::CellComplex& mesh,
                          std::size_t layerCount) {
    const auto layers = static_cast<Offset>(std::min<std::size_t>(layerCount, kMaxIndex));
    const auto corners = static_cast<Offset>(mesh.relation(2, 0).values().size());
    requireCountable(who, {layers, corners, 6});
}

std::vector<std::vector<Point3>> imagesOf(const Lattice& mesh, std::span<const Affine> stations) {
    std::vector<std::vector<Point3>> layers(stations.size(), mesh.positions);
    for (std::size_t layer = 0; layer < layers.size(); ++layer)
        for (Point3& position : layers[layer]) position = stations[layer](position);
    return layers;
}

std::vector<Point3> joined(std::span<const std::vector<Point3>> layers) {
    std::vector<Point3> positions;
    for (const auto& layer : layers) positions.insert(positions.end(), layer.begin(), layer.end());
    return positions;
}

Lattice assembled(const Sweep& sweep, const std::vector<bool>& reversed,
                  std::span<const std::vector<Point3>> layers) {
    return {sweep.complex(reversed), joined(layers), sweep.marks(), sweep.attributes(), {},
            sweep.integers()};
}

std::vector<Point3> loopPositions(const Loop& loop, const std::vector<Point3>& positions) {
    std::vector<Point3> result;
    for (const Index vertex : loop) result.push_back(positions[vertex]);
    return result;
}

/// Returns the cosine of the angle between a vector and the area vector of a loop; 0 for a loop
/// without area.
double facing(const std::vector<Point3>& loop, const Point3& direction) {
    const Point3 area = scaledNearOne(areaVector(loop)), along = scaledNearOne(direction);
    const double scale = length(area) * length(along);
    return scale > 0 ? dot(area, along) / scale : 0;
}

/// Throws unless the first row of cells of a straight extrusion has positive volume; the other rows
/// are copies of it.
void requireVolumes(const Lattice& mesh, const Lattice& lattice, const Point3& direction) {
    // A few rounding errors of the cross products, and far below any intended angle.
    constexpr double kAlong = 1e-12;
    for (Index face = 0; face < mesh.complex.count(2); ++face) {
        const Loop bottom = far::outwardLoops(lattice.complex, CellId(face)).front();
        const double cosine = -facing(loopPositions(bottom, lattice.positions), direction);
        if (cosine > kAlong) continue;
        const std::string name = concat("extrude: face ", face, " of the mesh ");
        if (cosine < -kAlong)
            throw Error(name + "faces away from the direction " + textOf(direction) +
                        ", unlike its neighbours; its cells would have a negative volume");
        throw Error(name + "lies along the direction " + textOf(direction) +
                    " or has no area; its cells would have no volume");
    }
}

}  // namespace

Lattice sweep(const Lattice& mesh, std::span<const std::vector<Point3>> layers, SweepEnds ends) {
    requireConsistent("sweep", "the mesh", mesh, 2);
    requireManifold("sweep", mesh.complex);
    const std::size_t least = ends == SweepEnds::Closed ? 3 : 2;
    if (layers.size() < least)
        throw ArgumentError("sweep", "layers", std::to_string(layers.size()),
                            concat(least, " or more"));
    for (std::size_t layer = 0; layer < layers.size(); ++layer) {
        if (layers[layer].size() != mesh.positions.size())
            throw Error(concat("sweep: layer ", layer, " has ", layers[layer].size(),
                               " positions; expected ", mesh.positions.size(),
                               ", one for each vertex of the mesh"));
        requireFinite(indexed("layers", layer), layers[layer]);
    }
    requireCountableRows("sweep", mesh.complex, layers.size());
    const std::vector<bool> reversed(mesh.complex.count(2), false);
    return assembled(Sweep(mesh, layers.size(), ends), reversed, layers);
}

Lattice sweep(const Lattice& mesh, std::span<const Affine> stations, SweepEnds ends) {
    return sweep(mesh, imagesOf(mesh, stations), ends);
}

std::vector<Affine> stationsBetween(const Point3& from, const Point3& to, int layers) {
    requireAtLeast("stationsBetween", "layers", layers, 1);
    std::vector<Affine> stations;
    for (int layer = 0; layer <= layers; ++layer)
        stations.push_back(translation(between(from, to, static_cast<double>(layer) / layers)));
    return stations;
}

Lattice extrude(const Lattice& mesh, const ExtrudeOptions& options) {
    requireConsistent("extrude", "the mesh", mesh, 2);
    requireManifold("extrude", mesh.complex);
    requireAtLeast("extrude", "layers", options.layers, 1);
    requireFinite("extrude", "direction", options.direction);
    if (!(length(options.direction) > 0))
        throw ArgumentError("extrude", "direction", textOf(options.direction),
                            "a vector other than 0");
    const std::size_t layerCount = Offset{options.layers} + 1;
    requireCountableRows("extrude", mesh.complex, layerCount);

    const auto layers =
        imagesOf(mesh, stationsBetween({0, 0, 0}, options.direction, options.layers));
    std::vector<bool> reversed;
    for (Index face = 0; face < mesh.complex.count(2); ++face) {
        std::vector<Point3> corners;
        for (const Index vertex : mesh.complex.relation(2, 0)[face])
            corners.push_back(mesh.positions[vertex]);
        reversed.push_back(facing(corners, options.direction) < 0);
    }
    Lattice lattice = assembled(Sweep(mesh, layerCount, SweepEnds::Open), reversed, layers);
    requireVolumes(mesh, lattice, options.direction);
    return lattice;
}

}  // namespace espalier::shapes
