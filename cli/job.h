// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "options.h"
#include "run.h"

namespace espalier::cli {

/// An argument of a command, "MODEL" or "--rest", and the files that it names.
struct Argument {
    std::string name;
    std::vector<std::string> paths;  ///< none if the argument is not given

    Argument(std::string argument, std::vector<std::string> files)
        : name(std::move(argument)), paths(std::move(files)) {}

    /// An empty path means that the argument is not given.
    Argument(std::string argument, const std::string& file) : name(std::move(argument)) {
        if (!file.empty()) paths.push_back(file);
    }
};

/// The run of a command: what it reads and writes, and its stages. All files are checked before
/// anything is read, so that no long work ends with an error that was known before.
class Job {
public:
    /// Limits the threads until the process ends, and checks the inputs.
    ///
    /// Refuses two inputs that are the same pipe or device: reading the second one would wait for
    /// ever. Refuses "-" unless a file has this name, since the extension of a name tells the
    /// format.
    /// \throws FileError naming the file and the arguments
    Job(const CommonOptions& common, std::vector<Argument> inputs);

    /// Checks a file that the command writes. Refuses an output that is also an input, whose folder
    /// does not exist, or that must not be written to; and an output that is the same file as an
    /// earlier one through links, since only the last one written would remain. Devices and pipes
    /// may take several outputs.
    /// \param extensions the output must have one of them (".mtx"); devices and pipes need none. If
    ///        the list is empty, any extension will do
    /// \throws FileError
    void writes(const std::filesystem::path& output,
                const std::vector<std::string>& extensions = {});

    /// The same for a lattice, whose format must be writable.
    void writesLattice(const std::filesystem::path& output);

    Stages& stages() { return stages_; }

private:
    void refuseInput(const std::filesystem::path& output) const;
    void refuseEarlier(const std::filesystem::path& output);

    std::vector<Argument> inputs_;
    std::map<std::filesystem::path, std::filesystem::path>
        outputs_;  ///< the name of each output by the file behind all links
    Stages stages_;
};

}  // namespace espalier::cli
