// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/memory.h>
#include <espalier/stencils/factored_table.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace espalier::cli {

/// No memory was left in a stage of the run. what() is "out of memory while binding". An object
/// takes no memory of its own.
class OutOfMemory : public std::bad_alloc {
public:
    explicit OutOfMemory(std::string_view stage) noexcept;
    const char* what() const noexcept override { return text_.data(); }

private:
    std::array<char, 80> text_ = {};
};

/// The stages of a run: times each, and shows on a terminal which one is at work and how far it is.
/// Nothing is shown if the run is quiet or standard error is not a terminal, and the line is empty
/// in the end, also if a signal ends the program. That it cannot be shown is no error.
class Stages {
public:
    explicit Stages(bool quiet);
    ~Stages();
    Stages(const Stages&) = delete;
    Stages& operator=(const Stages&) = delete;

    /// A stage that came again, for the next file or pose, is here once, with the sums of all.
    struct Finished {
        std::string name;
        double seconds;

        /// Read or made (run_report.h says of what); nothing if one of its runs did not say.
        std::optional<std::size_t> bytes;
    };

    /// Runs one stage, unless the process holds more memory than MemoryLimit allows already.
    /// \throws OutOfMemory in place of std::bad_alloc and std::length_error; MemoryError, with
    /// the stage in its message; what else `work` throws
    template <class Work>
    auto run(std::string_view name, Work work) {
        try {
            begin(name);
            struct End {
                Stages* stages;
                ~End() { stages->end(); }
            } end{this};
            checkMemory();
            return work();
        } catch (const MemoryError& error) {
            throw MemoryError(std::string(error.what()) + " (while " + std::string(name) + ")");
        } catch (const std::bad_alloc&) {
            throw OutOfMemory(name);
        } catch (const std::length_error&) {
            // A container would hold more than memory could.
            throw OutOfMemory(name);
        }
    }

    /// Reads a file, and counts its bytes, in the stage "reading".
    template <class Read>
    auto read(const std::filesystem::path& path, Read read) {
        return run("reading", [&] {
            addFile(path);
            return read();
        });
    }

    /// Says, from within the work of a stage, that it has read or made so many bytes more.
    void addBytes(std::size_t bytes);

    /// The same of a file that it has read or written. The size of a device or a pipe is not known.
    void addFile(const std::filesystem::path& path);

    /// Shows how much of the current stage is done; from any thread.
    void showProgress(std::size_t done, std::size_t total) const noexcept;

    /// In the order in which they first began.
    const std::vector<Finished>& finished() const { return finished_; }

private:
    void begin(std::string_view name);
    void end() noexcept;
    void clearLine() const noexcept;

    bool isShown_;
    std::size_t current_ = 0;  ///< the one of finished_ that is at work
    std::chrono::steady_clock::time_point start_;
    std::optional<std::size_t> bytes_;  ///< of the current stage
    std::vector<Finished> finished_;
};

/// A table's offsets, columns and weights.
template <class Real>
std::size_t bytesOf(const stencils::StencilTable<Real>& table) {
    return table.offsets().size_bytes() + table.columns().size_bytes() +
           table.weights().size_bytes();
}

/// Both tables'.
template <class Real>
std::size_t bytesOf(const stencils::FactoredTable<Real>& table) {
    return bytesOf(table.vertices) + bytesOf(table.points);
}

/// The most memory that this process has had, in bytes.
std::size_t peakMemory();

/// How many threads work under ThreadLimit(limit): never more than there are cores for this
/// process, and one in a build without oneTBB.
int threadCount(int limit);

}  // namespace espalier::cli
