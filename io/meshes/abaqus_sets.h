// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/far/incidence.h>

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "abaqus_elements.h"
#include "abaqus_file.h"
#include "cell_visitor.h"
#include "node_numbers.h"

namespace espalier::io {

/// The numbers of the nodes and of the elements of a file, for each scope.
struct AbaqusNumbers {
    std::vector<NodeNumbers> nodes, elements;

    /// The scope whose nodes the current one names: its own, or the part of an instance.
    std::vector<std::size_t> partOf;
    std::map<std::string, std::size_t> instances;  ///< by name, in lower case

    /// The first node, or element, of each keyword *NODE, or *ELEMENT, and their number at the end.
    std::vector<Index> nodeBlocks, elementBlocks;
};

/// A side of an element as a surface names it.
struct AbaqusSide {
    std::size_t number = 0;  ///< from 1; 0 for the face of a shell
    bool isEdge = false;     ///< "E3" and not "S3"
};

/// The named sets of a file: *NSET and *ELSET, the sets of *NODE and *ELEMENT, and *SURFACE. Sets
/// that are marked as internal serve the others only. Members that are not in the file are left
/// out.
class AbaqusSets {
public:
    /// Reads the sets.
    /// \throws FileError if they are malformed, or if they have more members than 100 for each node
    ///         and element
    AbaqusSets(const std::filesystem::path& path, std::string_view bytes,
               const AbaqusNumbers& numbers);

    /// Sets the names of the sets of an element. The elements must come in their order.
    /// \return false if the element has the same sets as the one before; the first has none before
    bool setNames(Index element, std::vector<std::string>& names);

    /// Returns true if elements have to be given to addElement(), since surfaces consist of their
    /// sides.
    bool needsElements() const { return !surfaces_.empty(); }

    /// Adds the nodes of a solid or a face, in VTK's order.
    void addElement(Index element, const AbaqusElement& type, std::span<const Index> nodes);

    /// Visits the sets of nodes and the surfaces.
    void visit(CellVisitor& visitor) const;

private:
    struct Set {
        std::string name;
        bool isInternal = false;
        std::vector<Index> members = {};
    };

    struct Surface {
        std::string name;
        std::vector<std::pair<Index, AbaqusSide>> sides = {};  ///< elements, and a side of each
        std::vector<Index> nodes = {};
    };

    /// The sets of one kind in the order of the file, and their numbers by scope and name.
    struct Sets {
        std::vector<Set> all;
        std::map<std::pair<std::size_t, std::string>, std::size_t> numbers;
    };

    Set& setOf(Sets& sets, std::size_t scope, std::string_view name, bool isInternal);
    void readSet(AbaqusFile& file, bool isOfNodes);
    void readSurface(AbaqusFile& file);
    void addMembers(std::vector<Index>& members, bool isOfNodes, std::size_t own, std::size_t scope,
                    std::string_view entry) const;
    std::size_t scopeOf(const AbaqusFile& file) const;
    void countMembers(const AbaqusFile& file, std::size_t members);
    void visitSide(Index element, const AbaqusSide& side, CellVisitor& visitor) const;

    const AbaqusNumbers& numbers_;
    Sets nodeSets_, elementSets_;
    std::vector<Surface> surfaces_;
    std::size_t memberCount_ = 0, maxMembers_ = 0;
    std::vector<std::vector<std::size_t>> setsOfElements_;
    std::vector<std::size_t> current_;  ///< the sets of the last element

    struct Element {
        int dimension = 0;
        bool isShell = false;
        std::vector<Index> nodes = {};
    };
    std::vector<Element> elements_;
};

}  // namespace espalier::io
