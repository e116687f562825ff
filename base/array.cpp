// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/array.h>

#ifdef __linux__
#include <sys/mman.h>

#include <cstdint>
#endif

namespace espalier {
namespace {

constexpr std::size_t kPage = std::size_t{2} << 20;

}  // namespace

void preferLargePages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) {
#ifdef __linux__
    // Only whole pages, because other arrays may share the first and the last one. If the call
    // fails, the pages are small, which is slower but correct.
    const auto address = reinterpret_cast<std::uintptr_t>(memory);
    const std::size_t before = (kPage - address % kPage) % kPage;
    if (bytes >= before + kPage)
        ::madvise(static_cast<char*>(memory) + before, (bytes - before) / kPage * kPage,
                  MADV_HUGEPAGE);
#endif
}

void* allocateLargePages(std::size_t bytes) {
    void* const memory = ::operator new (bytes, std::align_val_t{kPage});
    preferLargePages(memory, bytes);
    return memory;
}

void freeLargePages(void* memory) {
    ::operator delete (memory, std::align_val_t{kPage});
}

}  // namespace espalier
