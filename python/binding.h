// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/lazy.h>
#include <espalier/base/point.h>
#include <espalier/io/binding_file.h>
#include <espalier/io/model.h>
#include <espalier/osd/compiled_adjoint.h>
#include <espalier/osd/deformer.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "tables.h"

namespace espalier::python {

/// A model, and the file that it was read from.
struct ModelFile {
    std::string name;  ///< file name without folders
    std::string bytes;
    std::shared_ptr<const io::Model> model;
};

/// Returns a copy of the points of a model.
std::vector<Point3> pointsOf(const ModelFile& file);

/// Reads a model from the bytes of a file.
/// \param name of the file; its extension tells the format
ModelFile modelOfBytes(std::string name, std::string bytes);

/// Points that are bound to a lattice, and the forms that evaluate D, which are made on first use.
struct BoundPoints {
    io::BoundModel bound;

    std::tuple<Lazy<osd::Deformer<float>>, Lazy<osd::Deformer<double>>,
               Lazy<osd::CompiledAdjoint<float>>, Lazy<osd::CompiledAdjoint<double>>>
        forms = {};

    const bind::Binding& binding() const { return bound.binding; }
};

/// Returns statuses as bytes for NumPy, with the values of PointStatus in espalier/__init__.py.
std::span<const std::uint8_t> bytesOf(const std::vector<embed::PointStatus>& statuses);

/// Returns D. The pointer keeps the binding alive.
inline std::shared_ptr<Table> tableIn(const std::shared_ptr<BoundPoints>& bound) {
    return {bound, &bound->bound.binding.table};
}

}  // namespace espalier::python
