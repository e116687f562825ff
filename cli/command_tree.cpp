// SPDX-License-Identifier: Apache-2.0
#include "command_tree.h"

namespace espalier::cli {
namespace {

void visitCommands(const CLI::App& parent, const std::string& parentName,
                   const std::function<void(const CLI::App&, const std::string&)>& visit) {
    for (const CLI::App* command : parent.get_subcommands({})) {
        const std::string name = parentName + " " + command->get_name();
        visit(*command, name);
        visitCommands(*command, name, visit);
    }
}

}  // namespace

void forEachCommand(const CLI::App& program,
                    const std::function<void(const CLI::App&, const std::string&)>& visit) {
    visitCommands(program, program.get_name(), visit);
}

std::vector<const CLI::Option*> optionsOf(const CLI::App& command) {
    return command.get_options(
        [&](const CLI::Option* option) { return option != command.get_help_ptr(); });
}

std::vector<std::string> namesOf(const CLI::Option& option) {
    std::vector<std::string> names;
    for (const std::string& name : option.get_snames()) names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
    return names;
}

}  // namespace espalier::cli
