// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/printable.h>
#include <espalier/io/files/file.h>
#include <espalier/io/lattice_file.h>
#include <espalier/shapes/held.h>
#include <espalier/shapes/pose.h>
#include <espalier/shapes/selection.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "commands.h"
#include "files.h"
#include "job.h"
#include "options.h"
#include "pose_selection.h"
#include "posing.h"
#include "standard_streams.h"

namespace espalier::cli {
namespace {

namespace pose = shapes::pose;

constexpr const char* kSelectAll = "--select-all";

/// An option that selects vertices, sets an option or runs an operation, and its effect. Steps run
/// in the order of the options.
struct Step {
    std::string option;
    std::function<void(Posing&)> run;
    bool changesSelection = false;  ///< a --select that starts from the selection before
};

struct PoseOptions {
    CommonOptions common;
    std::string lattice;
    std::string output;
    std::vector<Step> steps;
    std::vector<std::string> displacements;  ///< the files of --displacements
    bool movesHeld = false;
};

/// Returns a check that a word names a direction.
CLI::Validator isDirection() {
    return CLI::Validator(
        [](std::string& word) {
            return directionOf(word)
                       ? std::string()
                       : "expected an axis x, y or z, or with a sign (+x, -z), got " + shown(word);
        },
        "");
}

std::optional<shapes::Falloff::Profile> falloffOf(std::string_view word) {
    const auto known =
        std::ranges::find(shapes::kFalloffWords, word, &Word<shapes::Falloff::Profile>::text);
    if (known == std::end(shapes::kFalloffWords)) return std::nullopt;
    return known->choice;
}

/// Returns a check that a word is a length.
/// \param words all words of the option, for the message
CLI::Validator isLengthOf(const std::string& words) {
    return CLI::Validator(
        [words](std::string& text) {
            return lengthOf(text) ? std::string()
                                  : "expected " + words + ", with spaces or commas between, got " +
                                        shown(text);
        },
        "");
}

/// The options that change an operation after them, and the operations that use them. All
/// operations use the others: --select, --select-all and --falloff.
constexpr std::pair<std::string_view, std::string_view> kModifiers[] = {
    {kSelect, ""},
    {kSelectAll, ""},
    {"--falloff", ""},
    {"--center", "--rotate, --scale, --twist, --bend or --taper"},
    {"--about", "--rotate, --scale, --twist, --bend or --taper"},
    {"--range", "--twist, --bend or --taper"},
    {"--toward", "--bend"}};

/// Refuses an option that changes no operation: no operation that follows uses it, or a later
/// option replaces it before. \throws CLI::ValidationError
void checkModifiers(std::span<const Step> steps) {
    using Modifier = std::pair<std::string_view, std::string_view>;
    std::vector<const Modifier*> unused;
    const auto refuse = [](const Modifier& modifier, const std::string& why) {
        throw CLI::ValidationError(
            std::string(modifier.first),
            fmt::format(
                "has no effect{}; put it before {}", why,
                modifier.second.empty() ? "the operation that it is for" : modifier.second));
    };
    for (const Step& step : steps) {
        const auto* const modifier = std::ranges::find(kModifiers, step.option, &Modifier::first);
        if (modifier == std::end(kModifiers)) {
            std::erase_if(unused, [&](const Modifier* other) {
                return other->second.empty() ||
                       other->second.find(step.option) != std::string_view::npos;
            });
            continue;
        }
        const bool isSelection = step.option.starts_with(kSelect);
        if (step.changesSelection)
            std::erase_if(unused, [](const Modifier* other) { return other->first == kSelect; });
        const auto isPlace = [](const Modifier& each) {
            return each.first == "--center" || each.first == "--about";
        };
        for (const Modifier* other : unused)
            if (isSelection || other == modifier || (isPlace(*other) && isPlace(*modifier)))
                refuse(*other, fmt::format(": the {} after it replaces it", step.option));
        unused.push_back(modifier);
    }
    if (!unused.empty()) refuse(*unused.front(), ": no operation after it uses it");
}

/// Returns the end of the line on the result: "; 98 are held".
std::string heldText(const Lattice& lattice, bool movesHeld) {
    const std::size_t held = movesHeld ? 0 : shapes::heldVertices(lattice).size();
    return held == 0 ? "" : fmt::format("; {} {} held", held, held == 1 ? "is" : "are");
}

void runPose(const PoseOptions& options) {
    checkModifiers(options.steps);
    Job job(options.common,
            {{"LATTICE", options.lattice}, {"--displacements", options.displacements}});
    job.writesLattice(options.output);
    Stages& stages = job.stages();
    Lattice lattice = readLattice(options.lattice, stages);
    Posing posing(lattice, options.movesHeld);
    stages.run("posing", [&] {
        for (const Step& step : options.steps) {
            try {
                step.run(posing);
            } catch (const MemoryError&) {
                throw;
            } catch (const io::FileError&) {
                throw;
            } catch (const ArgumentError& error) {
                throw CLI::ValidationError(step.option, error.messageOfField(std::identity()));
            } catch (const Error& error) {
                throw CLI::ValidationError(step.option, error.what());
            }
        }
    });
    Index moved = 0;
    for (std::size_t v = 0; v < lattice.positions.size(); ++v)
        moved += posing.positions()[v] != lattice.positions[v];
    lattice.positions = posing.positions();
    stages.run("writing", [&] { io::writeLattice(options.output, lattice); });
    for (const std::string& note : posing.notes()) printError(note.c_str());
    if (!options.common.quiet)
        for (const std::string& line : posing.found()) fmt::print("{}\n", line);
    if (!options.common.quiet)
        fmt::print("{}: {} of {} vertices moved{}\n", printable(options.output), moved,
                   lattice.positions.size(), heldText(lattice, options.movesHeld));
}

/// Adds an option that may be given several times. run(posing, values) is its effect.
template <class Values, class Run>
CLI::Option* addStep(CLI::App& command, std::vector<Step>& steps, const std::string& name,
                     const std::string& help, Run run) {
    // CLI11 calls the function while it reads the arguments, so the steps keep their order.
    return command
        .add_option_function<Values>(
            name,
            [name, &steps, run](const Values& values) {
                steps.push_back({name, [run, values](Posing& posing) { run(posing, values); }});
            },
            help)
        ->trigger_on_parse();
}

/// Adds an operation of an axis and a number.
template <class Operate>
void addAlongAxis(CLI::App& command, std::vector<Step>& steps, const std::string& name,
                  const std::string& numberName, const std::string& help, Operate operate) {
    using AxisAndNumber = std::array<std::string, 2>;
    const auto run = [operate](Posing& posing, const AxisAndNumber& values) {
        posing.operate([&](const auto& positions, const pose::Options& options) {
            return operate(positions, *directionOf(values[0]), *numberOf(values[1]), options,
                           posing);
        });
    };
    const std::string names = "AXIS " + numberName;
    addStep<AxisAndNumber>(command, steps, name, help, run)
        ->delimiter(',')
        ->check(isDirection().application_index(0))
        ->check(isNumberOf(names).application_index(1))
        ->type_name(names);
}

double radians(double degrees) {
    return degrees * (std::numbers::pi / 180);
}

void addOperations(CLI::App& command, PoseOptions& of) {
    std::vector<Step>& steps = of.steps;
    using Lengths = std::array<std::string, 3>;
    addStep<Lengths>(command, steps, "--move", "Move by a vector",
                     [](Posing& posing, const Lengths& words) {
                         Point3 offset;
                         for (std::size_t c = 0; c < 3; ++c)
                             offset[c] = lengthOf(words[c])->in(posing.lattice());
                         posing.operate([&](const auto& positions, const auto& options) {
                             return pose::move(positions, offset, options.weights);
                         });
                     })
        ->delimiter(',')
        ->check(isLengthOf("the numbers X Y Z"))
        ->type_name("X Y Z")
        ->allow_extra_args();
    command
        .add_option_function<std::string>(
            "--displacements",
            [&of](const std::string& path) {
                of.displacements.push_back(path);
                of.steps.push_back(
                    {"--displacements", [path](Posing& posing) { posing.displace(path); }});
            },
            "Move each vertex by its own vector, from a table of vertices and vectors: " +
                filesToRead(io::FileContent::Displacements))
        ->trigger_on_parse();
    addAlongAxis(
        command, steps, "--rotate", "DEGREES",
        "Rotate about an axis (x, y or z) through the centre, anticlockwise seen from its "
        "tip",
        [](const auto& positions, const Point3& axis, double degrees, const auto& options,
           const Posing&) { return pose::rotate(positions, axis, radians(degrees), options); });
    takeNumbers(
        addStep<std::vector<double>>(
            command, steps, "--scale", "Scale about the centre",
            [](Posing& posing, const std::vector<double>& factors) {
                if (factors.size() == 2)
                    throw CLI::ValidationError("--scale", "expected one factor or three, got two");
                const double first = factors.front();
                const Point3 three = factors.size() == 1 ? Point3{first, first, first}
                                                         : Point3{first, factors[1], factors[2]};
                posing.operate([&](const auto& positions, const auto& options) {
                    return pose::scale(positions, three, options);
                });
            }),
        "FACTOR|X Y Z")
        ->expected(1, 3);
    addAlongAxis(
        command, steps, "--twist", "DEGREES",
        "Rotate about an axis, by an angle that grows from 0 along the axis",
        [](const auto& positions, const Point3& axis, double degrees, const auto& options,
           const Posing&) { return pose::twist(positions, axis, radians(degrees), options); });
    addAlongAxis(command, steps, "--bend", "DEGREES", "Bend the axis into an arc of a circle",
                 [](const auto& positions, const Point3& axis, double degrees, const auto& options,
                    const Posing& posing) {
                     // By default the next of x, y, z.
                     const Point3 next = {std::abs(axis[2]), std::abs(axis[0]), std::abs(axis[1])};
                     return pose::bend(positions, axis, radians(degrees),
                                       posing.toward.value_or(next), options);
                 });
    addAlongAxis(command, steps, "--taper", "FACTOR",
                 "Scale across the axis: by 1 at its start, FACTOR at its end",
                 [](const auto& positions, const Point3& axis, double factor, const auto& options,
                    const Posing&) { return pose::taper(positions, axis, factor, options); });
    addStep<std::string>(
        command, steps, "--mirror",
        "The vertices on the other side do what the selected vertices did: the other side of the "
        "middle plane across an axis (x, y or z), or of a plane such as x=0.5",
        [](Posing& posing, const std::string& word) { posing.mirror(*mirrorPlaneOf(word)); })
        ->check(CLI::Validator(
            [](std::string& word) {
                return mirrorPlaneOf(word)
                           ? std::string()
                           : "expected x, y or z, or a plane such as x=0.5, got " + shown(word);
            },
            ""))
        ->type_name("AXIS|AXIS=PLACE");
}

void addSelections(CLI::App& command, std::vector<Step>& steps) {
    constexpr int kMany = 1000000;
    command
        .add_option_function<std::vector<std::string>>(
            kSelect,
            [&steps](std::vector<std::string> words) {
                std::erase(words,
                           "");  // CLI11 marks an incomplete group of words by an empty word.
                const Selection selection = selectionOf(words);
                steps.push_back({kSelect, [selection](Posing& posing) { posing.select(selection); },
                                 static_cast<bool>(selection.change)});
            },
            "Vertices for the operations that follow: box X0 Y0 Z0 X1 Y1 Z1; ball X Y Z RADIUS; "
            "near X Y Z RADIUS, a ball along the cells; half-space X Y Z NX NY NZ, a point of its "
            "plane and the normal into it; end +z, the last layer in a direction; limb X Y Z, the "
            "arm, leg or ear at a point, up to its narrowest section; beyond FACE, or the face "
            "nearest to X Y Z, the part of the lattice beyond it; vertices NUMBER...; attribute "
            "NAME, whose values from 0 to 1 are the parts of the operation that the vertices get; "
            "grow N or shrink N, the vertices selected before and N edges more or fewer. A radius "
            "may be a percentage of the lattice's diagonal, 10%. Clears the five options below")
        // Two words at least, so that the second one may begin with a minus. All words that follow
        // them are numbers, so endNumbers() ends them.
        ->type_size(2, kMany)
        ->expected(1)
        ->allow_extra_args()
        ->type_name("KIND ...")
        ->delimiter(',')
        ->trigger_on_parse();
    command
        .add_flag_callback(
            kSelectAll,
            [&steps] {
                steps.push_back({kSelectAll, [](Posing& posing) { posing.select({}); }});
            },
            "The operations that follow are for all vertices again")
        ->trigger_on_parse();
    using WordAndNumber = std::array<std::string, 2>;
    const CLI::Validator isProfile(
        [](std::string& word) {
            return falloffOf(word) ? std::string()
                                   : "expected linear or smooth, got " + shown(word);
        },
        "");
    addStep<WordAndNumber>(
        command, steps, "--falloff",
        "Vertices outside the selection, up to this distance, move in part. The "
        "distance is in space; after near, limb, beyond, grow and shrink it is "
        "along the cells",
        [](Posing& posing, const WordAndNumber& values) {
            const auto& [word, radius] = values;
            posing.setFalloff({*falloffOf(word), lengthOf(radius)->in(posing.lattice())});
        })
        ->delimiter(',')
        ->check(CLI::Validator(isProfile).application_index(0))
        ->check(isLengthOf("linear|smooth RADIUS").application_index(1))
        ->type_name("linear|smooth RADIUS");
    takeNumbers(
        addStep<Point3>(command, steps, "--center",
                        "A point on the axis of the operations that follow; by default, the "
                        "middle of the selected vertices",
                        [](Posing& posing, const Point3& point) { posing.center = point; }),
        "X Y Z");
    command
        .add_option_function<std::vector<std::string>>(
            "--about",
            [&steps](std::vector<std::string> words) {
                std::erase(words, "");
                steps.push_back({"--about", [pivot = pivotOf(words)](Posing& posing) {
                                     posing.pivot = pivot;
                                 }});
            },
            "The pivot of the operations that follow: vertex NUMBER; border, the middle of the "
            "section between the selected vertices and the rest; joint X Y Z, the middle of the "
            "section through the face nearest to a point, such as an elbow; X Y Z. Twist, bend and "
            "taper begin there")
        ->type_size(1, kMany)
        ->expected(1)
        ->allow_extra_args()
        ->type_name("PIVOT ...")
        ->delimiter(',')
        ->trigger_on_parse();
    using Range = std::array<double, 2>;
    takeNumbers(
        addStep<Range>(command, steps, "--range",
                       "Coordinates along the axis between which twist, bend and taper grow "
                       "from nothing to all; by default, the interval of the selected vertices",
                       [](Posing& posing, const Range& range) { posing.range = range; }),
        "FROM TO");
    addStep<std::string>(
        command, steps, "--toward",
        "Direction that --bend bends to: +x, -y ...; by default y for x, z for y, x for z",
        [](Posing& posing, const std::string& word) { posing.toward = directionOf(word); })
        ->check(isDirection())
        ->type_name("DIRECTION");
}

}  // namespace

void addPoseCommand(CLI::App& program) {
    const auto [command, options] = addCommand(program, "pose",
                                               "Pose a lattice: move, rotate, scale, twist, bend, "
                                               "taper or mirror its vertices, in the order of "
                                               "the options",
                                               runPose);
    command
        .add_option("LATTICE", options.lattice,
                    "The lattice: " + filesToRead(io::FileContent::Lattice))
        ->required();
    addSelections(command, options.steps);
    addOperations(command, options);
    addMoveHeldOption(command, options.movesHeld);
    addOutputOption(command, options.output, "The pose: " + filesToWrite(io::FileContent::Lattice))
        ->required();
    addRunOptions(command, options.common);
}

}  // namespace espalier::cli
