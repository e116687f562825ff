// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <espalier/base/parallel.h>
#include <espalier/io/model.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "workloads.h"

// Reads and writes a model of a million points and as many quadrilaterals, as `espalier deform`
// does, on one thread. Benchmarks are named file/FORMAT/WORK. The work "copying" is `cat` of the
// same file into another one, on the same disk.
namespace espalier {
namespace {

namespace fs = std::filesystem;

/// A folder with the file model.obj, which disappears with this object.
class Folder {
public:
    Folder() : path_(fs::temp_directory_path() / ("espalier-bench-" + std::to_string(getpid()))) {
        fs::create_directory(path_);
        const std::vector<Point3> points = bench::model();
        std::FILE* const file = std::fopen(model().c_str(), "w");
        if (file == nullptr) std::abort();
        for (const Point3& p : points) std::fprintf(file, "v %.9g %.9g %.9g\n", p[0], p[1], p[2]);
        const auto side = static_cast<int>(std::lround(std::sqrt(points.size())));
        for (int i = 0; i < side; ++i)
            for (int j = 0; j < side; ++j) {
                const int next = (i + 1) % side, beside = (j + 1) % side;
                std::fprintf(file, "f %d %d %d %d\n", i * side + j + 1, next * side + j + 1,
                             next * side + beside + 1, i * side + beside + 1);
            }
        std::fclose(file);
    }
    ~Folder() { fs::remove_all(path_); }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    std::string model() const { return (path_ / "model.obj").string(); }
    std::string copy() const { return (path_ / "copy.obj").string(); }

private:
    fs::path path_;
};

/// Times work() on one thread, with the bytes of the model.
template <class Work>
void run(benchmark::State& state, const Folder& folder, Work work) {
    const ThreadLimit limit(1);
    for (auto _ : state) work();
    state.SetBytesProcessed(state.iterations() *
                            static_cast<Offset>(fs::file_size(folder.model())));
}

void copying(benchmark::State& state) {
    const Folder folder;
    const std::string command = "cat " + folder.model() + " > " + folder.copy();
    run(state, folder, [&] {
        if (std::system(command.c_str()) != 0) state.SkipWithError("cat failed");
    });
}

void reading(benchmark::State& state) {
    const Folder folder;
    run(state, folder, [&] {
        if (io::readModel(folder.model())->positions().size() != bench::kMillion)
            state.SkipWithError("points are missing");
    });
}

void writing(benchmark::State& state) {
    const Folder folder;
    const auto model = io::readModel(folder.model());
    // Each point moves, so that each number is written anew.
    std::vector<Point3> pose(model->positions().begin(), model->positions().end());
    for (Point3& p : pose) p = {1.25 * p[0] + 0.1 * p[1], p[1] - 0.3 * p[2], 0.7 * p[2] + 0.01};
    run(state, folder, [&] { model->write(folder.copy(), pose); });
    if (io::readModel(folder.copy())->positions()[1] != pose[1])
        state.SkipWithError("the result is wrong");
}

const bool kRegistered = [] {
    for (const auto& [name, work] :
         {std::pair{"copying", &copying}, {"reading", &reading}, {"writing", &writing}})
        benchmark::RegisterBenchmark((std::string("file/obj/") + name).c_str(), work)
            ->UseRealTime()
            ->Unit(benchmark::kMillisecond);
    return true;
}();

}  // namespace
}  // namespace espalier
