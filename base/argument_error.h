// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/error.h>
#include <espalier/base/function_ref.h>

#include <string>
#include <string_view>

namespace espalier {

/// A function refuses the value of an argument, or of a field of its options. what() is
/// "torus: minorRadius: expected a number below majorRadius (1), got 3". A front end that has other
/// names for the fields makes its own message of the parts, by message().
class ESPALIER_API ArgumentError : public Error {
public:
    /// A field and its value.
    struct Field {
        std::string name;   ///< the name in C++: "minorRadius", "cells[1]", "joints[0].radius"
        std::string value;  ///< may be empty: not shown
    };

    /// \param function the function that refuses the value; empty if several functions share the
    ///        check
    /// \param field the argument or the field that has the value, as Field::name
    /// \param got the value, as a text
    /// \param expected describes the values that are accepted: "a number below"
    /// \param other the field that ends the description; none if its name is empty
    ArgumentError(std::string function, std::string field, std::string got, std::string expected,
                  Field other = {});

    const std::string& field() const { return field_; }

    /// Returns what() with nameOf(name) for the name of each field and of the function.
    std::string message(FunctionRef<std::string(const std::string&)> nameOf) const;

    /// Returns message(nameOf) without the function: "minor_radius: expected ...".
    std::string messageOfField(FunctionRef<std::string(const std::string&)> nameOf) const;

private:
    std::string function_, field_, got_, expected_;
    Field other_;
};

/// Returns the name of a field or a function in another style: "minor_radius" for "minorRadius" and
/// the separator '_'.
ESPALIER_API std::string separated(std::string_view name, char separator);

}  // namespace espalier
