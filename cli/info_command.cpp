// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/parallel.h>
#include <espalier/base/printable.h>
#include <espalier/embed/regular_cells.h>
#include <espalier/far/standard_cells.h>
#include <espalier/far/topology_error.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/io/binding_file.h>
#include <espalier/io/files/text_reader.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <espalier/limit/vertex_ring.h>
#include <espalier/shapes/lattice.h>
#include <espalier/solve/mesh_quality.h>
#include <espalier/solve/validity.h>
#include <espalier/stencils/composition.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <complex>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "commands.h"
#include "files.h"
#include "job.h"
#include "model_info.h"

namespace espalier::cli {
namespace {

struct InfoOptions : LatticeOptions {
    bool json = false;
    bool smoothness = false;
    bool asModel = false;
    const CLI::Option* levels = nullptr;  ///< -n

    /// True if an option asks for a lattice.
    bool asLattice() const { return levels->count() > 0 || smoothness; }
};

using SortedJson = nlohmann::json;

/// The number of occurrences of each value.
using Histogram = std::map<Index, Index>;

constexpr const char* kStrata[] = {"corner", "sharp", "boundary", "interior"};

using Eigen::Vector3d;
using far::CellComplex;

Vector3d at(const std::vector<Point3>& positions, Index vertex) {
    return Vector3d(positions[vertex].data());
}

Vector3d mean(const std::vector<Point3>& positions, std::span<const Index> vertices) {
    Vector3d sum = Vector3d::Zero();
    for (const Index vertex : vertices) sum += at(positions, vertex);
    return sum / static_cast<double>(vertices.size());
}

/// Returns the signed volume of a cell. Each face is a fan of triangles around its centroid.
double cellVolume(const CellComplex& complex, const std::vector<Point3>& positions, Index cell) {
    // Relative to the centroid of the cell, so that lattices far from the origin lose no digits.
    const Vector3d origin = mean(positions, complex.relation(3, 0)[cell]);
    const auto faces = complex.relation(3, 2)[cell];
    double volume = 0;
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const auto loop = complex.relation(2, 0)[faces[f]];
        const Vector3d centre = mean(positions, loop) - origin;
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Vector3d a = at(positions, loop[i]) - origin;
            const Vector3d b = at(positions, loop[(i + 1) % loop.size()]) - origin;
            volume += complex.boundary(3).signs(cell)[f] * centre.dot(a.cross(b)) / 6;
        }
    }
    return volume;
}

/// Counts the types n. On a base lattice, n is the number of edges of a cell at each of its
/// vertices; on the levels above, all cells are of type n, with 2n faces.
Histogram cellTypes(const CellComplex& complex, bool isBase) {
    Histogram types;
    for (Index cell = 0; cell < complex.count(3); ++cell) {
        if (!isBase) {
            ++types[static_cast<Index>(complex.relation(3, 2)[cell].size()) / 2];
            continue;
        }
        Histogram valence;
        for (const Index edge : complex.relation(3, 1)[cell])
            for (const Index end : complex.relation(1, 0)[edge]) ++valence[end];
        for (const auto& [vertex, n] : valence) ++types[n];
    }
    return types;
}

/// Returns a JSON object; its keys are texts.
SortedJson toJson(const Histogram& histogram) {
    SortedJson object = SortedJson::object();
    for (const auto& [value, count] : histogram) object[std::to_string(value)] = count;
    return object;
}

