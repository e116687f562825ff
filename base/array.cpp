// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/array.h>

#ifdef __linux__
#include <sys/mman.h>
#endif

#include <cstdint>
#include <limits>

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
    // An aligned operator new would be simpler. But glibc before 2.38 leaves gaps around aligned
    // memory and does not use them again: a process that refined a lattice again and again held
    // five times the memory of one lattice.
    constexpr std::size_t kMore = kPage + sizeof(void*);
    if (bytes > std::numeric_limits<std::size_t>::max() - kMore - kPage) throw std::bad_alloc();
    const std::size_t inLastPage = bytes % kPage;
    if (inLastPage >= kLargeArray) bytes += kPage - inLastPage;
    char* const own = static_cast<char*>(::operator new(bytes + kMore));
    char* const first = own + sizeof(void*);
    void* const memory = first + (kPage - reinterpret_cast<std::uintptr_t>(first) % kPage) % kPage;
    static_cast<void**>(memory)[-1] = own;  // for freeLargePages()
    preferLargePages(memory, bytes);
    return memory;
}

void freeLargePages(void* memory) {
    ::operator delete(static_cast<void**>(memory)[-1]);
}

}  // namespace espalier
