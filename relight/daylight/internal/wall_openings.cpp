#include "relight/daylight/internal/wall_openings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace pleinair::internal {
namespace {

double Cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

constexpr std::array<glm::ivec2, 4> kNeighbours{
    glm::ivec2(1, 0), glm::ivec2(-1, 0), glm::ivec2(0, 1), glm::ivec2(0, -1)};

}  // namespace

WallPlane WallPlane::Through(const glm::dvec3& normal, const glm::dvec3& point_m) {
  WallPlane plane;
  plane.normal = normal;
  plane.offset_m = glm::dot(normal, point_m);
  const glm::dvec3 level = glm::cross(glm::dvec3(0.0, 0.0, 1.0), normal);
  const double length = glm::length(level);
  // A floor or ceiling has no right of its own: east.
  constexpr double kLevel = 1e-3;
  plane.right = length > kLevel ? level / length
                                : glm::normalize(glm::dvec3(1.0, 0.0, 0.0) - normal.x * normal);
  plane.up = glm::cross(normal, plane.right);
  return plane;
}

glm::dvec2 WallPlane::Project(const glm::dvec3& point_m) const {
  return {glm::dot(right, point_m), glm::dot(up, point_m)};
}

glm::dvec3 WallPlane::Lift(const glm::dvec2& in_plane_m) const {
  return in_plane_m.x * right + in_plane_m.y * up + offset_m * normal;
}

WallRaster::WallRaster(const Mesh& mesh,
                       const WallPlane& plane,
                       const glm::dvec2& lower_m,
                       const glm::dvec2& upper_m,
                       double cell_m)
    : plane_(plane), cell_m_(cell_m) {
  const glm::dvec2 extent_m = upper_m - lower_m;
  constexpr double kMostCells = 2048.0;
  cell_m_ = std::max(cell_m, std::max(extent_m.x, extent_m.y) / kMostCells);
  // A ring of cells around, so that what the room's walls bound is bounded inside the raster.
  lower_m_ = lower_m - glm::dvec2(2.0 * cell_m_);
  label_ = Image<std::int32_t>(static_cast<int>(std::ceil(extent_m.x / cell_m_)) + 4,
                               static_cast<int>(std::ceil(extent_m.y / cell_m_)) + 4,
                               0);
  DrawSections(mesh);
  Cover(mesh);
}

void WallRaster::DrawSections(const Mesh& mesh) {
  // Half a cell into the room: there a wall that ends in the plane still crosses.
  const double section_m = plane_.offset_m + 0.5 * cell_m_;
  cv::Mat cells(label_.height, label_.width, CV_32SC1, label_.pixels.data());
  for (const glm::uvec3& triangle : mesh.triangles) {
    std::array<glm::dvec2, 2> ends;
    std::size_t count = 0;
    for (int side = 0; side < 3; ++side) {
      const glm::dvec3 from(mesh.positions_m[triangle[side]]);
      const glm::dvec3 to(mesh.positions_m[triangle[(side + 1) % 3]]);
      const double from_m = glm::dot(plane_.normal, from) - section_m;
      const double to_m = glm::dot(plane_.normal, to) - section_m;
      if (!((from_m < 0.0) != (to_m < 0.0)) || count == 2) continue;
      ends[count++] =
          (plane_.Project(glm::mix(from, to, from_m / (from_m - to_m))) - lower_m_) / cell_m_;
    }
    if (count < 2) continue;
    cv::Point2d from(ends[0].x, ends[0].y);
    cv::Point2d to(ends[1].x, ends[1].y);
    // Far triangles would overflow the raster's integers.
    const auto far = [this](const cv::Point2d& point) {
      const double reach = 16.0 * std::max(label_.width, label_.height);
      return !(std::abs(point.x) < reach && std::abs(point.y) < reach);
    };
    if (far(from) || far(to)) {
      const cv::Point2d middle(0.5 * label_.width, 0.5 * label_.height);
      const cv::Point2d along = (to - from) / cv::norm(to - from);
      const double foot = (middle - from).dot(along);
      const double reach = 2.0 * std::max(label_.width, label_.height);
      const double length = cv::norm(to - from);
      const cv::Point2d start = from;
      from = start + along * std::clamp(foot - reach, 0.0, length);
      to = start + along * std::clamp(foot + reach, 0.0, length);
      if (far(from) || far(to)) continue;
    }
    cv::line(cells,
             cv::Point(static_cast<int>(std::floor(from.x)), static_cast<int>(std::floor(from.y))),
             cv::Point(static_cast<int>(std::floor(to.x)), static_cast<int>(std::floor(to.y))),
             cv::Scalar(kSection));
  }
}