/// Returns the report on one level of a lattice:
///
///     counts                    by dimension
///     euler_characteristic
///     strata                    the counts by stratum
///     vertex_valences           edges at a vertex
///     interior_edge_valences    faces at an interior edge
///     cell_types                level 0: for each vertex of each cell, the number of edges of the
///                               cell there; levels above: n of each type-n cell
///     smallest_cell_volume, largest_cell_volume
///                               signed
///     inverted_cells            cells whose volume is not positive
///     smallest_scaled_jacobian  at the corners of hexahedra: 1 for a cube, 0 for a flat corner,
///                               below for a folded one; 1 without any
SortedJson reportLevel(const far::Level& level, const std::vector<Point3>& positions, bool isBase) {
    const CellComplex& complex = level.complex;
    // Begin with objects, not null: if memory runs out while nlohmann's operator[] turns a null
    // into an object, the null is left broken.
    SortedJson counts = SortedJson::object(), strata = SortedJson::object();
    for (int d = 0; d <= 3; ++d) {
        counts[kNamesOfParts[d]] = complex.count(d);
        SortedJson& own = strata[kNamesOfParts[d]] = SortedJson::object();
        for (int s = 0; s <= 3; ++s) own[kStrata[s]] = level.strata.count(d, s);
    }
    Histogram vertexValences, edgeValences;
    for (Index vertex = 0; vertex < complex.count(0); ++vertex)
        ++vertexValences[static_cast<Index>(complex.relation(0, 1)[vertex].size())];
    for (Index edge = 0; edge < complex.count(1); ++edge)
        if (level.strata.of({1, edge}) == 3)
            ++edgeValences[static_cast<Index>(complex.relation(1, 2)[edge].size())];
    double smallestVolume = std::numeric_limits<double>::infinity();
    double largestVolume = -smallestVolume;
    double smallestJacobian = 1;
    Index invertedCells = 0;
    for (Index cell = 0; cell < complex.count(3); ++cell) {
        const double volume = cellVolume(complex, positions, cell);
        smallestVolume = std::min(smallestVolume, volume);
        largestVolume = std::max(largestVolume, volume);
        invertedCells += !(volume > 0);
        if (const auto corners = far::hexahedronVertices(complex, CellId(cell)))
            smallestJacobian =
                std::min(smallestJacobian,
                         solve::scaledJacobian(far::StandardCell::Hexahedron, *corners, positions));
    }
    return {{"counts", counts},
            {"euler_characteristic", complex.eulerCharacteristic()},
            {"strata", strata},
            {"vertex_valences", toJson(vertexValences)},
            {"interior_edge_valences", toJson(edgeValences)},
            {"cell_types", toJson(cellTypes(complex, isBase))},
            {"smallest_cell_volume", smallestVolume},
            {"largest_cell_volume", largestVolume},
            {"inverted_cells", invertedCells},
            {"smallest_scaled_jacobian", smallestJacobian}};
}

/// Returns the report on a lattice that was read from `path`. Interior edges with only two faces
/// are counted because by the rules `siggraph96` their new point has a negative weight, and the
/// refined lattice may leave the convex hull there (MacCracken & Joy 1996, section 2.2, n = 2).
SortedJson reportLattice(const std::string& path, const Lattice& lattice,
                         const far::TopologyRefiner& refiner) {
    const BoundingBox box(lattice.positions);
    std::vector<std::string> attributes;
    for (const VertexAttribute& attribute : lattice.attributes)
        attributes.push_back(attribute.name);
    for (const VertexIntegers& integers : lattice.integers) attributes.push_back(integers.name);
    SortedJson levels = SortedJson::array();
    for (int level = 0; level <= refiner.maxLevel(); ++level) {
        const auto positions = stencils::refinePositions(refiner, level, lattice.positions);
        levels.push_back(reportLevel(refiner.level(level), positions, level == 0));
    }
    const auto edgesOfTwoFaces = levels[0]["interior_edge_valences"].value("2", 0);
    const far::TopologyRefiner base(refiner.level(0), refiner.options());
    return {{"lattice", path},
            {"bounds", {box.min, box.max}},
            {"size", box.size()},
            {"diagonal", box.diagonal()},
            {"marks", lattice.marks.edges.size() + lattice.marks.vertices.size()},
            {"attributes", attributes},
            {"interior_edges_of_two_faces", edgesOfTwoFaces},
            {"cells_bad_at_rest", solve::cellsBadAtRest(base, lattice.positions)},
            {"levels", levels}};
}

/// The behaviour of refinement in the limit at an irregular vertex or edge of a lattice.
struct Smoothness {
    Entity entity;  ///< a vertex or an edge of level 0
    int stratum;
    Index ringPoints;  ///< points of the ring, including the point itself
    /// False if the ring is too large: its eigenvalues and mask are then not computed.
    bool isKnown = false;
    /// Eigenvalues of the matrix from ring to ring, except the largest, 1: at most six, by
    /// descending modulus. At a regular vertex inside the lattice they are 1/2 three times, then
    /// 1/4.
    std::vector<std::complex<double>> eigenvalues = {};
    /// Weights of the limit point: of the point itself, and the sums over the ring's points of
    /// edges, faces and cells. At a regular vertex inside the lattice they are 8/27, 12/27, 6/27
    /// and 1/27.
    std::array<double, 4> mask = {};
};

/// The largest ring whose eigenvalues are computed. The eigenvalues of this ring take seconds; for
/// twice as many points they take eight times as long.
inline constexpr Index kMaxRingPoints = limit::kMaxEigenvalues;

/// Returns the number of points in the ring of a vertex: one for each entity that contains it.
Index ringPointsAt(const far::CellComplex& complex, Index vertex) {
    std::size_t count = 0;
    for (int d = 0; d <= complex.dimension(); ++d) count += complex.relation(0, d)[vertex].size();
    return static_cast<Index>(count);
}

