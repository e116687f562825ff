// SPDX-License-Identifier: Apache-2.0
#include <espalier/solve/lattice_fit.h>

#include "arguments.h"
#include "espalier_solve.h"
#include "guard.h"
#include "handles.h"
#include "rows.h"

using namespace espalier;

static_assert(static_cast<int>(solve::Smoothing::Laplacian) == ESPALIER_SMOOTHING_LAPLACIAN);
static_assert(static_cast<int>(solve::Undetermined::Refuse) == ESPALIER_UNDETERMINED_REFUSE);

namespace espalier::c {
namespace {

solve::FitOptions fitOptions(const espalier_fit_options& chosen) {
    solve::FitOptions options;
    options.smoothing = choice(chosen.smoothing, solve::Smoothing::Laplacian, "smoothing");
    options.undetermined = choice(chosen.undetermined, solve::Undetermined::Refuse, "undetermined");
    options.strength = chosen.strength;
    const auto frozen = array(chosen.frozen, chosen.frozen_count, "frozen");
    options.frozen.assign(frozen.begin(), frozen.end());
    return options;
}

}  // namespace
}  // namespace espalier::c

espalier_status espalier_lattice_fit(const espalier_table* deformation,
                                     const espalier_lattice* lattice, int32_t target_count,
                                     const int32_t* rows, const double* misses,
                                     const espalier_fit_options* options, int32_t vertex_count,
                                     double* displacements, espalier_fit_quality* quality) {
    return c::guarded([&] {
        const auto& table = *c::deref(deformation, "deformation").table;
        const auto& complex = c::deref(lattice, "lattice").lattice.complex;
        c::checkCount(vertex_count, complex.count(0), "vertices of room for the result");
        c::array(displacements, vertex_count, "displacements", 3);
        const auto chosen = c::fitOptions(c::optionsOr(options, espalier_default_fit_options(),
                                                       sizeof(espalier_fit_options),
                                                       "espalier_default_fit_options"));
        const auto fit = c::withRows(table, target_count, rows, "targets", [&](const auto& some) {
            // As many as there are rows, before they are read.
            const auto wanted = c::positions(misses, some.rowCount(), "misses");
            return solve::fitLattice(some, wanted, complex, chosen);
        });
        std::memcpy(displacements, fit.displacements.data(),
                    fit.displacements.size() * sizeof(Point3));
        if (quality != nullptr) *quality = {fit.largestMiss, fit.meanMiss, fit.condition};
    });
}
