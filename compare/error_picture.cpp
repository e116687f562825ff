// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/vector3.h>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "error_picture.h"
#include "report_text.h"

namespace espalier::compare {
namespace {

constexpr int kMinExponent = -18;
constexpr int kMaxExponent = -6;

// The anchors are at equal distances on the scale. The CIE lightness decreases in about equal
// steps: 93, 83, 70, 56 and 42 within the bound, then 42, 33 and 23. Neighbouring anchors are 19 to
// 27 apart in L*a*b*; the anchors at the two sides of the bound are 90 apart.
constexpr std::array<Colour, 5> kWithin = {
    {{233, 239, 197}, {169, 218, 188}, {98, 184, 196}, {58, 143, 192}, {44, 100, 168}}};
constexpr std::array<Colour, 3> kAbove = {{{178, 60, 40}, {149, 30, 55}, {107, 13, 63}}};

/// \param t 0 to 1
Colour interpolated(std::span<const Colour> anchors, double t) {
    const double at = t * static_cast<double>(anchors.size() - 1);
    const std::size_t before = std::min(static_cast<std::size_t>(at), anchors.size() - 2);
    Colour colour{};
    for (std::size_t k = 0; k < 3; ++k)
        colour[k] = static_cast<int>(std::lround(std::lerp(
            anchors[before][k], anchors[before + 1][k], at - static_cast<double>(before))));
    return colour;
}

}  // namespace

std::string hexText(const Colour& colour) {
    return fmt::format("#{:02x}{:02x}{:02x}", colour[0], colour[1], colour[2]);
}

Colour shaded(const Colour& colour, double shade) {
    Colour darker{};
    for (std::size_t k = 0; k < 3; ++k)
        darker[k] = static_cast<int>(std::lround(colour[k] * std::clamp(shade, 0.0, 1.0)));
    return darker;
}

ErrorScale::ErrorScale(double bound)
    : logBound_(std::clamp(bound > 0 ? std::log10(bound) : kMinExponent, kMinExponent + 1.0,
                           kMaxExponent - 1.0)) {}

double ErrorScale::place(double error) const {
    const double size = std::abs(error);
    if (!(size < kMax)) return 1;
    if (size <= kMin) return 0;
    const double log = std::log10(size);
    // The parentheses make the result at the bound kBoundPlace, to the last bit.
    if (log <= logBound_) return kBoundPlace * ((log - kMinExponent) / (logBound_ - kMinExponent));
    return kBoundPlace + (1 - kBoundPlace) * (log - logBound_) / (kMaxExponent - logBound_);
}

Colour ErrorScale::colour(double error) const {
    return error == 0 ? kExact : colourAt(place(error));
}

Colour ErrorScale::colourAt(double at) const {
    if (at <= kBoundPlace) return interpolated(kWithin, at / kBoundPlace);
    return interpolated(kAbove, (at - kBoundPlace) / (1 - kBoundPlace));
}

std::vector<ErrorScale::Tick> ErrorScale::ticks(double spacing) const {
    std::vector<Tick> ticks;
    double lastLabel = 0;
    for (int exponent = kMinExponent; exponent <= kMaxExponent; ++exponent) {
        // Compute the place from the text of the number, as for errors that are read from a text.
        const std::string label = fmt::format("1e{}", exponent);
        const double at = place(std::stod(label));
        const bool isEnd = exponent == kMinExponent || exponent == kMaxExponent;
        const bool fits = at - lastLabel >= spacing && 1 - at >= spacing;
        ticks.push_back({at, isEnd || fits ? label : ""});
        if (!ticks.back().label.empty()) lastLabel = at;
    }
    return ticks;
}

namespace {

using Eigen::Vector3d;

/// Returns the faces whose corners are all finite.
std::vector<SeenFace> drawableFaces(const SurfaceError& surface) {
    const auto count = static_cast<Index>(surface.positions.size());
    std::vector<SeenFace> faces;
    faces.reserve(surface.faces.size());
    for (std::size_t f = 0; f < surface.faces.size(); ++f) {
        bool isDrawable = true;
        for (const Index corner : surface.faces[f]) {
            if (corner < 0 || corner >= count)
                throw Error(
                    fmt::format("picture: face {} names position {} of {}", f, corner, count));
            isDrawable = isDrawable && isFinite(surface.positions[corner]);
        }
        if (isDrawable) faces.push_back({static_cast<Index>(f), 0, 0});
    }
    return faces;
}

/// A transformation of positions into a box near the origin, with sides of at most 1.
struct UnitBoxTransformation {
    Vector3d centre;
    double scale = 1;  ///< divides before `centre` is subtracted: coordinates near the limits of
                       ///< double have differences that overflow
    Vector3d extent;