/// Returns the total number of corners of the cells at a vertex. All these cells are refined to
/// compute its ring.
Offset cornersAt(const far::CellComplex& complex, Index vertex) {
    Offset count = 0;
    for (const Index cell : complex.relation(0, 3)[vertex])
        count += std::ssize(complex.relation(3, 0)[cell]);
    return count;
}

Smoothness smoothnessOf(const Entity& entity, const far::Level& level, Index vertex,
                        const far::RefinerOptions& options) {
    constexpr std::size_t kMaxEigenvalues = 6;
    Smoothness result{entity, level.strata.of({0, vertex}), ringPointsAt(level.complex, vertex)};
    if (result.ringPoints > kMaxRingPoints || cornersAt(level.complex, vertex) > kMaxRingPoints)
        return result;
    const auto ring = limit::ringOf(level, options, vertex);
    auto values = limit::eigenvalues(ring);
    values.erase(values.begin());
    values.resize(std::min(values.size(), kMaxEigenvalues));
    result.isKnown = true;
    result.eigenvalues = std::move(values);
    const Eigen::VectorXd mask = limit::limitMask(ring);
    for (std::size_t i = 0; i < ring.entities.size(); ++i)
        result.mask[ring.entities[i].dimension] += mask[static_cast<Eigen::Index>(i)];
    return result;
}

/// Reports each vertex, then each edge, of level 0 whose ring is not regular, in ascending order.
/// An edge is represented by its new point, since all later points on the edge have the same ring.
/// \cost O(n³) for each ring of n points, with n up to kMaxRingPoints
std::vector<Smoothness> reportSmoothness(const far::TopologyRefiner& lattice) {
    far::TopologyRefiner refiner(lattice.level(0), lattice.options());
    refiner.refineUniform(1);
    const far::Level& level = refiner.level(1);
    std::vector<std::pair<Entity, Index>> irregular;
    for (int d = 0; d <= 1; ++d)
        for (Index index = 0; index < refiner.level(0).complex.count(d); ++index) {
            const Entity entity{d, index};
            const auto point = refiner.refinement(1).childOf({entity, entity});
            if (point && !level.strata.isOpen(*point) &&
                !embed::isRegularVertex(level, point->index))
                irregular.emplace_back(entity, point->index);
        }
    std::vector<Smoothness> result(irregular.size());
    parallelFor(std::ssize(irregular), 1, [&](Offset first, Offset last) {
        for (Offset i = first; i < last; ++i) {
            const auto& [entity, vertex] = irregular[i];
            result[i] = smoothnessOf(entity, level, vertex, refiner.options());
        }
    });
    return result;
}

/// Returns the text for a ring that is too large to compute its eigenvalues.
std::string noteOf(const Smoothness& entry) {
    if (entry.ringPoints > kMaxRingPoints)
        return fmt::format("eigenvalues are not computed: its ring has {} points; the most is {}",
                           entry.ringPoints, kMaxRingPoints);
    return fmt::format("eigenvalues are not computed: its cells have more than {} vertices",
                       kMaxRingPoints);
}

SortedJson toJson(const std::vector<Smoothness>& entries) {
    SortedJson list = SortedJson::array();
    for (const Smoothness& entry : entries) {
        SortedJson values = SortedJson::array();
        for (const auto& value : entry.eigenvalues) values.push_back({value.real(), value.imag()});
        SortedJson object = {{dimensionName(entry.entity.dimension), entry.entity.index},
                             {"stratum", kStrata[entry.stratum]},
                             {"ring_points", entry.ringPoints},
                             {"eigenvalues", values},
                             {"limit_mask", entry.mask}};
        if (!entry.isKnown) {
            object["eigenvalues"] = nullptr;
            object["limit_mask"] = nullptr;
            object["note"] = noteOf(entry);
        }
        list.push_back(std::move(object));
    }
    return list;
}

/// Returns values and their counts as text: "3: 8, 4: 12".
std::string toText(const SortedJson& histogram, const char* prefix = "") {
    Histogram counts;
    for (const auto& [value, count] : histogram.items()) counts[std::stoi(value)] = count;
    std::string text;
    for (const auto& [value, count] : counts)
        text += fmt::format("{}{}{}: {}", text.empty() ? "" : ", ", prefix, value, count);
    return text.empty() ? "none" : text;
}

