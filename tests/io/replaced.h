// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <support/test.h>

#include <string>

namespace espalier::test {

/// Returns a text whose first part `before`, which it must have, is `after`.
inline std::string replaced(std::string text, const std::string& before, const std::string& after) {
    const std::size_t at = text.find(before);
    EXPECT_NE(at, std::string::npos) << before;
    return text.replace(at, before.size(), after);
}

}  // namespace espalier::test
