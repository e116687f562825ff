// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/io/files/file.h>

#include <cgns_io.h>
#include <hdf5.h>

#include <array>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cgns_check.h"

namespace espalier::io {
namespace {

using Path = std::filesystem::path;

constexpr const char* kElsewhere =
    "; only data in the file itself are read: write one file with all data, for example by "
    "cgnscompress or h5repack";

bool isHdf5(std::string_view bytes) {
    // HDF5 looks for its signature at the begin, and after a user block of 512, 1024, 2048 ...
    // bytes.
    constexpr std::string_view kSignature = "\x89HDF\r\n\x1a\n";
    for (std::size_t at = 0; at < bytes.size(); at = at == 0 ? 512 : 2 * at)
        if (bytes.substr(at).starts_with(kSignature)) return true;
    return false;
}

/// Throws unless a file begins with a whole header of ADF and is as long as this says.
///
/// The header has a tag at each of these offsets. Before the last one are two addresses: those of
/// the root node and of the end of the file, each as the hexadecimal number of a block of 4096
/// bytes (8 digits) and of a byte in it (4 digits).
void checkAdfHeader(const Path& shown, std::string_view bytes) {
    constexpr std::pair<std::size_t, std::string_view> kTags[] = {{4, "ADF Database Version"},
                                                                  {32, "AdF0"},
                                                                  {64, "AdF1"},
                                                                  {96, "AdF2"},
                                                                  {102, "AdF3"},
                                                                  {130, "AdF4"},
                                                                  {182, "AdF5"}};
    constexpr std::size_t kEnd = 146, kDigits = 8, kBlock = 4096;
    if (bytes.size() < kTags[0].first ||
        !kTags[0].second.starts_with(bytes.substr(kTags[0].first, kTags[0].second.size())))
        throw FileError(shown, "is neither an HDF5 file nor an ADF file, as CGNS files are");
    for (const auto& [offset, tag] : kTags)
        if (bytes.size() < offset || !bytes.substr(offset).starts_with(tag))
            throw FileError(shown, concat("the header of the ADF file is cut short or damaged: it "
                                          "lacks ",
                                          inQuotes(tag), " at byte ", offset));
    const auto hexadecimal = [&](std::size_t offset, std::size_t digits) {
        std::uint64_t number = 0;
        const char* const end = bytes.data() + offset + digits;
        if (std::from_chars(bytes.data() + offset, end, number, 16).ptr != end)
            throw FileError(
                shown, concat("byte ", offset, ": the header of the ADF file has no number here"));
        return number;
    };
    const std::uint64_t size = hexadecimal(kEnd, kDigits) * kBlock + hexadecimal(kEnd + kDigits, 4);
    if (size >= bytes.size())
        throw FileError(shown, concat("is cut short: its header says that it has more than ", size,
                                      " bytes, and it has ", bytes.size()));
}

/// An identifier of HDF5's library, which is closed on destruction.
class Hdf5Id {
public:
    Hdf5Id(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
    ~Hdf5Id() {
        if (id_ >= 0) close_(id_);
    }
    Hdf5Id(const Hdf5Id&) = delete;
    Hdf5Id& operator=(const Hdf5Id&) = delete;

    explicit operator bool() const { return id_ >= 0; }
    hid_t operator*() const { return id_; }

private:
    hid_t id_;
    herr_t (*close_)(hid_t);
};

/// HDF5's library prints its errors, unless it is told otherwise.
class WithoutHdf5Messages {
public:
    WithoutHdf5Messages() {
        ::H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
        ::H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    }
    ~WithoutHdf5Messages() { ::H5Eset_auto2(H5E_DEFAULT, print_, data_); }
    WithoutHdf5Messages(const WithoutHdf5Messages&) = delete;
    WithoutHdf5Messages& operator=(const WithoutHdf5Messages&) = delete;

private:
    H5E_auto2_t print_ = nullptr;
    void* data_ = nullptr;
};

/// Returns true if the values of a data set are in other files.
bool isElsewhere(hid_t group, const char* name) {
    H5O_info_t info;
    if (::H5Oget_info_by_name(group, name, &info, H5P_DEFAULT) < 0 || info.type != H5O_TYPE_DATASET)
        return false;
    const Hdf5Id dataSet(::H5Dopen2(group, name, H5P_DEFAULT), ::H5Dclose);
    if (!dataSet) return false;
    const Hdf5Id properties(::H5Dget_create_plist(*dataSet), ::H5Pclose);
    return properties && (::H5Pget_layout(*properties) == H5D_VIRTUAL ||
                          ::H5Pget_external_count(*properties) > 0);
}

/// Throws if a link of an HDF5 file leads out of it, or a data set has its values elsewhere.
void checkHdf5Links(const Path& shown, const char* path) {
    const WithoutHdf5Messages quiet;
    const Hdf5Id file(::H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT), ::H5Fclose);
    if (!file)
        throw FileError(shown, "HDF5's library refuses the file: it is cut short or damaged");
    std::string cause;
    const auto visit = [](hid_t group, const char* name, const H5L_info_t* link, void* data) {
        auto& found = *static_cast<std::string*>(data);
        if (link->type != H5L_TYPE_HARD && link->type != H5L_TYPE_SOFT)
            found = concat("the node '", name, "' is a link to another file");
        else if (link->type == H5L_TYPE_HARD && isElsewhere(group, name))
            found = concat("the values of '", name,
                           "' are in another file (a virtual data set or "
                           "external storage of HDF5)");
        return found.empty() ? 0 : 1;
    };
    if (::H5Lvisit(*file, H5_INDEX_NAME, H5_ITER_NATIVE, visit, &cause) < 0)
        throw FileError(shown, "HDF5's library refuses the file: its links cannot be read");
    if (!cause.empty()) throw FileError(shown, cause + kElsewhere);
}

/// Throws if a node of a CGNS file is a link to another file.
class NodeLinks {
public:
    /// \param size of the file
    NodeLinks(const Path& shown, const char* path, std::size_t size)
        : shown_(shown), nodesLeft_(size / kNodeBytes) {
        check(::cgio_open_file(path, CGIO_MODE_READ, CGIO_FILE_NONE, &file_));
    }
    ~NodeLinks() {
        if (file_ > 0) ::cgio_close_file(file_);
    }
    NodeLinks(const NodeLinks&) = delete;
    NodeLinks& operator=(const NodeLinks&) = delete;

