// SPDX-License-Identifier: Apache-2.0
// Sums of products. Part of kernels_body.h.

// Only the instructions written here fuse a product with a sum. If the compiler were allowed to
// fuse, its tuning would decide for each loop, and the result of a row would depend on the loop
// that computes the row: for one row or for four, for a range or for the whole table.

#if defined(ESPALIER_X86_64) && ESPALIER_REGISTER_BYTES >= 32
inline void addProduct(__m128& sum, const __m128& a, const __m128& b) {
    sum = _mm_fmadd_ps(a, b, sum);
}
inline void addProduct(__m256& sum, const __m256& a, const __m256& b) {
    sum = _mm256_fmadd_ps(a, b, sum);
}
inline void addProduct(__m256d& sum, const __m256d& a, const __m256d& b) {
    sum = _mm256_fmadd_pd(a, b, sum);
}
#if ESPALIER_REGISTER_BYTES == 64
inline void addProduct(__m512& sum, const __m512& a, const __m512& b) {
    sum = _mm512_fmadd_ps(a, b, sum);
}
inline void addProduct(__m512d& sum, const __m512d& a, const __m512d& b) {
    sum = _mm512_fmadd_pd(a, b, sum);
}
#endif
#elif defined(__aarch64__)
using Float4 = Vector<float, 4>::Type;
using Double2 = Vector<double, 2>::Type;
using Double4 = Vector<double, 4>::Type;
inline void addProduct(Float4& sum, const Float4& a, const Float4& b) {
    sum = vfmaq_f32(sum, a, b);
}
inline void addProduct(Double2& sum, const Double2& a, const Double2& b) {
    sum = vfmaq_f64(sum, a, b);
}
/// Four doubles take two registers.
inline void addProduct(Double4& sum, const Double4& a, const Double4& b) {
    Double2 low = __builtin_shufflevector(sum, sum, 0, 1);
    Double2 high = __builtin_shufflevector(sum, sum, 2, 3);
    addProduct(low, Double2(__builtin_shufflevector(a, a, 0, 1)),
               Double2(__builtin_shufflevector(b, b, 0, 1)));
    addProduct(high, Double2(__builtin_shufflevector(a, a, 2, 3)),
               Double2(__builtin_shufflevector(b, b, 2, 3)));
    sum = __builtin_shufflevector(low, high, 0, 1, 2, 3);
}
#else
/// SSE2, WebAssembly and other processors round each product.
template <class V>
void addProduct(V& sum, const V& a, const V& b) {
    sum += a * b;
}
#endif

/// Adds the products of the numbers in `a` and one number b to sums.
template <class V, class Real>
requires(sizeof(Real) < sizeof(V)) void addProduct(V& sum, const V& a, Real b) {
    // b − 0 is b, also for −0 and NaN, so compilers only copy b to all lanes.
    addProduct(sum, a, V(b - V{}));
}
