// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <string_view>
#include <vector>

#include "command_tree.h"

namespace espalier::cli {

namespace {

/// An option is described once for all commands if at least this number of them have it.
constexpr int kSharedBy = 5;

constexpr const char* kExamples = R"(.SH EXAMPLES
Make a lattice around model.obj, move some of its vertices in an editor that writes .vtu, .vtk or .ovm
(ParaView, for one), save it as pose.vtu, and deform the model:
.PP
.nf
.RS
espalier shape box \-\-cells 2 2 4 \-\-min \-1 \-1 0 \-\-max 1 1 4 \-o rest.vtu
espalier deform model.obj \-\-rest rest.vtu \-\-to pose.vtu \-o deformed.obj
.RE
.fi
.PP
Bind once, and apply poses later:
.PP
.nf
.RS
espalier bind model.obj \-\-rest rest.vtu \-o model.espb
espalier apply model.espb \-\-to pose.vtu \-o deformed.obj
.RE
.fi
.PP
Write the matrix of the deformation for SciPy:
.PP
.nf
.RS
espalier stencils rest.vtu \-\-points model.obj \-n 3 \-o D.npz
.RE
.fi
)";

/// Escapes the characters that troff would take for its own.
std::string escaped(std::string_view text) {
    std::string result;
    for (const char c : text)
        if (c == '-')
            result += "\\-";
        else if (c == '\\')
            result += "\\e";
        else
            result += c;
    if (result.starts_with('.') || result.starts_with('\'')) result.insert(0, "\\&");
    return result;
}

/// Escapes a text of the help, and ends it with a full stop.
std::string sentence(const std::string& text) {
    return escaped(text) + (text.ends_with('.') ? "" : ".");
}

std::string bold(std::string_view text) {
    return "\\fB" + escaped(text) + "\\fR";
}

std::string italic(std::string_view text) {
    return "\\fI" + escaped(text) + "\\fR";
}

/// Returns the words for the value of an option: "INT", "WORD|WORD", "" for flags.
std::string valueOf(const CLI::Option& option) {
    if (!option.get_option_text().empty()) return option.get_option_text();
    if (option.get_type_size() == 0) return {};
    std::string type = option.get_type_name();
    // A range is said as "INT:INT in [0 - 15]".
    if (const auto colon = type.find(':'); colon != std::string::npos) type.erase(0, colon + 1);
    if (option.get_expected_max() >= CLI::detail::expected_max_vector_size) type += " ...";
    return type;
}

/// Returns " Only with A and B.", from the words before and after; nothing if there are no options.
std::string withOthers(const std::set<CLI::Option*>& others, const char* before,
                       const char* after) {
    std::vector<std::string> names;
    for (const CLI::Option* other : others) names.push_back(bold(other->get_name()));
    std::sort(names.begin(), names.end());
    return names.empty() ? "" : fmt::format(" {}{}{}.", before, fmt::join(names, " and "), after);
}

/// Writes the paragraph on an option or an argument.
std::string entryOf(const CLI::Option& option) {
    std::string term;
    if (option.get_positional()) {
        term = italic(option.get_name(true, false));
        if (option.get_expected_max() >= CLI::detail::expected_max_vector_size) term += " ...";
    } else {
        term = bold(fmt::format("{}", fmt::join(namesOf(option), ", ")));
        if (const auto value = valueOf(option); !value.empty()) term += " " + italic(value);
    }
    std::string text = sentence(option.get_description());
    if (option.get_option_text().empty() && option.get_type_size() != 0) {
        if (!option.get_default_str().empty())
            text += " Default: " + escaped(option.get_default_str()) + ".";
        if (option.get_required() && !option.get_positional()) text += " Required.";
    }
    text += withOthers(option.get_needs(), "Only with ", "");
    text += withOthers(option.get_excludes(), "Not with ", "");
    return fmt::format(".TP\n{}\n{}\n", term, text);
}

/// Describes each command and the commands in it.
class Commands {
public:
    explicit Commands(const CLI::App& program) {
        std::map<std::string, int> counts;
        for (const CLI::App* command : program.get_subcommands({}))
            for (const CLI::Option* option : optionsOf(*command)) {
                const std::string entry = entryOf(*option);
                if (++counts[entry] == kSharedBy) shared_.push_back(entry);
            }
        forEachCommand(program, [this](const CLI::App& command, const std::string& name) {
            describe(command, name);
        });
    }

