// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/printable.h>

namespace espalier {

std::string inQuotes(std::string_view text) {
    constexpr std::size_t kMaxBytes = 40;
    std::string result = "'";
    return result.append(printable(text, kMaxBytes)).append("'");
}

}  // namespace espalier