void WallRaster::Cover(const Mesh& mesh) {
  for (const glm::uvec3& triangle : mesh.triangles) {
    std::array<glm::dvec2, 3> corner;
    bool in_plane = true;
    for (int i = 0; i < 3 && in_plane; ++i) {
      const glm::dvec3 position_m(mesh.positions_m[triangle[i]]);
      in_plane = std::abs(glm::dot(plane_.normal, position_m) - plane_.offset_m) <= 0.5 * cell_m_;
      corner[static_cast<std::size_t>(i)] = (plane_.Project(position_m) - lower_m_) / cell_m_;
    }
    if (!in_plane) continue;
    double area = Cross(corner[1] - corner[0], corner[2] - corner[0]);
    if (area < 0.0) std::swap(corner[1], corner[2]);
    if (area == 0.0) continue;
    const glm::dvec2 lower = glm::min(corner[0], glm::min(corner[1], corner[2]));
    const glm::dvec2 upper = glm::max(corner[0], glm::max(corner[1], corner[2]));
    const auto cell = [](double at, int side) {
      return static_cast<int>(std::clamp(std::floor(at), 0.0, static_cast<double>(side - 1)));
    };
    for (int y = cell(lower.y, label_.height); y <= cell(upper.y, label_.height); ++y) {
      for (int x = cell(lower.x, label_.width); x <= cell(upper.x, label_.width); ++x) {
        const glm::dvec2 centre(x + 0.5, y + 0.5);
        bool inside = true;
        for (std::size_t i = 0; i < 3 && inside; ++i) {
          const glm::dvec2& from = corner[i];
          const glm::dvec2 side = corner[(i + 1) % 3] - from;
          // A hundredth of a cell: no crack along edges that two triangles share.
          inside = Cross(side, centre - from) >= -0.01 * glm::length(side);
        }
        if (inside) label_.At(x, y) = kWall;
      }
    }
  }
}

void WallRaster::Follow(const glm::ivec2& from) {
  Opening& opening = openings_.emplace_back();
  const auto number = static_cast<std::int32_t>(openings_.size());
  std::vector<glm::ivec2> front{from};
  label_.At(from.x, from.y) = number;
  while (!front.empty()) {
    const glm::ivec2 at = front.back();
    front.pop_back();
    ++opening.cells;
    for (const glm::ivec2& step : kNeighbours) {
      const glm::ivec2 next = at + step;
      if (!label_.Contains(next.x, next.y)) {
        ++opening.rim;
        continue;
      }
      std::int32_t& label = label_.At(next.x, next.y);
      if (label == 0) {
        label = number;
        front.push_back(next);
      } else if (label != number) {
        ++opening.rim;
        if (label == kWall) ++opening.framed_rim;
      }
    }
  }
}

std::optional<int> WallRaster::OpeningAt(const glm::dvec2& in_plane_m) {
  const glm::dvec2 at = glm::floor((in_plane_m - lower_m_) / cell_m_);
  if (!(at.x >= 0.0 && at.y >= 0.0 && at.x < label_.width && at.y < label_.height)) {
    return std::nullopt;
  }
  const glm::ivec2 cell(at);
  if (label_.At(cell.x, cell.y) == 0) Follow(cell);
  const std::int32_t label = label_.At(cell.x, cell.y);
  if (label < 1) return std::nullopt;
  return label - 1;
}

double WallRaster::AreaM2(int opening) const {
  return static_cast<double>(openings_[static_cast<std::size_t>(opening)].cells) * cell_m_ *
         cell_m_;
}

double WallRaster::FramedShare(int opening) const {
  const Opening& of = openings_[static_cast<std::size_t>(opening)];
  return of.rim == 0 ? 0.0 : static_cast<double>(of.framed_rim) / static_cast<double>(of.rim);
}

std::vector<glm::dvec3> WallRaster::Outline(int opening) const {
  // One cell of margin for the growth.
  cv::Mat1b mask(label_.height + 2, label_.width + 2, std::uint8_t{0});
  for (int y = 0; y < label_.height; ++y) {
    for (int x = 0; x < label_.width; ++x) {
      if (label_.At(x, y) == opening + 1) mask(y + 1, x + 1) = 255;
    }
  }
  cv::dilate(mask, mask, cv::getStructuringElement(cv::MORPH_RECT, {3, 3}));
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(mask, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  const auto largest =
      std::max_element(contours.begin(), contours.end(), [](const auto& a, const auto& b) {
        return cv::contourArea(a) < cv::contourArea(b);
      });
  std::vector<cv::Point> corners;
  cv::approxPolyDP(*largest, corners, 1.0, true);
  std::vector<glm::dvec3> outline;
  outline.reserve(corners.size());
  for (const cv::Point& corner : corners) {
    // The contour runs through cell centres, half a cell inside what was grown by one.
    outline.push_back(plane_.Lift(lower_m_ + cell_m_ * glm::dvec2(corner.x - 0.5, corner.y - 0.5)));
  }
  return outline;
}

}  // namespace pleinair::internal
