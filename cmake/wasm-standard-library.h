// SPDX-License-Identifier: Apache-2.0
// The parts of C++20 that libc++ 14, the standard library of Debian's emscripten, lacks and that
// the sources use: algorithms on whole ranges, std::bit_cast() and <=> of vectors and arrays. The
// toolchain includes this file before each source. Later versions of libc++ have all of it.
#if !defined(ESPALIER_WASM_STANDARD_LIBRARY_H) && __cplusplus > 201703L
#define ESPALIER_WASM_STANDARD_LIBRARY_H

#include <algorithm>
#include <array>
#include <compare>
#include <functional>
#include <iterator>
#include <utility>
#include <vector>

#if !defined(_LIBCPP_VERSION) || _LIBCPP_VERSION >= 15000
#error "this file is for libc++ 14"
#endif

namespace std {

template <class To, class From>
constexpr To bit_cast(const From& from) noexcept {
    static_assert(sizeof(To) == sizeof(From));
    return __builtin_bit_cast(To, from);
}

// clang-format off
template <class Sequence>
auto compareInOrder(const Sequence& a, const Sequence& b) -> decltype(a[0] <=> b[0]) {
    for (size_t i = 0; i < min(a.size(), b.size()); ++i)
        if (const auto order = a[i] <=> b[i]; order != 0) return order;
    return a.size() <=> b.size();
}

template <class T, class Allocator>
auto operator<=>(const vector<T, Allocator>& a, const vector<T, Allocator>& b) {
    return compareInOrder(a, b);
}

template <class T, size_t count>
auto operator<=>(const array<T, count>& a, const array<T, count>& b) {
    return compareInOrder(a, b);
}
// clang-format on

namespace ranges {

struct Identity {
    template <class T>
    const T& operator()(const T& value) const {
        return value;
    }
};

template <class Range, class Value, class Of = Identity>
auto find(Range&& range, const Value& value, Of of = {}) {
    return std::find_if(std::begin(range), std::end(range),
                        [&](const auto& item) { return invoke(of, item) == value; });
}

#define ESPALIER_ON_RANGE(name)                                                                 \
    template <class Range, class... Arguments>                                                  \
    decltype(auto) name(Range&& range, Arguments&&... arguments) {                              \
        return std::name(std::begin(range), std::end(range), forward<Arguments>(arguments)...); \
    }
ESPALIER_ON_RANGE(all_of)
ESPALIER_ON_RANGE(any_of)
ESPALIER_ON_RANGE(none_of)
ESPALIER_ON_RANGE(copy)
ESPALIER_ON_RANGE(count)
ESPALIER_ON_RANGE(count_if)
ESPALIER_ON_RANGE(find_if)
ESPALIER_ON_RANGE(replace)
ESPALIER_ON_RANGE(reverse)
ESPALIER_ON_RANGE(sort)
ESPALIER_ON_RANGE(upper_bound)
#undef ESPALIER_ON_RANGE

template <class Range, class Value, class Of = Identity>
bool binary_search(Range&& range, const Value& value, std::less<> = {}, Of of = {}) {
    const auto first = std::lower_bound(
        std::begin(range), std::end(range), value,
        [&](const auto& item, const Value& other) { return invoke(of, item) < other; });
    return first != std::end(range) && !(value < invoke(of, *first));
}

template <class A, class B>
bool equal(A&& a, B&& b) {
    return std::equal(std::begin(a), std::end(a), std::begin(b), std::end(b));
}

template <class A, class B>
bool includes(A&& a, B&& b) {
    return std::includes(std::begin(a), std::end(a), std::begin(b), std::end(b));
}

template <class Range>
auto max(Range&& range) {
    return *std::max_element(std::begin(range), std::end(range));
}

template <class Range>
auto min(Range&& range) {
    return *std::min_element(std::begin(range), std::end(range));
}

template <class Of>
struct LessOf {
    Of of;
    template <class A, class B>
    bool operator()(const A& a, const B& b) const {
        return invoke(of, a) < invoke(of, b);
    }
};

template <class Range, class Of = Identity>
auto max_element(Range&& range, std::less<> = {}, Of of = {}) {
    return std::max_element(std::begin(range), std::end(range), LessOf<Of>{of});
}

template <class Range, class Of = Identity>
auto minmax_element(Range&& range, std::less<> = {}, Of of = {}) {
    return std::minmax_element(std::begin(range), std::end(range), LessOf<Of>{of});
}

struct PermutationResult {
    bool found;
};

template <class Range>
PermutationResult next_permutation(Range&& range) {
    return {std::next_permutation(std::begin(range), std::end(range))};
}

}  // namespace ranges
}  // namespace std

#endif
