// SPDX-License-Identifier: Apache-2.0
#include "gltf_compression.h"

#include <espalier/base/error.h>
#include <espalier/base/memory.h>
#include <espalier/base/progress.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "../files/number_types.h"
#include "gltf_accessor.h"
#include "gltf_file.h"

#ifdef ESPALIER_WITH_DRACO
#include <draco/compression/decode.h>
#include <meshoptimizer.h>
#endif

namespace espalier::io {
namespace {

constexpr const char* kDraco = "KHR_draco_mesh_compression";
/// The second is the name of a newer version, which has streams of the older one, too.
constexpr const char* kMeshopt[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};

#ifndef ESPALIER_WITH_DRACO
[[noreturn]] void failWithout(const GltfFile& file, const char* extension) {
    file.fail(concat("has meshes that are compressed by ", extension,
                     ", and this build of Espalier lacks the library that reads them; write the "
                     "file without compression first (gltf-transform copy IN OUT)"));
}
#endif

/// The decoded data, in the order in which they are added.
struct Decoded {
    std::string bytes;

    /// Adds data, aligned to four bytes, and returns their offset.
    std::size_t add(std::string_view data) {
        bytes.append((4 - bytes.size() % 4) % 4, '\0');
        const std::size_t offset = bytes.size();
        bytes += data;
        return offset;
    }
};

/// Removes an extension from an object, and the list of extensions if it was the last.
void removeExtension(Json& object, const char* name) {
    Json& extensions = object["extensions"];
    extensions.erase(name);
    if (extensions.empty()) object.erase("extensions");
}

/// Removes an extension from the lists of extensions that the file uses.
void removeUse(Json& json, const char* name) {
    for (const char* key : {"extensionsUsed", "extensionsRequired"}) {
        if (!json.contains(key) || !json[key].is_array()) continue;
        Json& names = json[key];
        for (std::size_t i = names.size(); i-- > 0;)
            if (names[i] == name) names.erase(i);
        if (names.empty()) json.erase(key);
    }
}

#ifdef ESPALIER_WITH_DRACO
/// Returns the attribute's values of all points, as the accessor stores them.
std::string valuesOf(const GltfFile& file, const draco::PointCloud& mesh,
                     const draco::PointAttribute& attribute, const GltfAccessor& accessor) {
    return visitStored(accessor.type, [&](auto zero) {
        using Stored = decltype(zero);
        std::string bytes(accessor.count * accessor.elementSize(), '\0');
        auto* values = reinterpret_cast<Stored*>(bytes.data());
        for (draco::PointIndex point(0); point < mesh.num_points(); ++point) {
            checkCancelledEvery(point.value(), 12);
            if (!attribute.ConvertValue<Stored>(attribute.mapped_index(point),
                                                static_cast<std::int8_t>(accessor.components),
                                                values + point.value() * accessor.components))
                file.fail(concat("a value of a mesh in ", kDraco, " cannot be read as ",
                                 accessor.components, " numbers of ", byteSize(accessor.type),
                                 " bytes"));
        }
        return bytes;
    });
}

std::string cornersOf(const draco::Mesh& mesh, NumberType type) {
    return visitStored(type, [&](auto zero) {
        using Stored = decltype(zero);
        std::string bytes(3 * mesh.num_faces() * sizeof(Stored), '\0');
        auto* corner = reinterpret_cast<Stored*>(bytes.data());
        for (draco::FaceIndex face(0); face < mesh.num_faces(); ++face)
            for (const draco::PointIndex& point : mesh.face(face))
                *corner++ = static_cast<Stored>(point.value());
        return bytes;
    });
}

/// Sets the bounds of an accessor that has bounds. Compression has changed its numbers.
void setBounds(Json& json, const GltfAccessor& accessor, const std::string& data) {
    if ((!json.contains("min") && !json.contains("max")) || data.empty()) return;
    visitStored(accessor.type, [&](auto zero) {
        using Stored = decltype(zero);
        const auto* values = reinterpret_cast<const Stored*>(data.data());
        std::vector<Stored> low(values, values + accessor.components), high = low;
        for (std::size_t i = 0; i < data.size() / sizeof(Stored); ++i) {
            Stored& least = low[i % accessor.components];
            Stored& most = high[i % accessor.components];
            least = std::min(least, values[i]);
            most = std::max(most, values[i]);
        }
        json["min"] = low;
        json["max"] = high;
    });
}

/// Adds the data of an accessor of this primitive.
/// \param count number of elements that were decoded
void setData(const GltfFile& file, Json& json, std::size_t accessor, std::size_t count,
             const std::string& data, Decoded& decoded) {
    setBounds(json["accessors"][accessor], accessorOf(file, accessor), data);
    Json& made = json["accessors"][accessor];
    if (made["count"] != count)
        file.fail(concat("accessor ", accessor, " claims ", made["count"].dump(), " elements, and ",
                         kDraco, " has ", count));
    made["bufferView"] = json["bufferViews"].size();
    made.erase("byteOffset");
    json["bufferViews"].push_back({{"buffer", file.bufferCount()},
                                   {"byteOffset", decoded.add(data)},
                                   {"byteLength", data.size()}});
}

void decodeDraco(const GltfFile& file, const Json& extension, const Json& primitive, Json& json,
                 Decoded& decoded) {
    const Json& view = file.item("bufferViews", file.needNumber(extension, "bufferView"));
    const std::string_view bytes =
        file.bytesOf(file.needNumber(view, "buffer"), file.number(view, "byteOffset").value_or(0),
                     file.needNumber(view, "byteLength"));
    draco::DecoderBuffer buffer;
    buffer.Init(bytes.data(), bytes.size());
    draco::Decoder decoder;
    auto result = decoder.DecodeMeshFromBuffer(&buffer);
    if (!result.ok())
        file.fail(concat("a mesh in ", kDraco, " is damaged: ", result.status().error_msg()));
    const std::unique_ptr<draco::Mesh> mesh = std::move(result).value();
    const auto attributes = extension.find("attributes");
    if (attributes == extension.end() || !attributes->is_object())
        file.fail(concat("a mesh in ", kDraco, " has no attributes"));
    for (const auto& [name, id] : attributes->items()) {
        const std::size_t index = file.needNumber(primitive.at("attributes"), name.c_str());
        const GltfAccessor accessor = accessorOf(file, index);
        const draco::PointAttribute* attribute = mesh->GetAttributeByUniqueId(
            static_cast<std::uint32_t>(file.needNumber(*attributes, name.c_str())));
        if (!attribute)
            file.fail(concat("a mesh in ", kDraco, " lacks the attribute ", inQuotes(name)));
        if (accessor.count != mesh->num_points())
            file.fail(concat("accessor ", index, " claims ", accessor.count, " elements, and ",
                             kDraco, " has ", mesh->num_points()));
        setData(file, json, index, mesh->num_points(), valuesOf(file, *mesh, *attribute, accessor),
                decoded);
    }
    if (const auto indices = file.number(primitive, "indices")) {
        const GltfAccessor accessor = accessorOf(file, *indices);
        const std::size_t largest = visitStored(accessor.type, [](auto zero) {
            return static_cast<std::size_t>(std::numeric_limits<decltype(zero)>::max());
        });
        if (!isInteger(accessor.type) || accessor.components != 1 ||
            largest + 1 < mesh->num_points())
            file.fail(concat("accessor ", *indices, " cannot hold the indices of ",
                             mesh->num_points(), " points"));
        setData(file, json, *indices, 3 * std::size_t{mesh->num_faces()},
                cornersOf(*mesh, accessor.type), decoded);
    }
}

std::string decodeMeshopt(const GltfFile& file, const Json& extension, const char* name) {
    // The format has at least one byte for 16 bytes of one column, and one byte for a triangle.
    constexpr std::size_t kMaxRatio = 256;
    const std::string_view bytes = file.bytesOf(file.needNumber(extension, "buffer"),
                                                file.number(extension, "byteOffset").value_or(0),
                                                file.needNumber(extension, "byteLength"));
    const std::size_t count = file.needNumber(extension, "count");
    const std::size_t stride = file.needNumber(extension, "byteStride");
    const std::string mode = GltfFile::text(extension, "mode");
    const std::string filter = GltfFile::text(extension, "filter");
    const bool isVertices = mode == "ATTRIBUTES";
    if (isVertices ? stride == 0 || stride > 256 || stride % 4 != 0 : stride != 2 && stride != 4)
        file.fail(concat("a view in ", name, " has the stride ", stride));
    if (saturatingProduct(count, stride) > saturatingProduct(kMaxRatio, bytes.size()) ||
        (mode == "TRIANGLES" && count % 3 != 0))
        file.fail(concat("a view in ", name, " claims ", count, " elements, which ", bytes.size(),
                         " bytes cannot hold"));
    requireMemory(count * stride, "a decompressed view");
    std::string data(count * stride, '\0');
    const auto* from = reinterpret_cast<const unsigned char*>(bytes.data());
    const int status =
        isVertices ? meshopt_decodeVertexBuffer(data.data(), count, stride, from, bytes.size())
        : mode == "TRIANGLES"
            ? meshopt_decodeIndexBuffer(data.data(), count, stride, from, bytes.size())
        : mode == "INDICES"
            ? meshopt_decodeIndexSequence(data.data(), count, stride, from, bytes.size())
            : -1;
    if (status != 0) file.fail(concat("a view in ", name, " is damaged, or of a newer version"));
    if (!isVertices && !filter.empty() && filter != "NONE")
        file.fail(concat("a view of indices in ", name, " has a filter"));
    if (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8))
        meshopt_decodeFilterOct(data.data(), count, stride);
    else if (filter == "QUATERNION" && stride == 8)
        meshopt_decodeFilterQuat(data.data(), count, stride);
    else if (filter == "EXPONENTIAL")
        meshopt_decodeFilterExp(data.data(), count, stride);
    else if (!filter.empty() && filter != "NONE")
        file.fail(concat("a view in ", name, " has the filter ", inQuotes(filter),
                         " and elements of ", stride, " bytes"));
    return data;
}
#else
void decodeDraco(const GltfFile& file, const Json&, const Json&, Json&, Decoded&) {
    failWithout(file, kDraco);
}

std::string decodeMeshopt(const GltfFile& file, const Json&, const char* name) {
    failWithout(file, name);
}
#endif

}  // namespace

