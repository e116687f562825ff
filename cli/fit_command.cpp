// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/bounding_box.h>
#include <espalier/base/error.h>
#include <espalier/base/printable.h>
#include <espalier/base/sort_unique.h>
#include <espalier/base/vector3.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/targets.h>
#include <espalier/shapes/held.h>
#include <espalier/solve/lattice_fit.h>
#include <espalier/solve/rigid_pull.h>
#include <espalier/solve/validity.h>
#include <espalier/stencils/composition.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "bind_model.h"
#include "commands.h"
#include "files.h"
#include "hold.h"
#include "job.h"
#include "run.h"
#include "run_report.h"

namespace espalier::cli {
namespace {

struct FitCommandOptions : BindOptions {
    std::string targets;
    std::vector<std::array<double, 6>> pulls;  ///< a place and a displacement each
    std::vector<Point3> pins;                  ///< places
    bool isStiff = false;
    std::vector<const CLI::Option*> ofLeastMovement;  ///< options of solve::fitLattice() alone
    std::optional<double> reach;
    bool noInverted = false;
    bool movesHeld = false;
    HoldOptions hold;
    std::optional<solve::Smoothing> smoothing;
    solve::FitOptions fit;
    std::string output;
    ReportFormat report = ReportFormat::Text;

    /// True if the cells stay rigid (solve::RigidPull), false for the least movement of vertices
    /// (solve::fitLattice()).
    bool bends() const {
        return !pulls.empty() && targets.empty() && !isStiff &&
               std::ranges::all_of(ofLeastMovement, &CLI::Option::empty);
    }
};

/// Points of a model, and their targets.
struct PointTargets {
    std::vector<Point3> points;
    std::vector<Point3> misses;       ///< target minus point
    std::vector<io::Target> targets;  ///< the targets; each has its line in the file, for messages
    std::vector<Index> pins = {};     ///< numbers of the targets of --pin; ascending

    void add(const Point3& point, const io::Target& target) {
        points.push_back(point);
        misses.push_back({target.position[0] - point[0], target.position[1] - point[1],
                          target.position[2] - point[2]});
        targets.push_back(target);
    }

