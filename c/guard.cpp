// SPDX-License-Identifier: Apache-2.0
#include "guard.h"

#include <espalier/far/error.h>
#include <espalier/far/memory.h>
#include <espalier/far/progress.h>
#include <espalier/io/file.h>

#include <new>
#include <stdexcept>
#include <string>

namespace espalier::c {
namespace {

constexpr const char* kNoMemory = "there is not enough memory";

thread_local std::string lastText;
/// Text of lastText, or one that needs no memory.
thread_local const char* lastError = "";

espalier_status report(espalier_status status, const char* text) noexcept {
    try {
        lastText = text;
        lastError = lastText.c_str();
    } catch (...) {
        lastError = kNoMemory;
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
    } catch (const far::MemoryError& error) {
        return report(ESPALIER_ERROR_MEMORY, error.what());
    } catch (const Error& error) {
        return report(ESPALIER_ERROR_INPUT, error.what());
    } catch (const far::Cancelled& cancelled) {
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
