// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/function_ref.h>
#include <espalier/embed/length_unit.h>
#include <espalier/embed/local_binding.h>
#include <espalier/embed/regular_search.h>

#include <span>

namespace espalier::embed {

/// Binds points that a regular search does not find. They are the points that are given to it, in
/// the order of the model.
using BindOthers =
    FunctionRef<BoundRows<>(std::span<const Point3> points, const BindingOptions& options)>;

/// Binds points in regular cells by their places, and all others by another function.
/// \param bindOthers called at most once, and not if all points are in regular cells
/// \param options the level has no meaning here
/// \throws Error as bindOthers, and under OutsidePolicy::Error for a point outside
ESPALIER_API BoundRows<> bindRegularFirst(const RegularSearch& search, const LengthUnit& unit,
                                          std::span<const Point3> points,
                                          const BindingOptions& options, BindOthers bindOthers);

/// Binds points that a regular search does not find, group by group. They are the points that are
/// given to it, in the order of the model; `sink` gets their numbers among these.
using BindOthersInto =
    FunctionRef<void(std::span<const Point3> points, const BindingOptions& options, RowSink sink)>;

/// The same, but gives the rows of each group to `sink` (bindInGroups()).
/// \param bindOthers as in bindRegularFirst(); it gets options without OutsidePolicy::Error
ESPALIER_API void bindRegularFirstInto(const RegularSearch& search, const LengthUnit& unit,
                                       std::span<const Point3> points,
                                       const BindingOptions& options, RowSink sink,
                                       BindOthersInto bindOthers);

}  // namespace espalier::embed
