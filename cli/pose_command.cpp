// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/parallel.h>
#include <espalier/base/printable.h>
#include <espalier/io/files/text_reader.h>
#include <espalier/io/lattice_file.h>
#include <espalier/shapes/pose.h>
#include <espalier/shapes/selection.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "commands.h"
#include "files.h"
#include "options.h"

namespace espalier::cli {
namespace {

namespace pose = shapes::pose;

/// An option with its values. The order of these options matters.
struct Step {
    std::string option;
    std::vector<std::string> words;
};

struct PoseOptions {
    CommonOptions common;
    std::string lattice;
    std::string output;
    std::vector<Step> steps;
};

[[noreturn]] void refuse(const Step& step, const std::string& expected) {
    throw CLI::ValidationError(
        step.option, fmt::format("{}: expected {}", fmt::join(step.words, " "), expected));
}

double number(const Step& step, std::size_t i, const std::string& expected) {
    double value = 0;
    if (i >= step.words.size() || !io::parseNumber(std::string_view(step.words[i]), value))
        refuse(step, expected);
    return value;
}

/// Returns the numbers of a step from word `begin` on.
template <std::size_t count>
std::array<double, count> numbers(const Step& step, std::size_t begin,
                                  const std::string& expected) {
    if (step.words.size() != begin + count) refuse(step, expected);
    std::array<double, count> values;
    for (std::size_t i = 0; i < count; ++i) values[i] = number(step, begin + i, expected);
    return values;
}

/// A kind of selection, and the words that follow its name.
struct SelectionKind {
    std::string_view name, words;
    std::size_t count;  ///< number of words; 0: one or more
};
constexpr SelectionKind kSelectionKinds[] = {
    {"box", "X0 Y0 Z0 X1 Y1 Z1", 6},     {"ball", "X Y Z RADIUS", 4},
    {"half-space", "X Y Z NX NY NZ", 6}, {"end", "AXIS with a sign, such as +z", 1},
    {"vertices", "NUMBER...", 0},        {"attribute", "NAME", 1}};

/// \throws CLI::ValidationError unless the words of a --select are a kind with its words
void checkWords(const Step& step) {
    std::string kinds;
    for (const SelectionKind& kind : kSelectionKinds) {
        const std::string form = fmt::format("{} {}", kind.name, kind.words);
        kinds += (kinds.empty() ? "" : "; ") + form;
        if (step.words.empty() || step.words[0] != kind.name) continue;
        const std::size_t count = step.words.size() - 1;
        if (kind.count == 0 ? count > 0 : count == kind.count) return;
        refuse(step, form);
    }
    refuse({step.option, {step.words.empty() ? "" : step.words[0]}}, kinds);
}

/// Returns the direction that a word names: x, +y, -z.
std::optional<Point3> directionOf(std::string_view word) {
    double sign = 1;
    if (!word.empty() && (word[0] == '+' || word[0] == '-')) {
        sign = word[0] == '-' ? -1 : 1;
        word.remove_prefix(1);
    }
    if (word.size() != 1 || word[0] < 'x' || word[0] > 'z') return std::nullopt;
    Point3 direction = {0, 0, 0};
    direction[static_cast<std::size_t>(word[0] - 'x')] = sign;
    return direction;
}

Point3 direction(const Step& step, std::size_t i, const std::string& expected) {
    if (i >= step.words.size()) refuse(step, expected);
    const auto result = directionOf(step.words[i]);
    if (!result) refuse(step, expected);
    return *result;
}

/// Applies the steps to a lattice, one after the other.
class Posing {
public:
    explicit Posing(const Lattice& lattice) : lattice_(lattice), positions_(lattice.positions) {}

    void apply(const Step& step) {
        const std::string name = step.option.substr(2);
        if (name == "select" || name == "select-all") {
            falloff_ = {};
            center_.reset();
            range_.reset();
            toward_.reset();
            selection_ = name == "select" ? std::optional(step) : std::nullopt;
            checkSelection();
        } else if (name == "falloff") {
            readFalloff(step);
        } else if (name == "center") {
            center_ = numbers<3>(step, 0, "X Y Z");
        } else if (name == "range") {
            range_ = numbers<2>(step, 0, "FROM TO");
        } else if (name == "toward") {
            toward_ = direction(step, 0, kAxis);
        } else {
            operate(name, step);
        }
    }

    const std::vector<Point3>& positions() const { return positions_; }

private:
    static constexpr const char* kAxis = "x, y or z, or with a sign: +x, -z";
    static constexpr const char* kAxisAndAngle = "an axis (x, y or z) and degrees";

