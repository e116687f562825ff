// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/files/file.h>
#include <espalier/io/model.h>
#include <support/temporary_folder.h>

#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>

#include "support/test.h"

namespace espalier::test {

inline void putFile(const std::filesystem::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

/// Returns the bytes that a model writes.
/// \param arguments positions, or positions and gradients
template <class... Arguments>
std::string written(const io::Model& model, const Arguments&... arguments) {
    const TemporaryFolder folder;
    const auto path = folder / ("out" + std::string(model.extension()));
    model.write(path, arguments...);
    return io::readFile(path);
}

/// Returns the bytes that a model writes if its points stay and all have this gradient.
inline std::string turned(const io::Model& model, const DeformationGradient& gradient) {
    return written(model, model.positions(),
                   std::vector<DeformationGradient>(model.positions().size(), gradient));
}

inline std::vector<Point3> copyOf(std::span<const Point3> points) {
    return {points.begin(), points.end()};
}

inline std::string withLineEnds(const std::string& text, const std::string& end) {
    std::string result;
    for (const char c : text) result += c == '\n' ? end : std::string(1, c);
    return result;
}

/// Returns the bytes of a number. This is independent of the code under test.
template <class Number>
std::string bytesOf(Number number, std::endian order) {
    std::string bytes(sizeof number, '\0');
    std::memcpy(bytes.data(), &number, sizeof number);
    if (order != std::endian::native) std::reverse(bytes.begin(), bytes.end());
    return bytes;
}

/// Truncates the file at every byte before `end`, and expects that each part is refused with a
/// FileError.
inline void expectPartsRefused(const std::string& name, const std::string& bytes, std::size_t end) {
    for (std::size_t size = 0; size < end; ++size)
        EXPECT_THROW(io::readModel(name, bytes.substr(0, size)), io::FileError)
            << name << " cut after byte " << size;
}

}  // namespace espalier::test
