// SPDX-License-Identifier: Apache-2.0
#include "descriptor.h"

#include <espalier/base/progress.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <ctime>

namespace espalier::io {
namespace {

/// Blocks the signals SIGPIPE and SIGXFSZ while a write runs. The system sends them with the errors
/// EPIPE and EFBIG, to the thread that writes, and they would end a program that does not handle
/// them.
class WithoutWriteSignals {
public:
    WithoutWriteSignals() {
        ::sigemptyset(&signals_);
        ::sigaddset(&signals_, SIGPIPE);
        ::sigaddset(&signals_, SIGXFSZ);
        ::sigpending(&pendingBefore_);
        ::pthread_sigmask(SIG_BLOCK, &signals_, &maskBefore_);
    }
    ~WithoutWriteSignals() { ::pthread_sigmask(SIG_SETMASK, &maskBefore_, nullptr); }
    WithoutWriteSignals(const WithoutWriteSignals&) = delete;
    WithoutWriteSignals& operator=(const WithoutWriteSignals&) = delete;

    /// Discards the signal that came with this error, unless it was pending before.
    void drop(int error) const {
        if (error == EPIPE) drop(SIGPIPE, pendingBefore_);
        if (error == EFBIG) drop(SIGXFSZ, pendingBefore_);
    }

private:
    static void drop(int signal, const ::sigset_t& pendingBefore) {
        if (::sigismember(&pendingBefore, signal) == 1) return;
        ::sigset_t one;
        ::sigemptyset(&one);
        ::sigaddset(&one, signal);
        const ::timespec now{};
        uninterrupted([&] { return ::sigtimedwait(&one, nullptr, &now); });
    }

    ::sigset_t signals_, pendingBefore_, maskBefore_;
};

}  // namespace

DescriptorBuffer::DescriptorBuffer(int descriptor) : descriptor_(descriptor), buffer_(1 << 16) {
    setp(buffer_.data(), buffer_.data() + buffer_.size());
}

bool DescriptorBuffer::write(const char* from, std::size_t count) {
    constexpr std::size_t kAtOnce = 1 << 20;  // about a millisecond
    while (count > 0 && error_ == 0 && !cancelled_) {
        try {
            checkCancelled();
        } catch (...) {
            cancelled_ = std::current_exception();
            break;
        }
        const WithoutWriteSignals quiet;
        const ssize_t written =
            uninterrupted([&] { return ::write(descriptor_, from, std::min(count, kAtOnce)); });
        if (written < 0) {
            error_ = errno;
            quiet.drop(error_);
            break;
        }
        from += written;
        count -= written;
    }
    return error_ == 0 && !cancelled_;
}

int DescriptorBuffer::sync() {
    const bool isWritten = write(pbase(), pptr() - pbase());
    setp(buffer_.data(), buffer_.data() + buffer_.size());
    return isWritten ? 0 : -1;
}

DescriptorBuffer::int_type DescriptorBuffer::overflow(int_type character) {
    if (sync() != 0) return traits_type::eof();
    if (!traits_type::eq_int_type(character, traits_type::eof()))
        sputc(traits_type::to_char_type(character));
    return traits_type::not_eof(character);
}

std::streamsize DescriptorBuffer::xsputn(const char* from, std::streamsize count) {
    if (count > epptr() - pptr()) {
        if (sync() != 0) return 0;
        // Large blocks, such as those of TextOutput, are written directly.
        if (count >= (epptr() - pptr()) / 2) return write(from, count) ? count : 0;
    }
    std::copy_n(from, count, pptr());  // `from` may be null if `count` is 0.
    pbump(static_cast<int>(count));
    return count;
}

}  // namespace espalier::io
