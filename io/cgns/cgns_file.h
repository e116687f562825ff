// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>
#include <espalier/io/files/file.h>

#include <cgns_io.h>
#include <cgnslib.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "../files/coding.h"
#include "../files/descriptor.h"
#include "../files/number_types.h"
#include "../models/coordinates.h"

// Files of CGNS, opened by CGNS's library.

namespace espalier::io {

/// CGNS's library has global state.
inline std::mutex& libraryMutex() {
    static std::mutex mutex;
    return mutex;
}

/// A file with some bytes, which exists as long as this object.
class TemporaryFile {
public:
    explicit TemporaryFile(std::string_view bytes) {
        std::error_code error;
        path_ = (std::filesystem::temp_directory_path(error) / "espalier-XXXXXX").string();
        if (error) fail("the folder of temporary files cannot be found", error.value());
        const Descriptor file(::mkstemp(path_.data()));
        if (!file) fail("a temporary file cannot be made", errno);
        while (!bytes.empty()) {
            const auto written =
                uninterrupted([&] { return ::write(file.number(), bytes.data(), bytes.size()); });
            if (written < 0) {
                const int reason = errno;
                remove();
                fail("a temporary file cannot be written", reason);
            }
            bytes.remove_prefix(written);
        }
    }
    ~TemporaryFile() { remove(); }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    const char* path() const { return path_.c_str(); }

private:
    void remove() const {
        std::error_code ignored;
        std::filesystem::remove(path_, ignored);
    }
    [[noreturn]] void fail(const char* what, int error) const {
        throw FileError(path_, concat(what, ": ", systemMessage(error),
                                      "; the variable TMPDIR names another folder for it"));
    }

    std::string path_;
};

/// An array of coordinates of a zone.
struct CoordinateArray {
    std::string node;  ///< path from the root: "/Base/Zone/GridCoordinates/CoordinateX"
    Precision precision = Precision::Double;
};

struct Zone {
    int base, number;  ///< numbers from 1 on
    bool isStructured;
    std::vector<std::size_t> extent;  ///< the extent of the arrays of coordinates
    std::size_t firstPoint, pointCount;
    std::vector<CoordinateArray> coordinates;  ///< two or three
};

/// Opens a file by the library's lower level, which reads and writes whole nodes.
class NodeFile {
public:
    NodeFile(const std::filesystem::path& shown, const char* path, int mode)
        : shown_(shown), path_(path) {
        check(cgio_open_file(path, mode, CGIO_FILE_NONE, &number_));
        check(cgio_get_root_id(number_, &root_));
    }
    ~NodeFile() {
        if (number_ > 0) cgio_close_file(number_);
    }
    NodeFile(const NodeFile&) = delete;
    NodeFile& operator=(const NodeFile&) = delete;

    double node(const std::string& path) const {
        double id = 0;
        check(cgio_get_node_id(number_, root_, path.c_str(), &id));
        return id;
    }
    std::string typeOf(double id) const {
        std::array<char, CGIO_MAX_DATATYPE_LENGTH + 1> type{};
        check(cgio_get_data_type(number_, id, type.data()));
        return type.data();
    }
    std::vector<std::size_t> extentOf(double id) const {
        int count = 0;
        std::array<cgsize_t, CGIO_MAX_DIMENSIONS> sizes{};
        check(cgio_get_dimensions(number_, id, &count, sizes.data()));
        return {sizes.begin(), sizes.begin() + count};
    }
    template <class Real>
    std::vector<Real> read(double id, std::size_t count) const {
        std::vector<Real> values(count);
        check(cgio_read_all_data(number_, id, values.data()));
        return values;
    }
    template <class Real>
    void write(double id, const std::vector<Real>& values) const {
        checkWritten(cgio_write_all_data(number_, id, values.data()));
    }
    void close() {
        const int number = std::exchange(number_, 0);
        checkWritten(cgio_close_file(number));
    }

private:
    void check(int code) const {
        if (code != CGIO_ERR_NONE)
            throw FileError(shown_, "CGNS's library refuses the file: " + message());
    }
    void checkWritten(int code) const {
        if (code != CGIO_ERR_NONE)
            throw FileError(path_,
                            "CGNS's library cannot write this temporary file (is its disk "
                            "full?): " +
                                message());
    }
    static std::string message() {
        std::array<char, CGIO_MAX_ERROR_LENGTH + 1> text{};
        cgio_error_message(text.data());
        return text.data();
    }

