// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>
#include <espalier/base/bounding_box.h>
#include <espalier/base/error.h>
#include <espalier/base/number_text.h>
#include <espalier/base/progress.h>
#include <espalier/cages/cage.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fit_cage.h"
#include "frames.h"
#include "grid_cells.h"
#include "model_samples.h"
#include "model_surface.h"
#include "model_voxels.h"
#include "symmetry.h"
#include "work.h"

namespace espalier::cages {
namespace {

/// Range of the number of vertices, as a fraction of the wanted number.
constexpr double kLeast = 0.8, kMost = 1.2;

/// Range at which the search for a size of cells stops.
constexpr double kWantedLeast = 0.94, kWantedMost = 1.04;

/// Largest number of vertices that can be asked for.
constexpr Index kMaxVertices = 100000;

/// Range of the diagonal of the box around a model. The energy of a fit has sixth powers of the
/// edges of cells, which a double can hold then.
constexpr double kMinDiagonal = 1e-40, kMaxDiagonal = 1e40;

/// Largest coordinates of a model, in diagonals. Then the rounding of a coordinate is less than a
/// tenth of the distance between samples. The samples of a line are closest: 3e-7 diagonals apart.
constexpr double kMaxDistance = 1e8;

/// The number of vertices grows about as this power of 1 / size.
constexpr double kPower = 2.4;

/// A choice of cells. If no lattice of one choice can be fitted, the next one is tried, from tight
/// to careful. The last one makes cells for a few points, which are in few voxels.
struct CellChoice {
    /// Parts of a model in one cell or in two neighbours are joined if they are nearer than this,
    /// in edges.
    double joinDistance;
    double reach;  ///< a cell is left out if the model reaches less than this into it, in edges
    int attempts;  ///< maximum number of attempts of fitCage()
    double padding = 0;  ///< cells reach at least this far around the model, in its diagonals
};
constexpr std::array<CellChoice, 4> kCellChoices = {
    {{0.75, 0.4, 2}, {2, 0.2, 3}, {2, 0, 4}, {2, 0, 4, 0.1}}};
constexpr std::array<CellChoice, 2> kCellChoicesApart = {{{0, 0.4, 3}, {0, 0.1, 4}}};

/// If a lattice that is symmetric about planes that the model has by itself is not found with the
/// first kSymmetricChoices choices of cells, or within this fraction of the work, other planes are
/// tried.
constexpr std::size_t kSymmetricChoices = 2;
constexpr double kWorkOfSymmetry = 0.75;

/// Lattices of one choice that are fitted before the next choice is tried.
constexpr std::size_t kMaxFits = 3;

/// Voxels along the edge of a cell; fewer if there would be too many voxels.
constexpr Index kVoxelsPerEdge = 8;

/// Least numbers of voxels that show the gaps between parts that stay separate: along the edge of a
/// cell, and along the diagonal of the box around the model.
constexpr Index kVoxelsPerEdgeApart = 24;
constexpr double kVoxelsAcrossApart = 100;

constexpr double kMaxVoxels = 2.5e7;

/// Rounds of a fit with a margin: the start is further away.
constexpr int kRoundsWithMargin = 14;

/// Work for a voxel of the box around a model, which has a bit: most of them are empty.
constexpr double kPerVoxel = 0.5;

/// Returns the limit of the work, in steps (work.h). Before fits that are lost ended early, of the
/// cages of docs/cages.md and of other options, 100 vertices took at most 5.7e9 steps of 5.8e9
/// (twelve shells in one another), 200 vertices 5.8e9 of 7.5e9 (random triangles), and 2,000
/// vertices 3.1e10 of 4.5e10 (a hollow body). With parts kept apart, the most was 4.9e9 of 5.4e9.
/// Parts of a tangle cannot be kept apart; the smaller limit ends the search for them earlier.
double mostWork(std::size_t triangles, const CageOptions& options, Index vertices) {
    return (options.keepApart ? 1.2e9 : 3.3e9) + 2.1e7 * vertices +
           std::min(2.5e5 * static_cast<double>(triangles), 1.5e10);
}

/// Returns the number of samples above which samples that are near others are left out.
std::size_t mostSamples(std::size_t triangles, std::size_t vertices) {
    return 1'500'000 + 7 * triangles + 50 * vertices;
}

/// A grid to try.
struct Candidate {
    std::size_t frame = 0;
    double cellSize = 0;
    std::array<Index, 3> offset = {0, 0, 0};  ///< the offset of the grid, in halves of a cell
    Index vertexCount = 0;
    double score = 0;  ///< the lower the better
};

class CageMaker {
public:
    CageMaker(const SurfaceModel& model, const CageOptions& options);
    Lattice make(ModelSymmetry& symmetry);

private:
    double padding() const { return std::max(margin_, choice_.padding * diagonal_); }
    std::vector<unsigned> planeChoices(const ModelSymmetry& symmetry) const;
    void choose(const CellChoice& choice);
    double voxelCount(const Frame& frame, double cellSize, Index perEdge) const;
    Index voxelsPerEdge(const Frame& frame, double cellSize) const;
    double smallestSize(const Frame& frame) const;
    ModelVoxels voxelsOf(const Frame& frame, double cellSize);
    GridCells cellsOf(const ModelVoxels& voxels, const Candidate& candidate);
    std::vector<Candidate> candidates();
    double ratioOf(Index vertexCount) const;
    double sizeFor(std::size_t frame, const std::array<Index, 3>& offset, double size, int rounds);
    void addCandidate(const ModelVoxels& voxels, Candidate candidate,
                      std::vector<Candidate>& found);
    Lattice fit(const Candidate& candidate);
    std::optional<Lattice> findLattice(std::span<const CellChoice> choices, std::string& failure);
    Index vertexEstimate() const;