    void check() {
        double root = 0;
        check(::cgio_get_root_id(file_, &root));
        visit(root, 0);
    }

private:
    // A node of ADF takes 246 bytes, one of HDF5 takes more.
    static constexpr std::size_t kNodeBytes = 200;
    // A tree of CGNS has no more than a dozen levels.
    static constexpr int kMaxDepth = 100;

    void visit(double node, int depth) {
        // Nodes of a damaged file may be their own children.
        if (depth > kMaxDepth || nodesLeft_-- == 0)
            throw FileError(shown_, "is damaged: its nodes are not a tree");
        int length = 0;
        check(::cgio_is_link(file_, node, &length));
        if (length > 0) return checkLink(node);
        int count = 0, got = 0;
        check(::cgio_number_children(file_, node, &count));
        for (int child = 1; child <= count; ++child) {
            double id = 0;
            check(::cgio_children_ids(file_, node, child, 1, &got, &id));
            if (got == 1) visit(id, depth + 1);
        }
    }

    void checkLink(double node) const {
        int fileLength = 0, nameLength = 0;
        check(::cgio_link_size(file_, node, &fileLength, &nameLength));
        if (fileLength == 0) return;
        std::array<char, CGIO_MAX_NAME_LENGTH + 1> name{};
        check(::cgio_get_name(file_, node, name.data()));
        throw FileError(
            shown_, concat("the node '", name.data(), "' is a link to another file", kElsewhere));
    }

    void check(int code) const {
        if (code == CGIO_ERR_NONE) return;
        std::array<char, CGIO_MAX_ERROR_LENGTH + 1> text{};
        ::cgio_error_message(text.data());
        throw FileError(shown_, concat("CGNS's library refuses the file: ", text.data()));
    }

    const Path& shown_;
    int file_ = 0;
    std::size_t nodesLeft_;
};

}  // namespace

void checkCgnsFile(const Path& shown, std::string_view bytes, const char* path) {
    if (isHdf5(bytes))
        checkHdf5Links(shown, path);
    else
        checkAdfHeader(shown, bytes);
    NodeLinks(shown, path, bytes.size()).check();
}

}  // namespace espalier::io
