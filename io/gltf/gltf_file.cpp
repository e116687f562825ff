// SPDX-License-Identifier: Apache-2.0
#include "gltf_file.h"

#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/io/files/base64.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <limits>
#include <ostream>
#include <system_error>
#include <utility>

#include "../files/bytes.h"
#include "../files/coding.h"
#include "gltf_compression.h"

namespace espalier::io {
namespace {

// Numbers of the specification: the magic "glTF", the version, and the types of chunks.
constexpr std::uint32_t kGltfMagic = 0x46546C67, kGltfVersion = 2, kJsonChunk = 0x4E4F534A,
                        kBinaryChunk = 0x004E4942;
constexpr std::size_t kGltfHeaderSize = 12, kChunkHeaderSize = 8;

/// The JSON of real files nests about ten values. A limit keeps the stack of dump() small.
constexpr int kMaxDepth = 200;

std::uint32_t loadWord(std::string_view bytes, std::size_t offset) {
    return loadNumber<std::uint32_t>(bytes.data() + offset, std::endian::little);
}

bool isSchemeCharacter(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '+' || c == '-' || c == '.';
}

std::string extensionOf(const std::filesystem::path& path) {
    return lowerCase(path.extension().string());
}

/// Returns how deep the values of a text nest, if it is JSON.
int depthOf(std::string_view text) {
    int depth = 0, deepest = 0;
    bool isText = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        checkCancelledEvery(i, 20);
        const char c = text[i];
        if (isText && c == '\\')
            ++i;
        else if (c == '"')
            isText = !isText;
        else if (!isText && (c == '[' || c == '{'))
            deepest = std::max(deepest, ++depth);
        else if (!isText && (c == ']' || c == '}'))
            --depth;
    }
    return deepest;
}

}  // namespace

std::optional<std::size_t> wholeNumber(const Json& value) {
    if (value.is_number_unsigned()) return value.get<std::size_t>();
    if (value.is_number_integer() && value.get<std::int64_t>() >= 0)
        return static_cast<std::size_t>(value.get<std::int64_t>());
    if (!value.is_number_float()) return std::nullopt;
    const double number = value.get<double>();
    constexpr double kMaxExact = 9007199254740992;  // 2^53
    if (!(number >= 0 && number <= kMaxExact && number == std::floor(number))) return std::nullopt;
    return static_cast<std::size_t>(number);
}

GltfFile::GltfFile(const std::filesystem::path& path, std::string bytes)
    : path_(path), bytes_(std::move(bytes)) {
    isBinary_ = bytes_.starts_with("glTF");
    if (isBinary_)
        readBinary();
    else {
        readJson(bytes_);
        readBuffers(std::nullopt);
    }
    decompress(*this);
}

void GltfFile::fail(const std::string& cause) const {
    throw FileError(path_, cause);
}

void GltfFile::readBinary() {
    if (bytes_.size() < kGltfHeaderSize) fail("the file ends within its header");
    if (const std::uint32_t version = loadWord(bytes_, 4); version != kGltfVersion)
        fail(concat("is binary glTF of version ", version, "; expected version 2"));
    const std::size_t claimed = loadWord(bytes_, 8);
    if (claimed > bytes_.size())
        fail(concat("the file ends; its header claims ", claimed, " bytes, got ", bytes_.size()));
    std::optional<std::pair<std::size_t, std::size_t>> json, binary;
    for (std::size_t at = kGltfHeaderSize; at + kChunkHeaderSize <= claimed;) {
        const std::size_t size = loadWord(bytes_, at);
        const std::uint32_t type = loadWord(bytes_, at + 4);
        at += kChunkHeaderSize;
        if (size > bytes_.size() - at)
            fail(concat("the file ends; a chunk at byte ", at, " claims ", size, " bytes, got ",
                        bytes_.size() - at));
        if (type == kJsonChunk && !json)
            json.emplace(at, size);
        else if (type == kBinaryChunk && !binary)
            binary.emplace(at, size);
        else
            otherChunks_ += bytes_.substr(at - kChunkHeaderSize, kChunkHeaderSize + size);
        at += size;
    }
    if (!json) fail("has no chunk of JSON");
    readJson(std::string_view(bytes_).substr(json->first, json->second));
    readBuffers(binary);
}

void GltfFile::readJson(std::string_view text) {
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    if (depthOf(text) > kMaxDepth) fail(concat("its JSON nests more than ", kMaxDepth, " values"));
    try {
        json_ = Json::parse(text.begin(), text.end());
    } catch (const Json::exception& error) {
        // The message of the library begins with a number in brackets.
        const std::string_view message = error.what();
        const std::size_t begin = message.find("] ");
        fail(concat("is no JSON, which a .gltf is: ",
                    message.substr(begin == std::string_view::npos ? 0 : begin + 2)));
    }
    if (!json_.is_object() || !json_.contains("asset") || !json_["asset"].is_object())
        fail("is no glTF 2.0: its JSON has no \"asset\"");
    const std::string version = GltfFile::text(json_["asset"], "version");
    if (!version.starts_with("2."))
        // Files of glTF 1.0 may lack the number.
        fail(concat("is glTF ", version.empty() ? "1.0" : inQuotes(version),
                    "; expected 2.0: open it in a program that reads it, and export it again"));
}

