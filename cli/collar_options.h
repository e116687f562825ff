// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/cages/collar.h>
#include <espalier/shapes/lattice.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "options.h"
#include "run_report.h"

// The options of collars, which `espalier shape` has in around, cage and collar.
namespace espalier::cli {

struct CollarCommandOptions {
    CommonOptions* common = nullptr;  ///< of the command
    std::optional<int> layers;        ///< none: no collar
    std::string reach;
    std::optional<std::array<double, 6>> until;  ///< two corners of a box
    std::string untilModel;                      ///< a model whose box it is
    std::vector<std::string> open;
    int held = 0;
};

/// Adds the options.
/// \param layers the name of the option for the number of layers
/// \param isRequired true: the command makes a collar always
void addCollarOptions(CLI::App& command, CollarCommandOptions& collar, CommonOptions& common,
                      const std::string& layers, bool isRequired);

/// A lattice with its collar, and the end of the line about it: "; collar of 3 layers ...".
struct WithCollar {
    Lattice lattice;
    std::string text;
};

/// Adds the collar to a lattice, if the options have one.
/// \param open sides that stay open besides those of the options, in the order of
///        cages::kSideWords
WithCollar withCollar(Lattice lattice, const CollarCommandOptions& collar, Stages& stages,
                      const std::array<bool, 6>& open = {});

}  // namespace espalier::cli
