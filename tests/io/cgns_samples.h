// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cgnslib.h>
#include <espalier/io/cgns/cgns_model.h>

#include <filesystem>
#include <string>
#include <vector>

#include "support/test.h"

namespace espalier::test {

// All tests read files by readModel().
inline const bool kCgnsAdded = [] {
    io::addCgnsModels();
    return true;
}();

/// Writes files by CGNS's library.
class CgnsFile {
public:
    CgnsFile(const std::filesystem::path& path, int storage, int dimension = 3) {
        check(cg_set_file_type(storage));
        check(cg_open(path.c_str(), CG_MODE_WRITE, &file));
        check(cg_base_write(file, "Base", dimension, dimension, &base));
    }
    ~CgnsFile() { check(cg_close(file)); }

    static void check(int code) { ASSERT_EQ(code, CG_OK) << cg_get_error(); }

    int unstructured(const char* name, cgsize_t points, cgsize_t cells) {
        cgsize_t sizes[3] = {points, cells, 0};
        int zone = 0;
        check(cg_zone_write(file, base, name, sizes, CGNS_ENUMV(Unstructured), &zone));
        return zone;
    }
    template <class Real>
    void coordinates(int zone, const char* name, const std::vector<Real>& values) {
        int number = 0;
        check(cg_coord_write(file, base, zone,
                             sizeof(Real) == 4 ? CGNS_ENUMV(RealSingle) : CGNS_ENUMV(RealDouble),
                             name, values.data(), &number));
    }
    void section(int zone, const char* name, CGNS_ENUMT(ElementType_t) type, cgsize_t first,
                 cgsize_t last, const std::vector<cgsize_t>& elements,
                 const std::vector<cgsize_t>& offsets = {}) {
        int number = 0;
        if (offsets.empty())
            check(cg_section_write(file, base, zone, name, type, first, last, 0, elements.data(),
                                   &number));
        else
            check(cg_poly_section_write(file, base, zone, name, type, first, last, 0,
                                        elements.data(), offsets.data(), &number));
    }
    void text(const char* name, const char* value) {
        check(cg_goto(file, base, "end"));
        check(cg_descriptor_write(name, value));
    }

    int file = 0, base = 0;
};

/// A grid of 2 × 3 × 2 points in doubles; a zone of floats with a pyramid, a wedge and a triangle;
/// a zone of one polyhedron.
inline void writeSample(const std::filesystem::path& path, int storage) {
    CgnsFile file(path, storage);
    cgsize_t sizes[9] = {2, 3, 2, 1, 2, 1, 0, 0, 0};
    int zone = 0;
    CgnsFile::check(
        cg_zone_write(file.file, file.base, "Grid", sizes, CGNS_ENUMV(Structured), &zone));
    std::vector<double> x, y, z;
    for (int k = 0; k < 2; ++k)
        for (int j = 0; j < 3; ++j)
            for (int i = 0; i < 2; ++i) {
                x.push_back(i);
                y.push_back(2 * j);
                z.push_back(3 * k + 0.1);
            }
    file.coordinates(zone, "CoordinateX", x);
    file.coordinates(zone, "CoordinateY", y);
    file.coordinates(zone, "CoordinateZ", z);

    zone = file.unstructured("Mixed", 8, 2);
    file.coordinates<float>(zone, "CoordinateX", {0, 1, 1, 0, 0.5f, 0, 1, 0.5f});
    file.coordinates<float>(zone, "CoordinateY", {0, 0, 1, 1, 0.5f, 2, 2, 0.5f});
    file.coordinates<float>(zone, "CoordinateZ", {0, 0, 0, 0, 1, 0.1f, 0, 3});
    file.section(zone, "Cells", CGNS_ENUMV(MIXED), 1, 2,
                 {CGNS_ENUMV(PYRA_5), 1, 2, 3, 4, 5, CGNS_ENUMV(TETRA_4), 4, 3, 6, 8}, {0, 6, 11});
    file.section(zone, "Wall", CGNS_ENUMV(TRI_3), 3, 3, {1, 3, 2});
    file.section(zone, "Curved", CGNS_ENUMV(TETRA_10), 4, 4, {1, 2, 3, 4, 5, 6, 7, 8, 1, 2});

    zone = file.unstructured("Polyhedron", 4, 1);
    file.coordinates<double>(zone, "CoordinateX", {0, 1, 0, 0});
    file.coordinates<double>(zone, "CoordinateY", {0, 0, 1, 0});
    file.coordinates<double>(zone, "CoordinateZ", {0, 0, 0, 1});
    file.section(zone, "Faces", CGNS_ENUMV(NGON_n), 1, 4, {1, 3, 2, 1, 2, 4, 2, 3, 4, 3, 4, 1},
                 {0, 3, 6, 9, 12});
    file.section(zone, "Cells", CGNS_ENUMV(NFACE_n), 5, 5, {1, 2, 3, -4}, {0, 4});
    file.text("Note", "everything but coordinates survives");
}

}  // namespace espalier::test