void GltfFile::readBuffers(std::optional<std::pair<std::size_t, std::size_t>> binary) {
    const Json& buffers = list("buffers");
    for (std::size_t i = 0; i < buffers.size(); ++i) {
        const Json& json = buffers[i];
        const std::size_t size = needNumber(json, "byteLength");
        const std::string uri = text(json, "uri");
        Buffer& buffer = buffers_.emplace_back();
        if (uri.empty()) {
            if (i > 0 || !binary) continue;
            buffer = {BufferSource::Binary, binary->first, binary->second, {}};
        } else {
            buffer.data = bytesOfUri(uri, buffer.source);
        }
        if (this->buffer(i).size() < size)
            fail(concat("buffer ", i, " claims ", size, " bytes, got ", this->buffer(i).size()));
    }
}

std::string GltfFile::bytesOfUri(std::string_view uri, BufferSource& source) const {
    if (!isRelativeUri(uri)) {
        source = BufferSource::DataUri;
        return bytesOfData(uri);
    }
    source = BufferSource::File;
    const std::filesystem::path file = path_.parent_path() / pathOfUri(uri);
    std::error_code error;
    if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error))
        fail(concat("its buffer ", inQuotes(uri.substr(0, 80)), " is no regular file"));
    try {
        return readFile(file);
    } catch (const FileError& cause) {
        fail(concat("its buffer is in another file, which cannot be read: ", cause.what()));
    }
}

std::string GltfFile::bytesOfData(std::string_view uri) const {
    const std::size_t comma = uri.find(',');
    if (!uri.starts_with("data:") || comma == std::string_view::npos)
        fail(concat("its data are at ", inQuotes(uri.substr(0, 80)),
                    "; expected data in the text, or a file beside the .gltf"));
    const std::string_view data = uri.substr(comma + 1);
    if (!uri.substr(0, comma).ends_with(";base64")) return pathOfUri(data);
    return decodeFile(path_, [&] {
        // Some exporters leave out the padding.
        std::string digits(data.substr(0, data.find_last_not_of('=') + 1));
        const std::size_t count = digits.size() * 3 / 4;
        digits.append((4 - digits.size() % 4) % 4, kBase64Padding);
        return Base64Reader(digits).read(count);
    });
}

const Json& GltfFile::list(const char* name) const {
    static const Json kEmpty = Json::array();
    const auto found = json_.find(name);
    if (found == json_.end()) return kEmpty;
    if (!found->is_array()) fail(concat("its ", inQuotes(name), " is no list"));
    return *found;
}

const Json& GltfFile::item(const char* name, std::size_t index) const {
    const Json& items = list(name);
    if (index >= items.size())
        fail(concat("item ", index, " of ", inQuotes(name), " does not exist; there are ",
                    items.size()));
    if (!items[index].is_object())
        fail(concat("item ", index, " of ", inQuotes(name), " is no object"));
    return items[index];
}

std::string_view GltfFile::buffer(std::size_t index) const {
    const Buffer& buffer = buffers_[index];
    if (buffer.source != BufferSource::Binary) return buffer.data;
    return std::string_view(bytes_).substr(buffer.begin, buffer.size);
}

std::string_view GltfFile::bytesOf(std::size_t index, std::size_t offset, std::size_t count) const {
    if (index >= bufferCount())
        fail(concat("buffer ", index, " does not exist; there are ", bufferCount()));
    const std::string_view bytes = buffer(index);
    if (offset > bytes.size() || count > bytes.size() - offset)
        fail(concat("expected ", count, " bytes at byte ", offset, " of buffer ", index,
                    ", which has ", bytes.size()));
    return bytes.substr(offset, count);
}

std::optional<std::size_t> GltfFile::number(const Json& object, const char* key) const {
    const auto found = object.find(key);
    if (found == object.end()) return std::nullopt;
    const auto number = wholeNumber(*found);
    if (!number)
        fail(concat(inQuotes(key), " is ", inQuotes(found->dump().substr(0, 80)),
                    "; expected a whole number of at least 0"));
    return number;
}

std::size_t GltfFile::needNumber(const Json& object, const char* key) const {
    const auto found = object.is_object() ? number(object, key) : std::nullopt;
    if (!found) fail(concat("an object lacks ", inQuotes(key)));
    return *found;
}

