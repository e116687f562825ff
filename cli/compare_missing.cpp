// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>

#include "commands.h"

namespace espalier::cli {

/// In a build without OpenSubdiv: the command says so.
void addCompareCommand(CLI::App& program) {
    CLI::App& command =
        *program.add_subcommand("compare", "Not in this build, which has no OpenSubdiv");
    command.allow_extras();
    command.callback([] {
        throw Error(
            "compare: this program was built without OpenSubdiv; install libosd-dev, and build it "
            "again");
    });
}

}  // namespace espalier::cli
