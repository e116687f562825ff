// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>
#include <espalier/io/files/file.h>

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

// The container of glTF 2.0: JSON with buffers of bytes, in one binary file (.glb) or as text
// (.gltf) with its buffers in the text or in files beside it (Khronos, glTF 2.0 Specification,
// sections 3.6.1 and 4).

namespace espalier::io {

/// JSON whose objects keep the order of the file.
using Json = nlohmann::ordered_json;

/// A glTF file that was read: its JSON, and the bytes of its buffers.
class GltfFile {
public:
    /// Reads the JSON and all buffers, also from the files beside it that the JSON names.
    /// Decompresses meshes and views (gltf_compression.h).
    /// \param path for messages, and to find the files beside it
    /// \throws FileError if the file is no glTF 2.0, is damaged, or lacks a buffer
    GltfFile(const std::filesystem::path& path, std::string bytes);
    GltfFile(const GltfFile&) = delete;
    GltfFile& operator=(const GltfFile&) = delete;

    const std::filesystem::path& path() const { return path_; }

    /// The file as it was read.
    const std::string& bytes() const { return bytes_; }

    /// True for .glb.
    bool isBinary() const { return isBinary_; }

    const Json& json() const { return json_; }

    /// The chunks of a .glb that are neither JSON nor buffer, with their headers. A .gltf has no
    /// place for them.
    const std::string& otherChunks() const { return otherChunks_; }

    /// A list at the top of the JSON, such as "nodes"; empty if there is none.
    const Json& list(const char* name) const;

    /// An item of this list.
    /// \throws FileError if it does not exist
    const Json& item(const char* list, std::size_t index) const;

    std::size_t bufferCount() const { return buffers_.size(); }
    std::string_view buffer(std::size_t index) const;

    /// Returns `count` bytes of a buffer.
    /// \throws FileError if the buffer has fewer
    std::string_view bytesOf(std::size_t buffer, std::size_t offset, std::size_t count) const;

    /// Returns the bytes of a URI "data:...".
    /// \throws FileError if it is none
    std::string bytesOfData(std::string_view uri) const;

    /// The place of a buffer in the file that was read.
    enum class BufferSource { Binary, DataUri, File, None };
    BufferSource sourceOf(std::size_t buffer) const { return buffers_[buffer].source; }

    /// \throws FileError for this file
    [[noreturn]] void fail(const std::string& cause) const;

    /// Returns the number `key` of an object, an index or a size; nothing if there is none.
    /// \throws FileError if it is no whole number of at least 0
    std::optional<std::size_t> number(const Json& object, const char* key) const;

    /// The same with an error if there is none.
    std::size_t needNumber(const Json& object, const char* key) const;

    /// Returns the text `key` of an object; empty if there is none.
    static std::string text(const Json& object, const char* key);

    /// Returns an object in the "extensions" of another one; null if there is none.
    static const Json* extension(const Json& object, const char* name);

private:
    friend void decompress(GltfFile& file);

    struct Buffer {
        BufferSource source = BufferSource::None;
        std::size_t begin = 0, size = 0;  ///< the bytes of bytes_, if source is Binary
        std::string data = {};            ///< the bytes otherwise
    };

    void readJson(std::string_view text);
    void readBinary();
    void readBuffers(std::optional<std::pair<std::size_t, std::size_t>> binary);
    std::string bytesOfUri(std::string_view uri, BufferSource& source) const;

    std::filesystem::path path_;
    std::string bytes_;
    std::string otherChunks_;
    bool isBinary_ = false;
    Json json_;
    std::vector<Buffer> buffers_;
};

/// Returns a whole number as it stands in JSON, also as 3.0; nothing if it is none.
std::optional<std::size_t> wholeNumber(const Json& value);

/// Returns the text of JSON. Bytes that are no UTF-8 become U+FFFD, since JSON cannot hold them.
std::string textOf(const Json& json, int indent = -1);

/// Runs a function that reads JSON, and makes errors of the JSON library, such as a text where a
/// list belongs, errors of the file.
template <class F>
auto withJsonErrors(const std::filesystem::path& path, F f) {
    try {
        return f();
    } catch (const Json::exception& error) {
        throw FileError(path, concat("is malformed: ", error.what()));
    }
}

/// Returns true for a URI that names a file beside the glTF file: no data, scheme or root.
bool isRelativeUri(std::string_view uri);

/// Returns the path of a relative URI, and the URI of a relative path.
std::string pathOfUri(std::string_view uri);
std::string uriOfPath(std::string_view path);

/// A glTF file that is written again with changes. Copies only buffers that change.
class GltfEdit {
public:
    /// \param file must outlive this
    explicit GltfEdit(const GltfFile& file) : file_(file), json_(file.json()) {
        buffers_.resize(file.bufferCount());
    }

    Json& json() {
        isChanged_ = true;
        return json_;
    }

    /// Returns a buffer whose bytes may be changed.
    char* buffer(std::size_t index);

    /// Appends data to the first buffer, aligned to four bytes, and adds a view of it.
    /// \return number of the view
    std::size_t addView(std::string_view data);

    /// Writes the file as .glb or .gltf, by the extension of the path; without one of these, as it
    /// was read. It writes the bytes that were read if nothing has changed, the form is the same,
    /// and the files beside it have the same names from the new folder.
    ///
    /// A .glb gets all its buffers in itself. Beside a .gltf, buffers that have changed or were in
    /// a .glb are written to "NAME.bin" ("NAME_1.bin" ... if there are several, or the old file
    /// names one); buffers in the text stay there. Files beside the old file are named from the
    /// folder of the new one. \throws FileError if it cannot be written, or if a .glb would have 4
    /// GiB or more
    void write(const std::filesystem::path& path);

private:
    std::string_view current(std::size_t buffer) const;
    void moveUris(const std::filesystem::path& folder);
    void moveImages();
    std::filesystem::path newBufferPath(const std::filesystem::path& path,
                                        std::size_t& number) const;
    std::string binary();

    const GltfFile& file_;
    Json json_;
    std::vector<std::optional<std::string>> buffers_;  ///< those that have changed
    bool isChanged_ = false;
};

/// Returns the bytes of a binary glTF file (.glb).
/// \param path for messages
/// \param otherChunks whole chunks, with their headers
/// \throws FileError if it would have 4 GiB or more
std::string binaryGltf(const std::filesystem::path& path, std::string json, std::string_view data,
                       std::string_view otherChunks = {});

}  // namespace espalier::io