std::string GltfFile::text(const Json& object, const char* key) {
    const auto found = object.find(key);
    return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

const Json* GltfFile::extension(const Json& object, const char* name) {
    const auto extensions = object.find("extensions");
    if (extensions == object.end() || !extensions->is_object()) return nullptr;
    const auto found = extensions->find(name);
    return found != extensions->end() && found->is_object() ? &*found : nullptr;
}

bool isRelativeUri(std::string_view uri) {
    std::size_t end = 0;
    while (end < uri.size() && isSchemeCharacter(uri[end])) ++end;
    return !uri.empty() && uri[0] != '/' && uri[0] != '\\' &&
           !(end < uri.size() && uri[end] == ':');
}

std::string pathOfUri(std::string_view uri) {
    std::string path;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        constexpr std::string_view kDigits = "0123456789abcdef";
        if (uri[i] == '%' && i + 2 < uri.size()) {
            const auto digit = [&](std::size_t at) {
                return kDigits.find(
                    static_cast<char>(std::tolower(static_cast<unsigned char>(uri[at]))));
            };
            if (digit(i + 1) != std::string_view::npos && digit(i + 2) != std::string_view::npos) {
                path += static_cast<char>(16 * digit(i + 1) + digit(i + 2));
                i += 2;
                continue;
            }
        }
        path += uri[i];
    }
    return path;
}

std::string uriOfPath(std::string_view path) {
    constexpr std::string_view kDigits = "0123456789ABCDEF", kPlain = "-._~/!$&'()*+,;=@";
    std::string uri;
    for (const char c : path) {
        const auto byte = static_cast<unsigned char>(c);
        if ((byte < 0x80 && std::isalnum(byte) != 0) || kPlain.find(c) != std::string_view::npos)
            uri += c;
        else
            uri += {'%', kDigits[byte / 16], kDigits[byte % 16]};
    }
    return uri;
}

char* GltfEdit::buffer(std::size_t index) {
    isChanged_ = true;
    if (!buffers_[index]) buffers_[index] = std::string(file_.buffer(index));
    return buffers_[index]->data();
}

std::string_view GltfEdit::current(std::size_t index) const {
    return buffers_[index] ? std::string_view(*buffers_[index]) : file_.buffer(index);
}

std::size_t GltfEdit::addView(std::string_view data) {
    Json& json = this->json();
    if (buffers_.empty()) {
        buffers_.emplace_back(std::string());
        json["buffers"] = Json::array({Json{{"byteLength", 0}}});
    }
    buffer(0);
    std::string& bytes = *buffers_[0];
    bytes.append((4 - bytes.size() % 4) % 4, '\0');
    Json& views = json["bufferViews"];
    views.push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", data.size()}});
    bytes += data;
    json["buffers"][0]["byteLength"] = bytes.size();
    return views.size() - 1;
}

