// SPDX-License-Identifier: Apache-2.0
#include "openfoam.h"

#include <espalier/base/error.h>
#include <espalier/base/vector3.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <deque>
#include <numeric>
#include <sstream>
#include <system_error>
#include <utility>

#include "../files/bytes.h"
#include "../files/gzip.h"
#include "../files/zip.h"
#include "../format.h"
#include "../lattices/lattice_parts.h"
#include "../models/file_model.h"
#include "../models/held_points.h"
#include "foam_file.h"
#include "foam_mesh.h"
#include "lattice_cells.h"
#include "shared_points.h"

namespace espalier::io {
namespace {

using Path = std::filesystem::path;

constexpr std::string_view kArchive = "PK\x03\x04";

/// A file of points: of one mesh, or a collated one with the points of several processes.
struct PointsFile {
    Path path;                           ///< where it was read
    Path name;                           ///< relative to the folder of the case
    std::string_view stored;             ///< the bytes of the file
    std::string text;                    ///< inflated; empty if the file is not compressed
    std::vector<FoamBlock> blocks = {};  ///< of a collated file

    bool isCompressed() const { return isGzip(stored); }
    std::string_view content() const { return isCompressed() ? text : stored; }
};

/// The points of a mesh, or of one part of a decomposed mesh.
struct PartOfPoints {
    std::size_t file;
    std::string name;  ///< "processor0"; empty for a whole mesh
    std::string_view text;
    FileNumbers numbers;
    std::vector<Index> inModel = {};  ///< the number of each point in the model
};

/// The model of a mesh in one file, or of a decomposed case.
class FoamModel final : public Model {
public:
    FoamModel(const Format& format, const Path& path, std::string bytes)
        : Model(format, path), path_(path), bytes_(std::move(bytes)) {
        isArchive_ = bytes_.starts_with(kArchive);
        if (isArchive_)
            openArchive();
        else
            files_.push_back({path, path.filename(), bytes_, {}});
        for (std::size_t file = 0; file < files_.size(); ++file) readFileOfPoints(file);
        if (!isArchive_)
            if (auto note = noteOnDecomposed(path)) notes_.push_back(*note);
        joinParts();
        held_.emplace(isJoined() ? std::span(positions_)
                                 : std::span(parts_[0].numbers.points.values));
        if (const auto used = held_->findUsed(*this)) refuse(*used);
        if (!held_->empty()) notes_.push_back(held_->note());
        // Points that are not finite have their stand-ins in the parts, too.
        for (std::size_t i = 0; i < parts_.size() && isJoined() && !held_->empty(); ++i)
            for (std::size_t point = 0; point < parts_[i].inModel.size(); ++point)
                if (Point3& own = parts_[i].numbers.points.values[point]; !isFinite(own))
                    own = positions_[parts_[i].inModel[point]];
    }

    std::span<const Point3> positions() const override {
        return isJoined() ? std::span<const Point3>(positions_)
                          : std::span<const Point3>(parts_[0].numbers.points.values);
    }
    std::vector<Index> heldPoints() const override { return held_->numbers(); }
    std::vector<std::string> notes() const override { return notes_; }
    CoordinateStorage storage() const override {
        const auto isFloat = [](const PartOfPoints& part) {
            return part.numbers.storage == CoordinateStorage::Float;
        };
        return std::ranges::any_of(parts_, isFloat) ? CoordinateStorage::Float
                                                    : parts_[0].numbers.storage;
    }
    DirectionCounts directions() const override { return {}; }

    ModelSurface readSurface() const override {
        ModelSurface surface;
        surface.faces = boundaryFaces(readCells().volume);
        return surface;
    }

    ModelCells readCells() const override {
        const auto pointCount = static_cast<Index>(positions().size());
        ModelCells cells;
        cells.isOpenFoam = true;
        if (!isJoined() || parts_[0].name.empty()) {
            const auto folder = facesFolder(files_[parts_[0].file].path);
            static_cast<far::SimulationMesh&>(cells) = readFoamMesh(folder, pointCount);
            return cells;
        }
        std::vector<FoamParts> folders;
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            if (i == 0 || parts_[i].file != parts_[i - 1].file) {
                const auto folder = facesFolder(files_[parts_[i].file].path);
                if (!folder) return cells;  // of a binding
                folders.push_back({*folder, {}, {}});
            }
            folders.back().names.push_back(parts_[i].name);
            folders.back().pointNumbers.emplace_back(parts_[i].inModel);
        }
        static_cast<far::SimulationMesh&>(cells) =
            readFoamParts(folders, pointCount, cells.facesApart);
        return cells;
    }

