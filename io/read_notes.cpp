// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>
#include <espalier/io/read_notes.h>

#include <algorithm>

namespace espalier::io {

std::string describe(const std::filesystem::path& path, const ReadNotes& notes) {
    constexpr std::size_t kMaxNamed = 5;
    const std::vector<Index>& dropped = notes.droppedVertices;
    if (dropped.empty()) return "";
    const bool isOne = dropped.size() == 1;
    std::string text = concat(shownPath(path), ": dropped ", dropped.size(),
                              isOne ? " unused vertex (vertex " : " unused vertices (vertices ");
    for (std::size_t i = 0; i < std::min(dropped.size(), kMaxNamed); ++i)
        text += concat(i == 0 ? "" : ", ", dropped[i]);
    return text + (dropped.size() > kMaxNamed ? ", ...)" : ")");
}

}  // namespace espalier::io