std::string textOf(const Json& json, int indent) {
    return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

std::string binaryGltf(const std::filesystem::path& path, std::string json, std::string_view data,
                       std::string_view otherChunks) {
    json.append((4 - json.size() % 4) % 4, ' ');
    const std::size_t padding = (4 - data.size() % 4) % 4;
    const std::size_t size = kGltfHeaderSize + kChunkHeaderSize + json.size() +
                             (data.empty() ? 0 : kChunkHeaderSize + data.size() + padding) +
                             otherChunks.size();
    if (size > std::numeric_limits<std::uint32_t>::max())
        throw FileError(path, concat("cannot be written: a .glb would have ", size,
                                     " bytes, and at most 4294967295 are possible; name the output "
                                     ".gltf"));
    std::string bytes;
    bytes.reserve(size);
    const auto word = [&](std::size_t number) {
        char stored[4];
        storeNumber(stored, static_cast<std::uint32_t>(number), std::endian::little);
        bytes.append(stored, sizeof stored);
    };
    for (const std::size_t number : {std::size_t{kGltfMagic}, std::size_t{kGltfVersion}, size})
        word(number);
    word(json.size());
    word(kJsonChunk);
    bytes += json;
    if (!data.empty()) {
        word(data.size() + padding);
        word(kBinaryChunk);
        bytes += data;
        bytes.append(padding, '\0');
    }
    bytes += otherChunks;
    return bytes;
}

/// Renames the files beside the old file from the folder of the new one.
void GltfEdit::moveUris(const std::filesystem::path& folder) {
    const auto old = std::filesystem::absolute(file_.path()).parent_path().lexically_normal();
    const auto now = std::filesystem::absolute(folder / "file").parent_path().lexically_normal();
    if (old == now) return;
    for (const char* list : {"buffers", "images"}) {
        if (!json_.contains(list)) continue;
        for (std::size_t i = 0; i < json_[list].size(); ++i) {
            const std::string uri = GltfFile::text(json_[list][i], "uri");
            if (!isRelativeUri(uri)) continue;
            const auto moved = (old / pathOfUri(uri)).lexically_normal().lexically_relative(now);
            json()[list][i]["uri"] = uriOfPath(moved.generic_string());
        }
    }
}

/// Moves the images in the text to views, as a .glb has them.
void GltfEdit::moveImages() {
    if (!json_.contains("images") || buffers_.empty()) return;
    for (std::size_t i = 0; i < json_["images"].size(); ++i) {
        const std::string uri = GltfFile::text(json_["images"][i], "uri");
        if (!uri.starts_with("data:")) continue;
        const std::string type = uri.substr(5, uri.find_first_of(";,") - 5);
        const std::size_t view = addView(file_.bytesOfData(uri));
        Json& image = json()["images"][i];
        image.erase("uri");
        image["bufferView"] = view;
        if (!image.contains("mimeType")) image["mimeType"] = type;
    }
}

/// Makes one buffer of all, and returns its bytes.
std::string GltfEdit::binary() {
    if (!file_.isBinary()) moveImages();
    std::string bytes;
    std::vector<std::size_t> begins;
    for (std::size_t i = 0; i < buffers_.size(); ++i) {
        bytes.append((4 - bytes.size() % 4) % 4, '\0');
        begins.push_back(bytes.size());
        bytes += current(i);
    }
    const bool isOne = buffers_.size() == 1 && !json_["buffers"][0].contains("uri");
    if (buffers_.empty() || isOne) return bytes;
    Json& json = this->json();
    for (Json& view : json["bufferViews"]) {
        const std::size_t buffer = file_.needNumber(view, "buffer");
        if (buffer >= begins.size())
            file_.fail(concat("a view is of buffer ", buffer, "; there are ", begins.size()));
        view["byteOffset"] = view.value("byteOffset", std::size_t{0}) + begins[buffer];
        view["buffer"] = 0;
    }
    Json first = json["buffers"][0];
    first.erase("uri");
    first["byteLength"] = bytes.size();
    json["buffers"] = Json::array({first});
    return bytes;
}

/// Returns a path beside the new file that no file of the old one has.
/// \param number counts the calls, and is increased
std::filesystem::path GltfEdit::newBufferPath(const std::filesystem::path& path,
                                              std::size_t& number) const {
    const auto isTaken = [&](const std::filesystem::path& name) {
        for (const char* list : {"buffers", "images"})
            for (const Json& item : file_.list(list)) {
                const std::string uri = GltfFile::text(item, "uri");
                if (isRelativeUri(uri) && std::filesystem::weakly_canonical(
                                              file_.path().parent_path() / pathOfUri(uri)) ==
                                              std::filesystem::weakly_canonical(name))
                    return true;
            }
        return false;
    };
    while (true) {
        std::filesystem::path name = path.stem();
        name += number == 0 ? ".bin" : concat("_", number, ".bin");
        ++number;
        if (!isTaken(path.parent_path() / name)) return path.parent_path() / name;
    }
}

void GltfEdit::write(const std::filesystem::path& path) {
    const std::string extension = extensionOf(path);
    const bool isBinary = extension == ".glb" || (extension != ".gltf" && file_.isBinary());
    const bool isNamed = extension == ".glb" || extension == ".gltf";
    moveUris(isNamed ? path.parent_path() : file_.path().parent_path());
    if (!isChanged_ && isBinary == file_.isBinary())
        return writeFile(path, [&](std::ostream& out) { out << file_.bytes(); });
    if (isBinary) {
        const std::string data = binary();
        return writeFile(path, [&](std::ostream& out) {
            out << binaryGltf(path, textOf(json_), data, file_.otherChunks());
        });
    }
    std::vector<FileToWrite> files;
    std::size_t number = 0;
    for (std::size_t i = 0; i < buffers_.size(); ++i) {
        const auto source =
            i < file_.bufferCount() ? file_.sourceOf(i) : GltfFile::BufferSource::None;
        const bool isStored =
            source == GltfFile::BufferSource::DataUri || source == GltfFile::BufferSource::File;
        // A buffer without bytes belongs to an extension.
        if (!buffers_[i] && (isStored || current(i).empty())) continue;
        if (source == GltfFile::BufferSource::DataUri || !isNamed) {
            json()["buffers"][i]["uri"] =
                "data:application/octet-stream;base64," + encodeBase64(current(i));
            continue;
        }
        const std::filesystem::path target = newBufferPath(path, number);
        json()["buffers"][i]["uri"] = uriOfPath(target.filename().generic_string());
        files.push_back({target, [this, i](std::ostream& out) { out << current(i); }});
    }
    files.push_back({path, [&](std::ostream& out) { out << textOf(json_, 2) << '\n'; }});
    writeFiles(files);
}

}  // namespace espalier::io
