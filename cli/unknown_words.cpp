// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "command_tree.h"
#include "options.h"

namespace espalier::cli {
namespace {

/// Returns whether a word is a number, finite or not.
bool isNumber(const std::string& word) {
    double number = 0;
    return CLI::detail::lexical_cast(word, number);
}

/// Returns the smallest number of changes that make b of a: insert, delete or replace a character,
/// or exchange two neighbours.
std::size_t editDistance(std::string_view a, std::string_view b) {
    // distances[i][j] is for the first i characters of a and the first j of b.
    std::vector distances(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
    for (std::size_t i = 0; i <= a.size(); ++i)
        for (std::size_t j = 0; j <= b.size(); ++j) {
            std::size_t& least = distances[i][j] = std::max(i, j);  // if i or j is 0
            if (i == 0 || j == 0) continue;
            least = std::min({distances[i - 1][j] + 1, distances[i][j - 1] + 1,
                              distances[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                least = std::min(least, distances[i - 2][j - 2] + 1);
        }
    return distances.back().back();
}

/// Returns "; did you mean NAME?" for the name nearest to a word; nothing if none is near.
std::string suggestion(const std::string& word, const std::vector<std::string>& names) {
    const auto letters = [](std::string_view text) {
        return text.substr(std::min(text.find_first_not_of('-'), text.size()));
    };
    // One letter in three may be wrong.
    std::size_t nearest = std::max<std::size_t>(1, letters(word).size() / 3) + 1;
    std::string found;
    for (const std::string& name : names) {
        const std::size_t distance = editDistance(letters(word), letters(name));
        if (letters(name).size() <= 1 || distance >= nearest) continue;
        nearest = distance;
        found = fmt::format("; did you mean {}?", name);
    }
    return found;
}

[[noreturn]] void refuse(const CLI::App& command, const char* kind, const std::string& word,
                         const std::vector<std::string>& names) {
    std::string name = command.get_name();
    for (const CLI::App* outer = command.get_parent(); outer != nullptr;
         outer = outer->get_parent())
        name = outer->get_name() + " " + name;
    const std::string nearest = suggestion(word, names);
    throw CLI::ValidationError(fmt::format("{} has no {} {}{}{} --help lists them", name, kind,
                                           word, nearest.empty() ? "; " : nearest + " ", name));
}

const CLI::App& findSubcommand(const CLI::App& command, const std::string& word) {
    std::vector<std::string> names;
    for (const CLI::App* inner : command.get_subcommands({})) {
        if (inner->get_name() == word) return *inner;
        names.push_back(inner->get_name());
    }
    refuse(command, "command", word, names);
}

/// \param word "--level", "--level=3", "-n" or "-n3"
const CLI::Option& findOption(const CLI::App& command, const std::string& word) {
    const std::string name =
        word.starts_with("--") ? word.substr(0, word.find('=')) : word.substr(0, 2);
    std::vector<std::string> all;
    for (const CLI::Option* option : command.get_options({}))
        for (const std::string& each : namesOf(*option)) {
            if (each == name) return *option;
            all.push_back(each);
        }
    if (isNumber(word)) throw CLI::ValidationError(word, "expected a finite number");
    refuse(command, "option", word.substr(0, word.find('=')), all);
}

/// Returns whether a word begins as options do. "-0.5" and "-" do not.
bool isOption(const std::string& word) {
    return word.size() > 1 && word[0] == '-' &&
           std::string_view("0123456789.").find(word[1]) == std::string_view::npos;
}

/// Returns the index of the last word that an option requires. The words after an option are its
/// values, also if they begin as options do.
/// \param at the index of the option in the words
std::size_t lastRequired(const CLI::Option& option, std::span<const std::string> words,
                         std::size_t at) {
    const std::string& word = words[at];
    const bool isValueInWord =
        word.find('=') != std::string::npos || (word[1] != '-' && word.size() > 2);
    const auto valuesIn = [&](const std::string& text) {
        const char delimiter = option.get_delimiter();
        return 1 + (delimiter == '\0' ? 0 : static_cast<int>(std::ranges::count(text, delimiter)));
    };
    int values = option.get_items_expected_min() - (isValueInWord ? valuesIn(word) : 0);
    while (values > 0 && at + 1 < words.size()) values -= valuesIn(words[++at]);
    return at;
}

/// Returns whether a word is numbers or percentages with a delimiter between: "1,2,3", "10%", or
/// "--cells=1,2,3".
bool isNumbers(const std::string& word, char delimiter) {
    const std::string numbers =
        isOption(word) && !isNumber(word) ? word.substr(word.find('=') + 1) : word;
    return std::ranges::all_of(CLI::detail::split(numbers, delimiter), [](std::string part) {
        if (part.ends_with('%')) part.pop_back();
        return isNumber(part);
    });
}

/// Refuses values that the parser would not take for values: -inf and -nan are groups of options to
/// it, and an empty word ends a group of words.
void refuseNoValue(const CLI::Option& option, const std::string& word) {
    if (word.starts_with('-') && isNumber(word) && !numberOf(word))
        throw CLI::ValidationError(option.get_name(), "expected a finite number, got " + word);
    const std::string type = option.get_type_name();
    if (word.empty() && option.get_delimiter() != '\0')
        throw CLI::ValidationError(
            option.get_name(),
            "expected " + (type == "INT" ? "whole numbers" : type) + ", got " + shown(word));
}

}  // namespace

const CLI::App& findCommand(const CLI::App& program, std::span<const std::string> words) {
    const CLI::App* command = &program;
    for (std::size_t i = 0; i < words.size() && words[i] != "--"; ++i) {
        if (command->get_allow_extras()) break;
        if (isOption(words[i]))
            i = lastRequired(findOption(*command, words[i]), words, i);
        else if (!command->get_subcommands({}).empty())
            command = &findSubcommand(*command, words[i]);
    }
    return *command;
}

void endNumbers(const CLI::App& command, std::vector<std::string>& words) {
    for (std::size_t i = 0; i < words.size() && words[i] != "--"; ++i) {
        if (command.get_allow_extras()) break;
        if (!isOption(words[i])) continue;
        const CLI::Option& option = findOption(command, words[i]);
        const std::size_t first = i;
        i = lastRequired(option, words, i);
        for (std::size_t k = first + 1; k <= i; ++k) refuseNoValue(option, words[k]);
        const char delimiter = option.get_delimiter();
        if (delimiter == '\0' || !option.get_allow_extra_args()) continue;
        while (i + 1 < words.size() &&
               (words[i + 1].empty() || isNumbers(words[i + 1], delimiter))) {
            refuseNoValue(option, words[++i]);
            // The parser takes -.5 for an option.
            if (words[i].starts_with("-.")) words[i].insert(1, "0");
        }
        if (i + 1 < words.size() && !isOption(words[i + 1]))
            words.insert(words.begin() + static_cast<std::ptrdiff_t>(++i), "--");
    }
}

}  // namespace espalier::cli