    const std::string& synopsis() const { return synopsis_; }
    const std::string& descriptions() const { return descriptions_; }
    const std::vector<std::string>& sharedEntries() const { return shared_; }

private:
    /// Returns "espalier bind MODEL --rest TEXT -o TEXT [OPTIONS]".
    static std::string usageOf(const CLI::App& command, const std::string& name) {
        std::string usage = bold(name);
        for (const CLI::Option* option : optionsOf(command))
            if (option->get_positional()) {
                usage += " " + italic(option->get_name(true, false));
                if (option->get_expected_max() > 1) usage += " ...";
            }
        if (!command.get_subcommands({}).empty()) return usage + " " + italic("NAME");
        for (const CLI::Option* option : optionsOf(command))
            if (option->get_required() && !option->get_positional()) {
                usage +=
                    fmt::format(" {} {}", bold(namesOf(*option).front()), italic(valueOf(*option)));
            }
        return usage + " [" + italic("OPTIONS") + "]";
    }

    void describe(const CLI::App& command, const std::string& name) {
        const std::string usage = usageOf(command, name);
        if (command.get_parent()->get_parent() == nullptr)
            synopsis_ += (synopsis_.empty() ? "" : ".br\n") + usage + "\n";
        descriptions_ += fmt::format(".SS {}\n{}\n.PP\n{}\n", escaped(name), usage,
                                     sentence(command.get_description()));
        for (const std::string& group : command.get_groups()) {
            std::string entries;
            std::vector<std::string> others;
            for (const CLI::Option* option : optionsOf(command)) {
                const bool isArgument = option->get_positional();
                if (!isArgument && option->get_group() != group) continue;
                if (isArgument && group != command.get_groups().front()) continue;
                const std::string entry = entryOf(*option);
                if (std::ranges::count(shared_, entry) == 0)
                    entries += entry;
                else
                    others.push_back(bold(option->get_name()));
            }
            if (group != command.get_groups().front())
                descriptions_ += ".PP\n" + escaped(group) + ":\n";
            descriptions_ += entries;
            if (!others.empty())
                descriptions_ += fmt::format(".PP\nAlso {} ({}).\n", fmt::join(others, ", "),
                                             bold("COMMON OPTIONS"));
        }
    }

    std::string synopsis_, descriptions_;
    std::vector<std::string> shared_;
};

}  // namespace

std::string manPage(const CLI::App& program, const std::string& version) {
    const Commands commands(program);
    std::string page = fmt::format(
        "'\\\" -*- coding: UTF-8 -*-\n"
        ".TH ESPALIER 1 \"\" \"espalier {}\" \"User Commands\"\n"
        ".nh\n.ad l\n"
        ".SH NAME\nespalier \\- deform models by lattices of any polyhedral topology\n"
        ".SH SYNOPSIS\n{}.SH DESCRIPTION\n{}\n.SH OPTIONS\n",
        version, commands.synopsis(), sentence(program.get_description()));
    for (const CLI::Option* option : program.get_options({})) page += entryOf(*option);
    page += ".PP\nEvery command has " + bold("--help") + " too.\n";
    page += ".SH COMMANDS\n" + commands.descriptions() + ".SH COMMON OPTIONS\n";
    for (const std::string& entry : commands.sharedEntries()) page += entry;
    page += ".SH EXIT STATUS\n" + sentence(kExitCodes) + "\n";
    return page + kExamples;
}

}  // namespace espalier::cli
