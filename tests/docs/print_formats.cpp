// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/formats.h>

#include <cstdio>
#include <string>
#include <utility>

// Prints the extensions of each content and use, one line each,
// for formats_test.py.

int main() {
    using espalier::io::FileContent, espalier::io::FileUse;
    constexpr std::pair<FileContent, const char*> kContents[] =
        {{FileContent::Lattice, "Lattice"},
         {FileContent::Mesh, "Mesh"},
         {FileContent::Model, "Model"},
         {FileContent::EditorMesh, "EditorMesh"},
         {FileContent::Matrix, "Matrix"},
         {FileContent::Animation, "Animation"},
         {FileContent::BoundModel, "BoundModel"},
         {FileContent::Targets, "Targets"},
         {FileContent::Displacements, "Displacements"}};
    for (const auto& [content, name] : kContents)
        for (const auto& [use, word] :
             {std::pair{FileUse::Read, "read"},
              std::pair{FileUse::Write, "write"}}) {
            std::printf("%s %s:", name, word);
            for (const std::string& extension :
                 espalier::io::extensionsOf(content, use))
                std::printf(" %s", extension.c_str());
            std::printf("\n");
        }
    return 0;
}