    void operate(const std::string& name, const Step& step) {
        const std::vector<double> weights = currentWeights();
        const pose::Place place{weights, center_, range_};
        const auto radians = [&] {
            return number(step, 1, kAxisAndAngle) * (std::numbers::pi / 180);
        };
        if (name == "move") {
            positions_ = pose::move(positions_, numbers<3>(step, 0, "X Y Z"), weights);
        } else if (name == "scale") {
            if (step.words.size() == 1) {
                const double factor = number(step, 0, "one factor or three");
                positions_ = pose::scale(positions_, {factor, factor, factor}, place);
            } else {
                positions_ =
                    pose::scale(positions_, numbers<3>(step, 0, "one factor or three"), place);
            }
        } else if (name == "rotate") {
            const Point3 axis = direction(step, 0, kAxisAndAngle);
            positions_ = pose::rotate(positions_, axis, radians(), place);
        } else if (name == "twist") {
            const Point3 axis = direction(step, 0, kAxisAndAngle);
            positions_ = pose::twist(positions_, axis, radians(), place);
        } else if (name == "bend") {
            const Point3 axis = direction(step, 0, kAxisAndAngle);
            // By default the next of x, y, z.
            const Point3 next = {std::abs(axis[2]), std::abs(axis[0]), std::abs(axis[1])};
            positions_ = pose::bend(positions_, axis, radians(), toward_.value_or(next), place);
        } else {
            const char* const expected = "an axis (x, y or z) and a factor";
            const Point3 axis = direction(step, 0, expected);
            positions_ = pose::taper(positions_, axis, number(step, 1, expected), place);
        }
    }

    void readFalloff(const Step& step) {
        const char* const expected = "linear or smooth, and a radius above 0";
        if (step.words.size() != 2) refuse(step, expected);
        const auto word = std::ranges::find(shapes::kFalloffWords, std::string_view(step.words[0]),
                                            &Word<shapes::Falloff::Profile>::text);
        falloff_ = {word == std::end(shapes::kFalloffWords) ? shapes::Falloff::Profile::Linear
                                                            : word->choice,
                    number(step, 1, expected)};
        if (word == std::end(shapes::kFalloffWords) || !(falloff_.radius > 0))
            refuse(step, expected);
        if (!selection_)
            throw CLI::ValidationError(
                step.option, "the whole lattice is selected; give --select before --falloff");
        if (selection_->words[0] == "attribute")
            throw CLI::ValidationError(
                step.option, "the values of an attribute are the weights already, without falloff");
    }

    /// Returns the weight of each vertex; no weights if all vertices are selected. Selections use
    /// the positions in the file: operations before them do not matter.
    std::vector<double> currentWeights() const {
        if (!selection_) return {};
        const Step& step = *selection_;
        const std::string& kind = step.words[0];
        const auto& rest = lattice_.positions;
        if (kind == "box") {
            const auto box = numbers<6>(step, 1, "numbers");
            return shapes::selectBox(rest, {box[0], box[1], box[2]}, {box[3], box[4], box[5]},
                                     falloff_);
        }
        if (kind == "ball") {
            const auto ball = numbers<4>(step, 1, "numbers");
            return shapes::selectBall(rest, {ball[0], ball[1], ball[2]}, ball[3], falloff_);
        }
        if (kind == "half-space") {
            const auto side = numbers<6>(step, 1, "numbers");
            return shapes::selectHalfSpace(rest, {side[0], side[1], side[2]},
                                           {side[3], side[4], side[5]}, falloff_);
        }
        if (kind == "end") return shapes::selectEnd(rest, direction(step, 1, kAxis), falloff_);
        if (kind == "attribute") return attributeWeights();
        std::vector<Index> vertices;
        for (std::size_t i = 1; i < step.words.size(); ++i) {
            Index vertex = 0;
            if (!io::parseNumber(std::string_view(step.words[i]), vertex))
                refuse(step, "numbers of vertices");
            vertices.push_back(vertex);
        }
        return shapes::selectNumbers(rest, vertices, falloff_);
    }

    /// Returns the values of the attribute that is selected.
    std::vector<double> attributeWeights() const {
        const Step& step = *selection_;
        const std::string& name = step.words[1];
        const auto hasName = [&](const auto& attribute) { return attribute.name == name; };
        const auto real = std::ranges::find_if(lattice_.attributes, hasName);
        const auto whole = std::ranges::find_if(lattice_.integers, hasName);
        std::vector<double> weights;
        if (real != lattice_.attributes.end() && real->components == 1)
            weights = real->values;
        else if (whole != lattice_.integers.end() && whole->components == 1)
            weights.assign(whole->values.begin(), whole->values.end());
        else
            throw CLI::ValidationError(
                step.option, fmt::format("the lattice has no attribute {} with one value for each "
                                         "vertex; its attributes: {}",
                                         printable(name), namesOfAttributes()));
        for (std::size_t v = 0; v < weights.size(); ++v)
            if (!(weights[v] >= 0 && weights[v] <= 1))
                throw CLI::ValidationError(
                    step.option, fmt::format("attribute {} is {} at vertex {}; expected 0 to 1",
                                             printable(name), weights[v], v));
        return weights;
    }

