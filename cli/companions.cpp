// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <sstream>
#include <system_error>

#include "companions.h"

namespace espalier::cli {
namespace {

namespace fs = std::filesystem;

std::string lowerCase(std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

/// The kinds of files that a page opens beside a model: a model may name any file of its reader,
/// and a page is sent to others.
constexpr const char* kExtensions[] = {".mtl", ".bin",  ".png", ".jpg", ".jpeg",
                                       ".gif", ".webp", ".bmp", ".avif"};

class Finder {
public:
    /// Adds the file of a name. The folders of other computers do not count if the file is beside
    /// the model.
    /// \param folder of the file that has the name
    /// \return the file; empty if it is not there
    fs::path add(const fs::path& folder, const std::string& name) {
        const fs::path file = fileOf(folder, name);
        if (file.empty())
            addOnce(found.missing, name);
        else
            addOnce(found.files, file);
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
    /// Returns the file that a name means; empty if there is none in the folder or below it. A
    /// model of somebody else may name any file, and the page is sent to others.
    static fs::path fileOf(const fs::path& folder, std::string name) {
        if (name.find('\0') != std::string::npos) return {};
        std::ranges::replace(name, '\\', '/');
        const fs::path named(name);
        if (std::ranges::find(kExtensions, lowerCase(named.extension().string())) ==
            std::end(kExtensions))
            return {};
        std::error_code unknown;
        const fs::path top = fs::weakly_canonical(folder.empty() ? "." : folder, unknown);
        const auto isInside = [&](const fs::path& file) {
            const fs::path real = fs::weakly_canonical(file, unknown);
            return std::ranges::mismatch(top, real).in1 == top.end();
        };
        for (const fs::path& file : {folder / named.relative_path(), folder / named.filename()})
            if (fs::is_regular_file(file, unknown) && isInside(file)) return file;
        // Windows does not tell capital letters from small ones.
        std::vector<fs::path> alike;
        for (const auto& entry : fs::directory_iterator(folder.empty() ? "." : folder, unknown))
            if (lowerCase(entry.path().filename().string()) ==
                    lowerCase(named.filename().string()) &&
                entry.is_regular_file(unknown) && isInside(entry.path()))
                alike.push_back(folder / entry.path().filename());
        return alike.empty() ? fs::path() : *std::ranges::min_element(alike);
    }

    template <class Item>
    static void addOnce(std::vector<Item>& list, const Item& item) {
        if (std::ranges::find(list, item) == list.end()) list.push_back(item);
    }
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
        visitLines(io::readFile(library), [&](const std::string& keyword, const std::string& rest) {
            if (namesPicture(keyword)) finder.addAfterOptions(library.parent_path(), rest);
        });
}

/// Replaces %20 and its like.
std::string decoded(const std::string& uri) {
    std::string text;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        const bool isCode = uri[i] == '%' && i + 2 < uri.size() &&
                            std::isxdigit(static_cast<unsigned char>(uri[i + 1])) &&
                            std::isxdigit(static_cast<unsigned char>(uri[i + 2]));
        text += isCode ? static_cast<char>(std::stoi(uri.substr(i + 1, 2), nullptr, 16)) : uri[i];
        if (isCode) i += 2;
    }
    return text;
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
            if (uri.find(':') == std::string::npos) finder.add(folder, decoded(uri));
        }
    }
}

}  // namespace

Companions findCompanions(const fs::path& path, std::string_view bytes) {
    Finder finder;
    const fs::path folder = path.parent_path();
    const std::string extension = lowerCase(path.extension().string());
    if (extension == ".obj") findOfObj(folder, bytes, finder);
    if (extension == ".gltf") findOfGltf(folder, bytes, finder);
    return std::move(finder.found);
}

}  // namespace espalier::cli
