// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/far/printable.h>

namespace espalier {

std::string inQuotes(std::string_view text) {
    constexpr std::size_t kMaxBytes = 40;
    std::string result = "'";
    return result.append(printable(text, kMaxBytes)).append("'");
}

}  // namespace espalier