    ModelSurface surface_;
    ModelSurface::Sizes sizes_ = surface_.sizes();
    CageOptions options_;
    std::vector<Frame> frames_;
    double diagonal_ = 0, margin_ = 0;
    double smallestSize_ = 0;  ///< the smallest size of cells
    CellChoice choice_;
    Work work_{0};
};

void requireNumber(double value, const char* name, double max) {
    if (!(value >= 0 && value <= max))
        throw ArgumentError("cage", name, textOf(value), "0 to " + textOf(max));
}

CageMaker::CageMaker(const SurfaceModel& model, const CageOptions& options)
    : surface_(model), options_(options) {
    if (options.vertices < 8 || options.vertices > kMaxVertices)
        throw ArgumentError("cage", "vertices", std::to_string(options.vertices),
                            concat("8 to ", kMaxVertices));
    requireNumber(options.cellSize, "cellSize", 1e90);
    requireNumber(options.margin, "margin", 1);
    const std::span<const Point3> points(surface_.points().data(), surface_.modelPointCount());
    diagonal_ = BoundingBox(points).diagonal();
    if (diagonal_ == 0) throw Error("all points of the model are at one place");
    if (diagonal_ < kMinDiagonal || diagonal_ > kMaxDiagonal)
        throw Error(concat("the diagonal of the model is ", textOf(diagonal_), "; expected ",
                           textOf(kMinDiagonal), " to ", textOf(kMaxDiagonal),
                           "; scale the model"));
    for (const Point3& point : points)
        for (const double coordinate : point)
            if (std::abs(coordinate) > kMaxDistance * diagonal_)
                throw Error(concat("a coordinate of the model is ", textOf(coordinate),
                                   ", too large for its diagonal of ", textOf(diagonal_),
                                   "; move the model to the origin"));
    requireNumber(options.shell, "shell", 2 * diagonal_);
    requireNumber(options.symmetry, "symmetry", 1);
    margin_ = options.margin * diagonal_ + options.shell / 2;
    frames_.push_back({shapes::kCoordinateAxes, surface_.points(), {}});
    choose(kCellChoices.front());
    if (options.cellSize > 0 && options.cellSize < smallestSize_)
        throw ArgumentError("cage", "cellSize", textOf(options.cellSize),
                            concat("at least ", smallestSize_, " for this model"));
}

void CageMaker::choose(const CellChoice& choice) {
    choice_ = choice;
    // At least two voxels along each edge, in memory for kMaxVoxels.
    smallestSize_ = 0;
    for (const Frame& frame : frames_) smallestSize_ = std::max(smallestSize_, smallestSize(frame));
}

/// Returns the number of voxels in the box around the model.
double CageMaker::voxelCount(const Frame& frame, double cellSize, Index perEdge) const {
    double count = 1;
    for (int axis = 0; axis < 3; ++axis)
        count *= (frame.size[axis] + 2 * padding()) / cellSize * perEdge + perEdge + 4;
    return count;
}

Index CageMaker::voxelsPerEdge(const Frame& frame, double cellSize) const {
    Index perEdge = kVoxelsPerEdge;
    if (options_.keepApart)
        perEdge = static_cast<Index>(std::max<double>(
            kVoxelsPerEdgeApart, std::ceil(kVoxelsAcrossApart * cellSize / diagonal_)));
    // A plane of symmetry may be in the middle of a cell: then the number is even.
    const Index step = frame.isSymmetric() ? 2 : 1;
    perEdge += perEdge % step;
    while (perEdge > 2 && voxelCount(frame, cellSize, perEdge) > kMaxVoxels) perEdge -= step;
    return perEdge;
}

/// Returns the least size of cells that two voxels along an edge allow.
double CageMaker::smallestSize(const Frame& frame) const {
    double low = 1e-9 * (diagonal_ + padding()), high = 2 * (diagonal_ + padding());
    for (int round = 0; round < 60; ++round) {
        const double middle = std::sqrt(low * high);
        (voxelCount(frame, middle, 2) > kMaxVoxels ? low : high) = middle;
    }
    return high;
}

ModelVoxels CageMaker::voxelsOf(const Frame& frame, double cellSize) {
    const double size = cellSize / voxelsPerEdge(frame, cellSize);
    constexpr double kPerTriangle = 200, kPerMark = 50;
    const double marks = sizes_.area / (size * size) + sizes_.perimeter / size;
    work_.add(kPerVoxel * voxelCount(frame, cellSize, voxelsPerEdge(frame, cellSize)) +
              kPerTriangle * static_cast<double>(surface_.triangles().size()) + kPerMark * marks);
    return {surface_,
            frame.points,
            {.size = size,
             .isShell = options_.shell > 0,
             .around = padding(),
             .gap = cellSize / 2,
             .mirrors = frame.mirrors}};
}

GridCells CageMaker::cellsOf(const ModelVoxels& voxels, const Candidate& candidate) {
    constexpr double kPerUsedVoxel = 100;
    work_.add(kPerVoxel * voxels.grid().cubeCount() +
              kPerUsedVoxel * static_cast<double>(voxels.used().count()));
    const Index k = voxelsPerEdge(frames_[candidate.frame], candidate.cellSize);
    std::array<Index, 3> offset;
    unsigned mirrorAxes = 0;
    for (int axis = 0; axis < 3; ++axis) {
        offset[axis] = candidate.offset[axis] * k / 2;
        if (!frames_[candidate.frame].mirrors[axis]) continue;
        // The plane is between two cells, or in the middle of one.
        mirrorAxes |= 1u << axis;
        offset[axis] += k - voxels.grid().counts[axis] / 2 % k;
        offset[axis] %= k;
    }
    return {voxels,
            {.voxelsPerEdge = k,
             .offset = offset,
             .joinDistance = std::max(1.0, choice_.joinDistance * k),
             .reach = choice_.reach * k,
             .mirrorAxes = mirrorAxes}};
}

/// Returns the number of vertices that bounds the work: the wanted one, or all cells of the given
/// size in the box around the model.
Index CageMaker::vertexEstimate() const {
    if (options_.cellSize == 0) return options_.vertices;
    return static_cast<Index>(
        std::min<double>(kMaxVertices, voxelCount(frames_.front(), options_.cellSize, 1)));
}

double CageMaker::ratioOf(Index vertexCount) const {
    return static_cast<double>(vertexCount) / options_.vertices;
}

/// Returns a size of cells for which the number of vertices is about the wanted one. It may not be
/// found: the number of vertices is not a continuous function of the size.
/// \param offset in halves of a cell
/// \param size the first size to try
double CageMaker::sizeFor(std::size_t frame, const std::array<Index, 3>& offset, double size,
                          int rounds) {
    double best = size, bestRatio = 0, last = size;
    double small = 0, large = 0;  // sizes with too many and with too few vertices
    for (int round = 0; round < rounds; ++round) {
        Candidate candidate{frame, size, offset};
        const double ratio =
            ratioOf(cellsOf(voxelsOf(frames_[frame], size), candidate).vertexCount());
        if (bestRatio == 0 || std::abs(std::log(ratio)) < std::abs(std::log(bestRatio))) {
            best = size;
            bestRatio = ratio;
        }
        if (ratio > kWantedLeast && ratio < kWantedMost) break;
        double& bound = ratio > 1 ? small : large;
        if (bound == 0 || (ratio > 1 ? size > small : size < large)) bound = size;
        size *= std::clamp(std::pow(ratio, 1 / kPower), 0.2, 5.0);
        if (small > 0 && large > 0 && (size <= small || size >= large))
            size = std::sqrt(small * large);
        // One cell of the largest size holds the model.
        const double next = std::clamp(size, smallestSize_, 1.2 * (diagonal_ + 2 * padding()));
        if (next == last) break;
        size = last = next;
    }
    return best;
}

/// Adds a candidate, unless its lattice is not fit for use.
void CageMaker::addCandidate(const ModelVoxels& voxels, Candidate candidate,
                             std::vector<Candidate>& found) {
    const GridCells cells = cellsOf(voxels, candidate);
    if (!cells.isManifold() || (options_.keepApart && cells.joined())) return;
    candidate.vertexCount = cells.vertexCount();
    const double ratio = ratioOf(candidate.vertexCount);
    if (options_.cellSize == 0 && (ratio < kLeast || ratio > kMost)) return;
    // Small cells with few vertices are best.
    candidate.score = candidate.cellSize * std::pow(ratio, 1 / kPower);
    found.push_back(candidate);
}

std::vector<Candidate> CageMaker::candidates() {
    const auto byScore = [](const Candidate& a, const Candidate& b) { return a.score < b.score; };
    std::vector<Candidate> found;
    for (std::size_t frame = 0; frame < frames_.size(); ++frame) {
        const double size = options_.cellSize > 0 ? options_.cellSize
                                                  : sizeFor(frame, {0, 0, 0}, diagonal_ / 4, 12);
        const ModelVoxels voxels = voxelsOf(frames_[frame], size);
        std::vector<Candidate> offsets;
        for (Index octant = 0; octant < 8; ++octant) {
            Candidate candidate{frame, size, {octant & 1, octant >> 1 & 1, octant >> 2}};
            if (options_.cellSize > 0) {
                addCandidate(voxels, candidate, found);
                continue;
            }
            candidate.score =
                std::pow(ratioOf(cellsOf(voxels, candidate).vertexCount()), 1 / kPower);
            offsets.push_back(candidate);
        }
        std::stable_sort(offsets.begin(), offsets.end(), byScore);
        std::size_t wanted = found.size() + kMaxFits;
        for (const Candidate& offset : offsets) {
            if (found.size() == wanted) break;
            Candidate candidate = offset;
            candidate.cellSize = sizeFor(frame, offset.offset, size * offset.score, 4);
            addCandidate(voxelsOf(frames_[frame], candidate.cellSize), candidate, found);
        }
    }
    std::stable_sort(found.begin(), found.end(), byScore);
    if (found.size() > kMaxFits) found.resize(kMaxFits);
    return found;
}

Lattice CageMaker::fit(const Candidate& candidate) {
    const Frame& frame = frames_[candidate.frame];
    Lattice start;
    std::vector<FitPoint> samples;
    std::vector<VertexMirror> mirrors;
    {
        const ModelVoxels voxels = voxelsOf(frame, candidate.cellSize);
        const GridCells cells = cellsOf(voxels, candidate);
        start = cells.build();
        for (int axis = 0; axis < 3; ++axis)
            if (const auto& plane = frame.mirrors[axis])
                mirrors.push_back(
                    {axis, *plane, unitOfMirror(*plane, diagonal_), cells.vertexImages(axis)});
        samples = sampleModel(surface_, voxels, cells,
                              {.spacing = candidate.cellSize / 8,
                               .isShell = options_.shell > 0,
                               .axes = frame.axes,
                               .most = mostSamples(surface_.triangles().size(), vertexEstimate())},
                              work_);
    }
    for (Point3& position : start.positions) position = fromFrame(frame.axes, position);
    return fitCage(std::move(start), std::move(samples),
                   {.margin = margin_,
                    .maxRounds = margin_ > 0 ? kRoundsWithMargin : FitOptions().maxRounds,
                    .maxAttempts = choice_.attempts,
                    .mirrors = std::move(mirrors)},
                   work_);
}

/// Names a point that is in no face, and so may be far from the faces by mistake.
std::string loosePointText(const ModelSurface& surface) {
    for (const Triangle& t : surface.triangles())
        if (t[0] == t[1] && t[1] == t[2])
            return concat("; the lattice must hold the point ", textOf(surface.points()[t[0]]),
                          ", too, which is in no face");
    return {};
}

/// Returns the first lattice that is proved; none if there is none.
/// \param failure gets the reason why the last one is not
std::optional<Lattice> CageMaker::findLattice(std::span<const CellChoice> choices,
                                              std::string& failure) {
    for (const CellChoice& choice : choices) {
        choose(choice);
        // Room around the model takes voxels, too.
        if (options_.cellSize > 0 && options_.cellSize < smallestSize_) continue;
        for (const Candidate& candidate : candidates()) {
            try {
                return fit(candidate);
            } catch (const FitError& error) {
                failure = error.what();
            }
        }
    }
    return std::nullopt;
}

/// Returns the planes about which the lattice is to be symmetric: the first choice, and others if
/// no lattice can be fitted. Bit a of a choice stands for the plane across axis a.
std::vector<unsigned> CageMaker::planeChoices(const ModelSymmetry& symmetry) const {
    constexpr unsigned kPlanes[] = {0, 0, 1, 2, 4, 3, 5, 6, 7};
    static_assert(std::size(kPlanes) == std::size(kSymmetricWords));
    if (options_.symmetric != Symmetric::Auto)
        return {kPlanes[static_cast<std::size_t>(options_.symmetric)]};
    unsigned all = 0;
    for (unsigned axis = 0; axis < 3; ++axis)
        if (symmetry.planes[axis].isOfModel) all |= 1u << axis;
    std::vector<unsigned> choices = {all};
    if (std::popcount(all) > 1)
        for (unsigned axis = 0; axis < 3; ++axis)
            if (all >> axis & 1) choices.push_back(1u << axis);
    if (all != 0) choices.push_back(0);
    return choices;
}

Lattice CageMaker::make(ModelSymmetry& symmetry) {
    symmetry = {};
    if (options_.symmetric != Symmetric::None) {
        symmetry.planes = measureSymmetry(surface_, options_.symmetry);
        symmetry.isMeasured = true;
    }
    const double most = mostWork(surface_.triangles().size(), options_, vertexEstimate());
    const std::span<const CellChoice> cells =
        options_.keepApart ? std::span<const CellChoice>(kCellChoicesApart) : kCellChoices;
    double workLeft = kWorkOfSymmetry * most;
    std::string failure, end;
    const auto choices = planeChoices(symmetry);
    for (std::size_t i = 0; i < choices.size(); ++i) {
        MirrorPlanes mirrors;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            symmetry.planes[axis].isUsed = choices[i] >> axis & 1;
            if (symmetry.planes[axis].isUsed) mirrors[axis] = symmetry.planes[axis].at;
        }
        // All searches before the last one share their work.
        const bool isLast = i + 1 == choices.size();
        work_ = Work(isLast ? most : workLeft);
        failure.clear();
        end.clear();
        try {
            frames_ = framesOf(surface_, mirrors);
            if (auto found = findLattice(isLast ? cells : cells.first(kSymmetricChoices), failure))
                return std::move(*found);
        } catch (const WorkError&) {
            end = concat(
                "; the search ended early, after the most work for a lattice of this size and ",
                surface_.triangles().size(), " triangles");
        }
        workLeft -= work_.done();
    }
    const std::string wanted = options_.cellSize > 0
                                   ? concat("with cells of the size ", textOf(options_.cellSize))
                                   : concat("of about ", options_.vertices, " vertices");
    throw Error(concat("found no lattice ", wanted, " that follows the model",
                       failure.empty() ? "" : "; the last one that was tried: ", failure, end,
                       loosePointText(surface_),
                       options_.cellSize > 0 ? "; try smaller cells" : "; try more vertices",
                       end.empty() ? "" : ", or a model of fewer faces that overlap",
                       options_.keepApart ? ", or without keeping parts apart" : "",
                       frames_.front().isSymmetric() ? ", or without symmetry" : ""));
}

}  // namespace

Lattice cage(const SurfaceModel& model, const CageOptions& options, ModelSymmetry* symmetry) {
    ModelSymmetry found;
    Lattice lattice = CageMaker(model, options).make(found);
    if (symmetry != nullptr) *symmetry = found;
    return lattice;
}

}  // namespace espalier::cages
