// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace espalier::cli {

/// The stages of a run: times each, and shows on a terminal which one is at work and how far it is.
/// Nothing is shown if the run is quiet or standard error is not a terminal.
class Stages {
public:
    explicit Stages(bool quiet);
    ~Stages();
    Stages(const Stages&) = delete;
    Stages& operator=(const Stages&) = delete;

    struct Finished {
        std::string name;
        double seconds;
    };

    /// Runs one stage.
    template <class Work>
    auto run(const std::string& name, Work work) {
        begin(name);
        struct End {
            Stages* stages;
            ~End() { stages->end(); }
        } end{this};
        return work();
    }

    /// Shows how much of the current stage is done; from any thread.
    void showProgress(std::size_t done, std::size_t total);

    const std::vector<Finished>& finished() const { return finished_; }

private:
    void begin(const std::string& name);
    void end();
    void clearLine() const;

    bool isShown_;
    std::string name_;
    std::chrono::steady_clock::time_point start_;
    std::vector<Finished> finished_;
};

/// The most memory that this process has had, in bytes.
std::size_t peakMemory();

/// 1536 → "1.5 kB".
std::string formatBytes(std::size_t bytes);

}  // namespace espalier::cli