void decompress(GltfFile& file) {
    Json json = file.json();
    Decoded decoded;
    const auto hasViews = [&](std::size_t buffer) {
        return std::ranges::any_of(json["bufferViews"], [&](const Json& view) {
            return view.contains("buffer") && view["buffer"] == buffer;
        });
    };
    bool usesMeshopt = false, usesDraco = false;
    for (const char* name : kMeshopt) {
        for (std::size_t i = 0; i < file.list("bufferViews").size(); ++i) {
            checkCancelled();
            const Json* extension = GltfFile::extension(file.item("bufferViews", i), name);
            if (!extension) continue;
            usesMeshopt = true;
            const std::string data = decodeMeshopt(file, *extension, name);
            Json& view = json["bufferViews"][i];
            view["buffer"] = file.bufferCount();
            view["byteOffset"] = decoded.add(data);
            view["byteLength"] = data.size();
            removeExtension(view, name);
        }
        if (!usesMeshopt) continue;
        // The buffers that programs without the extension read are marked by it.
        for (Json& buffer : json["buffers"])
            if (GltfFile::extension(buffer, name)) removeExtension(buffer, name);
        removeUse(json, name);
    }
    const auto finish = [&] {
        // These buffers have neither bytes nor views any more.
        for (std::size_t i = file.bufferCount(); i-- > 0;) {
            if (file.sourceOf(i) != GltfFile::BufferSource::None || hasViews(i)) continue;
            json["buffers"].erase(i);
            file.buffers_.erase(file.buffers_.begin() + std::ptrdiff_t(i));
            for (Json& view : json["bufferViews"])
                if (view["buffer"] > i) view["buffer"] = view["buffer"].get<std::size_t>() - 1;
        }
        json["buffers"].push_back({{"byteLength", decoded.bytes.size()}});
        file.buffers_.push_back({GltfFile::BufferSource::None, 0, 0, std::move(decoded.bytes)});
        file.json_ = std::move(json);
    };
    if (usesMeshopt) {
        finish();
        json = file.json();
        decoded = {};
    }
    const Json& meshes = file.list("meshes");
    for (std::size_t m = 0; m < meshes.size(); ++m) {
        const auto primitives = meshes[m].find("primitives");
        if (primitives == meshes[m].end() || !primitives->is_array()) continue;
        for (std::size_t p = 0; p < primitives->size(); ++p) {
            checkCancelled();
            const Json& primitive = (*primitives)[p];
            const Json* extension = GltfFile::extension(primitive, kDraco);
            if (!extension) continue;
            if (!primitive.contains("attributes"))
                file.fail(concat("a mesh in ", kDraco, " has no attributes"));
            usesDraco = true;
            decodeDraco(file, *extension, primitive, json, decoded);
            Json& plain = json["meshes"][m]["primitives"][p];
            removeExtension(plain, kDraco);
            plain["mode"] = 4;  // Draco's decoder returns triangles, of strips as well
        }
    }
    if (!usesDraco) return;
    removeUse(json, kDraco);
    finish();
}

}  // namespace espalier::io
