// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace espalier::cli {

/// Returns a script by which a shell completes commands, options and the words that options take;
/// names of files everywhere else.
/// \param shell "bash", for a file that bash sources; or "zsh", for a file _espalier in its $fpath
/// \throws CLI::ValidationError for another shell
std::string completionScript(const CLI::App& program, const std::string& shell);

}  // namespace espalier::cli
