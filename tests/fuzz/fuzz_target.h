// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

// Functions that all targets use. A target passes bytes to the library, and aborts if the library
// breaks a promise; the sanitizers find other errors.
namespace espalier::fuzz {

/// A fuzz target. It has the name of its corpus. All targets are made before main() runs.
class Target {
public:
    using Run = void (*)(std::string_view bytes);

    Target(const std::string& name, Run run) { all()[name] = run; }

    static std::map<std::string, Run>& all() {
        static std::map<std::string, Run> targets;
        return targets;
    }
};

/// Aborts if a promise is broken.
inline void require(bool isKept, const char* promise, const std::string& detail = {}) {
    if (isKept) return;
    std::fprintf(stderr, "broken promise: %s%s%s\n", promise, detail.empty() ? "" : ": ",
                 detail.c_str());
    std::abort();
}

/// Requires that a message is one line that a terminal can show.
inline void requireOneLine(const std::string& message) {
    for (const char c : message)
        require(static_cast<unsigned char>(c) >= ' ' && c != '\x7f',
                "a message is one line without control characters", message);
    require(message.size() < 1000, "a message is short", message);
}

/// Returns the result of work that may refuse its input; nothing if it threw an Error. Any other
/// exception ends the program, including std::bad_alloc.
template <class Work>
auto resultOf(Work work) -> std::optional<decltype(work())> {
    try {
        return work();
    } catch (const Error& error) {
        requireOneLine(error.what());
        return std::nullopt;
    }
}

/// The same for work that reads a file of this name. The message must begin with the name.
template <class Read>
auto readResult(const std::string& name, Read read) -> std::optional<decltype(read())> {
    try {
        return read();
    } catch (const Error& error) {
        requireOneLine(error.what());
        require(std::string_view(error.what()).substr(0, name.size()) == name,
                "a message names the file", error.what());
        return std::nullopt;
    }
}

/// Reads numbers from the bytes of an input; 0 after the end.
class Input {
public:
    explicit Input(std::string_view bytes) : bytes_(bytes) {}

    std::size_t left() const { return bytes_.size(); }
    std::uint8_t byte() { return take<std::uint8_t>(); }
    bool flag() { return byte() % 2 != 0; }
    /// Returns a number from 0 to count − 1.
    int choice(int count) { return byte() % count; }
    template <class Number>
    Number take() {
        Number number{};
        bytes_.remove_prefix(bytes_.copy(reinterpret_cast<char*>(&number), sizeof number));
        return number;
    }

private:
    std::string_view bytes_;
};

}  // namespace espalier::fuzz
