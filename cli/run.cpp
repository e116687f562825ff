// SPDX-License-Identifier: Apache-2.0
#include "run.h"

#include <espalier/base/parallel.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <system_error>

#ifdef ESPALIER_WITH_TBB
#include <tbb/info.h>
#endif

namespace espalier::cli {

namespace {

constexpr char kClearLine[] = "\r\033[K";
constexpr std::array<int, 3> kEndingSignals = {SIGINT, SIGTERM, SIGHUP};

/// Clears the line of progress, and raises the signal again. The handler is reset to the default by
/// then (SA_RESETHAND), so that the signal ends the program.
extern "C" void clearLineAndEnd(int signal) {
    const int before = errno;
    if (::write(STDERR_FILENO, kClearLine, sizeof kClearLine - 1) < 0) errno = before;
    ::raise(signal);
}

/// Replaces the handler `from` of the ending signals by `to`. Signals with another handler, such as
/// ignored ones, keep it.
void exchangeHandlers(void (*from)(int), void (*to)(int)) {
    for (const int signal : kEndingSignals) {
        struct sigaction action {};
        ::sigaction(signal, nullptr, &action);
        if (action.sa_handler != from) continue;
        action.sa_handler = to;
        action.sa_flags = static_cast<int>(SA_RESETHAND);
        ::sigaction(signal, &action, nullptr);
    }
}

}  // namespace

OutOfMemory::OutOfMemory(std::string_view stage) noexcept {
    // Texts as short as sizes allocate nothing.
    const std::optional<std::uint64_t> limit = memoryLimit();
    std::snprintf(text_.data(), text_.size(), "out of memory%s%.*s: %s were in use at most%s%s%s",
                  stage.empty() ? "" : " while ", static_cast<int>(stage.size()), stage.data(),
                  formatBytes(peakMemory()).c_str(), limit ? "; the limit is " : "",
                  limit ? formatBytes(*limit).c_str() : "", limit ? " (--max-memory)" : "");
}

// The functions below write progress. They do not throw, because stages end in destructors.

Stages::Stages(bool quiet) : isShown_(!quiet && ::isatty(STDERR_FILENO) == 1) {
    if (isShown_) exchangeHandlers(SIG_DFL, clearLineAndEnd);
}

Stages::~Stages() {
    clearLine();
    if (isShown_) exchangeHandlers(clearLineAndEnd, SIG_DFL);
}

void Stages::begin(std::string_view name) {
    const auto same = std::find_if(finished_.begin(), finished_.end(),
                                   [&](const FinishedStage& stage) { return stage.name == name; });
    current_ = same - finished_.begin();
    if (same == finished_.end()) finished_.push_back({std::string(name), 0, 0});
    bytes_.reset();
    start_ = std::chrono::steady_clock::now();
    if (isShown_) std::fprintf(stderr, "%s%s ...", kClearLine, finished_[current_].name.c_str());
}

void Stages::end() noexcept {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
    FinishedStage& stage = finished_[current_];
    stage.seconds += elapsed.count();
    if (stage.bytes && bytes_)
        *stage.bytes += *bytes_;
    else
        stage.bytes.reset();
    clearLine();
}

void Stages::addBytes(std::size_t bytes) {
    bytes_ = bytes_.value_or(0) + bytes;
}

void Stages::addFile(const std::filesystem::path& path) {
    std::error_code failure;
    if (!std::filesystem::is_regular_file(path, failure)) return;
    const auto size = std::filesystem::file_size(path, failure);
    if (!failure) addBytes(size);
}

void Stages::showProgress(std::size_t done, std::size_t total) const noexcept {
    if (isShown_ && total > 0)
        std::fprintf(stderr, "%s%s ... %zu %%", kClearLine, finished_[current_].name.c_str(),
                     100 * done / total);
}

void Stages::clearLine() const noexcept {
    if (isShown_) std::fputs(kClearLine, stderr);
}

std::size_t peakMemory() {
    ::rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss * std::size_t{1024};
}

int threadCount([[maybe_unused]] int limit) {
#ifdef ESPALIER_WITH_TBB
    const int cores = tbb::info::default_concurrency();
    return limit > 0 ? std::min(limit, cores) : cores;
#else
    return 1;
#endif
}

}  // namespace espalier::cli
