// SPDX-License-Identifier: Apache-2.0
#include "run.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <system_error>

#ifdef ESPALIER_WITH_TBB
#include <tbb/info.h>
#endif

namespace espalier::cli {

Stages::Stages(bool quiet) : isShown_(!quiet && ::isatty(STDERR_FILENO) == 1) {}

Stages::~Stages() {
    clearLine();
}

void Stages::begin(const std::string& name) {
    name_ = name;
    bytes_.reset();
    start_ = std::chrono::steady_clock::now();
    if (isShown_) fmt::print(stderr, "\r\033[K{} ...", name_);
}

void Stages::end() {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
    const auto same = std::find_if(finished_.begin(), finished_.end(),
                                   [&](const Finished& stage) { return stage.name == name_; });
    if (same == finished_.end()) {
        finished_.push_back({name_, elapsed.count(), bytes_});
    } else {
        same->seconds += elapsed.count();
        if (same->bytes && bytes_)
            *same->bytes += *bytes_;
        else
            same->bytes.reset();
    }
    clearLine();
}

void Stages::addBytes(std::size_t bytes) {
    bytes_ = bytes_.value_or(0) + bytes;
}

void Stages::addFile(const std::filesystem::path& path) {
    std::error_code failure;
    if (!std::filesystem::is_regular_file(path, failure)) return;
    const auto size = std::filesystem::file_size(path, failure);
    if (!failure) addBytes(static_cast<std::size_t>(size));
}

void Stages::showProgress(std::size_t done, std::size_t total) {
    if (isShown_ && total > 0) fmt::print(stderr, "\r\033[K{} ... {} %", name_, 100 * done / total);
}

void Stages::clearLine() const {
    if (isShown_) fmt::print(stderr, "\r\033[K");
}

std::size_t peakMemory() {
    ::rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
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