    std::vector<PointGroup> groups() const override { return groupsOf(readCells().patches); }

private:
    /// Returns true if the model has points of several parts.
    bool isJoined() const { return parts_.size() > 1; }

    void openArchive() {
        const FoamCase found = foamCaseOf(path_);
        // An archive of bytes that are no case on disk: messages name it, too.
        const Path root = found.isDecomposed ? found.root : path_;
        decodeFile(path_, [&] {
            const ZipReader zip(bytes_);
            std::vector<std::pair<std::uint64_t, Path>> names;
            for (const std::string& name : zip.names()) {
                const auto part = partOf(name);
                names.emplace_back(part ? 1 + processesOf(*part)->first : 0, name);
            }
            std::ranges::sort(names);
            for (const auto& [order, name] : names) {
                std::string& room = rooms_.emplace_back();
                files_.push_back({root / name, name, zip.read(name.string(), room), {}});
            }
        });
        if (files_.empty()) throw FileError(path_, "is an archive without files");
    }

    /// Reads the parts of a file.
    void readFileOfPoints(std::size_t number) {
        PointsFile& file = files_[number];
        if (file.isCompressed()) file.text = inflatedFoam(file.path, std::string(file.stored));
        const std::string_view content = file.content();
        FoamFile whole(file.path, content);
        if (whole.isCollated()) file.blocks = whole.blocks();
        const auto folder = isArchive_ ? partOf(file.name) : std::nullopt;
        const auto processes = folder ? processesOf(*folder) : std::nullopt;
        std::size_t count = 0;
        forEachFoamPart(file.path, content, [&](FoamFile& text) {
            PartOfPoints part{number, {}, content, text.points()};
            if (whole.isCollated()) {
                const FoamBlock& block = file.blocks[count];
                part.text = content.substr(block.begin, block.end - block.begin);
            }
            if (whole.isCollated() || folder)
                part.name = concat("processor", (processes ? processes->first : 0) + count);
            checkedIndex(file.path, part.numbers.points.values.size(), "points");
            parts_.push_back(std::move(part));
            ++count;
        });
        if (processes && count != processes->count)
            throw FileError(file.path,
                            concat("has the points of ", count, " processes; its folder ", "is of ",
                                   processes->count));
    }

    /// Finds the points that parts share, and the positions of all.
    void joinParts() {
        if (!isJoined()) return;
        const auto find = [&] {
            std::vector<std::span<const Point3>> points;
            for (const PartOfPoints& part : parts_) points.emplace_back(part.numbers.points.values);
            return decodeFile(path_, [&] { return findSharedPoints(points); });
        };
        SharedPoints shared = find();
        const auto wholeCount = static_cast<Index>(parts_[0].numbers.points.values.size());
        if (parts_[0].name.empty() && shared.count != wholeCount) {
            notes_.push_back(concat("has a whole mesh in ", files_[0].name.parent_path().string(),
                                    ", which stays, because ", shared.count - wholeCount,
                                    " points of the parts are not among its points; name this "
                                    "folder to move it"));
            parts_.erase(parts_.begin());
            shared = find();
        }
        positions_.resize(shared.count);
        std::vector<bool> isKnown(shared.count);
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            PartOfPoints& part = parts_[i];
            part.inModel = std::move(shared.numbers[i]);
            for (std::size_t point = 0; point < part.inModel.size(); ++point) {
                const Index number = part.inModel[point];
                if (!isKnown[number]) positions_[number] = part.numbers.points.values[point];
                isKnown[number] = true;
            }
        }
    }

    /// Throws the error of a point that is not finite.
    [[noreturn]] void refuse(Index point) {
        const auto refuseIn = [&](const PartOfPoints& part, std::size_t own) {
            refuseNotFinitePoint({files_[part.file].path, part.text, part.numbers}, own);
        };
        if (!isJoined()) {
            held_->restore(parts_[0].numbers.points.values);
            refuseIn(parts_[0], static_cast<std::size_t>(point));
        }
        for (const PartOfPoints& part : parts_)
            if (const auto own = std::ranges::find(part.inModel, point); own != part.inModel.end())
                refuseIn(part, static_cast<std::size_t>(own - part.inModel.begin()));
        throw FileError(path_, concat("point ", point, " is not finite"));
    }

