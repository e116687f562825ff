// SPDX-License-Identifier: Apache-2.0
#include "options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace espalier::cli {

void addLatticeOptions(CLI::App& command, FileKind kind, LatticeOptions& options) {
    const bool isAny = kind == FileKind::Refinable;
    command
        .add_option(isAny ? "LATTICE|MESH|CURVE" : "LATTICE", options.lattice,
                    isAny ? "A lattice: " + filesToRead(io::FileContent::Lattice) +
                                "; or a mesh or a curve: " + filesToRead(io::FileContent::Mesh)
                          : "The lattice: " + filesToRead(io::FileContent::Lattice))
        ->required();
    addLevelOption(command, options.level, 0);
    addRefinementOptions(command, options.common, isAny ? RulesFor::Anything : RulesFor::Lattices);
    addRunOptions(command, options.common);
}

void addRefinementOptions(CLI::App& command, CommonOptions& options, RulesFor rulesFor) {
    const std::string unlessTagged = ", unless the file says otherwise";
    addChoice<far::Boundary>(
        command, "--boundary", options.refinement.boundary, far::kBoundaryWords,
        "How the boundary is refined. sharp: corners, sharp edges and the boundary surface follow "
        "rules of their own; edge-only: the same, but the corner of a single cell or face is "
        "rounded; open: no rules of their own, and the refined region is smaller",
        "sharp" + unlessTagged);
    addChoice<far::Creasing>(
        command, "--creasing", options.refinement.creasing, far::kCreasingWords,
        "How semi-sharp edges lose sharpness from level to level. uniform: by 1; "
        "chaikin: also averaged along the crease",
        "uniform" + unlessTagged);
    addChoice<far::TriangleSubdivision>(command, "--triangles", options.refinement.triangles,
                                        far::kTriangleSubdivisionWords,
                                        "How triangles of a surface are refined. catmark: as all "
                                        "faces; smooth: by weights that make "
                                        "the surface smoother",
                                        "catmark" + unlessTagged);
    addChoice<far::SharpEdges>(command, "--sharp-edges", options.sharpEdges, far::kSharpEdgesWords,
                               "Which boundary edges are sharp. single-cell: edges of only one "
                               "cell; literal: edges between "
                               "vertices that lie in at most two cells");
    std::vector<Word<far::Rules>> rules;
    for (const auto& word : far::kRulesWords)
        if ((word.choice != far::Rules::Mlca || rulesFor != RulesFor::OpenSubdiv) &&
            (word.choice != far::Rules::Rats || rulesFor == RulesFor::Anything))
            rules.push_back(word);
    std::string help =
        "siggraph96, cse96: Catmull-Clark, in two versions for edges inside a lattice";
    if (rulesFor != RulesFor::OpenSubdiv) help += "; mlca: multilinear cell averaging";
    if (rulesFor == RulesFor::Anything) help += "; rats: RATS splines, for curves and meshes";
    addChoice<far::Rules>(command, "--rules", options.rules, rules, help);
}

void addEmbeddingOptions(CLI::App& command, CommonOptions& options) {
    options.outside = addChoice<embed::OutsidePolicy>(
        command, "--outside", options.embedding.outside, embed::kOutsidePolicyWords,
        "Points outside the lattice. keep: they stay where they are, without a warning if you give "
        "this word; nearest: they move with the nearest cell; error: they are an error");
    command
        .add_option(
            "--tolerance", options.embedding.tolerance,
            "How far outside a point still counts as inside, as a fraction of the diagonal of "
            "the lattice's bounding box")
        ->check(inRange(0, 1))
        ->capture_default_str();
}

void addRunOptions(CLI::App& command, CommonOptions& options) {
    command.add_flag("--quiet", options.quiet, "Print nothing but errors");
    command
        .add_option("--threads", options.threads,
                    "Largest number of threads; 0: one for each core. The results do not "
                    "depend on it")
        ->check(inRange(0, 4096, true))
        ->capture_default_str();
}

void addStrictOption(CLI::App& command, CommonOptions& options) {
    command.add_flag("--strict", options.strict,
                     "Refuse a model of which a part is not understood. By default a note on "
                     "standard error names the part, which is kept as it is");
}

void addMoveHeldOption(CLI::App& command, bool& movesHeld) {
    command.add_flag("--move-held", movesHeld,
                     "Move the vertices, too, that the lattice holds in place, such as the outer "
                     "vertices of a collar");
}

CLI::Option* addOutputOption(CLI::App& command, std::string& path, const std::string& help,
                             const std::string& name) {
    const CLI::Validator isNotDash(
        [](std::string& text) {
            return text == "-"
                       ? "- does not mean standard output: reports are printed there, and "
                         "the extension of a name tells the format. Use /dev/stdout, or for "
                         "a lattice a link to it with the extension of the format, and "
                         "--quiet"
                       : std::string();
        },
        "");
    return command.add_option(name, path, help)->check(isNotDash);
}

