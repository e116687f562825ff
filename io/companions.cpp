// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/companions.h>
#include <espalier/io/files/file.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <system_error>
#include <utility>

#include <espalier/io/files/text_reader.h>
#include "gltf/gltf_file.h"

namespace espalier::io {
namespace {

namespace fs = std::filesystem;

/// The kinds of files that browsers show, or that hold points and materials.
constexpr const char* kExtensions[] = {".mtl", ".bin",  ".png", ".jpg", ".jpeg",
                                       ".gif", ".webp", ".bmp", ".avif"};

class Finder {
public:
    explicit Finder(fs::path folder)
        : folder_(std::move(folder)),
          top_(fs::weakly_canonical(folder_.empty() ? "." : folder_, unknown_)) {}

    /// Adds the file of a name.
    /// \param folder of the file that has the name
    /// \return the file; empty if it is not there
    fs::path add(const fs::path& folder, const std::string& name) {
        const fs::path file = fileOf(folder, name);
        if (file.empty()) {
            if (std::ranges::find(found.missing, name) == found.missing.end())
                found.missing.push_back(name);
        } else if (std::ranges::find(found.files, file, &Companion::file) == found.files.end()) {
            found.files.push_back({file.lexically_relative(folder_).generic_string(), file});
        }
        return file;
    }

    /// Adds the file whose name ends a line, after options: the longest end of which there is one.
    fs::path addAfterOptions(const fs::path& folder, const std::string& line) {
        for (std::size_t at = 0; at != std::string::npos; at = line.find_first_not_of(' ', at)) {
            if (const std::string name = line.substr(at); !fileOf(folder, name).empty())
                return add(folder, name);
            at = std::min(line.find(' ', at), line.size());
        }
        return add(folder, line.substr(line.rfind(' ') + 1));
    }

    Companions found;

private:
    /// Returns the file that a name means; empty if there is none.
    fs::path fileOf(const fs::path& folder, std::string name) {
        if (name.find('\0') != std::string::npos) return {};
        std::ranges::replace(name, '\\', '/');
        const fs::path named(name);
        if (std::ranges::find(kExtensions, lowerCase(named.extension().string())) ==
            std::end(kExtensions))
            return {};
        for (const fs::path& file : {folder / named.relative_path(), folder / named.filename()})
            if (isHere(file)) return file;
        const auto alike = filesBeside().find(lowerCase(named.filename().string()));
        return alike != filesBeside().end() && isHere(alike->second) ? alike->second : fs::path();
    }

    /// Returns true for a file in the folder of the model or below it.
    bool isHere(const fs::path& file) {
        if (!fs::is_regular_file(file, unknown_)) return false;
        const fs::path real = fs::weakly_canonical(file, unknown_);
        return std::mismatch(top_.begin(), top_.end(), real.begin(), real.end()).first ==
               top_.end();
    }

    /// Returns the files beside the model, by their names in small letters.
    const std::map<std::string, fs::path>& filesBeside() {
        if (filesBeside_) return *filesBeside_;
        filesBeside_.emplace();
        // Of several names that differ in their letters alone, the first in order.
        for (const std::string& name : namesIn(top_))
            filesBeside_->try_emplace(lowerCase(name), folder_ / name);
        return *filesBeside_;
    }

    std::error_code unknown_;
    fs::path folder_, top_;
    std::optional<std::map<std::string, fs::path>> filesBeside_;
};

/// Calls visit(keyword, rest) for each line of a text. Spaces and tabs around both are left out.
template <class Visit>
void visitLines(std::string_view text, const Visit& visit) {
    constexpr const char* kSpace = " \t\r";
    std::istringstream lines{std::string(text)};
    for (std::string line; std::getline(lines, line);) {
        std::ranges::replace(line, '\t', ' ');
        const std::size_t begin = line.find_first_not_of(kSpace);
        if (begin == std::string::npos) continue;
        const std::size_t end = std::min(line.find(' ', begin), line.size());
        const std::size_t rest = line.find_first_not_of(kSpace, end);
        if (rest == std::string::npos) continue;
        const std::size_t last = line.find_last_not_of(kSpace);
        visit(line.substr(begin, end - begin), line.substr(rest, last + 1 - rest));
    }
}

bool namesPicture(const std::string& keyword) {
    const std::string word = lowerCase(keyword);
    constexpr const char* kOthers[] = {"bump", "disp", "decal", "refl", "norm"};
    return word.starts_with("map_") || std::ranges::find(kOthers, word) != std::end(kOthers);
}

void findOfObj(const fs::path& folder, std::string_view bytes, Finder& finder) {
    std::vector<fs::path> libraries;
    visitLines(bytes, [&](const std::string& keyword, const std::string& rest) {
        if (keyword != "mtllib") return;
        const fs::path file = finder.addAfterOptions(folder, rest);
        if (!file.empty() && std::ranges::find(libraries, file) == libraries.end())
            libraries.push_back(file);
    });
    for (const fs::path& library : libraries)
        visitLines(readFile(library), [&](const std::string& keyword, const std::string& rest) {
            if (namesPicture(keyword)) finder.addAfterOptions(library.parent_path(), rest);
        });
}

void findOfGltf(const fs::path& folder, std::string_view bytes, Finder& finder) {
    const auto json = nlohmann::json::parse(bytes, nullptr, false);
    if (!json.is_object()) return;
    for (const char* list : {"buffers", "images"}) {
        const auto entries = json.find(list);
        if (entries == json.end() || !entries->is_array()) continue;
        for (const auto& entry : *entries) {
            if (!entry.is_object() || !entry.contains("uri") || !entry["uri"].is_string()) continue;
            const std::string uri = entry["uri"];
            if (isRelativeUri(uri)) finder.add(folder, pathOfUri(uri));
        }
    }
}

}  // namespace

Companions findCompanions(const fs::path& path, std::string_view bytes) {
    const fs::path folder = path.parent_path();
    Finder finder(folder);
    const std::string extension = lowerCase(path.extension().string());
    if (extension == ".obj") findOfObj(folder, bytes, finder);
    if (extension == ".gltf") findOfGltf(folder, bytes, finder);
    return std::move(finder.found);
}

}  // namespace espalier::io