void printLevel(std::size_t number, const SortedJson& level) {
    const auto real = [&](const char* key) { return level[key].get<double>(); };
    fmt::print("\nlevel {}\n", number);
    for (std::size_t d = 0; d < 4; ++d) {
        const char* const name = kNamesOfParts[d];
        fmt::print("  {:<9} {:>9}   ", name, level["counts"][name].get<Index>());
        for (std::size_t s = d; s < 4; ++s)
            fmt::print(" {} {:<8}", kStrata[s], level["strata"][name][kStrata[s]].get<Index>());
        fmt::print("\n");
    }
    fmt::print("  Euler characteristic      {}\n", level["euler_characteristic"].get<Index>());
    fmt::print("  edges at a vertex         {}\n", toText(level["vertex_valences"]));
    fmt::print("  faces at an interior edge {}\n", toText(level["interior_edge_valences"]));
    fmt::print("  {} {}\n", number == 0 ? "edges at a cell's corner " : "cell types               ",
               toText(level["cell_types"], number == 0 ? "" : "type-"));
    fmt::print("  cell volumes              {:.4g} to {:.4g}, {} cells flat or inverted\n",
               real("smallest_cell_volume"), real("largest_cell_volume"),
               level["inverted_cells"].get<Index>());
    fmt::print(
        "  worst corner of a cell    {:.3f} (scaled Jacobian: 1 cube, 0 flat, below 0 folded)\n",
        real("smallest_scaled_jacobian"));
}

void printText(const SortedJson& report, const InfoOptions& options) {
    fmt::print("{}\n", printable(options.lattice));
    fmt::print("{}",
               boundsText({report["bounds"][0].get<Point3>(), report["bounds"][1].get<Point3>()}));
    fmt::print("marks       {} edges and vertices with a sharpness set by hand\n",
               report["marks"].get<std::size_t>());
    std::string attributes;
    for (const auto& name : report["attributes"])
        attributes += (attributes.empty() ? "" : ", ") + printable(name.get<std::string>());
    fmt::print("attributes  {}\n", attributes.empty() ? "none" : attributes);
    const auto edgesOfTwoFaces = report["interior_edges_of_two_faces"].get<Index>();
    if (edgesOfTwoFaces > 0 && options.common.rules == far::Rules::Siggraph96)
        fmt::print(
            "note        {} of the interior edges have only two faces: their new points have a "
            "negative "
            "weight, and the refined lattice may leave the convex hull there\n",
            edgesOfTwoFaces);
    if (const auto& cells = report["cells_bad_at_rest"]; !cells.empty())
        fmt::print(
            "folds       {} of {} cells are flat, folded or inside out after one refinement "
            "(first: "
            "cell {}). A point there may be in several cells or in none\n",
            cells.size(), report["levels"][0]["counts"]["cells"].get<Index>(),
            cells.front().get<Index>());
    fmt::print(
        "\nRows count by place: at corners, on sharp edges, on the boundary surface, in the "
        "interior.\n"
        "\"3: 8, 4: 12\" means 3 at 8 places and 4 at 12. A type-n cell has 2n faces; type-3 is a "
        "hexahedron.\n");
    for (std::size_t level = 0; level < report["levels"].size(); ++level)
        printLevel(level, report["levels"][level]);
}

std::string toText(const std::complex<double>& value) {
    // An imaginary part below this is rounding: the matrix is not symmetric.
    constexpr double kReal = 1e-9;
    if (std::abs(value.imag()) < kReal) return fmt::format("{:.4f}", value.real());
    return fmt::format("{:.4f}{:+.4f}i", value.real(), value.imag());
}

void printSmoothness(const std::vector<Smoothness>& entries) {
    fmt::print("\nsmoothness: as smooth as the tricubic B-spline {}\n",
               entries.empty() ? "everywhere" : "except at");
    for (const Smoothness& entry : entries) {
        if (!entry.isKnown) {
            fmt::print("  {:<6} {:>6}  {:<8}  {}\n", dimensionName(entry.entity.dimension),
                       entry.entity.index, kStrata[entry.stratum], noteOf(entry));
            continue;
        }
        std::vector<std::string> values;
        for (const auto& value : entry.eigenvalues) values.push_back(toText(value));
        fmt::print("  {:<6} {:>6}  {:<8}  eigenvalues of refinement 1 {}\n",
                   dimensionName(entry.entity.dimension), entry.entity.index,
                   kStrata[entry.stratum], fmt::join(values, " "));
        fmt::print(
            "  {:25}weights of its limit: itself {:.4f}, edges {:.4f}, faces {:.4f}, cells "
            "{:.4f}\n",
            "", entry.mask[0], entry.mask[1], entry.mask[2], entry.mask[3]);
    }
}

