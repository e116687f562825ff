// SPDX-License-Identifier: Apache-2.0
#include "gltf_accessor.h"

#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/io/files/file.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include "../files/bytes.h"

namespace espalier::io {
namespace {

NumberType typeOf(const GltfFile& file, const Json& json) {
    constexpr std::pair<std::size_t, NumberType> kTypes[] = {
        {5120, NumberType::Int8},   {5121, NumberType::UInt8},  {5122, NumberType::Int16},
        {5123, NumberType::UInt16}, {5125, NumberType::UInt32}, {5126, NumberType::Float32}};
    const std::size_t number = file.needNumber(json, "componentType");
    for (const auto& [code, type] : kTypes)
        if (code == number) return type;
    file.fail(concat("an accessor has the component type ", number,
                     "; expected 5120 to 5123, 5125 or 5126"));
}

std::size_t componentsOf(const GltfFile& file, const Json& json) {
    constexpr std::pair<std::string_view, std::size_t> kTypes[] = {
        {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4},
        {"MAT2", 4},   {"MAT3", 9}, {"MAT4", 16}};
    const std::string name = GltfFile::text(json, "type");
    for (const auto& [type, components] : kTypes)
        if (type == name) return components;
    file.fail(concat("an accessor has the type ", inQuotes(name),
                     "; expected SCALAR, VEC2 to VEC4 "
                     "or MAT2 to MAT4"));
}

/// Returns the bytes of elements in a view, after a check that the view has them.
/// \param elementSize bytes of an element, and from one to the next if the view does not say it
GltfAccessor::View viewOf(const GltfFile& file, std::size_t index, std::size_t offset,
                          std::size_t count, std::size_t elementSize) {
    const Json& json = file.item("bufferViews", index);
    GltfAccessor::View view;
    view.buffer = file.needNumber(json, "buffer");
    view.stride = file.number(json, "byteStride").value_or(elementSize);
    const std::size_t begin = file.number(json, "byteOffset").value_or(0);
    const std::size_t size = file.needNumber(json, "byteLength");
    file.bytesOf(view.buffer, begin, size);
    if (view.stride < elementSize)
        file.fail(concat("view ", index, " has elements every ", view.stride,
                         " bytes, which is less than the ", elementSize, " of an element"));
    const std::size_t extent =
        count == 0 ? 0 : saturatingProduct(count - 1, view.stride) + elementSize;
    if (offset > size || extent > size - offset || extent < elementSize * (count > 0 ? 1 : 0))
        file.fail(concat("an accessor of ", count, " elements needs ", extent, " bytes at byte ",
                         offset, " of view ", index, ", which has ", size));
    view.offset = begin + offset;
    return view;
}

/// Reads a number of this type, with integers normalized or as they are.
double loadComponent(const char* bytes, NumberType type, bool isNormalized) {
    return visitStored(type, [&](auto zero) -> double {
        using Stored = decltype(zero);
        const auto stored = static_cast<double>(loadNumber<Stored>(bytes, std::endian::little));
        if (!isNormalized) return stored;
        return std::max(stored / static_cast<double>(std::numeric_limits<Stored>::max()), -1.0);
    });
}

/// Copies elements of a view to `numbers`, each to where `slotOf` says.
template <class SlotOf>
void loadElements(const GltfFile& file, const GltfAccessor& accessor,
                  const GltfAccessor::View& view, std::size_t count, SlotOf slotOf,
                  std::vector<double>& numbers) {
    const char* bytes = file.buffer(view.buffer).data() + view.offset;
    const std::size_t size = byteSize(accessor.type);
    for (std::size_t i = 0; i < count; ++i) {
        checkCancelledEvery(i, 14);
        for (std::size_t c = 0; c < accessor.components; ++c)
            numbers[slotOf(i) * accessor.components + c] = loadComponent(
                bytes + i * view.stride + c * size, accessor.type, accessor.isNormalized);
    }
}

/// Replaces the elements that a sparse accessor has elsewhere.
void loadSparse(const GltfFile& file, const GltfAccessor& accessor, const Json& json,
                std::vector<double>& numbers) {
    const auto part = [&](const char* name) -> const Json& {
        const auto found = json.find(name);
        if (found == json.end() || !found->is_object())
            file.fail(concat("a sparse accessor lacks ", inQuotes(name)));
        return *found;
    };
    const std::size_t count = file.needNumber(json, "count");
    const Json& where = part("indices");
    const Json& values = part("values");
    const NumberType type = typeOf(file, where);
    if (type != NumberType::UInt8 && type != NumberType::UInt16 && type != NumberType::UInt32)
        file.fail("the indices of a sparse accessor are no unsigned integers");
    const auto at = viewOf(file, file.needNumber(where, "bufferView"),
                           file.number(where, "byteOffset").value_or(0), count, byteSize(type));
    const auto from =
        viewOf(file, file.needNumber(values, "bufferView"),
               file.number(values, "byteOffset").value_or(0), count, accessor.elementSize());
    const char* indices = file.buffer(at.buffer).data() + at.offset;
    const auto slotOf = [&](std::size_t i) {
        const std::int64_t slot = loadInteger(indices + i * at.stride, type, std::endian::little);
        if (std::cmp_greater_equal(slot, accessor.count))
            file.fail(concat("a sparse accessor replaces element ", slot, " of ", accessor.count));
        return static_cast<std::size_t>(slot);
    };
    loadElements(file, accessor, from, count, slotOf, numbers);
}

/// Returns an accessor; nothing if it is malformed, and so belongs to nothing that is read.
std::optional<GltfAccessor> readableAccessor(const GltfFile& file, std::size_t index) {
    try {
        return accessorOf(file, index);
    } catch (const FileError&) {
        return std::nullopt;
    }
}

}  // namespace

GltfAccessor accessorOf(const GltfFile& file, std::size_t index) {
    const Json& json = file.item("accessors", index);
    GltfAccessor accessor;
    accessor.type = typeOf(file, json);
    accessor.components = componentsOf(file, json);
    accessor.count = file.needNumber(json, "count");
    const auto normalized = json.find("normalized");
    accessor.isNormalized = normalized != json.end() && normalized->is_boolean() &&
                            normalized->get<bool>() && isInteger(accessor.type);
    const auto sparse = json.find("sparse");
    accessor.isSparse = sparse != json.end() && sparse->is_object();
    if (const auto view = file.number(json, "bufferView"))
        accessor.view = viewOf(file, *view, file.number(json, "byteOffset").value_or(0),
                               accessor.count, accessor.elementSize());
    return accessor;
}

std::vector<double> numbersOf(const GltfFile& file, std::size_t index) {
    const GltfAccessor accessor = accessorOf(file, index);
    // Elements without bytes are zero. A damaged count must not fill the memory.
    std::size_t size = file.bytes().size();
    for (std::size_t i = 0; i < file.bufferCount(); ++i) size += file.buffer(i).size();
    if (!accessor.view && accessor.count > size)
        file.fail(concat("accessor ", index, " claims ", accessor.count,
                         " elements without a view; the file has ", size, " bytes"));
    std::vector<double> numbers(accessor.count * accessor.components);
    if (accessor.view)
        loadElements(
            file, accessor, *accessor.view, accessor.count, [](std::size_t i) { return i; },
            numbers);
    if (accessor.isSparse)
        loadSparse(file, accessor, file.item("accessors", index)["sparse"], numbers);
    return numbers;
}

std::vector<Point3> vectorsOf(const GltfFile& file, std::size_t index, const char* what,
                              std::optional<std::size_t> count) {
    const GltfAccessor accessor = accessorOf(file, index);
    if (accessor.components != 3 && accessor.components != 4)
        file.fail(concat("accessor ", index, " has ", what, " of ", accessor.components,
                         " numbers; expected 3"));
    if (count && accessor.count != *count)
        file.fail(concat("accessor ", index, " has ", accessor.count, " ", what, "; expected ",
                         *count, ", one per position"));
    const std::vector<double> numbers = numbersOf(file, index);
    std::vector<Point3> vectors(accessor.count);
    for (std::size_t i = 0; i < vectors.size(); ++i)
        std::copy_n(numbers.begin() + std::ptrdiff_t(i * accessor.components), 3,
                    vectors[i].begin());
    return vectors;
}

std::vector<Index> indicesOf(const GltfFile& file, std::size_t index, std::size_t count) {
    const GltfAccessor accessor = accessorOf(file, index);
    if (accessor.components != 1 || !isInteger(accessor.type))
        file.fail(concat("accessor ", index, " is no list of indices, which a primitive needs"));
    std::vector<Index> corners;
    corners.reserve(accessor.count);
    for (const double number : numbersOf(file, index)) {
        if (!(number >= 0 && number < static_cast<double>(count)))
            file.fail(concat("accessor ", index, " has the index ", number,
                             ", which is not the number of a point; there are ", count));
        corners.push_back(static_cast<Index>(number));
    }
    return corners;
}

std::size_t writeVectors(GltfEdit& edit, const GltfFile& file, std::size_t index,
                         std::span<const Point3> vectors, GltfOwnership ownership) {
    const GltfAccessor accessor = accessorOf(file, index);
    const Json& before = file.item("accessors", index);
    // A fourth number, such as the handedness of a tangent, stays.
    std::vector<double> numbers = numbersOf(file, index);
    const std::size_t components = accessor.components;
    for (std::size_t i = 0; i < vectors.size(); ++i)
        std::ranges::copy(vectors[i], numbers.begin() + std::ptrdiff_t(i * components));

    Json bounds = Json::object();
    if ((before.contains("min") || before.contains("max")) && !vectors.empty()) {
        std::vector<float> low(components, std::numeric_limits<float>::max());
        std::vector<float> high(components, std::numeric_limits<float>::lowest());
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            const auto number = static_cast<float>(numbers[i]);
            low[i % components] = std::min(low[i % components], number);
            high[i % components] = std::max(high[i % components], number);
        }
        bounds = {{"min", low}, {"max", high}};
    }

