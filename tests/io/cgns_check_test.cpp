// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/cgns/cgns_model.h>
#include <espalier/io/files/file.h>
#include <espalier/io/model.h>
#include <hdf5.h>
#include <io/cgns_samples.h>

#include <functional>

#include "support/temporary_folder.h"
#include "support/test.h"

namespace espalier::io {
namespace {

void read(const std::filesystem::path& path) {
    readModel(path, readFile(path))->readCells();
}

/// Writes a sample in HDF5 and changes it by HDF5's library.
void writeChanged(const std::filesystem::path& path, const std::function<void(hid_t)>& change) {
    writeSample(path, CG_FILE_HDF5);
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    change(file);
    H5Fclose(file);
}

/// The values of an array of four coordinates.
constexpr const char* kArray = "/Base/Polyhedron/GridCoordinates/CoordinateX/ data";

/// Replaces the values of an array by a data set of doubles that is never written.
void replaceArray(hid_t file, hid_t properties, hsize_t size = 4, const char* array = kArray) {
    H5Ldelete(file, array, H5P_DEFAULT);
    const hid_t space = H5Screate_simple(1, &size, nullptr);
    const hid_t data =
        H5Dcreate2(file, array, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, properties, H5P_DEFAULT);
    EXPECT_GE(data, 0);
    H5Dclose(data);
    H5Sclose(space);
}

// CGNS's library has aborted for some of these, if it had read other files before; so it must not
// see them.
TEST(CgnsCheck, PartsOfFilesAreRefused) {
    for (const int storage : {CG_FILE_ADF, CG_FILE_HDF5}) {
        const TemporaryFolder folder;
        writeSample(folder / "a.cgns", storage);
        const std::string bytes = readFile(folder / "a.cgns");
        EXPECT_NO_THROW(readModel("a.cgns", bytes));
        // Each length of a header, and some of the rest. ADF pads files to whole blocks.
        for (std::size_t size = 0; size + 4096 < bytes.size(); size += size < 300 ? 1 : 97)
            EXPECT_THAT(messageOf<FileError>([&] { readModel("a.cgns", bytes.substr(0, size)); }),
                        AllOf(StartsWith("a.cgns: "), Not(HasSubstr("CGNS's library"))))
                << size;
        EXPECT_NO_THROW(readModel("a.cgns", bytes));
    }
}

TEST(CgnsCheck, AHeaderOfAdfIsWhole) {
    const TemporaryFolder folder;
    writeSample(folder / "a.cgns", CG_FILE_ADF);
    const std::string good = readFile(folder / "a.cgns");
    const auto refused = [&](std::size_t place, const std::string& text, const char* message) {
        EXPECT_REFUSED(FileError, message,
                       readModel("a.cgns", std::string(good).replace(place, text.size(), text)));
    };
    refused(4, "BDF", "is neither an HDF5 file nor an ADF file");
    refused(64, "AdF9", "cut short or damaged: it lacks 'AdF1' at byte 64");
    refused(182, "AdF4", "it lacks 'AdF5' at byte 182");
    refused(146, "7FFFFFFF", "is cut short: its header says that it has more than");
    refused(146, "-0000001", "byte 146: the header of the ADF file has no number here");
    EXPECT_REFUSED(FileError, "is neither an HDF5 file", readModel("a.cgns", ""));
}

TEST(CgnsCheck, LinksToOtherFilesAreRefused) {
    for (const int storage : {CG_FILE_ADF, CG_FILE_HDF5}) {
        const TemporaryFolder folder;
        writeSample(folder / "other.cgns", storage);
        const std::string other = folder / "other.cgns";
        // The first names no file, so the link leads to the file itself.
        for (const std::string& target : {std::string(), other, std::string("/dev/stdin")}) {
            const auto path = folder / "a.cgns";
            writeSample(path, storage);
            int file = 0;
            CgnsFile::check(cg_open(path.c_str(), CG_MODE_MODIFY, &file));
            CgnsFile::check(cg_goto(file, 1, "end"));
            CgnsFile::check(cg_link_write("Link", target.c_str(), "/Base/Note"));
            CgnsFile::check(cg_close(file));
            if (target.empty())
                EXPECT_NO_THROW(read(path)) << storage;
            else
                EXPECT_REFUSED(FileError, "is a link to another file; only data in the file itself",
                               read(path));
        }
    }
}

TEST(CgnsCheck, ExternalLinksAndDataOfHdf5AreRefused) {
    const TemporaryFolder folder;
    const auto path = folder / "a.cgns";
    const std::string other = folder / "other.cgns";
    writeSample(other, CG_FILE_HDF5);
    writeChanged(path, [&](hid_t file) {
        H5Ldelete(file, "/Base/Polyhedron", H5P_DEFAULT);
        H5Lcreate_external(other.c_str(), "/Base/Polyhedron", file, "/Base/Polyhedron", H5P_DEFAULT,
                           H5P_DEFAULT);
    });
    EXPECT_REFUSED(FileError, "the node 'Base/Polyhedron' is a link to another file", read(path));
    // The values of a data set: from a data set of another file, and from the bytes of any file.
    writeChanged(path, [&](hid_t file) {
        const hsize_t size = 4;
        const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
        const hid_t space = H5Screate_simple(1, &size, nullptr);
        H5Pset_virtual(properties, space, other.c_str(), kArray, space);
        replaceArray(file, properties);
        H5Sclose(space);
        H5Pclose(properties);
    });
    EXPECT_REFUSED(FileError, "CoordinateX/ data' are in another file (a virtual data set",
                   read(path));
    writeChanged(path, [&](hid_t file) {
        const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
        H5Pset_external(properties, other.c_str(), 0, 32);
        replaceArray(file, properties);
        H5Pclose(properties);
    });
    EXPECT_REFUSED(FileError, "are in another file", read(path));
}

TEST(CgnsCheck, ValuesThatWereNeverWrittenAreRefusedBeforeMemoryIsTaken) {
    const TemporaryFolder folder;
    const auto path = folder / "a.cgns";
    // 16 GB, of which the file has no byte: HDF5 fills them with zeros when they are read.
    writeChanged(path, [&](hid_t file) {
        constexpr int kPoints = 2000000000;
        const int sizes[] = {kPoints, 1, 0};
        const hid_t zone = H5Dopen2(file, "/Base/Polyhedron/ data", H5P_DEFAULT);
        EXPECT_GE(H5Dwrite(zone, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, sizes), 0);
        H5Dclose(zone);
        for (const char axis : {'X', 'Y', 'Z'}) {
            std::string array = kArray;
            array[array.find(" data") - 2] = axis;
            replaceArray(file, H5P_DEFAULT, kPoints, array.c_str());
        }
    });
    EXPECT_REFUSED(FileError, "CoordinateX claims 2000000000 values, but the", read(path));
    {
        CgnsFile file(path, CG_FILE_HDF5);
        const int zone = file.unstructured("Z", 3, 1);
        for (const char* axis : {"CoordinateX", "CoordinateY"})
            file.coordinates<double>(zone, axis, {0, 1, 2});
        int section = 0;
        file.check(cg_section_partial_write(file.file, file.base, zone, "Huge", CGNS_ENUMV(TRI_3),
                                            1, 500000000, 0, &section));
    }
    EXPECT_REFUSED(FileError, "the section 'Huge' claims 1500000000 values", read(path));
}

}  // namespace
}  // namespace espalier::io
