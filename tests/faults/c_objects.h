// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier.h>

#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>
#include <vector>

// Wraps objects of the C API in owners that destroy them, and converts statuses to exceptions.
namespace espalier::test {

/// Throws std::bad_alloc for the status of exhausted memory.
inline void check(espalier_status status) {
    if (status == ESPALIER_OK) return;
    if (status == ESPALIER_ERROR_MEMORY &&
        std::strcmp(espalier_last_error(), "there is not enough memory") == 0)
        throw std::bad_alloc();
    throw std::runtime_error(espalier_last_error());
}

template <class Object>
using Owned = std::unique_ptr<Object, void (*)(Object*)>;

/// Calls a function that makes an object, and expects that it makes none if it fails.
template <class Object, class Create>
Owned<Object> make(void (*destroy)(Object*), Create create) {
    Object* object = nullptr;
    const espalier_status status = create(&object);
    Owned<Object> owned(object, destroy);
    if (status != ESPALIER_OK && owned) throw std::logic_error("an object in spite of an error");
    check(status);
    return owned;
}

inline const std::vector<double> kCorners = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0,
                                             0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
inline const std::vector<std::int32_t> kCell = {0, 1, 2, 3, 4, 5, 6, 7};
inline const std::vector<double> kPoints = {0.5, 0.5, 0.5, 0.25, 0.75, 0.1, 7, 7, 7};

inline auto makeLattice() {
    return make<espalier_lattice>(espalier_lattice_destroy, [](auto** out) {
        return espalier_lattice_create_hexahedra(8, kCorners.data(), 1, kCell.data(), out);
    });
}

inline auto makeRefiner(const espalier_lattice* lattice) {
    return make<espalier_refiner>(espalier_refiner_destroy, [&](auto** out) {
        return espalier_refiner_create(lattice, nullptr, out);
    });
}

inline auto makeBinding(const espalier_refiner* refiner) {
    auto options = espalier_default_bind_options();
    options.level = 1;
    return make<espalier_binding>(espalier_binding_destroy, [&](auto** out) {
        return espalier_binding_create(refiner, 8, kCorners.data(), 3, kPoints.data(), &options,
                                       out);
    });
}

}  // namespace espalier::test