    const std::filesystem::path& shown_;
    std::filesystem::path path_;
    int number_ = 0;
    double root_ = 0;
};

/// Throws if a file is too small for a number of values of four bytes or more. HDF5 may have
/// compressed them; but it may as well claim values that were never written.
inline void requireRoom(const std::filesystem::path& shown, std::size_t fileBytes,
                        std::uint64_t count, const std::string& what) {
    const std::uint64_t most = saturatingProduct<std::uint64_t>(fileBytes, kMaxInflation) / 4;
    if (count > most)
        throw FileError(shown, concat(what, " claims ", count, " values, but the ", fileBytes,
                                      " bytes of the file can hold at most ", most));
}

/// Opens a file by the library's middle level, which knows zones and elements.
class ZoneFile {
public:
    /// \param fileBytes size of the file
    ZoneFile(const std::filesystem::path& shown, const char* path, std::size_t fileBytes)
        : shown_(shown), fileBytes_(fileBytes) {
        check(cg_open(path, CG_MODE_READ, &number_));
    }
    ~ZoneFile() {
        if (number_ > 0) cg_close(number_);
    }
    ZoneFile(const ZoneFile&) = delete;
    ZoneFile& operator=(const ZoneFile&) = delete;

    int number() const { return number_; }
    void requireRoom(std::uint64_t count, const std::string& what) const {
        io::requireRoom(shown_, fileBytes_, count, what);
    }
    void check(int code) const {
        if (code != CG_OK)
            throw FileError(shown_, concat("CGNS's library refuses the file: ", cg_get_error()));
    }
    [[noreturn]] void fail(const std::string& cause) const { throw FileError(shown_, cause); }

    std::vector<Zone> zones() const {
        std::vector<Zone> zones;
        int baseCount = 0;
        check(cg_nbases(number_, &baseCount));
        for (int base = 1; base <= baseCount; ++base) {
            int zoneCount = 0;
            check(cg_nzones(number_, base, &zoneCount));
            for (int zone = 1; zone <= zoneCount; ++zone) addZone(zones, base, zone);
        }
        return zones;
    }

private:
    using Name = std::array<char, 33>;  // The library's longest name, and its end.

    void addZone(std::vector<Zone>& zones, int base, int number) const {
        Name baseName{}, zoneName{};
        int cellDimension = 0, spaceDimension = 0, coordinateCount = 0;
        std::array<cgsize_t, 9> sizes{};
        CGNS_ENUMT(ZoneType_t) type;
        check(cg_base_read(number_, base, baseName.data(), &cellDimension, &spaceDimension));
        check(cg_zone_read(number_, base, number, zoneName.data(), sizes.data()));
        check(cg_zone_type(number_, base, number, &type));
        check(cg_ncoords(number_, base, number, &coordinateCount));
        if (coordinateCount == 0) return;
        Zone zone{base, number, type == CGNS_ENUMV(Structured), {}, 0, 0, {}};
        const std::string place = concat("/", baseName.data(), "/", zoneName.data());
        for (const char* axis : {"CoordinateX", "CoordinateY", "CoordinateZ"}) {
            bool isThere = false;
            for (int i = 1; i <= coordinateCount; ++i) {
                Name name{};
                CGNS_ENUMT(DataType_t) stored;
                check(cg_coord_info(number_, base, number, i, &stored, name.data()));
                isThere = isThere || std::string_view(name.data()) == axis;
            }
            if (isThere) zone.coordinates.push_back({place + "/GridCoordinates/" + axis});
        }
        if (zone.coordinates.size() < 2)
            fail("the zone '" + std::string(zoneName.data()) +
                 "' has no coordinates CoordinateX and CoordinateY; others, such as CoordinateR, "
                 "cannot be deformed");
        zones.push_back(std::move(zone));
    }

    const std::filesystem::path& shown_;
    std::size_t fileBytes_;
    int number_ = 0;
};

}  // namespace espalier::io