    UnitBoxTransformation(const SurfaceError& surface, const std::vector<SeenFace>& faces) {
        scale = 0;
        for (const SeenFace& seen : faces)
            for (const Index corner : surface.faces[seen.face])
                for (const double x : surface.positions[corner])
                    scale = std::max(scale, std::abs(x));
        if (scale == 0) scale = 1;
        Vector3d min = Vector3d::Constant(1);
        Vector3d max = Vector3d::Constant(-1);
        for (const SeenFace& seen : faces)
            for (const Index corner : surface.faces[seen.face]) {
                const Vector3d p = divided(surface.positions[corner]);
                min = min.cwiseMin(p);
                max = max.cwiseMax(p);
            }
        centre = (min + max) / 2;
        extent = max - min;
    }

    Vector3d divided(const Point3& p) const { return Vector3d(p.data()) / scale; }
    Vector3d operator()(const Point3& p) const { return divided(p) - centre; }
};

/// Axes of the picture, in space.
struct PictureFrame {
    Vector3d right;
    Vector3d up;
    Vector3d towards;  ///< towards the viewer
};

/// Chooses the axes as viewOf() describes.
PictureFrame frameOf(const Vector3d& extent) {
    // If extents are equal, z counts as the shortest: it is then up.
    std::array<int, 3> byExtent = {2, 1, 0};
    std::stable_sort(byExtent.begin(), byExtent.end(),
                     [&](int a, int b) { return extent[a] < extent[b]; });
    // The flatness is 0 if the shape is as thick as it is wide, and 1 if it has no thickness.
    const double flatness =
        1 - (extent[byExtent[1]] > 0 ? extent[byExtent[0]] / extent[byExtent[1]] : 1);
    const bool isFlat = flatness > 0.4;
    const bool isTallInY = byExtent[2] == 1 && extent[1] > 1.2 * extent[byExtent[1]];
    const int upAxis = isFlat ? byExtent[0] : isTallInY ? 1 : 2;
    const int across = byExtent[2] != upAxis ? byExtent[2] : byExtent[1];

    // View from 30 degrees right of the front, and from 28 degrees above for a cube to 58 degrees
    // above for a sheet of paper.
    constexpr double kDegree = std::numbers::pi / 180;
    const double azimuth = 30 * kDegree;
    const double elevation = (28 + (isFlat ? 30 * flatness : 0)) * kDegree;
    const Vector3d vertical = Vector3d::Unit(upAxis);
    const Vector3d side = Vector3d::Unit(across);
    const Vector3d front = side.cross(vertical);
    const Vector3d ground = std::sin(azimuth) * side + std::cos(azimuth) * front;
    PictureFrame frame;
    frame.towards = std::cos(elevation) * ground + std::sin(elevation) * vertical;
    frame.right = vertical.cross(frame.towards).normalized();
    frame.up = frame.towards.cross(frame.right);
    return frame;
}

/// Returns how much a face turns towards a light over the viewer's left shoulder.
double lightOn(const std::array<Vector3d, 4>& corners) {
    // The axes of the picture are: right, up, towards the viewer.
    const Vector3d light = Vector3d(-0.45, 0.7, 0.75).normalized();
    Vector3d normal = (corners[2] - corners[0]).cross(corners[3] - corners[1]);
    if (normal.z() < 0) normal = -normal;
    const double length = normal.norm();
    if (!(length > 0)) return 1;  // a face without area shows its outline only
    return std::max(0.0, normal.dot(light) / length);
}

/// Even-odd rule: true if the outline of a face goes around a point an odd number of times.
bool isInside(const std::array<std::array<double, 2>, 4>& loop, const std::array<double, 2>& p) {
    bool inside = false;
    for (std::size_t i = 0; i < 4; ++i) {
        const auto& a = loop[i];
        const auto& b = loop[(i + 1) % 4];
        if ((a[1] > p[1]) == (b[1] > p[1])) continue;
        if (p[0] < a[0] + (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1])) inside = !inside;
    }
    return inside;
}

}  // namespace

