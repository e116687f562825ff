// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/array.h>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace espalier {
namespace {

constexpr std::size_t kPage = std::size_t{2} << 20;

}  // namespace

void* allocateLargePages(std::size_t bytes) {
    void* const memory = ::operator new (bytes, std::align_val_t{kPage});
#ifdef __linux__
    // Only whole pages, because other arrays may share the last page. If the call fails, the pages
    // are small, which is slower but correct.
    ::madvise(memory, bytes / kPage * kPage, MADV_HUGEPAGE);
#endif
    return memory;
}

void freeLargePages(void* memory) {
    ::operator delete (memory, std::align_val_t{kPage});
}

}  // namespace espalier
