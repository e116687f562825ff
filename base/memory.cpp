// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/memory.h>
#include <espalier/base/number_text.h>
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <charconv>
#include <chrono>
#include <limits>
#include <mutex>
#include <set>
#include <string_view>

namespace espalier {
namespace {

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

/// The limits of this process.
class Limits {
public:
    void add(std::uint64_t bytes) {
        const std::lock_guard lock(mutex_);
        all_.insert(bytes);
        lowest_ = *all_.begin();
    }
    void remove(std::uint64_t bytes) {
        const std::lock_guard lock(mutex_);
        all_.erase(all_.find(bytes));
        lowest_ = all_.empty() ? kNoLimit : *all_.begin();
    }
    std::uint64_t lowest() const { return lowest_.load(std::memory_order_relaxed); }

    /// Returns true if it is time to check the memory again.
    bool isLookDue() {
        using Clock = std::chrono::steady_clock;
        constexpr Clock::duration kInterval = std::chrono::milliseconds(5);
        const auto now = Clock::now().time_since_epoch().count();
        const auto last = lastLook_.load(std::memory_order_relaxed);
        if (now - last < kInterval.count()) return false;
        lastLook_.store(now, std::memory_order_relaxed);
        return true;
    }

private:
    std::mutex mutex_;
    std::multiset<std::uint64_t> all_;
    std::atomic<std::uint64_t> lowest_ = kNoLimit;
    std::atomic<std::chrono::steady_clock::rep> lastLook_ = 0;
};

Limits& limits() {
    static Limits limits;
    return limits;
}

MemoryError outOfMemory(std::uint64_t held, std::uint64_t limit) {
    return MemoryError("out of memory: " + formatBytes(held) + " are in use; the limit is " +
                       formatBytes(limit));
}

}  // namespace

MemoryLimit::MemoryLimit(std::uint64_t bytes) : bytes_(bytes) {
    limits().add(bytes_);
}

MemoryLimit::~MemoryLimit() {
    limits().remove(bytes_);
}

std::optional<std::uint64_t> memoryLimit() {
    const std::uint64_t limit = limits().lowest();
    return limit == kNoLimit ? std::nullopt : std::optional(limit);
}

std::uint64_t residentMemory() {
#ifdef __EMSCRIPTEN__
    return std::uint64_t{__builtin_wasm_memory_size(0)} * 65536;  // in pages; it never shrinks
#else
    // The file has numbers of pages: total, resident, shared ... Streams would allocate memory.
    const int file = ::open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
    if (file < 0) return 0;
    std::array<char, 64> text;
    const auto size = ::read(file, text.data(), text.size());
    ::close(file);
    if (size <= 0) return 0;
    const std::string_view words(text.data(), size);
    const std::size_t space = words.find(' ');
    if (space == std::string_view::npos) return 0;
    std::uint64_t pages = 0;
    std::from_chars(words.data() + space + 1, words.data() + words.size(), pages);
    return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
#endif
}

void requireMemory(std::uint64_t bytes, const std::string& what) {
    if constexpr (constexpr std::uint64_t kReach = std::numeric_limits<std::size_t>::max();
                  kReach < kNoLimit)
        if (bytes > kReach)
            throw MemoryError(what + " takes about " + formatBytes(bytes) +
                              " of memory; an address of this machine reaches " +
                              formatBytes(kReach));
    const std::uint64_t limit = limits().lowest();
    if (limit == kNoLimit) return;
    const std::uint64_t held = residentMemory();
    if (held > limit) throw outOfMemory(held, limit);
    if (bytes <= limit - held) return;
    throw MemoryError(what + " takes about " + formatBytes(bytes) + " of memory; the limit is " +
                      formatBytes(limit) + ", of which " + formatBytes(held) + " are in use");
}

void checkMemory() {
    const std::uint64_t limit = limits().lowest();
    if (limit == kNoLimit || !limits().isLookDue()) return;
    const std::uint64_t held = residentMemory();
    if (held > limit) throw outOfMemory(held, limit);
}

std::string formatBytes(std::uint64_t bytes) {
    constexpr std::array<const char*, 7> kUnits = {"B", "kB", "MB", "GB", "TB", "PB", "EB"};
    auto amount = static_cast<double>(bytes);
    std::size_t unit = 0;
    for (; amount >= 1000 && unit + 1 < kUnits.size(); ++unit) amount /= 1000;
    return fixedText(amount, unit == 0 ? 0 : 1) + " " + kUnits[unit];
}

}  // namespace espalier
