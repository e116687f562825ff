// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace espalier::cli {

/// Returns the text of --version: the version with the commit, if it is known, the compiler, and
/// the optional libraries that are built in.
std::string versionText();

}  // namespace espalier::cli