SurfaceView viewOf(const SurfaceError& surface) {
    SurfaceView view;
    view.faces = drawableFaces(surface);
    view.points.resize(surface.positions.size());
    view.depths.resize(surface.positions.size());
    if (view.faces.empty()) return view;

    const UnitBoxTransformation normalised(surface, view.faces);
    const PictureFrame frame = frameOf(normalised.extent);
    std::vector<Vector3d> seen;  // right, up, towards the viewer
    seen.reserve(surface.positions.size());
    for (const Point3& position : surface.positions) {
        const Vector3d p = normalised(position);
        seen.emplace_back(p.dot(frame.right), p.dot(frame.up), p.dot(frame.towards));
        view.points[seen.size() - 1] = {seen.back().x(), -seen.back().y()};
        view.depths[seen.size() - 1] = seen.back().z();
    }

    view.min = view.max = view.points[surface.faces[view.faces[0].face][0]];
    for (SeenFace& face : view.faces) {
        std::array<Vector3d, 4> corners;
        for (std::size_t i = 0; i < 4; ++i) {
            const std::size_t corner = surface.faces[face.face][i];
            corners[i] = seen[corner];
            face.depth += view.depths[corner] / 4;
            for (std::size_t k = 0; k < 2; ++k) {
                view.min[k] = std::min(view.min[k], view.points[corner][k]);
                view.max[k] = std::max(view.max[k], view.points[corner][k]);
            }
        }
        face.light = lightOn(corners);
    }
    std::stable_sort(view.faces.begin(), view.faces.end(),
                     [](const SeenFace& a, const SeenFace& b) { return a.depth < b.depth; });
    return view;
}

Sight sightOf(const SurfaceError& surface, const SurfaceView& view, Index vertex) {
    Sight sight = Sight::Absent;
    bool isBehind = false;
    for (const SeenFace& seen : view.faces) {
        const std::array<Index, 4>& face = surface.faces[seen.face];
        if (std::find(face.begin(), face.end(), vertex) != face.end()) {
            sight = Sight::Visible;
            continue;
        }
        if (isBehind || seen.depth <= view.depths[vertex]) continue;
        std::array<std::array<double, 2>, 4> loop{};
        for (std::size_t i = 0; i < 4; ++i) loop[i] = view.points[face[i]];
        isBehind = isInside(loop, view.points[vertex]);
    }
    return sight == Sight::Visible && isBehind ? Sight::Hidden : sight;
}

namespace {

// Lengths in px of the picture; the surface is above the legend.
constexpr int kWidth = 640;
constexpr int kHeight = 500;
constexpr int kMargin = 16;
constexpr int kSurfaceHeight = 418;
constexpr int kLineHeight = 18;
constexpr int kBarTop = 444;
constexpr int kBarHeight = 14;
constexpr int kBarLeft = 96;
constexpr int kBarWidth = 510;
constexpr int kExactLeft = 30;
constexpr int kExactWidth = 36;

/// Coordinates of the surface are integers in units of 1/kUnits px, which are shorter than
/// decimals.
constexpr int kUnits = 10;

/// The brightness of a face edge-on to the light; a face towards the light has 1.
constexpr double kAmbient = 0.6;

std::string svg(int height, const std::string& label, const std::string& content) {
    return fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" role=\"img\" "
        "aria-label=\"{}\" font-family=\"system-ui,sans-serif\" font-size=\"13\" "
        "fill=\"currentColor\">\n{}</svg>\n",
        kWidth, height, label, content);
}

std::string text(double x, double y, const std::string& anchor, const std::string& words) {
    return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y,
                       anchor, words);
}

/// Maps the plane of a view to the picture.
class Placement {
public:
    /// \param top upper end of the room for the surface, in px
    Placement(const SurfaceView& view, int top) : middle_((top + kSurfaceHeight) / 2.0) {
        for (std::size_t k = 0; k < 2; ++k) {
            const double extent = view.max[k] - view.min[k];
            const double room = (k == 0 ? kWidth : kSurfaceHeight - top) - 2 * kMargin;
            if (extent > 0) scale_ = std::min(scale_, room / extent);
            from_[k] = (view.min[k] + view.max[k]) / 2;
        }
        if (!std::isfinite(scale_)) scale_ = 1;
    }

