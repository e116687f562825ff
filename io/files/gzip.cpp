// SPDX-License-Identifier: Apache-2.0
#include "gzip.h"

#include <espalier/base/error.h>
#include <espalier/base/memory.h>
#include <espalier/base/progress.h>

#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <new>

#include "bytes.h"

namespace espalier::io {
namespace {

constexpr int kLargestWindow = 15;
constexpr int kGzipForm = 16;  // zlib: added to the window
constexpr std::size_t kBlock = 1 << 20;

/// Gives zlib the next part of an input, which it takes without const and does not change.
void feed(z_stream& state, std::string_view bytes, std::size_t& position) {
    if (state.avail_in > 0) return;
    const std::size_t size = std::min(kBlock, bytes.size() - position);
    state.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(bytes.data() + position));
    state.avail_in = static_cast<uInt>(size);
    position += size;
}

/// Gives zlib room for a further block behind the bytes.
void makeRoom(z_stream& state, std::string& bytes) {
    if (state.avail_out > 0) return;
    const std::size_t size = bytes.size();
    if (size + kBlock > bytes.capacity()) {
        const std::size_t capacity = std::max(2 * size, size + kBlock);
        requireMemory(capacity, "its data");
        bytes.reserve(capacity);
    }
    bytes.resize(size + kBlock);
    state.next_out = reinterpret_cast<Bytef*>(bytes.data() + size);
    state.avail_out = static_cast<uInt>(kBlock);
}

/// Ends the use of zlib's state.
struct Ended {
    z_stream& state;
    int (*end)(z_stream*);
    ~Ended() { end(&state); }
};

}  // namespace

bool isGzip(std::string_view bytes) {
    return bytes.starts_with("\x1f\x8b");
}

std::string gunzip(std::string_view file) {
    z_stream state = {};
    if (::inflateInit2(&state, kLargestWindow + kGzipForm) != Z_OK) throw std::bad_alloc();
    const Ended ended{state, ::inflateEnd};
    std::string bytes;
    std::size_t position = 0;
    while (true) {
        checkCancelled();
        feed(state, file, position);
        makeRoom(state, bytes);
        const int status = ::inflate(&state, Z_NO_FLUSH);
        if (status == Z_MEM_ERROR) throw std::bad_alloc();
        const std::size_t left = state.avail_in + (file.size() - position);
        if (status == Z_STREAM_END) {
            const std::string_view rest = file.substr(file.size() - left);
            if (rest.find_first_not_of('\0') == std::string_view::npos) break;
            if (!isGzip(rest))
                throw CodingError(concat("is damaged: it has ", left,
                                         " further bytes behind the compressed ones"));
            if (::inflateReset(&state) != Z_OK) throw std::bad_alloc();
        } else if (status == Z_BUF_ERROR && left == 0) {
            throw CodingError("is damaged: it ends too early");
        } else if (status != Z_OK && status != Z_BUF_ERROR) {
            throw CodingError("is damaged: its compressed bytes cannot be read (zlib)");
        }
    }
    bytes.resize(bytes.size() - state.avail_out);
    return bytes;
}

std::string gzip(std::string_view bytes) {
    z_stream state = {};
    constexpr int kUsualMemory = 8;
    if (::deflateInit2(&state, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kLargestWindow + kGzipForm,
                       kUsualMemory, Z_DEFAULT_STRATEGY) != Z_OK)
        throw std::bad_alloc();
    const Ended ended{state, ::deflateEnd};
    std::string file;
    std::size_t position = 0;
    int status = Z_OK;
    while (status != Z_STREAM_END) {
        checkCancelled();
        feed(state, bytes, position);
        makeRoom(state, file);
        status = ::deflate(&state, position == bytes.size() ? Z_FINISH : Z_NO_FLUSH);
    }
    file.resize(file.size() - state.avail_out);
    return file;
}

}  // namespace espalier::io