    PointTargets select(std::span<const Index> rows) const {
        PointTargets selected;
        for (const Index row : rows) {
            selected.points.push_back(points[row]);
            selected.misses.push_back(misses[row]);
            if (std::ranges::binary_search(pins, row))
                selected.pins.push_back(static_cast<Index>(selected.targets.size()));
            selected.targets.push_back(targets[row]);
        }
        return selected;
    }
};

/// Adds a target for a --pull or a --pin: the point nearest to its place moves by a displacement.
/// \throws Error naming a point that has a target already
void addPull(const FitCommandOptions& options, const char* option, const Point3& place,
             const Point3& by, std::span<const Point3> points, PointTargets& pointTargets) {
    const auto distance = [&](const Point3& point) { return length(difference(point, place)); };
    const auto nearest = std::ranges::min_element(points, {}, distance);
    const auto number = static_cast<Index>(nearest - points.begin());
    const auto& [x, y, z] = place;
    // From farther away, rounding makes all points equally near. If all points are at one
    // place, they are equally near from anywhere, and the first is pulled.
    constexpr double kFarthest = 1e8;
    if (const double size = BoundingBox(points).diagonal();
        size > 0 && distance(*nearest) > kFarthest * size)
        throw Error(
            fmt::format("{} {} {} {}: the place is more than 1e8 times the size of the "
                        "model ({:.4g}) away from it, so that all points are equally near; "
                        "give a place near the point to pull",
                        option, x, y, z, size));
    for (const io::Target& target : pointTargets.targets)
        if (target.point == number)
            throw Error(
                fmt::format("{} {} {} {}: the nearest point is {}, which has a target "
                            "already",
                            option, x, y, z, number));
    pointTargets.add(*nearest, {number, sum(*nearest, by), 0});
    if (!options.common.quiet && options.report == ReportFormat::Text)
        fmt::print("{:<22}point {} at {:.6g} {:.6g} {:.6g}\n",
                   std::string_view(option) == "--pin" ? "pinned" : "pulled", number, (*nearest)[0],
                   (*nearest)[1], (*nearest)[2]);
}

/// Adds the targets of all --pull and --pin.
void addPulls(const FitCommandOptions& options, std::span<const Point3> points,
              PointTargets& pointTargets) {
    for (const auto& [x, y, z, dx, dy, dz] : options.pulls)
        addPull(options, "--pull", {x, y, z}, {dx, dy, dz}, points, pointTargets);
    for (const Point3& place : options.pins) {
        pointTargets.pins.push_back(static_cast<Index>(pointTargets.targets.size()));
        addPull(options, "--pin", place, {0, 0, 0}, points, pointTargets);
    }
}

PointTargets readPointTargets(const FitCommandOptions& options, const io::Model& model,
                              Stages& stages) {
    const auto points = model.positions();
    PointTargets pointTargets;
    if (options.targets.empty()) return pointTargets;
    if (io::isFileOf(io::FileContent::Targets, options.targets)) {
        const auto targets = stages.read(options.targets, [&] {
            return io::readTargets(options.targets, static_cast<Index>(points.size()));
        });
        for (const io::Target& target : targets) pointTargets.add(points[target.point], target);
        return pointTargets;
    }
    const auto wanted = readModel(options.targets, options.common, stages);
    io::refuseHeldPoints(options.targets, *wanted);
    if (wanted->positions().size() != points.size())
        throw io::FileError(options.targets, fmt::format("has {} points, but the model {} has {}",
                                                         wanted->positions().size(),
                                                         printable(options.model), points.size()));
    for (std::size_t i = 0; i < points.size(); ++i)
        pointTargets.add(points[i], {static_cast<Index>(i), wanted->positions()[i], 0});
    return pointTargets;
}

/// Rows of D for the points that have targets and for the held points.
struct FitRows {
    stencils::StencilTable<double> ofTargets, ofHeld;
    bind::BindingStatistics binding = {};  ///< of all these points
};

/// Returns the end of a message: why the row of a point in D is empty.
std::string whyNotCarried(const FitCommandOptions& options, embed::PointStatus status) {
    if (status != embed::PointStatus::Outside)
        return fmt::format("could not be placed in the lattice {}: its cell is degenerate",
                           printable(options.rest));
    const bool isTooFar = options.common.embedding.outside == embed::OutsidePolicy::Nearest;
    return fmt::format("lies outside the lattice {}{}", printable(options.rest),
                       isTooFar ? ", too far for the nearest cell to carry it" : "");
}

/// Throws an error of a target, which is in a line of --targets, in the model of --targets, or
/// comes from a --pull. \param line of the target; 0 if it has none
[[noreturn]] void throwOfTarget(const FitCommandOptions& options, std::size_t line,
                                const std::string& cause) {
    if (line > 0) throw io::FileError(options.targets, line, cause);
    if (!options.targets.empty()) throw io::FileError(options.targets, cause);
    throw Error("--pull: " + cause);
}

[[noreturn]] void refuseTarget(const FitCommandOptions& options, const io::Target& target,
                               embed::PointStatus status) {
    const std::string cause = fmt::format("point {} {}; the lattice cannot carry it to its target",
                                          target.point, whyNotCarried(options, status));
    throw target.line > 0 ? io::FileError(options.targets, target.line, cause)
                          : io::FileError(options.model, cause);
}

/// Returns the rows of the targets whose points move with the lattice. A point that does not move
/// with it is left out if its target is its own position, unless --outside error is given. \throws
/// FileError for other points that do not move with the lattice, and if no target is left
std::vector<Index> carriedTargets(const FitCommandOptions& options, const bind::Binding& bound,
                                  const PointTargets& pointTargets) {
    const bool isOutsideRefused = options.common.embedding.outside == embed::OutsidePolicy::Error;
    std::vector<Index> carried;
    for (std::size_t i = 0; i < pointTargets.targets.size(); ++i) {
        const auto row = static_cast<Index>(i);
        if (!bound.table.columns(row).empty())
            carried.push_back(row);
        else if (isOutsideRefused || pointTargets.misses[i] != Point3{})
            refuseTarget(options, pointTargets.targets[i], bound.statuses[i]);
    }
    if (carried.empty())
        throwOfTarget(
            options, 0,
            fmt::format("no target is left: all {} points lie outside the lattice {}, and "
                        "their targets are where they are already",
                        pointTargets.targets.size(), printable(options.rest)));
    return carried;
}

/// Cells of a level that a pose turns inside out.
struct FoldCount {
    std::size_t inverted = 0;
    Index cells = 0;  ///< of the level
    int level = 0;
};

/// Counts the cells that a pose turns inside out, on the level of the points; in the limit on level
/// 3. Empty unless refined cells move the points.
std::optional<FoldCount> countFolds(const FitCommandOptions& options, const Lattice& lattice,
                                    std::span<const Point3> displacements) {
    if (options.basis) return {};
    constexpr int kLimitLevel = 3;
    const int level = options.limit ? kLimitLevel : options.level;
    const auto refiner = refineLattice(options.rest, lattice, options.common, level);
    std::vector<Point3> pose;
    for (std::size_t v = 0; v < displacements.size(); ++v)
        pose.push_back(sum(lattice.positions[v], displacements[v]));
    const auto& complex = refiner.level(level).complex;
    const solve::ValidityCheck check(complex,
                                     stencils::refinePositions(refiner, level, lattice.positions));
    const auto validity = check.check(stencils::refinePositions(refiner, level, pose));
    return FoldCount{validity.inverted.size(), complex.count(3), level};
}

/// The result of a fit, of one of the two kinds.
struct FitResult {
    solve::LatticeFit fit;
    Index fixedCount = 0;           ///< the vertices that a pull that bends keeps in place
    std::optional<int> iterations;  ///< of a pull that bends
    bool meetsBarrier = false;      ///< the pull would fold cells without the barrier
    std::optional<FoldCount> folds = {};
};

/// Fits the lattice. An error in a target names its point, and the file and line of the target.
FitResult fitNamingTargets(const FitCommandOptions& options, const FitRows& rows,
                           const PointTargets& pointTargets, const Lattice& lattice,
                           const solve::FitOptions& fitOptions) {
    try {
        if (!options.bends())
            return {
                solve::fitLattice(rows.ofTargets, pointTargets.misses, lattice.complex, fitOptions),
                0,
                {}};
        solve::RigidPullOptions pull{.frozen = fitOptions.frozen, .pins = pointTargets.pins};
        if (options.reach) pull.reach = *options.reach;
        const solve::RigidPull rigid(lattice.complex, lattice.positions, rows.ofTargets, pull);
        const auto pose = rigid.solve(pointTargets.misses);
        return {{pose.displacements, pose.largestMiss, pose.rmsMiss, 1},
                static_cast<Index>(rigid.fixedVertices().size()),
                pose.iterations,
                pose.meetsBarrier};
    } catch (const solve::TargetError& error) {
        const io::Target& target = pointTargets.targets[error.row()];
        throwOfTarget(options, target.line,
                      fmt::format("the target of point {} is too far from the point: the square of "
                                  "the distance overflows",
                                  target.point));
    }
}

/// Binds the points that have targets and the held points at once. A point that is both is bound
/// once. Removes from `pointTargets` the targets that carriedTargets() leaves out.
FitRows bindAll(const FitCommandOptions& options, const BindOptions& bind,
                PointTargets& pointTargets, const HeldPart& part,
                std::span<const Point3> modelPoints, const Lattice& lattice, Stages& stages) {
    std::vector<Point3> points = pointTargets.points;
    std::vector<Index> heldRows;
    if (!part.points.empty()) {
        std::unordered_map<Index, Index> rowOf;
        for (std::size_t i = 0; i < pointTargets.targets.size(); ++i)
            rowOf.emplace(pointTargets.targets[i].point, static_cast<Index>(i));
        for (const Index point : part.points) {
            const auto [row, isNew] = rowOf.emplace(point, static_cast<Index>(points.size()));
            if (isNew) points.push_back(modelPoints[point]);
            heldRows.push_back(row->second);
        }
    }
    auto bound = bindPoints(bind, points, lattice, stages);
    const bind::BindingStatistics statistics = bind::statisticsOf(bound);
    const auto carried = carriedTargets(options, bound, pointTargets);
    stencils::StencilTable<double>& table = bound.table;
    FitRows rows{{}, stencils::selectRows<double>(table, heldRows)};
    if (options.common.embedding.outside == embed::OutsidePolicy::Error)
        for (std::size_t i = 0; i < part.points.size(); ++i)
            if (rows.ofHeld.columns(static_cast<Index>(i)).empty())
                throw io::FileError(
                    options.model,
                    fmt::format("point {}, in the box of --hold, {}", part.points[i],
                                whyNotCarried(options, bound.statuses[heldRows[i]])));
    rows.ofTargets = carried.size() == points.size() ? std::move(table)
                                                     : stencils::selectRows<double>(table, carried);
    if (carried.size() < pointTargets.targets.size()) pointTargets = pointTargets.select(carried);
    rows.binding = statistics;
    return rows;
}

/// Returns how many different vertices of the lattice are listed. Other numbers are ignored here:
/// solve::fitLattice() refuses them.
Offset countAmong(std::vector<Index> vertices, const Lattice& lattice) {
    sortUnique(vertices);
    return std::ranges::count_if(
        vertices, [&](Index vertex) { return vertex >= 0 && vertex < lattice.complex.count(0); });
}

/// Returns the vertices of --freeze and --hold, and the held ones of the lattice.
/// \throws Error if these are all vertices of the lattice
std::vector<Index> frozenVertices(const FitCommandOptions& options, const std::vector<Index>& held,
                                  const Lattice& lattice) {
    const auto& named = options.fit.frozen;
    std::vector<Index> frozen = named;
    frozen.insert(frozen.end(), held.begin(), held.end());
    if (!options.movesHeld) frozen = shapes::frozenWithHeld(lattice, frozen);
    const Offset all = std::ssize(lattice.positions);
    if (countAmong(frozen, lattice) < all) return frozen;
    throw Error(fmt::format("{} all {} vertices of {}: no vertex is left to move",
                            countAmong(held, lattice) == all    ? "--hold keeps"
                            : countAmong(named, lattice) == all ? "--freeze keeps"
                            : options.movesHeld || shapes::heldVertices(lattice).empty()
                                ? "--hold and --freeze keep"
                                : "--hold, --freeze and the lattice, which holds vertices, keep",
                            all, printable(options.rest)));
}

/// Returns the number of vertices that --hold and the lattice keep.
std::size_t keptByBoxOrLattice(const FitCommandOptions& options, const std::vector<Index>& held,
                               const Lattice& lattice) {
    return options.movesHeld ? held.size() : shapes::frozenWithHeld(lattice, held).size();
}

/// Returns the largest distance of a point from its target before the fit.
double longestWay(const PointTargets& pointTargets) {
    double longest = 0;
    for (const Point3& miss : pointTargets.misses) longest = std::max(longest, length(miss));
    return longest;
}

/// \param leftOut number of targets that carriedTargets() leaves out
void printFit(const FitCommandOptions& options, const PointTargets& pointTargets,
              std::size_t leftOut, std::size_t heldCount, const FitResult& result) {
    const solve::LatticeFit& fit = result.fit;
    double largest = 0;
    for (const Point3& displacement : fit.displacements)
        largest = std::max(largest, length(displacement));
    if (options.report == ReportFormat::Json) {
        OrderedJson json = {
            {"targets", pointTargets.targets.size()},
            {"left_out", leftOut},
            {"held_vertices", heldCount},
            {"largest_miss", fit.largestMiss},
            {"rms_miss", fit.rmsMiss},
            {"largest_displacement", largest},
            // JSON has no infinity.
            {"condition", std::isinf(fit.condition) ? OrderedJson() : OrderedJson(fit.condition)}};
        if (result.iterations) {
            json.erase("condition");
            json["fixed_vertices"] = result.fixedCount;
            json["iterations"] = *result.iterations;
            json["held_back"] = result.meetsBarrier;
        }
        if (result.folds) json["folded_cells"] = result.folds->inverted;
        fmt::print("{}\n", json.dump(2));
        return;
    }
    fmt::print("targets               {}\n", pointTargets.targets.size());
    if (leftOut > 0)
        fmt::print("targets left out      {}: points outside the lattice that are to stay\n",
                   leftOut);
    if (options.hold.box || heldCount > 0) fmt::print("vertices held         {}\n", heldCount);
    fmt::print("largest distance      {:.3g} from a target\n", fit.largestMiss);
    fmt::print("root mean square      {:.3g} of these distances\n", fit.rmsMiss);
    fmt::print("largest displacement  {:.3g} of a lattice vertex\n", largest);
    if (result.iterations)
        fmt::print(
            "rigid cells           {} iterations; {} of {} vertices stay; --reach keeps more or "
            "fewer\n",
            *result.iterations, result.fixedCount, fit.displacements.size());
    else if (std::isinf(fit.condition))
        fmt::print(
            "undetermined          the targets leave vertices free, which move as little as "
            "possible; --smoothing chooses otherwise\n");
    else
        fmt::print("condition number      {:.3g}\n", fit.condition);
    if (result.meetsBarrier)
        fmt::print(
            "held back             cells would fold: they stay open, {:.3g} of the way from a "
            "target; pull less far, or let more move with --reach\n",
            fit.largestMiss / longestWay(pointTargets));
    if (result.folds)
        fmt::print(
            "folded cells          {} of {} of level {}{}\n", result.folds->inverted,
            result.folds->cells, result.folds->level,
            result.folds->inverted == 0
                ? ""
                : "; pull less far, or let more move with --reach; espalier check names them");
    else if (!options.pulls.empty())
        fmt::print("folded cells          not checked under a basis\n");
}

void runFit(const FitCommandOptions& options) {
    checkBasis(options);
    if (options.targets.empty() && options.pulls.empty())
        throw CLI::ValidationError("--targets or --pull is required: where the points should go");
    Job job(options.common,
            {{"MODEL", options.model}, {"--rest", options.rest}, {"--targets", options.targets}});
    job.writesLattice(options.output);
    Stages& stages = job.stages();
    const auto model = readModel(options.model, options.common, stages);
    Lattice lattice = readLattice(options.rest, stages);
    PointTargets pointTargets = readPointTargets(options, *model, stages);
    addPulls(options, model->positions(), pointTargets);
    const std::size_t readCount = pointTargets.targets.size();
    const auto points = model->positions();
    const HeldPart part = findHeldPart(options.hold, options, points, lattice);
    // bindAll() refuses points outside itself: it knows their numbers in the model.
    BindOptions bind = options;
    if (bind.common.embedding.outside == embed::OutsidePolicy::Error)
        bind.common.embedding.outside = embed::OutsidePolicy::Keep;
    const FitRows rows = bindAll(options, bind, pointTargets, part, points, lattice, stages);
    const auto held = heldVertices(part, options.hold, bind, points, rows.ofHeld, lattice, stages);
    solve::FitOptions fitOptions = options.fit;
    fitOptions.frozen = frozenVertices(options, held, lattice);
    fitOptions.smoothing = options.smoothing.value_or(
        options.pulls.empty() ? solve::Smoothing::None : solve::Smoothing::Tikhonov);
    auto result = stages.run("solving", [&] {
        return fitNamingTargets(options, rows, pointTargets, lattice, fitOptions);
    });
    if (!options.pulls.empty())
        result.folds = stages.run("checking cells", [&] {
            return countFolds(options, lattice, result.fit.displacements);
        });
    if (options.noInverted && result.folds && result.folds->inverted > 0)
        throw FailedCheck(fmt::format(
            "--no-inverted: the pose turns {} of {} cells of level {} inside out; nothing is "
            "written. Pull less far, or let more move with --reach",
            result.folds->inverted, result.folds->cells, result.folds->level));
    for (std::size_t v = 0; v < lattice.positions.size(); ++v)
        for (std::size_t c = 0; c < 3; ++c)
            lattice.positions[v][c] += result.fit.displacements[v][c];
    stages.run("writing", [&] { io::writeLattice(options.output, lattice); });
    if (!options.common.quiet)
        printFit(options, pointTargets, readCount - pointTargets.targets.size(),
                 keptByBoxOrLattice(options, held, lattice), result);
    warnOfPointsOutside(rows.binding, options.common);
}

}  // namespace

void addFitCommand(CLI::App& program) {
    const auto [command, options] = addCommand(
        program, "fit", "Find the pose of a lattice that moves points of a model to given targets",
        runFit);
    addModelAndRest(command, options);
    command.add_option(
        "--targets", options.targets,
        "Where the points should go: a .txt with the number of a point, from 0, and three "
        "coordinates on each line; or the whole model in the wanted shape, in any model format");
    command
        .add_option_function<std::vector<double>>(
            "--pull",
            [&pulls = options.pulls](const std::vector<double>& numbers) {
                std::ranges::copy(numbers, pulls.emplace_back().begin());
            },
            "Pull the point of the model that is nearest to X Y Z by DX DY DZ. The cells of the "
            "lattice stay as rigid as they can: a pulled hand bends its arm. May be given several "
            "times")
        ->type_size(6)
        ->expected(1)
        ->delimiter(',')
        ->check(isNumberOf("the numbers X Y Z DX DY DZ"))
        ->type_name("X Y Z DX DY DZ")
        ->trigger_on_parse();
    command
        .add_option_function<std::vector<double>>(
            "--pin",
            [&pins = options.pins](const std::vector<double>& numbers) {
                std::ranges::copy(numbers, pins.emplace_back().begin());
            },
            "Keep the point of the model that is nearest to X Y Z in place. May be given several "
            "times")
        ->type_size(3)
        ->expected(1)
        ->delimiter(',')
        ->check(isNumberOf("the numbers X Y Z"))
        ->type_name("X Y Z")
        ->trigger_on_parse();
    CLI::Option* const reach =
        command
            .add_option("--reach", options.reach,
                        "How far a pull reaches: vertices farther from all pulls along the cells "
                        "than this part of the farthest one's distance stay. At 1, all may move")
            ->check(inRange(0, 1))
            ->default_str("0.5");
    CLI::Option* const stiff =
        command.add_flag("--stiff", options.isStiff,
                         "Pull stiffly: without bending. The vertices move as little as possible, "
                         "each for itself, as with --smoothing tikhonov");
    CLI::Option* const noInverted =
        command.add_flag("--no-inverted", options.noInverted,
                         "Write nothing if pulls turn cells inside out; exit code 3");
    noInverted->needs(command.get_option("--pull"));
    options.ofSubdivision.push_back(noInverted);
    stiff->needs(command.get_option("--pull"));
    reach->needs(command.get_option("--pull"))->excludes(stiff);
    reach->excludes(command.get_option("--targets"));
    addBindingOptions(command, options);
    addChoice<solve::Smoothing>(command, "--smoothing", options.smoothing, solve::kSmoothingWords,
                                "The second aim of the fit, for the displacements of the lattice. "
                                "tikhonov: small ones; laplacian: like the neighbours' ones. Pulls "
                                "then move vertices each for itself, as with --stiff",
                                "none, but tikhonov with --stiff");
    command
        .add_option("--strength", options.fit.strength,
                    "Weight of the smoothing against the targets")
        ->check(inRange(0.0001, 10000))
        ->capture_default_str();
    command
        .add_option("--freeze", options.fit.frozen,
                    "Numbers of lattice vertices that must not move")
        ->delimiter(',');
    addMoveHeldOption(command, options.movesHeld);
    addHoldOptions(command, options.hold, options);
    addChoice<solve::Undetermined>(
        command, "--undetermined", options.fit.undetermined, solve::kUndeterminedWords,
        "If the targets do not determine all vertices. smallest: take the "
        "smallest displacements; refuse: that is an error");
    for (const char* name : {"--smoothing", "--strength", "--undetermined"}) {
        reach->excludes(command.get_option(name));
        options.ofLeastMovement.push_back(command.get_option(name));
    }
    addOutputOption(command, options.output, "The pose: " + filesToWrite(io::FileContent::Lattice))
        ->required();
    addStrictOption(command, options.common);
    addRunOptions(command, options.common);
    addReportOption(command, options.report);
}

}  // namespace espalier::cli