    /// Returns a point in units of 1/kUnits px.
    std::array<long, 2> operator()(const std::array<double, 2>& point) const {
        return {std::lround(((point[0] - from_[0]) * scale_ + kWidth / 2.0) * kUnits),
                std::lround(((point[1] - from_[1]) * scale_ + middle_) * kUnits)};
    }

private:
    double middle_;
    double scale_ = std::numeric_limits<double>::infinity();
    std::array<double, 2> from_ = {};
};

/// Appends "3-4": two numbers of a path, separated by a space or the sign of the second.
void appendPair(std::string& path, const std::array<long, 2>& pair) {
    fmt::format_to(std::back_inserter(path), "{}{}{}", pair[0], pair[1] < 0 ? "" : " ", pair[1]);
}

/// Draws the faces. Strokes in each face's own colour close the hairlines between neighbours.
std::string drawnFaces(const SurfaceError& surface, const SurfaceView& view,
                       const Placement& placement, const ErrorScale& scale) {
    std::string group = fmt::format(
        "<g class=\"surface\" transform=\"scale({})\" fill=\"currentColor\" "
        "stroke=\"currentColor\" stroke-width=\"{}\" stroke-linejoin=\"round\">\n",
        1.0 / kUnits, 0.7 * kUnits);
    for (const SeenFace& seen : view.faces) {
        const std::array<Index, 4>& face = surface.faces[seen.face];
        double error = 0;
        for (const Index corner : face) {
            const double e = std::abs(surface.errors[corner]);
            // NaN counts as the largest.
            if (!(e <= error) && !std::isnan(error)) error = e;
        }
        const Colour colour = shaded(scale.colour(error), std::lerp(kAmbient, 1.0, seen.light));
        fmt::format_to(std::back_inserter(group), "<path color=\"{}\" d=\"M", hexText(colour));
        std::array<long, 2> last{};
        for (std::size_t i = 0; i < 4; ++i) {
            const auto point = placement(view.points[face[i]]);
            if (i == 1) group += 'l';
            if (i > 1 && point[0] >= last[0]) group += ' ';
            appendPair(group, {point[0] - last[0], point[1] - last[1]});
            last = point;
        }
        group += "z\"/>\n";
    }
    group += "</g>\n";
    return group;
}

/// Two strokes, a dark one on a light one, so that the ring is visible on every colour.
std::string ring(const std::array<long, 2>& centre, bool isHidden) {
    const std::string circle = fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"9\" fill=\"none\"{}",
        static_cast<double>(centre[0]) / kUnits, static_cast<double>(centre[1]) / kUnits,
        isHidden ? " stroke-dasharray=\"4.04 3.03\"" : "");
    return circle + " stroke=\"#fff\" stroke-width=\"4.5\"/>\n" + circle +
           " stroke=\"#111\" stroke-width=\"2\"/>\n";
}

