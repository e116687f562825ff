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

/// Memory ran out. what() is "out of memory while binding: 5.9 GB were in use at most; the limit is
/// 6.0 GB (--max-memory)". Making the exception allocates nothing.
class OutOfMemory : public std::bad_alloc {
public:
    /// \param stage of the run; empty outside the stages
    explicit OutOfMemory(std::string_view stage = {}) noexcept;
    const char* what() const noexcept override { return text_.data(); }

private:
    std::array<char, 200> text_ = {};
};

/// Times the stages of a run, and shows on a terminal which stage runs and how much of it is done.
/// Shows nothing if the run is quiet or standard error is not a terminal. At the end the line is
/// empty, also if a signal ends the program. Failing to write to the terminal is not an error.
class Stages {
public:
    explicit Stages(bool quiet);
    ~Stages();
    Stages(const Stages&) = delete;
    Stages& operator=(const Stages&) = delete;

    /// A stage that ran several times, for several files or poses, is listed once, with its sums.
    struct FinishedStage {
        std::string name;
        double seconds;

        /// Bytes read or made (run_report.h says of what); nothing if one of its runs did not tell.
        std::optional<std::size_t> bytes;
    };

    /// Runs one stage.
    /// \throws MemoryError if the process already holds more memory than MemoryLimit allows.
    /// OutOfMemory in place of std::bad_alloc and std::length_error from `work`. Its other
    /// exceptions pass; the message of a MemoryError gets the name of the stage
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
            // A container would have become larger than memory.
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

    /// Adds to the bytes that the current stage has read or made. To be called by its work.
    void addBytes(std::size_t bytes);

    /// Adds the size of a file that the stage has read or written; nothing for a device or a pipe.
    void addFile(const std::filesystem::path& path);

    /// Shows how much of the current stage is done. May be called from any thread.
    void showProgress(std::size_t done, std::size_t total) const noexcept;

    /// Returns the stages in the order in which they first began.
    const std::vector<FinishedStage>& finished() const { return finished_; }

private:
    void begin(std::string_view name);
    void end() noexcept;
    void clearLine() const noexcept;

    bool isShown_;
    std::size_t current_ = 0;  ///< index in finished_ of the stage that runs
    std::chrono::steady_clock::time_point start_;
    std::optional<std::size_t> bytes_;  ///< bytes of the current stage
    std::vector<FinishedStage> finished_;
};

/// Returns the bytes of a table's offsets, columns and weights.
template <class Real>
std::size_t bytesOf(const stencils::StencilTable<Real>& table) {
    return table.offsets().size_bytes() + table.columns().size_bytes() +
           table.weights().size_bytes();
}

/// Returns the bytes of both tables.
template <class Real>
std::size_t bytesOf(const stencils::FactoredTable<Real>& table) {
    return bytesOf(table.vertices) + bytesOf(table.points);
}

/// Returns the peak memory of this process so far, in bytes.
std::size_t peakMemory();

/// Returns the number of threads that work under ThreadLimit(limit): at most the number of cores
/// available to this process, and 1 in a build without oneTBB.
int threadCount(int limit);

}  // namespace espalier::cli
