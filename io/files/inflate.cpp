// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/memory.h>
#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <new>

#include "coding_error.h"
#include "inflate.h"

namespace espalier::io {
namespace {

/// zlib counts what it is given in fewer bits than a size has: it gets one part after the other.
uInt takePart(std::size_t& left) {
    const std::size_t part = std::min<std::size_t>(left, std::numeric_limits<uInt>::max());
    left -= part;
    return static_cast<uInt>(part);
}

class Inflater {
public:
    explicit Inflater(DeflateForm form) {
        constexpr int kLargestWindow = 15;
        const int window = form == DeflateForm::Raw ? -kLargestWindow : kLargestWindow;
        if (::inflateInit2(&state_, window) != Z_OK) throw std::bad_alloc();
    }
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;
    ~Inflater() { ::inflateEnd(&state_); }

    /// \return whether the stream came to its end with exactly so many bytes
    bool inflate(std::string_view stream, Bytef* to, std::size_t size) {
        // zlib's interface is older than const.
        state_.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(stream.data()));
        state_.next_out = to;
        std::size_t inLeft = stream.size(), outLeft = size;
        int status = Z_OK;
        while (status == Z_OK) {
            if (state_.avail_in == 0) state_.avail_in = takePart(inLeft);
            if (state_.avail_out == 0) state_.avail_out = takePart(outLeft);
            // An error, where it has neither anything to read nor room to write to.
            status = ::inflate(&state_, Z_NO_FLUSH);
        }
        if (status == Z_MEM_ERROR) throw std::bad_alloc();
        return status == Z_STREAM_END && outLeft == 0 && state_.avail_out == 0;
    }

private:
    z_stream state_ = {};
};

}  // namespace

void appendInflated(std::string_view stream, std::uint64_t size, DeflateForm form,
                    std::string& bytes) {
    if (size / kMostInflation > stream.size())
        throw CodingError("a stream of " + std::to_string(stream.size()) +
                          " compressed bytes claims to hold " + std::to_string(size));
    requireMemory(size, "its data");
    Inflater inflater(form);
    const std::size_t before = bytes.size();
    bytes.resize(before + size);
    // zlib refuses a null destination, which an empty stream could give it.
    Bytef none = 0;
    Bytef* to = size == 0 ? &none : reinterpret_cast<Bytef*>(bytes.data() + before);
    if (!inflater.inflate(stream, to, size))
        throw CodingError("a compressed stream of " + std::to_string(stream.size()) +
                          " bytes is damaged (zlib)");
}

}  // namespace espalier::io
