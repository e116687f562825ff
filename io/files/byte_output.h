// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <zlib.h>
#include "byte_order.h"

#include <array>
#include <cstdint>
#include <ostream>
#include <span>
#include <string_view>

namespace espalier::io {

/// Writes numbers in one order of bytes.
class ByteOutput {
public:
    ByteOutput(std::ostream& out, std::endian order) : out_(out), order_(order) {}
    virtual ~ByteOutput() = default;

    virtual void bytes(std::string_view bytes) {
        out_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        count_ += bytes.size();
    }

    template <class Number>
    void number(Number number) {
        char stored[sizeof number];
        storeNumber(stored, number, order_);
        bytes({stored, sizeof stored});
    }

    /// Numbers, each as a Stored, which holds them.
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

    /// Bytes written.
    std::uint64_t count() const { return count_; }

private:
    std::ostream& out_;
    std::endian order_;
    std::uint64_t count_ = 0;
};

/// The same, with the CRC-32 of all that was written.
class ChecksummedOutput : public ByteOutput {
public:
    using ByteOutput::ByteOutput;

    void bytes(std::string_view bytes) override {
        if (bytes.empty()) return;  // zlib takes a null pointer for the start of a new checksum.
        ByteOutput::bytes(bytes);
        crc_ = crc32_z(crc_, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
    }
    std::uint32_t checksum() const { return static_cast<std::uint32_t>(crc_); }

private:
    uLong crc_ = crc32_z(0, nullptr, 0);
};

}  // namespace espalier::io
