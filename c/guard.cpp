// SPDX-License-Identifier: Apache-2.0
#include "guard.h"

#include <espalier/base/memory.h>
#include <espalier/base/progress.h>
#include <espalier/io/files/file.h>
#include <pthread.h>

#include <memory>
#include <new>
#include <stdexcept>
#include <string>

namespace espalier::c {
namespace {

constexpr const char* kNoMemory = "there is not enough memory";
constexpr const char* kNoMemoryForMessage = "there is not enough memory to say what is wrong";

/// Holds the text of the last error of each thread, and deletes it when the thread ends. A
/// thread_local string would not do: creating one allocates memory, and the C library aborts if
/// there is none.
class LastErrorTexts {
public:
    LastErrorTexts() : hasKey_(::pthread_key_create(&key_, erase) == 0) {}
    ~LastErrorTexts() {
        if (!hasKey_) return;
        // Deletes the text of the thread that unloads the library. The texts of other threads are
        // lost: pthread has no call that reaches them.
        erase(::pthread_getspecific(key_));
        ::pthread_key_delete(key_);
    }
    LastErrorTexts(const LastErrorTexts&) = delete;
    LastErrorTexts& operator=(const LastErrorTexts&) = delete;

    /// Returns the text of the calling thread.
    std::string& text() {
        if (!hasKey_) throw std::bad_alloc();
        if (void* known = ::pthread_getspecific(key_)) return *static_cast<std::string*>(known);
        auto text = std::make_unique<std::string>();
        if (::pthread_setspecific(key_, text.get()) != 0) throw std::bad_alloc();
        return *text.release();
    }

private:
    static void erase(void* text) { delete static_cast<std::string*>(text); }

    ::pthread_key_t key_{};
    bool hasKey_;
};

LastErrorTexts lastTexts;

/// The message of the last error of this thread: a text of `lastTexts`, or a constant text, which
/// needs no memory. The pointer is in the static thread-local block, which every thread has from
/// its start (see loopContext()).
[[gnu::tls_model("initial-exec")]] thread_local constinit const char* lastError = "";

/// Returns the message of an error, with the names of C: minor_radius for minorRadius. The module
/// for JavaScript, which has the names of C++, keeps these.
std::string messageOf(const std::exception& error) {
#ifndef __EMSCRIPTEN__
    if (const auto* const argument = dynamic_cast<const ArgumentError*>(&error))
        return argument->message([](const std::string& name) { return separated(name, '_'); });
#endif
    return error.what();
}

espalier_status report(espalier_status status, const std::exception& error) noexcept {
    try {
        std::string& own = lastTexts.text();
        own = messageOf(error);
        lastError = own.c_str();
    } catch (...) {
        lastError = kNoMemoryForMessage;
    }
    return status;
}

espalier_status reportNoMemory() noexcept {
    lastError = kNoMemory;
    return ESPALIER_ERROR_MEMORY;
}

}  // namespace

espalier_status statusOfException() noexcept {
    try {
        throw;
    } catch (const io::FileError& error) {
        return report(ESPALIER_ERROR_FILE, error);
    } catch (const MemoryError& error) {
        return report(ESPALIER_ERROR_MEMORY, error);
    } catch (const Error& error) {
        return report(ESPALIER_ERROR_INPUT, error);
    } catch (const Cancelled& cancelled) {
        return report(ESPALIER_CANCELLED, cancelled);
    } catch (const std::bad_alloc&) {
        return reportNoMemory();
    } catch (const std::length_error&) {
        // A container was asked to hold more than memory could.
        return reportNoMemory();
    } catch (const std::exception& error) {
        return report(ESPALIER_ERROR_INTERNAL, error);
    } catch (...) {
        lastError = "an exception of unknown type";
        return ESPALIER_ERROR_INTERNAL;
    }
}

}  // namespace espalier::c

const char* espalier_last_error(void) {
    return espalier::c::lastError;
}
