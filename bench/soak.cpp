// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/bounding_box.h>
#include <espalier/base/error.h>
#include <espalier/base/memory.h>
#include <espalier/bind/bind.h>
#include <espalier/io/binding_file.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/osd/deformer.h>
#include <espalier/shapes/inventory.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "support/temporary_folder.h"

// Binds lattices, applies them from several threads, saves, loads and frees them, one after the
// other, as a host does in a long session. Results must stay correct, and memory must not grow.
//
//     soak [LATTICES] [THREADS]     default 1000 and 8

namespace {

using namespace espalier;

/// Returns one of 24 lattices, alternating between large and small ones.
Lattice latticeOf(int number) {
    const int size = 1 + number / 4 % 6;
    switch (number % 4) {
        case 0:
            return shapes::box({.cells = {size, 2, 3}});
        case 1:
            return shapes::cylinder({.sectors = 3 + size, .layers = 2});
        case 2:
            return shapes::torus();
        default:
            return shapes::arm({.sides = 4 + size});
    }
}

std::vector<Point3> pointsAround(const Lattice& lattice, int number) {
    const BoundingBox bounds(lattice.positions);
    std::mt19937_64 random(static_cast<std::uint64_t>(number));
    std::uniform_real_distribution<double> share(-0.1, 1.1);
    std::vector<Point3> points(3000);
    for (Point3& point : points)
        for (std::size_t axis = 0; axis < 3; ++axis)
            point[axis] = bounds.min[axis] + share(random) * bounds.size()[axis];
    return points;
}

void require(bool isSo, const std::string& what) {
    if (!isSo) throw Error(what);
}

/// Does all the work with one lattice.
void runOne(int number, const std::filesystem::path& folder) {
    const Lattice lattice = latticeOf(number);
    const std::vector<Point3> points = pointsAround(lattice, number);
    const far::TopologyRefiner refiner(lattice.complex);
    io::BoundModel model;
    model.binding =
        bind::bindPoints({refiner, lattice.positions}, points, bind::Level{2 + number % 2});
    model.modelName = "points";

    const auto path = folder / (std::to_string(number) + ".espb");
    io::writeBoundModel(path, model);
    const io::BoundModel loaded = io::readBoundModel(path);
    std::filesystem::remove(path);
    require(loaded.binding == model.binding, "a binding came back changed");

    const osd::Deformer<double> deformer(loaded.binding);
    std::vector<double> result(3 * points.size());
    for (int pose = 0; pose < 5; ++pose) {
        std::vector<Point3> moved = lattice.positions;
        for (Point3& position : moved) position[2] += pose + 0.1 * position[0];
        const std::vector<Point3> expected = osd::evaluateBinding(model.binding, moved);
        const std::span<const double> source(moved.data()->data(), 3 * moved.size());
        deformer.deform(source, result);
        for (std::size_t i = 0; i < points.size(); ++i)
            for (std::size_t axis = 0; axis < 3; ++axis)
                // A few ulp of numbers up to 10.
                require(std::abs(result[3 * i + axis] - expected[i][axis]) < 1e-12,
                        "a result is wrong");
    }
}

/// Memory of the process, recorded after every few lattices.
class MemoryRecord {
public:
    void add() {
        const std::lock_guard lock(mutex_);
        bytes_.push_back(residentMemory());
    }
    /// The maximum in a part of the record.
    std::uint64_t peak(double from, double to) const {
        const auto at = [&](double share) {
            return bytes_.begin() +
                   static_cast<std::ptrdiff_t>(share * static_cast<double>(bytes_.size()));
        };
        return *std::max_element(at(from), std::max(at(to), at(from) + 1));
    }

private:
    std::mutex mutex_;
    std::vector<std::uint64_t> bytes_;
};

/// \return true if memory did not grow
bool soak(int latticeCount, int threadCount) {
    const test::TemporaryFolder folder;
    MemoryRecord record;
    std::atomic<int> next = 0;
    std::exception_ptr failure;
    std::mutex failureMutex;
    const auto work = [&] {
        try {
            for (int number = next++; number < latticeCount; number = next++) {
                runOne(number, folder.path());
                record.add();
            }
        } catch (...) {
            const std::lock_guard lock(failureMutex);
            failure = std::current_exception();
            next = latticeCount;
        }
    };
    const auto start = std::chrono::steady_clock::now();
    std::vector<std::thread> threads;
    for (int i = 0; i < threadCount; ++i) threads.emplace_back(work);
    for (std::thread& thread : threads) thread.join();
    if (failure) std::rethrow_exception(failure);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;

    // The first quarter is warm-up: allocators keep memory that threads free.
    const std::uint64_t early = record.peak(0.25, 0.5), late = record.peak(0.75, 1);
    std::printf(
        "%d lattices on %d threads in %.1f s; most memory %s in the second quarter, %s in "
        "the last\n",
        latticeCount, threadCount, seconds.count(), formatBytes(early).c_str(),
        formatBytes(late).c_str());
    // Which lattices are in memory at the same time is random. A leak of one table per lattice
    // would be ten times as much.
    return static_cast<double>(late) < 1.1 * static_cast<double>(early);
}

}  // namespace

int main(int argumentCount, char** arguments) {
    try {
        const int latticeCount = argumentCount > 1 ? std::stoi(arguments[1]) : 1000;
        const int threadCount = argumentCount > 2 ? std::stoi(arguments[2]) : 8;
        if (soak(latticeCount, threadCount)) return EXIT_SUCCESS;
        std::fprintf(stderr, "soak: memory grew\n");
    } catch (const std::exception& error) {
        std::fprintf(stderr, "soak: %s\n", error.what());
    }
    return EXIT_FAILURE;
}
