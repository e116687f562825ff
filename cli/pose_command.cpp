// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/printable.h>
#include <espalier/io/lattice_file.h>
#include <espalier/shapes/pose.h>
#include <espalier/shapes/selection.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

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

namespace espalier::cli {
namespace {

namespace pose = shapes::pose;

constexpr const char* kSelect = "--select";
constexpr const char* kSelectAll = "--select-all";

class Posing;

/// An option that selects vertices, sets an option or runs an operation, and its effect. Steps run
/// in the order of the options.
struct Step {
    std::string option;
    std::function<void(Posing&)> run;
};

struct PoseOptions {
    CommonOptions common;
    std::string lattice;
    std::string output;
    std::vector<Step> steps;
};

/// Returns the direction that a word names: x, +y, -z.
std::optional<Point3> directionOf(std::string_view word) {
    double sign = 1;
    if (!word.empty() && (word[0] == '+' || word[0] == '-')) {
        sign = word[0] == '-' ? -1 : 1;
        word.remove_prefix(1);
    }
    if (word.size() != 1 || word[0] < 'x' || word[0] > 'z') return std::nullopt;
    Point3 direction = {0, 0, 0};
    direction[word[0] - 'x'] = sign;
    return direction;
}

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

/// A set of vertices that --select names.
struct Selection {
    std::string text;  ///< the words
    std::function<std::vector<double>(const Lattice&, const shapes::Falloff&)> weights;
    bool takesFalloff = true;
};

/// Returns the weights that an attribute holds.
/// \throws CLI::ValidationError if there is no such attribute, or a value is not a weight
std::vector<double> weightsIn(const Lattice& lattice, const std::string& name) {
    const auto hasName = [&](const auto& attribute) { return attribute.name == name; };
    const auto real = std::ranges::find_if(lattice.attributes, hasName);
    const auto whole = std::ranges::find_if(lattice.integers, hasName);
    std::vector<double> weights;
    if (real != lattice.attributes.end() && real->components == 1) {
        weights = real->values;
    } else if (whole != lattice.integers.end() && whole->components == 1) {
        weights.assign(whole->values.begin(), whole->values.end());
    } else {
        std::vector<std::string> names;
        for (const auto& attribute : lattice.attributes) names.push_back(printable(attribute.name));
        for (const auto& attribute : lattice.integers) names.push_back(printable(attribute.name));
        throw CLI::ValidationError(
            kSelect,
            fmt::format("the lattice has no attribute {} with one value for each vertex; its "
                        "attributes: {}",
                        printable(name),
                        names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
    }
    for (std::size_t v = 0; v < weights.size(); ++v)
        if (!(weights[v] >= 0 && weights[v] <= 1))
            throw CLI::ValidationError(
                kSelect, fmt::format("attribute {} is {} at vertex {}; expected 0 to 1",
                                     printable(name), weights[v], v));
    return weights;
}

/// The kinds of selections, and the words that follow their names.
constexpr std::pair<std::string_view, std::string_view> kSelectionKinds[] = {
    {"box", "X0 Y0 Z0 X1 Y1 Z1"},     {"ball", "X Y Z RADIUS"},
    {"half-space", "X Y Z NX NY NZ"}, {"end", "AXIS with a sign, such as +z"},
    {"vertices", "NUMBER..."},        {"attribute", "NAME"}};

/// Returns the selection that the words of a --select name.
/// \throws CLI::ValidationError with the words that were expected
Selection selectionOf(const std::vector<std::string>& words) {
    const std::string kind = words.empty() ? "" : words[0];
    const auto known = std::ranges::find(kSelectionKinds, kind,
                                         &std::pair<std::string_view, std::string_view>::first);
    const auto refuse = [](const std::string& got, const std::string& expected) {
        throw CLI::ValidationError(kSelect, printable(got) + ": expected " + expected);
    };
    if (known == std::end(kSelectionKinds)) {
        std::vector<std::string> forms;
        for (const auto& [name, rest] : kSelectionKinds)
            forms.push_back(fmt::format("{} {}", name, rest));
        refuse(kind, fmt::format("{}", fmt::join(forms, "; ")));
    }
    const std::string text = fmt::format("{}", fmt::join(words, " "));
    const std::string form = fmt::format("{} {}", known->first, known->second);
    const auto numbers = [&](std::size_t count) {
        std::vector<double> values;
        for (const std::string& word : std::span(words).subspan(1))
            if (const auto number = numberOf(word)) values.push_back(*number);
        if (values.size() != words.size() - 1 || values.size() != count) refuse(text, form);
        return values;
    };
    Selection result{text, {}};
    if (kind == "box") {
        result.weights = [n = numbers(6)](const Lattice& lattice, const shapes::Falloff& falloff) {
            return shapes::selectBox(lattice.positions, {n[0], n[1], n[2]}, {n[3], n[4], n[5]},
                                     falloff);
        };
    } else if (kind == "ball") {
        result.weights = [n = numbers(4)](const Lattice& lattice, const shapes::Falloff& falloff) {
            return shapes::selectBall(lattice.positions, {n[0], n[1], n[2]}, n[3], falloff);
        };
    } else if (kind == "half-space") {
        result.weights = [n = numbers(6)](const Lattice& lattice, const shapes::Falloff& falloff) {
            return shapes::selectHalfSpace(lattice.positions, {n[0], n[1], n[2]},
                                           {n[3], n[4], n[5]}, falloff);
        };
    } else if (kind == "end") {
        const auto direction = words.size() == 2 ? directionOf(words[1]) : std::nullopt;
        if (!direction) refuse(text, form);
        result.weights = [d = *direction](const Lattice& lattice, const shapes::Falloff& falloff) {
            return shapes::selectEnd(lattice.positions, d, falloff);
        };
    } else if (kind == "vertices") {
        if (words.size() < 2) refuse(text, form);
        result.weights = [n = numbers(words.size() - 1), refuse, text](
                             const Lattice& lattice, const shapes::Falloff& falloff) {
            std::vector<Index> vertices;
            for (const double number : n) {
                if (!(number >= 0 && number < static_cast<double>(lattice.positions.size())) ||
                    number != std::floor(number))
                    refuse(text, fmt::format("numbers of vertices, 0 to {}",
                                             lattice.positions.size() - 1));
                vertices.push_back(static_cast<Index>(number));
            }
            return shapes::selectNumbers(lattice.positions, vertices, falloff);
        };
    } else {
        if (words.size() != 2) refuse(text, form);
        result.takesFalloff = false;
        result.weights = [name = words[1]](const Lattice& lattice, const shapes::Falloff&) {
            return weightsIn(lattice, name);
        };
    }
    return result;
}

/// Applies the steps to a lattice, one after the other.
class Posing {
public:
    explicit Posing(const Lattice& lattice) : lattice_(lattice), positions_(lattice.positions) {}

    const std::vector<Point3>& positions() const { return positions_; }

    /// Selects the vertices of `selection`; all vertices without one. Clears falloff, centre, range
    /// and direction.
    /// \throws CLI::ValidationError if no vertex is selected
    void select(std::optional<Selection> selection) {
        selection_ = std::move(selection);
        falloff_ = {};
        center.reset();
        range.reset();
        toward.reset();
        if (!selection_) return;
        const auto selected = weights();
        if (std::ranges::none_of(selected, [](double weight) { return weight > 0; }))
            throw CLI::ValidationError(
                kSelect, printable(selection_->text) +
                             ": expected at least one vertex there; the lattice has none");
    }

    void setFalloff(const shapes::Falloff& falloff) {
        constexpr const char* kOption = "--falloff";
        if (!(falloff.radius > 0))
            throw CLI::ValidationError(
                kOption, fmt::format("expected a radius above 0, got {}", falloff.radius));
        if (!selection_)
            throw CLI::ValidationError(
                kOption, "the whole lattice is selected; give --select before --falloff");
        if (!selection_->takesFalloff)
            throw CLI::ValidationError(
                kOption, "the values of an attribute are the weights already, without falloff");
        falloff_ = falloff;
    }

    /// Replaces the positions by operate(positions, options).
    template <class Operate>
    void operate(const Operate& operate) {
        const std::vector<double> selected = weights();
        positions_ =
            operate(std::span<const Point3>(positions_), pose::Options{selected, center, range});
    }

    std::optional<Point3> center, toward;
    std::optional<std::array<double, 2>> range;

private:
    /// Returns the weight of each vertex; no weights if all vertices are selected. Selections use
    /// the positions in the file: operations before them do not matter.
    std::vector<double> weights() const {
        return selection_ ? selection_->weights(lattice_, falloff_) : std::vector<double>();
    }

    const Lattice& lattice_;
    std::vector<Point3> positions_;
    std::optional<Selection> selection_;  ///< none: all vertices
    shapes::Falloff falloff_;
};

/// The options that change an operation after them, and the operations that use them. All
/// operations use the others: --select, --select-all and --falloff.
constexpr std::pair<std::string_view, std::string_view> kModifiers[] = {
    {kSelect, ""},
    {kSelectAll, ""},
    {"--falloff", ""},
    {"--center", "--rotate, --scale, --twist, --bend or --taper"},
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
        for (const Modifier* other : unused)
            if (isSelection || other == modifier)
                refuse(*other, fmt::format(": the {} after it replaces it", step.option));
        unused.push_back(modifier);
    }
    if (!unused.empty()) refuse(*unused.front(), ": no operation after it uses it");
}

void runPose(const PoseOptions& options) {
    checkModifiers(options.steps);
    Job job(options.common, {{"LATTICE", options.lattice}});
    job.writesLattice(options.output);
    Stages& stages = job.stages();
    Lattice lattice = readLattice(options.lattice, stages);
    Posing posing(lattice);
    stages.run("posing", [&] {
        for (const Step& step : options.steps) {
            try {
                step.run(posing);
            } catch (const MemoryError&) {
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
    if (!options.common.quiet)
        fmt::print("{}: {} of {} vertices moved\n", printable(options.output), moved,
                   lattice.positions.size());
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

void addOperations(CLI::App& command, std::vector<Step>& steps) {
    takeNumbers(addStep<Point3>(command, steps, "--move", "Move by a vector",
                                [](Posing& posing, const Point3& offset) {
                                    posing.operate([&](const auto& positions, const auto& options) {
                                        return pose::move(positions, offset, options.weights);
                                    });
                                }),
                "X Y Z");
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
}

void addSelections(CLI::App& command, std::vector<Step>& steps) {
    constexpr int kMany = 1000000;
    command
        .add_option_function<std::vector<std::string>>(
            kSelect,
            [&steps](std::vector<std::string> words) {
                std::erase(words,
                           "");  // CLI11 marks an incomplete group of words by an empty word.
                steps.push_back({kSelect, [selection = selectionOf(words)](Posing& posing) {
                                     posing.select(selection);
                                 }});
            },
            "Vertices for the operations that follow: box X0 Y0 Z0 X1 Y1 Z1; ball X Y Z RADIUS; "
            "half-space X Y Z NX NY NZ, a point of its plane and the normal into it; end +z, the "
            "last layer in a direction; vertices NUMBER...; attribute NAME, whose values from 0 to "
            "1 are the parts of the operation that the vertices get. Clears the four options below")
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
    addStep<WordAndNumber>(command, steps, "--falloff",
                           "Vertices outside the selection, up to this distance, move in part",
                           [](Posing& posing, const WordAndNumber& values) {
                               const auto& [word, radius] = values;
                               posing.setFalloff({*falloffOf(word), *numberOf(radius)});
                           })
        ->delimiter(',')
        ->check(CLI::Validator(isProfile).application_index(0))
        ->check(isNumberOf("linear|smooth RADIUS").application_index(1))
        ->type_name("linear|smooth RADIUS");
    takeNumbers(
        addStep<Point3>(command, steps, "--center",
                        "A point on the axis of the operations that follow; by default, the "
                        "middle of the selected vertices",
                        [](Posing& posing, const Point3& point) { posing.center = point; }),
        "X Y Z");
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
    const auto [command, options] = addCommand(
        program, "pose",
        "Pose a lattice: move, rotate, scale, twist, bend or taper its vertices, in the order of "
        "the options",
        runPose);
    command
        .add_option("LATTICE", options.lattice,
                    "The lattice: " + filesToRead(io::FileContent::Lattice))
        ->required();
    addSelections(command, options.steps);
    addOperations(command, options.steps);
    addOutputOption(command, options.output, "The pose: " + filesToWrite(io::FileContent::Lattice))
        ->required();
    addRunOptions(command, options.common);
}

}  // namespace espalier::cli
