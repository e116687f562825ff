// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/binding_file.h>
#include <espalier/io/byte_output.h>
#include <espalier/io/file.h>
#include <zlib.h>

#include <array>
#include <ostream>
#include <string_view>
#include <utility>
#include <vector>

namespace espalier::io {
namespace {

constexpr std::string_view kMagic = "ESPALIER";
constexpr std::uint32_t kVersion = 1;

/// What the file holds, in numbers.
struct Sizes {
    std::int64_t rows, columns, entries, kept, nameBytes, modelBytes;
};

/// Takes numbers off bytes that are known to be enough.
class NumberReader {
public:
    explicit NumberReader(std::string_view bytes) : bytes_(bytes) {}

    std::size_t left() const { return bytes_.size(); }
    std::string_view bytes(std::size_t count) {
        const std::string_view taken = bytes_.substr(0, count);
        bytes_.remove_prefix(count);
        return taken;
    }
    template <class Number>
    Number number() {
        return loadNumber<Number>(bytes(sizeof(Number)).data(), std::endian::little);
    }
    template <class Number>
    far::Array<Number> numbers(std::int64_t count) {
        far::Array<Number> result(static_cast<std::size_t>(count));
        for (Number& value : result) value = number<Number>();
        return result;
    }

private:
    std::string_view bytes_;
};

/// The sizes of the header; nothing if the file is not exactly as long as they say.
bool fitTheRest(const Sizes& sizes, std::size_t left) {
    // Subtracted part by part from what is there: no claim, however large, overflows.
    std::uint64_t room = left;
    const auto take = [&](std::int64_t count, std::uint64_t size) {
        if (count < 0 || static_cast<std::uint64_t>(count) > room / size) return false;
        room -= static_cast<std::uint64_t>(count) * size;
        return true;
    };
    return take(1, 8) && take(sizes.rows, 8) && take(sizes.entries, 8 + 4) &&
           take(sizes.kept, 3 * 8 + 4) && take(sizes.nameBytes, 1) && take(sizes.modelBytes, 1) &&
           room == sizeof(std::uint32_t);
}

Sizes readHeader(const std::filesystem::path& path, NumberReader& in, std::uint64_t& hash) {
    constexpr std::size_t kHeaderSize = 8 + 4 + 4 + 8 + 6 * 8;
    if (in.left() < kMagic.size() || in.bytes(kMagic.size()) != kMagic)
        throw FileError(path, "is not a bound model");
    if (in.left() + kMagic.size() < kHeaderSize) throw FileError(path, "is truncated");
    if (const auto version = in.number<std::uint32_t>(); version != kVersion)
        throw FileError(path, "has version " + std::to_string(version) + "; expected " +
                                  std::to_string(kVersion));
    in.number<std::uint32_t>();
    hash = in.number<std::uint64_t>();
    Sizes sizes{};
    for (std::int64_t* size : {&sizes.rows, &sizes.columns, &sizes.entries, &sizes.kept,
                               &sizes.nameBytes, &sizes.modelBytes})
        *size = in.number<std::int64_t>();
    if (!fitTheRest(sizes, in.left()))
        throw FileError(path, "is truncated or corrupted: its size is not what its header says");
    return sizes;
}

}  // namespace

void writeBoundModel(const std::filesystem::path& path, const BoundModel& model) {
    const stencils::StencilTable<double>& table = model.binding.table;
    writeFile(path, [&](std::ostream& stream) {
        ChecksummedOutput out(stream, std::endian::little);
        out.bytes(kMagic);
        out.number(kVersion);
        out.number(std::uint32_t{0});
        out.number(model.binding.topologyHash);
        out.number(std::int64_t{table.rowCount()});
        out.number(std::int64_t{table.columnCount()});
        out.number(std::int64_t{table.entryCount()});
        out.number(static_cast<std::int64_t>(model.binding.kept.size()));
        out.number(static_cast<std::int64_t>(model.modelName.size()));
        out.number(static_cast<std::int64_t>(model.modelBytes.size()));
        out.numbers(table.offsets());
        out.numbers(table.weights());
        for (const Point3& point : model.binding.keptAt)
            out.numbers(std::span<const double>(point));
        out.numbers(table.columns());
        out.numbers(std::span<const stencils::Index>(model.binding.kept));
        out.bytes(model.modelName);
        out.bytes(model.modelBytes);
        out.number(out.checksum());
    });
}

BoundModel readBoundModel(const std::filesystem::path& path) {
    return readBoundModel(path, readFile(path));
}

BoundModel readBoundModel(const std::filesystem::path& path, std::string_view bytes) {
    NumberReader in(bytes);
    BoundModel model;
    const Sizes sizes = readHeader(path, in, model.binding.topologyHash);
    const std::string_view checked = bytes.substr(0, bytes.size() - 4);
    const auto expected =
        loadNumber<std::uint32_t>(checked.data() + checked.size(), std::endian::little);
    const auto got = static_cast<std::uint32_t>(crc32_z(
        crc32_z(0, nullptr, 0), reinterpret_cast<const Bytef*>(checked.data()), checked.size()));
    if (expected != got) throw FileError(path, "is corrupted: its checksum does not match");

    auto offsets = in.numbers<stencils::Offset>(sizes.rows + 1);
    auto weights = in.numbers<double>(sizes.entries);
    for (std::int64_t i = 0; i < sizes.kept; ++i) {
        Point3& point = model.binding.keptAt.emplace_back();
        for (double& coordinate : point) coordinate = in.number<double>();
    }
    auto columns = in.numbers<stencils::Index>(sizes.entries);
    const auto keptPoints = in.numbers<stencils::Index>(sizes.kept);
    model.binding.kept.assign(keptPoints.begin(), keptPoints.end());
    model.modelName = in.bytes(static_cast<std::size_t>(sizes.nameBytes));
    model.modelBytes = in.bytes(static_cast<std::size_t>(sizes.modelBytes));
    // What follows no file of ours gets wrong, but one that was made to.
    if (sizes.columns < 0 || sizes.columns > far::kMaxIndex)
        throw FileError(path, "claims " + std::to_string(sizes.columns) + " lattice vertices");
    for (const stencils::Index kept : model.binding.kept)
        if (kept < 0 || kept >= sizes.rows)
            throw FileError(
                path, "keeps point " + std::to_string(kept) + " of " + std::to_string(sizes.rows));
    try {
        model.binding.table = stencils::StencilTable<double>(
            static_cast<stencils::Index>(sizes.columns), std::move(offsets), std::move(columns),
            std::move(weights));
    } catch (const Error& error) {
        throw FileError(path, error.what());
    }
    return model;
}

}  // namespace espalier::io
