#include "scene/lat_long.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace pleinair {
namespace {

constexpr double kPi = std::numbers::pi;

std::string Text(LatLongSize size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

void RequireUsable(LatLongSize size) {
  if (size.width < 1 || size.height < 1) {
    throw std::invalid_argument("lat-long size " + Text(size) + ": sides must be at least 1");
  }
}

LatLongSize SizeOf(const RgbImage& image) { return {image.width, image.height}; }

// One row read between its pixel centres; `u_centre` counts from the centre of pixel 0 and wraps.
glm::dvec3 SampleRow(const RgbImage& image, int y, double u_centre) {
  const double left = std::floor(u_centre);
  const double share = u_centre - left;
  const auto wrap = [&](double x) {
    const int column = static_cast<int>(std::fmod(x, image.width));
    return column < 0 ? column + image.width : column;
  };
  return (1.0 - share) * glm::dvec3(image.At(wrap(left), y)) +
         share * glm::dvec3(image.At(wrap(left + 1.0), y));
}

}  // namespace

glm::dvec3 DirectionFromLatLong(glm::dvec2 uv_px, LatLongSize size) {
  RequireUsable(size);
  const double azimuth = (uv_px.x / size.width - 0.5) * 2.0 * kPi;
  const double elevation = (0.5 - uv_px.y / size.height) * kPi;
  const double horizontal = std::cos(elevation);
  return {horizontal * std::sin(azimuth), horizontal * std::cos(azimuth), std::sin(elevation)};
}

glm::dvec2 LatLongFromDirection(const glm::dvec3& direction_enu, LatLongSize size) {
  RequireUsable(size);
  const double horizontal = std::hypot(direction_enu.x, direction_enu.y);
  if (!std::isfinite(horizontal) || !std::isfinite(direction_enu.z) ||
      (horizontal == 0.0 && direction_enu.z == 0.0)) {
    throw std::invalid_argument("lat-long direction (" + std::to_string(direction_enu.x) + ", " +
                                std::to_string(direction_enu.y) + ", " +
                                std::to_string(direction_enu.z) + "): must be finite and not zero");
  }
  // atan2(0, 0) is 0: the poles lie on the centre column.
  const double azimuth = horizontal == 0.0 ? 0.0 : std::atan2(direction_enu.x, direction_enu.y);
  const double elevation = std::atan2(direction_enu.z, horizontal);
  double u = (azimuth / (2.0 * kPi) + 0.5) * size.width;
  if (u >= size.width) u = 0.0;  // Due south from the east side.
  const double v = (0.5 - elevation / kPi) * size.height;
  return {std::max(u, 0.0), std::clamp(v, 0.0, static_cast<double>(size.height))};
}

glm::ivec2 LatLongPixelFromDirection(const glm::dvec3& direction_enu, LatLongSize size) {
  const glm::dvec2 uv = LatLongFromDirection(direction_enu, size);
  return {std::min(static_cast<int>(uv.x), size.width - 1),
          std::min(static_cast<int>(uv.y), size.height - 1)};
}

double LatLongPixelSolidAngleSr(int y, LatLongSize size) {
  RequireUsable(size);
  if (y < 0 || y >= size.height) {
    throw std::invalid_argument("lat-long row " + std::to_string(y) + ": outside a " + Text(size) +
                                " image");
  }
  // sin(top) - sin(bottom) of the row, as a product: no cancellation next to the poles.
  const double half_step = 0.5 * kPi / size.height;
  const double centre = (0.5 - (y + 0.5) / size.height) * kPi;
  return 2.0 * kPi / size.width * 2.0 * std::cos(centre) * std::sin(half_step);
}

glm::vec3 SampleLatLong(const RgbImage& image, const glm::dvec3& direction_enu) {
  const glm::dvec2 uv = LatLongFromDirection(direction_enu, SizeOf(image));
  const double v_centre = uv.y - 0.5;
  const double top = std::floor(v_centre);
  const double share = v_centre - top;
  const auto row = [&](int y) {
    // The row beyond a pole is the pole's own row, seen half way round.
    const bool beyond = y < 0 || y >= image.height;
    const double turned = beyond ? 0.5 * image.width : 0.0;
    return SampleRow(image, std::clamp(y, 0, image.height - 1), uv.x - 0.5 + turned);
  };
  const int y = static_cast<int>(top);
  return glm::vec3((1.0 - share) * row(y) + share * row(y + 1));
}

RgbImage TurnedLatLong(const RgbImage& image, double clockwise_rad) {
  RequireUsable(SizeOf(image));
  const double shift_px = clockwise_rad / (2.0 * kPi) * image.width;
  RgbImage turned(image.width, image.height);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      turned.At(x, y) = glm::vec3(SampleRow(image, y, x - shift_px));
    }
  }
  return turned;
}

RgbImage DownsampleLatLong(const RgbImage& image, LatLongSize size) {
  RequireUsable(size);
  if (image.Empty() || image.width % size.width != 0 || image.height % size.height != 0) {
    throw std::invalid_argument("lat-long image of " + Text(SizeOf(image)) + " to " + Text(size) +
                                ": each side must divide the image's");
  }
  const int columns = image.width / size.width;
  const int rows = image.height / size.height;
  RgbImage reduced(size.width, size.height);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      glm::dvec3 sum(0.0);
      double total_sr = 0.0;
      for (int row = y * rows; row < (y + 1) * rows; ++row) {
        const double solid_angle_sr = LatLongPixelSolidAngleSr(row, SizeOf(image));
        for (int column = x * columns; column < (x + 1) * columns; ++column) {
          sum += solid_angle_sr * glm::dvec3(image.At(column, row));
          total_sr += solid_angle_sr;
        }
      }
      reduced.At(x, y) = glm::vec3(sum / total_sr);
    }
  }
  return reduced;
}

}  // namespace pleinair