    std::string namesOfAttributes() const {
        std::vector<std::string> names;
        for (const auto& attribute : lattice_.attributes)
            names.push_back(printable(attribute.name));
        for (const auto& attribute : lattice_.integers) names.push_back(printable(attribute.name));
        return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
    }

    /// \throws CLI::ValidationError if nothing is selected
    void checkSelection() const {
        if (!selection_) return;
        const auto weights = currentWeights();
        if (std::ranges::none_of(weights, [](double weight) { return weight > 0; }))
            refuse(*selection_, "at least one vertex there; the lattice has none");
    }

    const Lattice& lattice_;
    std::vector<Point3> positions_;
    std::optional<Step> selection_;  ///< none: all vertices
    shapes::Falloff falloff_;
    std::optional<Point3> center_, toward_;
    std::optional<std::array<double, 2>> range_;
};

void runPose(const PoseOptions& options) {
    const std::vector<Input> inputs = {{"LATTICE", options.lattice}};
    checkInputs(inputs);
    checkOutput(options.output, inputs);
    io::checkLatticeTarget(options.output);
    const ThreadLimit limit(options.common.threads);
    Stages stages(options.common.quiet);
    Lattice lattice = readLattice(options.lattice, stages);
    Posing posing(lattice);
    stages.run("posing", [&] {
        for (const Step& step : options.steps) {
            try {
                posing.apply(step);
            } catch (const MemoryError&) {
                throw;
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

}  // namespace

void addPoseCommand(CLI::App& program) {
    const auto [command, options] = addCommand(
        program, "pose",
        "Pose a lattice: move, rotate, scale, twist, bend or taper its vertices, in the order of "
        "the options",
        runPose);
    command.add_option("LATTICE", options.lattice, "The lattice: .ovm, .vtu or .vtk")->required();
    const auto add = [&app = command, &steps = options.steps](const std::string& name, int least,
                                                              int most, const char* values,
                                                              const char* help) -> CLI::Option* {
        // CLI11 calls the function while it reads the arguments, so the steps keep their order.
        return app
            .add_option_function<std::vector<std::string>>(
                name,
                [name, &steps](const std::vector<std::string>& words) {
                    Step& step = steps.emplace_back(Step{name, {}});
                    // CLI11 marks an incomplete group of words by an empty word.
                    std::ranges::copy_if(words, std::back_inserter(step.words),
                                         [](const std::string& word) { return !word.empty(); });
                    if (name == "--select") checkWords(step);
                },
                help)
            ->type_size(least, most)
            ->expected(1)
            ->type_name(values)
            ->trigger_on_parse();
    };
    constexpr int kMany = 1000000;
    // Two words at least, so that the second one may begin with a minus.
    add("--select", 2, kMany, "KIND ...",
        "Vertices for the operations that follow: box X0 Y0 Z0 X1 Y1 Z1; ball X Y Z RADIUS; "
        "half-space X Y Z NX NY NZ, a point of its plane and the normal into it; end +z, the last "
        "layer in a direction; vertices NUMBER...; attribute NAME, whose values from 0 to 1 are "
        "the parts of the operation that the vertices get. Clears the four options below")
        ->delimiter(',');
    command
        .add_flag_callback(
            "--select-all",
            [&steps = options.steps] {
                steps.push_back({"--select-all", {}});
            },
            "The operations that follow are for all vertices again")
        ->trigger_on_parse();
    add("--falloff", 2, 2, "linear|smooth RADIUS",
        "Vertices outside the selection, up to this distance, move in part");
    add("--center", 3, 3, "X Y Z",
        "A point on the axis of the operations that follow; by default, the middle of the selected "
        "vertices")
        ->delimiter(',');
    add("--range", 2, 2, "FROM TO",
        "Coordinates along the axis between which twist, bend and taper grow from nothing to all; "
        "by default, those of the selected vertices")
        ->delimiter(',');
    add("--toward", 1, 1, "DIRECTION",
        "Direction that --bend bends to: +x, -y ...; by default y for x, z for y, x for z");
    add("--move", 3, 3, "X Y Z", "Move by a vector")->delimiter(',');
    add("--rotate", 2, 2, "AXIS DEGREES",
        "Rotate about an axis (x, y or z) through the centre, anticlockwise seen from its tip");
    add("--scale", 1, 3, "FACTOR|X Y Z", "Scale about the centre")->delimiter(',');
    add("--twist", 2, 2, "AXIS DEGREES", "Rotate about an axis, the more the farther along it");
    add("--bend", 2, 2, "AXIS DEGREES", "Bend the axis into an arc of a circle");
    add("--taper", 2, 2, "AXIS FACTOR",
        "Scale across the axis: by 1 at its start, FACTOR at its end");
    addOutputOption(command, options.output, "The pose: .ovm, .vtu or .vtk")->required();
    addRunOptions(command, options.common);
}

}  // namespace espalier::cli