    /// Returns the files that this model writes for a folder of a decomposed case.
    /// \throws FileError unless it has the same parts
    std::vector<Path> targetsIn(const Path& folder) const {
        const FoamCase target = foamTargetOf(folder);
        std::vector<std::optional<std::string>> own, theirs;
        for (const PointsFile& file : files_) own.push_back(partOf(file.name));
        for (const Path& file : target.files) theirs.push_back(partOf(file));
        if (!target.isDecomposed || own != theirs)
            throw FileError(folder, concat("is no copy of the decomposed case, with the same ",
                                           "processor folders; write into a copy (cp -r CASE "
                                           "COPY)"));
        std::vector<Path> paths;
        for (const Path& file : target.files) paths.push_back(target.root / file);
        return paths;
    }

    /// Throws unless a file "points" belongs to the same mesh as one of our files, or to none.
    void checkMesh(const PointsFile& file, const Path& target) const {
        const auto refuse = [&](const std::string& cause) {
            throw FileError(target, "belongs to another mesh, " + cause +
                                        "; write into a copy of the case (cp -r CASE COPY)");
        };
        const auto theirs = facesFolder(target);
        if (!theirs) return;
        if (const auto ours = facesFolder(file.path)) {
            if (!haveSameFoamCells(*ours, *theirs))
                refuse("whose faces, owner and neighbour are not those of " + shownPath(file.path));
            return;
        }
        // The points of a binding come without their faces.
        std::error_code ignored;
        if (!std::filesystem::is_regular_file(target, ignored)) return;
        const std::string text = inflatedFoam(target, readFile(target));
        std::vector<std::size_t> counts, own;
        forEachFoamPart(target, text, [&](FoamFile& other) {
            counts.push_back(other.points().points.values.size());
        });
        const auto number = static_cast<std::size_t>(&file - files_.data());
        for (const PartOfPoints& part : parts_)
            if (part.file == number) own.push_back(part.numbers.points.values.size());
        if (counts != own)
            refuse(concat("which has ", std::reduce(counts.begin(), counts.end()), " points",
                          counts.size() > 1 ? concat(" in ", counts.size(), " processes") : "",
                          ", and not ", std::reduce(own.begin(), own.end())));
    }

