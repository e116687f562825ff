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

/// A lattice, perhaps with a collar, and what the line about it says.
struct WithCollar {
    Lattice lattice;
    std::vector<std::string> facts;  ///< about the lattice without the collar
    std::string collar;              ///< "a collar of 3 layers ..."; empty if there is none
};

/// Adds the collar to a lattice, if the options have one.
WithCollar withCollar(Lattice lattice, const CollarCommandOptions& collar, Stages& stages,
                      const std::optional<shapes::SymmetryPlane>& symmetry = {});

/// Writes the lattice, and prints the line about it, unless the options are quiet.
void writeWithCollar(const std::string& path, const WithCollar& made, const CommonOptions& common,
                     Stages& stages);

}  // namespace espalier::cli
