// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/point.h>
#include <espalier/io/binding_file.h>
#include <espalier/osd/compiled_adjoint.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/stencils/point_location.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "tables.h"

namespace espalier::python {

/// A value that is made when it is first asked for, by whichever thread comes first.
template <class T>
class Lazy {
public:
    template <class Make>
    const T& get(Make make) {
        std::call_once(once_, [&] { value_.emplace(make()); });
        return *value_;
    }

private:
    std::once_flag once_;
    std::optional<T> value_;
};

/// How binding went for each point.
struct Placement {
    std::vector<stencils::PointStatus> statuses;
    double largestResidual = 0;
};

/// Points that are bound to a lattice; what io::BoundModel has, where they were, and the forms of D
/// that were asked for.
struct BoundPoints {
    /// The file of the model is empty where the points are those of an array.
    io::BoundModel bound;
    std::vector<Point3> points;
    std::optional<Placement> placement;  ///< a file does not tell

    template <class Real>
    struct Compiled {
        Lazy<osd::CompiledTable<Real>> table;
        Lazy<osd::CompiledAdjoint<Real>> adjoint;
    };
    Compiled<float> single;
    Compiled<double> twofold;
};

/// D, which lives as long as the binding.
inline std::shared_ptr<Table> tableIn(const std::shared_ptr<BoundPoints>& bound) {
    return {bound, &bound->bound.binding.table};
}

}  // namespace espalier::python