std::string legend(const ErrorScale& scale, double bound, double largest) {
    constexpr int kSteps = 102;
    constexpr double kBarBottom = kBarTop + kBarHeight;
    std::string content = "<g class=\"legend\">\n";
    const auto block = [&](double x, double width, const Colour& colour) {
        content +=
            fmt::format("<rect x=\"{:g}\" y=\"{}\" width=\"{:g}\" height=\"{}\" fill=\"{}\"/>\n", x,
                        kBarTop, width, kBarHeight, hexText(colour));
    };
    block(kExactLeft, kExactWidth, ErrorScale::kExact);
    content += text(kExactLeft + kExactWidth / 2.0, kBarBottom + 18, "middle", "0");
    constexpr double kStep = static_cast<double>(kBarWidth) / kSteps;
    // Each step is drawn up to the end of the bar, and the next step covers a part of it, so that
    // there are no gaps between steps.
    for (int i = 0; i < kSteps; ++i)
        block(kBarLeft + i * kStep, kBarWidth - i * kStep, scale.colourAt((i + 0.5) / kSteps));
    for (const ErrorScale::Tick& tick : scale.ticks(0.085)) {
        const double x = kBarLeft + tick.place * kBarWidth;
        content += fmt::format("<path d=\"M{:.1f} {}v{}\" stroke=\"currentColor\"/>\n", x,
                               kBarBottom, tick.label.empty() ? 3 : 5);
        if (tick.label.empty()) continue;
        const char* sign = tick.place == 0 ? "≤ " : tick.place == 1 ? "≥ " : "";
        content += text(x, kBarBottom + 18, "middle", sign + tick.label);
    }
    if (scale.place(bound) == ErrorScale::kBoundPlace) {
        const double x = kBarLeft + ErrorScale::kBoundPlace * kBarWidth;
        content +=
            fmt::format("<path d=\"M{:.1f} {}v{}\" stroke=\"currentColor\" stroke-width=\"2\"/>\n",
                        x, kBarTop - 6, kBarHeight + 6);
        content += text(x, kBarTop - 11, "middle", "bound");
    }
    const double at =
        largest == 0 ? kExactLeft + kExactWidth / 2.0 : kBarLeft + scale.place(largest) * kBarWidth;
    content +=
        fmt::format("<path class=\"largest\" d=\"M{:.1f} {}l-5-9h10z\"/>\n", at, kBarTop - 1);
    content +=
        text(kWidth / 2.0, kHeight - 6, "middle", "error, as a fraction of the size of the shape");
    content += "</g>\n";
    return content;
}

/// Returns a line of text for each irregularity of a surface.
std::vector<std::string> remarks(const SurfaceError& surface, const SurfaceView& view) {
    std::vector<std::string> lines;
    const std::size_t left = surface.faces.size() - view.faces.size();
    if (left > 0)
        lines.push_back(fmt::format("{} not drawn: a position is not finite.",
                                    counted(left, "face is", "faces are")));
    const std::size_t bad = std::count_if(surface.errors.begin(), surface.errors.end(),
                                          [](double e) { return !std::isfinite(e); });
    if (bad > 0)
        lines.push_back(fmt::format("{} not finite.", counted(bad, "error is", "errors are")));
    return lines;
}

}  // namespace

std::optional<Index> largestErrorVertex(const SurfaceError& surface) {
    std::optional<Index> vertex;
    double largest = 0;
    for (std::size_t i = 0; i < surface.errors.size(); ++i) {
        const double error = std::abs(surface.errors[i]);
        if (error <= largest) continue;
        vertex = static_cast<Index>(i);
        largest = error;
        if (std::isnan(error)) break;
    }
    return vertex;
}

std::string errorPicture(const SurfaceError& surface, const Bounds& bounds) {
    if (surface.errors.size() != surface.positions.size())
        throw Error(fmt::format("picture: {} errors for {} positions", surface.errors.size(),
                                surface.positions.size()));
    const SurfaceView view = viewOf(surface);
    const auto nothing = [](const std::string& why) {
        const std::string words = fmt::format("No picture: {}.", why);
        return svg(80, words, text(kWidth / 2.0, 45, "middle", words));
    };
    if (surface.faces.empty()) return nothing("the surface has no faces");
    if (view.faces.empty()) return nothing("every face has a position that is not finite");
    if (!(std::max(view.max[0] - view.min[0], view.max[1] - view.min[1]) > 0))
        return nothing("all positions are the same");

    const std::vector<std::string> lines = remarks(surface, view);
    const Placement placement(view, kLineHeight * static_cast<int>(lines.size()));
    const ErrorScale scale(bounds.position);
    const std::optional<Index> worst = largestErrorVertex(surface);
    const double largest = worst ? surface.errors[*worst] : 0;
    std::string content = drawnFaces(surface, view, placement, scale);
    const Sight sight = worst ? sightOf(surface, view, *worst) : Sight::Absent;
    if (sight != Sight::Absent)
        content += ring(placement(view.points[*worst]), sight == Sight::Hidden);
    content += legend(scale, bounds.position, largest);
    for (std::size_t i = 0; i < lines.size(); ++i)
        content += text(kMargin, 20 + kLineHeight * static_cast<double>(i), "start", lines[i]);
    return svg(kHeight,
               fmt::format("The surface at level {}, coloured by error: {}, the largest error {}.",
                           surface.level, counted(surface.faces.size(), "face", "faces"),
                           scientific(largest)),
               content);
}

}  // namespace espalier::compare