    const bool isInPlace = ownership.isOwn && ownership.isAlone && accessor.isPlain();
    std::string data(isInPlace ? 0 : 4 * numbers.size(), '\0');
    const std::size_t stride = isInPlace ? accessor.view->stride : 4 * components;
    char* bytes =
        isInPlace ? edit.buffer(accessor.view->buffer) + accessor.view->offset : data.data();
    for (std::size_t i = 0; i < numbers.size(); ++i)
        storeNumber(bytes + i / components * stride + i % components * 4,
                    static_cast<float>(numbers[i]), std::endian::little);
    if (isInPlace) {
        for (const auto& [key, value] : bounds.items())
            if (before.value(key, Json()) != value) edit.json()["accessors"][index][key] = value;
        return index;
    }
    Json made = before;
    for (const char* key : {"byteOffset", "normalized", "sparse"}) made.erase(key);
    made["bufferView"] = edit.addView(data);
    made["componentType"] = 5126;
    made.update(bounds);
    Json& accessors = edit.json()["accessors"];
    if (ownership.isOwn) {
        accessors[index] = std::move(made);
        return index;
    }
    accessors.push_back(std::move(made));
    return accessors.size() - 1;
}

std::vector<bool> overlappingAccessors(const GltfFile& file) {
    struct Range {
        std::size_t buffer, begin, end, stride, size, accessor;
        auto key() const { return std::pair(buffer, begin); }
    };
    std::vector<Range> ranges;
    const std::size_t count = file.list("accessors").size();
    for (std::size_t i = 0; i < count; ++i) {
        const std::optional<GltfAccessor> accessor = readableAccessor(file, i);
        if (!accessor || accessor->count == 0) continue;
        if (accessor->view)
            ranges.push_back({accessor->view->buffer, accessor->view->offset,
                              accessor->view->offset + accessor->extent(), accessor->view->stride,
                              accessor->elementSize(), i});
        if (!accessor->isSparse) continue;
        // The views of a sparse accessor: all their bytes.
        const Json& sparse = file.item("accessors", i)["sparse"];
        for (const char* part : {"indices", "values"}) {
            const auto found = sparse.find(part);
            const auto number = found == sparse.end() || !found->is_object()
                                    ? std::nullopt
                                    : file.number(*found, "bufferView");
            if (!number || *number >= file.list("bufferViews").size()) continue;
            const Json& view = file.item("bufferViews", *number);
            const std::size_t begin = file.number(view, "byteOffset").value_or(0);
            ranges.push_back({file.needNumber(view, "buffer"), begin,
                              begin + file.needNumber(view, "byteLength"), 0, 0, i});
        }
    }
    std::sort(ranges.begin(), ranges.end(),
              [](const Range& a, const Range& b) { return a.key() < b.key(); });
    // Interleaved elements of one stride lie beside each other if their phases do.
    const auto areApart = [](const Range& a, const Range& b) {
        if (a.stride != b.stride || a.stride == 0) return false;
        const std::size_t phase = (b.begin - a.begin) % a.stride;
        return phase >= a.size && phase + b.size <= a.stride;
    };
    std::vector<bool> overlaps(count);
    std::vector<const Range*> open;  // ranges that may reach beyond the current one
    for (const Range& range : ranges) {
        checkCancelledEvery(range.accessor, 8);
        std::erase_if(open, [&](const Range* other) {
            return other->buffer != range.buffer || other->end <= range.begin;
        });
        // Interleaved elements share no byte. More ranges than this cannot be interleaved.
        constexpr std::size_t kMaxInterleaved = 256;
        const bool isCrowded = open.size() > kMaxInterleaved;
        for (const Range* other : open)
            if (isCrowded || !areApart(*other, range))
                overlaps[range.accessor] = overlaps[other->accessor] = true;
        open.push_back(&range);
        if (isCrowded)
            open = {*std::max_element(open.begin(), open.end(), [](const Range* a, const Range* b) {
                return a->end < b->end;
            })};
    }
    return overlaps;
}

}  // namespace espalier::io