std::string filesToRead(io::FileContent content) {
    return io::listOfFormats(content, io::FileUse::Read);
}

std::string filesToWrite(io::FileContent content) {
    return io::listOfFormats(content, io::FileUse::Write);
}

std::string shown(const std::string& word) {
    return word.empty() ? "nothing" : word;
}

std::optional<double> numberOf(const std::string& word) {
    double number = 0;
    if (!CLI::detail::lexical_cast(word, number) || !std::isfinite(number)) return std::nullopt;
    return number;
}

CLI::Option* takeNumbers(CLI::Option* option, const std::string& names) {
    // The parser refuses too many numbers. The word -- ends the numbers: see endNumbers().
    return option->delimiter(',')
        ->check(isNumberOf("the numbers " + names))
        ->type_name(names)
        ->allow_extra_args();
}

CLI::Validator isNumberOf(const std::string& words) {
    return CLI::Validator(
        [words](std::string& text) {
            return numberOf(text) ? std::string()
                                  : "expected " + words + ", with spaces or commas between, got " +
                                        shown(text);
        },
        "");
}

namespace {

/// Returns the option that sets a field: "--minor-radius" for "minorRadius".
std::string optionOf(const std::string& field) {
    // The options that have other words than the field.
    static const std::map<std::string, std::string> kOthers = {
        {"cellSize", "size"},           {"cellsAlongLongest", "cells"}, {"frozen", "freeze"},
        {"gridCells", "grid"},          {"symmetryAt", "symmetry"},     {"joints", "joint"},
        {"limitTolerance", "tolerance"}};
    const auto other = kOthers.find(field);
    return "--" + (other != kOthers.end() ? other->second : separated(field, '-'));
}

}  // namespace

std::optional<std::string> messageOnOption(const CLI::App& command, const ArgumentError& error) {
    const auto endOfName = [](const std::string& field) {
        return std::min(field.find_first_of("[."), field.size());  // "joints[1].radius"
    };
    const std::string& field = error.field();
    if (command.get_option_no_throw(optionOf(field.substr(0, endOfName(field)))) == nullptr)
        return std::nullopt;
    return error.messageOfField([&](const std::string& name) {
        return optionOf(name.substr(0, endOfName(name))) + name.substr(endOfName(name));
    });
}

namespace {

/// Returns a check of one number.
/// \param expected the numbers that isAllowed() accepts, for the message
template <class IsAllowed>
CLI::Validator numberCheck(const std::string& expected, const std::string& nameInHelp,
                           IsAllowed isAllowed) {
    return CLI::Validator(
        [expected, isAllowed](std::string& text) {
            const auto number = numberOf(text);
            return number && isAllowed(*number) ? std::string()
                                                : "expected " + expected + ", got " + shown(text);
        },
        nameInHelp);
}

}  // namespace

CLI::Validator isWholeNumber(double least, double most) {
    return CLI::Validator(
        [least, most](std::string& text) {
            // The parser converts the same words; 1e3 is none.
            std::int64_t number = 0;
            const bool isWhole = numberOf(text) && CLI::detail::lexical_cast(text, number);
            return isWhole && static_cast<double>(number) >= least &&
                           static_cast<double>(number) <= most
                       ? std::string()
                       : fmt::format("expected a whole number, {} to {}, got {}", least, most,
                                     shown(text));
        },
        "");
}

CLI::Validator aboveZero(double most) {
    const bool isAny = most == std::numeric_limits<double>::max();
    const std::string limit = isAny ? "" : fmt::format(" and at most {}", most);
    return numberCheck("a number above 0" + limit, isAny ? "POSITIVE" : "POSITIVE" + limit,
                       [most](double number) { return number > 0 && number <= most; });
}

CLI::Validator inRange(double least, double most, bool whole) {
    const std::string ends = fmt::format("{} to {}", least, most);
    if (whole) return isWholeNumber(least, most).description(ends);
    return numberCheck(ends, ends,
                       [=](double number) { return number >= least && number <= most; });
}

void checkValues(CLI::App& command) {
    const CLI::Validator isName(
        [](std::string& text) {
            return std::string(text.empty() ? "expected the name of a file, got nothing" : "");
        },
        "");
    for (CLI::Option* option : command.get_options()) {
        const std::string type = option->get_type_name();
        if (type.find("FLOAT") != std::string::npos)
            option->check(numberCheck("a finite number", "", [](double) { return true; }));
        else if (type.find("INT") != std::string::npos)
            option->check(isWholeNumber());
        else if (type.find("TEXT") != std::string::npos)
            option->check(isName);
    }
    for (CLI::App* inner : command.get_subcommands({})) checkValues(*inner);
}

void addLevelOption(CLI::App& command, int& level, int least) {
    // Level 15 of a single cell has 8¹⁵ cells, far more than an index can count.
    constexpr int kMaxLevel = 15;
    command.add_option("-n,--level", level, "Refinement level: how many times to refine")
        ->check(inRange(least, kMaxLevel, true))
        ->capture_default_str();
}

}  // namespace espalier::cli
