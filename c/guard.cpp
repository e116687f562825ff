// SPDX-License-Identifier: Apache-2.0
#include "guard.h"

#include <espalier/base/error.h>
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
constexpr const char* kNotTold = "there is not enough memory to say what is wrong";

/// The text of each thread's last error, deleted when the thread ends. Not a thread_local string:
/// to make one on a thread takes memory, and the C library ends the program if there is none.
class LastTexts {
public:
    LastTexts() : isThere_(::pthread_key_create(&key_, erase) == 0) {}
    ~LastTexts() {
        if (!isThere_) return;
        // Of the thread that unloads the library; for the others none is left who could.
        erase(::pthread_getspecific(key_));
        ::pthread_key_delete(key_);
    }
    LastTexts(const LastTexts&) = delete;
    LastTexts& operator=(const LastTexts&) = delete;

    /// That of the calling thread.
    std::string& own() {
        if (!isThere_) throw std::bad_alloc();
        if (void* known = ::pthread_getspecific(key_)) return *static_cast<std::string*>(known);
        auto text = std::make_unique<std::string>();
        if (::pthread_setspecific(key_, text.get()) != 0) throw std::bad_alloc();
        return *text.release();
    }

private:
    static void erase(void* text) { delete static_cast<std::string*>(text); }

    ::pthread_key_t key_{};
    bool isThere_;
};

LastTexts lastTexts;

/// One of these, or one that needs no memory. Of the block that each thread is born with (see
/// loopContext()).
[[gnu::tls_model("initial-exec")]] thread_local constinit const char* lastError = "";

espalier_status report(espalier_status status, const char* text) noexcept {
    try {
        std::string& own = lastTexts.own();
        own = text;
        lastError = own.c_str();
    } catch (...) {
        lastError = kNotTold;
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
        return report(ESPALIER_ERROR_FILE, error.what());
    } catch (const MemoryError& error) {
        return report(ESPALIER_ERROR_MEMORY, error.what());
    } catch (const Error& error) {
        return report(ESPALIER_ERROR_INPUT, error.what());
    } catch (const Cancelled& cancelled) {
        return report(ESPALIER_CANCELLED, cancelled.what());
    } catch (const std::bad_alloc&) {
        return reportNoMemory();
    } catch (const std::length_error&) {
        // Of a container that would hold more than memory could.
        return reportNoMemory();
    } catch (const std::exception& error) {
        return report(ESPALIER_ERROR_INTERNAL, error.what());
    } catch (...) {
        return report(ESPALIER_ERROR_INTERNAL, "an exception of unknown type");
    }
}

}  // namespace espalier::c

const char* espalier_last_error(void) {
    return espalier::c::lastError;
}
