// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <string_view>
#include <vector>

#include "command_tree.h"
#include "options.h"

namespace espalier::cli {
namespace {

/// Returns the words that an option takes, separated by spaces; nothing if it takes other values.
std::string wordsOf(const CLI::Option& option) {
    std::string words = option.get_type_name();  // "keep|nearest|error" (addChoice)
    const bool areWords =
        words.find('|') != std::string::npos && std::ranges::all_of(words, [](char c) {
            return c == '|' || c == '-' || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
        });
    if (!areWords) return {};
    std::ranges::replace(words, '|', ' ');
    return words;
}

/// The branches of a `case` in the language of both shells: the words to offer, with the patterns
/// for which they are offered.
class Branches {
public:
    void add(const std::string& pattern, const std::string& words) {
        if (!words.empty()) patterns_[words].push_back("'" + pattern + "'");
    }

    std::string text() const {
        std::string text;
        for (const auto& [words, patterns] : patterns_)
            text +=
                fmt::format("    {})\n      choices='{}' ;;\n", fmt::join(patterns, " | "), words);
        return text;
    }

private:
    std::map<std::string, std::vector<std::string>> patterns_;
};

/// Returns commands that set `choices` from `command` ("espalier shape"), the word `before` and the
/// begin of the word to complete, `word`.
std::string choose(const CLI::App& program) {
    Branches values, options, commands;
    const auto add = [&](const CLI::App& command, const std::string& name) {
        std::vector<std::string> optionNames, commandNames;
        for (const CLI::Option* option : command.get_options({}))
            for (const std::string& each : namesOf(*option)) {
                optionNames.push_back(each);
                values.add(name + " " + each, wordsOf(*option));
            }
        for (const CLI::App* inner : command.get_subcommands({}))
            commandNames.push_back(inner->get_name());
        options.add(name, fmt::format("{}", fmt::join(optionNames, " ")));
        commands.add(name, fmt::format("{}", fmt::join(commandNames, " ")));
    };
    add(program, program.get_name());
    forEachCommand(program, add);
    return fmt::format(
        "  case \"$command $before\" in\n{}  esac\n"
        "  if [[ -z $choices && $word == -* ]]; then\n    case $command in\n{}    esac\n"
        "  elif [[ -z $choices ]]; then\n    case $command in\n{}    esac\n  fi\n",
        values.text(), options.text(), commands.text());
}

/// Returns commands that append the command `$1` to `command` if there is such a command.
std::string descend(const CLI::App& program, std::string_view word) {
    std::vector<std::string> names;
    forEachCommand(program, [&](const CLI::App&, const std::string& name) {
        names.push_back("'" + name + "'");
    });
    return fmt::format(
        "    case \"$command {0}\" in\n      {1})\n        command=\"$command {0}\" ;;\n"
        "    esac\n",
        word, fmt::join(names, " | "));
}

}  // namespace

std::string completionScript(const CLI::App& program, const std::string& shell) {
    if (shell == "bash")
        return "# Completion of espalier for bash, printed by espalier --completion bash.\n"
               "_espalier() {\n"
               "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]}\n"
               "  # bash splits --option=word into three words.\n"
               "  if [[ $word == = ]]; then\n    word=\n"
               "  elif [[ $before == = ]]; then\n    before=${COMP_WORDS[COMP_CWORD-2]}\n  fi\n"
               "  local command=espalier choices= i\n"
               "  for ((i = 1; i < COMP_CWORD; ++i)); do\n" +
               descend(program, "${COMP_WORDS[i]}") + "  done\n" + choose(program) +
               "  COMPREPLY=($(compgen -W \"$choices\" -- \"$word\"))\n"
               "}\n"
               "complete -o default -F _espalier espalier";
    if (shell == "zsh")
        return "#compdef espalier\n"
               "# Completion of espalier for zsh, printed by espalier --completion zsh.\n"
               "_espalier() {\n"
               "  local word=${words[CURRENT]} before=${words[CURRENT-1]}\n"
               "  if [[ $word == --*=* ]]; then\n"
               "    before=${word%%=*} word=${word#*=}\n    compset -P '*='\n  fi\n"
               "  local command=espalier choices= i\n"
               "  for ((i = 2; i < CURRENT; ++i)); do\n" +
               descend(program, "${words[i]}") + "  done\n" + choose(program) +
               "  if [[ -n $choices ]]; then\n    compadd -- ${=choices}\n  else\n    _files\n  "
               "fi\n"
               "}\n"
               "_espalier \"$@\"";
    throw CLI::ValidationError("--completion", "expected bash or zsh, got " + shown(shell));
}

}  // namespace espalier::cli