    void checkOwnTarget(const Path& target) const override {
        if (isArchive_) {
            std::error_code ignored;
            if (const auto status = std::filesystem::status(target, ignored);
                std::filesystem::exists(status) && !std::filesystem::is_directory(status))
                throw FileError(target, concat("cannot hold the ", files_.size(),
                                               " files of a decomposed case; write into a copy of "
                                               "the case (cp -r CASE COPY)"));
            const auto targets = targetsIn(target);
            for (std::size_t i = 0; i < targets.size(); ++i)
                if (isMoved(i)) checkMesh(files_[i], targets[i]);
            return;
        }
        std::error_code ignored;
        const auto status = std::filesystem::status(target, ignored);
        if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status) &&
            !std::filesystem::is_directory(status))
            return;
        if (foamTargetOf(target).isDecomposed)
            throw FileError(target,
                            "is a decomposed case, but the model has the points of one mesh "
                            "alone; name a file 'points' in this case");
        // A new name without an extension may be meant as the folder of a case.
        if (target.filename() != kFoamPoints && !isCompressedName(target))
            throw FileError(
                target,
                "the points of an OpenFOAM mesh are written to a file of the name 'points', "
                "or into a folder with a copy of the case (cp -r CASE COPY)");
        checkMesh(files_[0], target);
    }

    static bool isCompressedName(const Path& path) {
        return path.filename() == concat(kFoamPoints, ".gz");
    }

    /// Returns true if the points of a file belong to the model.
    bool isMoved(std::size_t file) const {
        return std::ranges::find(parts_, file, &PartOfPoints::file) != parts_.end();
    }

    void writeChecked(const Path& path, std::span<const Point3> moved,
                      std::span<const DeformationGradient>) const override {
        const std::vector<Point3> held =
            held_->empty() ? std::vector<Point3>() : held_->held(moved);
        const auto now = held_->empty() ? moved : std::span<const Point3>(held);
        const auto targets = isArchive_ ? targetsIn(path) : std::vector<Path>{path};
        std::vector<FileToWrite> files;
        for (std::size_t i = 0; i < files_.size(); ++i)
            if (isMoved(i))
                files.push_back(
                    {targets[i], [this, i, now, target = targets[i]](std::ostream& out) {
                         write(out, files_[i], now, target);
                     }});
        writeFiles(files);
    }

    /// Writes a file: compressed if its name says so, or as the file of the same name that was
    /// read. Another name than "points" or "points.gz" is that of a device.
    void write(std::ostream& out, const PointsFile& file, std::span<const Point3> now,
               const Path& target) const {
        const Path name = target.filename();
        const bool isOwnForm =
            name == file.name.filename() || (name != kFoamPoints && !isCompressedName(target));
        const bool compresses = isOwnForm ? file.isCompressed() : isCompressedName(target);
        const auto number = static_cast<std::size_t>(&file - files_.data());
        const auto positionsAtRest = positions();
        bool isAtRest = true;
        for (const PartOfPoints& part : parts_)
            for (std::size_t point = 0;
                 part.file == number && isAtRest && point < part.numbers.points.values.size();
                 ++point) {
                const std::size_t inModel = numberInModel(part, point);
                isAtRest = now[inModel] == positionsAtRest[inModel];
            }
        if (isAtRest && compresses == file.isCompressed()) {
            out << file.stored;
            return;
        }
        if (!compresses) {
            writeText(out, file, now);
            return;
        }
        std::ostringstream text;
        writeText(text, file, now);
        out << gzip(std::move(text).str());
    }

    std::size_t numberInModel(const PartOfPoints& part, std::size_t point) const {
        return isJoined() ? static_cast<std::size_t>(part.inModel[point]) : point;
    }

    void writeText(std::ostream& out, const PointsFile& file, std::span<const Point3> now) const {
        const auto number = static_cast<std::size_t>(&file - files_.data());
        const std::string_view content = file.content();
        std::size_t written = 0;
        auto block = file.blocks.begin();
        for (const PartOfPoints& part : parts_) {
            if (part.file != number) continue;
            if (file.blocks.empty()) {
                writePart(out, file, part, now);
                return;
            }
            std::ostringstream stream;
            writePart(stream, file, part, now);
            const std::string text = std::move(stream).str();
            out << content.substr(written, block->sizeBegin - written) << text.size()
                << content.substr(block->sizeEnd, block->begin - block->sizeEnd) << text;
            written = block->end;
            ++block;
        }
        out << content.substr(written);
    }

    void writePart(std::ostream& out, const PointsFile& file, const PartOfPoints& part,
                   std::span<const Point3> now) const {
        const FileView view{file.path, part.text, part.numbers};
        if (!isJoined()) {
            writeNumbers(out, view, now, {});
            return;
        }
        // A point that stays keeps its text, also where two parts differ in the sign of a zero.
        const auto& own = part.numbers.points.values;
        std::vector<Point3> moved(own.begin(), own.end());
        for (std::size_t point = 0; point < moved.size(); ++point)
            if (const Index inModel = part.inModel[point]; now[inModel] != positions_[inModel])
                moved[point] = now[inModel];
        writeNumbers(out, view, moved, {});
    }

    Path path_;
    std::string bytes_;
    bool isArchive_ = false;         ///< a decomposed case
    std::deque<std::string> rooms_;  ///< inflated members of the archive
    std::vector<PointsFile> files_;
    std::vector<PartOfPoints> parts_;
    std::vector<Point3> positions_;  ///< of the model, if it has several parts
    std::vector<std::string> notes_;
    std::optional<HeldPoints> held_;
};

std::unique_ptr<Model> readFoamModel(const Format& format, const Path& path, std::string bytes) {
    return std::make_unique<FoamModel>(format, path, std::move(bytes));
}

Lattice readFoamLattice(const Path& path, std::string_view bytes, ReadNotes* notes) {
    const auto model = readFoamModel(kFoamFormat, path, std::string(bytes));
    const far::VolumeMesh mesh = model->readCells().volume;
    if (mesh.pointCount() == 0)
        throw FileError(path,
                        "has no file 'faces' beside it, nor in constant/polyMesh of its case; a "
                        "lattice needs the files faces, owner and neighbour");
    LatticeCells cells(path, mesh.pointCount());
    visitVolume(mesh, cells);
    Lattice parts;
    parts.positions.assign(model->positions().begin(), model->positions().end());
    return finishLattice(path, cells.takeBuilder(), std::move(parts), notes);
}

}  // namespace

std::string archiveOf(const FoamCase& files) {
    std::ostringstream stream;
    ZipWriter zip(stream);
    for (const Path& file : files.files) {
        const std::string bytes = readFile(files.root / file);
        zip.add(file.generic_string(), [&](ByteOutput& out) { out.bytes(bytes); });
    }
    zip.finish();
    return std::move(stream).str();
}

const Format kFoamFormat = {.extensions = {kFoamPoints},
                            .words = "an OpenFOAM case",
                            .isMesh = true,
                            .isPath = isFoamPath,
                            .readModel = readFoamModel,
                            .readLattice = readFoamLattice};

}  // namespace espalier::io
