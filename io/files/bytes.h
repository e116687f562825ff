// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/array.h>
#include <espalier/base/error.h>
#include <espalier/base/memory.h>
#include <espalier/base/progress.h>
#include <espalier/io/files/file.h>

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <ostream>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace espalier::io {

/// Reads the number at `bytes`, in this byte order. The bytes need no alignment.
template <class Number>
Number loadNumber(const char* bytes, std::endian order) {
    static_assert(std::is_arithmetic_v<Number>);
    char native[sizeof(Number)];
    std::memcpy(native, bytes, sizeof native);
    if (order != std::endian::native) std::reverse(native, native + sizeof native);
    Number number;
    std::memcpy(&number, native, sizeof native);
    return number;
}

/// Writes a number to `bytes`, in this byte order.
template <class Number>
void storeNumber(char* bytes, Number number, std::endian order) {
    static_assert(std::is_arithmetic_v<Number>);
    std::memcpy(bytes, &number, sizeof number);
    if (order != std::endian::native) std::reverse(bytes, bytes + sizeof number);
}

/// Thrown for data that cannot be decoded. what() is the cause only; callers that know the file and
/// the line convert it to a FileError (decodeFile).
class CodingError : public Error {
public:
    using Error::Error;
};

/// Reads numbers of one byte order from bytes. All functions throw a CodingError if they need more
/// bytes than are left, before they allocate memory.
class ByteInput {
public:
    /// \param bytes must outlive the views that bytes() returns
    ByteInput(std::string_view bytes, std::endian order) : bytes_(bytes), order_(order) {}

    /// Returns the number of bytes that are left.
    std::size_t left() const { return bytes_.size(); }

    /// Reads `count` bytes.
    std::string_view bytes(std::uint64_t count) {
        if (count > left()) failFor(concat(count, " bytes"));
        const std::string_view taken = bytes_.substr(0, count);
        bytes_.remove_prefix(count);
        return taken;
    }

    template <class Number>
    Number number() {
        return loadNumber<Number>(bytes(sizeof(Number)).data(), order_);
    }

    /// Reads numbers that are stored as type Stored.
    /// \throws CodingError naming the first number, counted from 0, that a Number cannot hold
    template <class Stored, class Number>
    Array<Number> numbersAs(std::uint64_t count) {
        if (count > left() / sizeof(Stored))
            failFor(concat(count, " numbers of ", sizeof(Stored), " bytes"));
        requireMemory(count * sizeof(Number), "its data");
        const std::string_view stored = bytes(count * sizeof(Stored));
        Array<Number> numbers(count);
        if (std::is_same_v<Stored, Number> && order_ == std::endian::native) {
            constexpr std::size_t kAtOnce = 1 << 22;  // a few milliseconds
            forEachBlock(stored.size(), kAtOnce, [&](std::size_t first, std::size_t last) {
                std::memcpy(reinterpret_cast<char*>(numbers.data()) + first, stored.data() + first,
                            last - first);
            });
            return numbers;
        }
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            checkCancelledEvery(i, 16);
            const auto number = loadNumber<Stored>(stored.data() + i * sizeof(Stored), order_);
            if (!fitsInto<Number>(number))
                throw CodingError(concat("number ", i, " is ", number, ", which is out of range"));
            numbers[i] = static_cast<Number>(number);
        }
        return numbers;
    }

private:
    /// Returns true if a Number can hold this value exactly. Real numbers are only read as reals of
    /// at least as many bits.
    template <class Number, class Stored>
    static bool fitsInto(Stored number) {
        if constexpr (std::is_floating_point_v<Stored>) {
            static_assert(std::is_floating_point_v<Number> && sizeof(Number) >= sizeof(Stored));
            return true;
        } else if constexpr (std::is_floating_point_v<Number>) {
            constexpr auto kLargest = std::int64_t{1} << std::numeric_limits<Number>::digits;
            return std::cmp_less_equal(number, kLargest) &&
                   std::cmp_greater_equal(number, -kLargest);
        } else {
            return std::in_range<Number>(number);
        }
    }

    [[noreturn]] void failFor(const std::string& expected) const {
        throw CodingError(concat("the data ends too early: ", expected, " are expected, ", left(),
                                 " bytes are there"));
    }

    std::string_view bytes_;
    std::endian order_;
};

/// Returns the result of `decode`. Converts a CodingError to a FileError for this file, and adds
/// the file to the message of a MemoryError.
template <class Decode>
auto decodeFile(const std::filesystem::path& path, Decode decode) {
    try {
        return decode();
    } catch (const CodingError& error) {
        throw FileError(path, error.what());
    } catch (const MemoryError& error) {
        throw MemoryError(shownPath(path) + ": " + error.what());
    }
}

/// Writes numbers in one byte order.
class ByteOutput {
public:
    ByteOutput(std::ostream& out, std::endian order) : out_(out), order_(order) {}
    virtual ~ByteOutput() = default;

    virtual void bytes(std::string_view bytes) {
        out_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        count_ += bytes.size();
    }

    /// Writes numbers, each in its own type.
    template <class... Numbers>
    void number(Numbers... numbers) {
        const auto one = [&](auto number) {
            char stored[sizeof number];
            storeNumber(stored, number, order_);
            bytes({stored, sizeof stored});
        };
        (one(numbers), ...);
    }

    /// Writes numbers as type Stored, which must hold them exactly.
    template <class Stored, class Number>
    void numbersAs(std::span<const Number> numbers) {
        if (std::is_same_v<Stored, Number> && order_ == std::endian::native)
            return bytes({reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()});
        constexpr std::size_t kBlock = 4096;
        std::array<char, kBlock * sizeof(Stored)> stored;
        while (!numbers.empty()) {
            const auto block = numbers.first(std::min(numbers.size(), kBlock));
            for (std::size_t i = 0; i < block.size(); ++i)
                storeNumber(stored.data() + i * sizeof(Stored), static_cast<Stored>(block[i]),
                            order_);
            bytes({stored.data(), block.size() * sizeof(Stored)});
            numbers = numbers.subspan(block.size());
        }
    }

    template <class Number>
    void numbers(std::span<const Number> numbers) {
        numbersAs<Number>(numbers);
    }

    /// Returns the number of bytes written.
    std::uint64_t count() const { return count_; }

private:
    std::ostream& out_;
    std::endian order_;
    std::uint64_t count_ = 0;
};

/// Returns the CRC-32 of bytes that follow other bytes.
/// \param before CRC-32 of the other bytes; 0 if there are none
inline std::uint32_t crc32Of(std::string_view bytes, std::uint32_t before = 0) {
    // zlib takes a null pointer for the start of a new checksum, so it gets no empty parts.
    constexpr std::size_t kAtOnce = 1 << 20;  // less than a millisecond
    forEachBlock(bytes.size(), kAtOnce, [&](std::size_t first, std::size_t last) {
        before = static_cast<std::uint32_t>(
            crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data() + first), last - first));
    });
    return before;
}

/// A ByteOutput that computes the CRC-32 of all bytes written.
class ChecksummedOutput : public ByteOutput {
public:
    using ByteOutput::ByteOutput;

    void bytes(std::string_view bytes) override {
        ByteOutput::bytes(bytes);
        crc_ = crc32Of(bytes, crc_);
    }
    std::uint32_t checksum() const { return crc_; }

private:
    std::uint32_t crc_ = 0;
};

}  // namespace espalier::io
