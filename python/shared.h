// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <utility>

namespace espalier::python {

/// What an argument shares with its caller. Never null: pybind11 makes a null std::shared_ptr of
/// None, where a function takes one.
template <class T>
class Shared {
public:
    Shared() = default;  ///< for the caster alone, until it has found what to share
    explicit Shared(std::shared_ptr<T> pointer) : pointer_(std::move(pointer)) {}

    T& operator*() const { return *pointer_; }
    T* operator->() const { return pointer_.get(); }
    operator const std::shared_ptr<T>&() const { return pointer_; }

private:
    std::shared_ptr<T> pointer_;
};

/// What a property calls. Given a method itself, pybind11 would call that on a null pointer for
/// None.
template <class Result, class T>
auto getter(Result (T::*method)() const) {
    return [method](const T& self) -> Result { return (self.*method)(); };
}

}  // namespace espalier::python

namespace pybind11::detail {

template <class T>
class type_caster<espalier::python::Shared<T>> {
public:
    PYBIND11_TYPE_CASTER(espalier::python::Shared<T>, make_caster<T>::name);

    bool load(handle source, bool convert) {
        make_caster<std::shared_ptr<T>> caster;
        if (source.is_none() || !caster.load(source, convert)) return false;
        value = espalier::python::Shared<T>(static_cast<std::shared_ptr<T>&>(caster));
        return true;
    }
};

}  // namespace pybind11::detail