void printJson(const SortedJson& report) {
    // ASCII only, since names come from files; a byte that is not UTF-8 becomes U+FFFD.
    fmt::print("{}\n", report.dump(2, ' ', true, SortedJson::error_handler_t::replace));
}

/// The contents of the file that `info` describes: a lattice or a model.
struct DescribedFile {
    std::optional<Lattice> lattice;
    std::unique_ptr<io::Model> model;
    io::ReadNotes notes;
};

/// Reads a lattice or a model. A file that can be both is a model if it has no cells of a volume,
/// or with --model. A mesh of a simulation is a model unless an option asks for its levels: as a
/// lattice of a million cells, it takes 12 GB.
DescribedFile readDescribed(const InfoOptions& options) {
    const std::filesystem::path path = io::modelFile(options.lattice);
    DescribedFile result;
    if (io::isFileOf(io::FileContent::BoundModel, path)) {
        result.model = io::modelOf(io::readBoundModel(path), path);
        return result;
    }
    const bool isModel = io::isFileOf(io::FileContent::Model, path);
    const bool isLattice = io::isFileOf(io::FileContent::Lattice, path);
    if (!isModel && !isLattice)
        throw io::FileError(path, "is not of a known format; expected a model: " +
                                      filesToRead(io::FileContent::Model) +
                                      "; or a lattice: " + filesToRead(io::FileContent::Lattice));
    const bool isMesh = io::isMeshFile(path) && !options.asLattice();
    std::string bytes = io::readModelBytes(path);
    if (!isModel || (isLattice && !options.asModel && !isMesh)) {
        try {
            result.lattice = io::readLattice(path, bytes, &result.notes);
            return result;
        } catch (const far::TopologyError& error) {
            if (!isModel || error.cause() != far::TopologyCause::EmptyComplex) throw;
        }
    }
    result.model = io::readModel(path, std::move(bytes));
    return result;
}

void runModelInfo(const InfoOptions& options, const io::Model& model, Stages& stages) {
    if (options.smoothness)
        throw io::FileError(options.lattice, "is a model; --smoothness needs a lattice");
    tellNotes(options.lattice, model, options.common);
    const SortedJson report =
        stages.run("measuring", [&] { return reportModel(options.lattice, model); });
    if (options.json)
        printJson(report);
    else if (!options.common.quiet)
        fmt::print("{}", modelText(report));
}

void runInfo(const InfoOptions& options) {
    Job job(options.common, {{"FILE", options.lattice}});
    Stages& stages = job.stages();
    const DescribedFile described =
        stages.read(options.lattice, [&] { return readDescribed(options); });
    if (!described.lattice) {
        runModelInfo(options, *described.model, stages);
        return;
    }
    const Lattice& lattice = *described.lattice;
    printNotes(options.lattice, described.notes);
    const auto refiner = stages.run("refining", [&] {
        return refineLattice(options.lattice, lattice, options.common, options.level);
    });
    SortedJson report =
        stages.run("measuring", [&] { return reportLattice(options.lattice, lattice, refiner); });
    std::vector<Smoothness> smoothness;
    if (options.smoothness)
        smoothness = stages.run("finding eigenvalues", [&] { return reportSmoothness(refiner); });
    if (options.json) {
        if (options.smoothness) report["smoothness"] = toJson(smoothness);
        printJson(report);
    } else if (!options.common.quiet) {
        printText(report, options);
        if (options.smoothness) printSmoothness(smoothness);
    }
}

}  // namespace

void addInfoCommand(CLI::App& program) {
    const auto [command, options] =
        addCommand(program, "info",
                   "Print what a model, or a lattice and its levels, consist of: "
                   "counts, bounds, sharp parts, valences, cell quality",
                   runInfo);
    addLatticeOptions(command, FileKind::Lattice, options);
    addStrictOption(command, options.common);
    options.levels = command.get_option("-n");
    command.get_option("LATTICE")->description(
        "A lattice: " + filesToRead(io::FileContent::Lattice) +
        "; a model: " + filesToRead(io::FileContent::Model) +
        "; or a bound model: .espb. A file that may be either is a lattice if it has cells of a "
        "volume; but a mesh of a simulation is a model, with its cells, patches and quality, "
        "unless "
        "-n or --smoothness is given");
    command.add_flag("--model", options.asModel,
                     "Describe a file that may be either as a model, whatever cells it has");
    command.add_flag("--json", options.json, "Print JSON");
    command.add_flag("--smoothness", options.smoothness,
                     "Also print how smooth the limit is at each irregular vertex and edge: the "
                     "largest eigenvalues of refinement, and the weights of the limit point");
}

}  // namespace espalier::cli
