#include "relight/survey/internal/survey_skyline.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>

#include "scene/lat_long.h"
#include "scene/upper_median.h"

namespace pleinair {
namespace {

// Radiance of a white surface that faces a sun of ten times the sky, per unit of the sky's
// irradiance: a bound of the largest channel. What is brighter shines by itself, such as a street
// lamp at night, and does not follow the sky.
constexpr double kMostReflected = 11.0 / std::numbers::pi;

// The edge: means of this height above and below it, blurred over the gap.
constexpr double kEdgeWindowDeg = 0.7;
constexpr double kEdgeGapDeg = 0.35;
// The sky above is compared with what is about it as well, so that neither a bright cloud nor the
// sun's glow makes the sky below look dark.
constexpr double kAroundDeg = 10.0;
// All in octaves, that is binary logarithms of ratios.
constexpr double kSkyEdgeStep = 0.7;
constexpr double kDark = 1.0;  // The median of what hides the sky, against the sky above it.
constexpr double kSomewhatDark = 0.4;  // Its single pixels,
constexpr double kShareDark = 0.75;    // so many of them.
constexpr double kBluer = 0.2;         // Blue over red: as shades of things lit by a blue sky vary.
// A thing is wider than a degree and a half's three fifths: noise has narrow columns. Gaps narrower
// than that belong to it.
constexpr double kNeighbourhoodDeg = 0.7;
constexpr double kShareOfNeighbours = 0.6;
// An eave of half a metre at 7 m: what rises no farther over the mesh is a part of it, and near.
// Seen from elsewhere, such a near part is in another direction.
constexpr double kLeastOverMeshDeg = 4.0;
// Below this share of the map's mean radiance a value counts as that.
constexpr double kLeastOfMean = 1e-3;

int MapRows(double degrees, int height) {
  return std::max(1, static_cast<int>(std::lround(degrees / 180.0 * height)));
}

// The upper half of the map in octaves, each row averaged over a window's width.
struct LogMap {
  Image<double> brightness;
  Image<double> blueness;  // Blue over red.
};

LogMap LogOf(const RgbImage& radiance, int reach_px) {
  const int width = radiance.width;
  const int rows = radiance.height / 2;
  double mean = 0.0;
  for (const glm::vec3& value : radiance.pixels) {
    if (!std::isfinite(value.x + value.y + value.z)) continue;
    mean += std::min({value.x, value.y, value.z}) / static_cast<double>(radiance.pixels.size());
  }
  LogMap log{Image<double>(width, rows, 0.0), Image<double>(width, rows, 0.0)};
  if (!(mean > 0.0)) return log;
  const double floor = kLeastOfMean * mean;
  tbb::parallel_for(0, rows, [&](int y) {
    std::vector<double> brightness(static_cast<std::size_t>(width));
    std::vector<double> blueness(brightness.size());
    for (int x = 0; x < width; ++x) {
      const glm::dvec3 value(radiance.At(x, y));
      const auto i = static_cast<std::size_t>(x);
      // A pixel that is not finite is as dark as can be.
      const auto held = [floor](double light) {
        return std::isfinite(light) ? std::max(light, floor) : floor;
      };
      brightness[i] = std::log2(held((value.x + value.y + value.z) / 3.0));
      blueness[i] = std::log2(held(value.z) / held(value.x));
    }
    for (int x = 0; x < width; ++x) {
      for (int dx = -reach_px; dx <= reach_px; ++dx) {
        const auto i = static_cast<std::size_t>((x + dx + width) % width);
        log.brightness.At(x, y) += brightness[i] / (2 * reach_px + 1);
        log.blueness.At(x, y) += blueness[i] / (2 * reach_px + 1);
      }
    }
  });
  return log;
}

// Rows [top, bottom) of a column.
struct ColumnRun {
  int top = 0;
  int bottom = 0;
};

class SkylineSearch {
 public:
  SkylineSearch(const RgbImage& radiance, const Gray8Image& shows_sky)
      : shows_sky_(shows_sky),
        window_px_(MapRows(kEdgeWindowDeg, radiance.height)),
        gap_px_(MapRows(kEdgeGapDeg, radiance.height)),
        around_px_(MapRows(kAroundDeg, radiance.height)),
        over_mesh_px_(MapRows(kLeastOverMeshDeg, radiance.height)),
        log_(LogOf(radiance, gap_px_)) {}

  // The highest thing of each stretch of column x that the mesh leaves free.
  std::vector<ColumnRun> InColumn(int x) const {
    std::vector<ColumnRun> runs;
    const int rows = log_.brightness.height;
    for (int y = 0; y < rows;) {
      if (shows_sky_.At(x, y) == 0) {
        ++y;
        continue;
      }
      const int first = y;
      while (y < rows && shows_sky_.At(x, y) != 0) ++y;
      for (int top = first + window_px_ + gap_px_; top + window_px_ <= y; ++top) {
        if (y < rows && y - top < over_mesh_px_) break;
        if (!IsThing(x, {top, y})) continue;
        runs.push_back({top, y});
        break;
      }
    }
    return runs;
  }

 private:
  static double Mean(const Image<double>& image, int x, int first, int count) {
    double sum = 0.0;
    for (int y = first; y < first + count; ++y) sum += image.At(x, y);
    return sum / count;
  }

  // Median of the sky in the rows of the window above and the columns around.
  double SkyAround(int x, int first) const {
    std::vector<double> values;
    const int width = shows_sky_.width;
    for (int y = first; y < first + window_px_; ++y) {
      for (int dx = -around_px_; dx <= around_px_; ++dx) {
        const int column = ((x + dx) % width + width) % width;
        if (shows_sky_.At(column, y) != 0) values.push_back(log_.brightness.At(column, y));
      }
    }
    return UpperMedianInPlace(values);
  }

  bool IsThing(int x, const ColumnRun& run) const {
    const int above = run.top - gap_px_ - window_px_;
    const double below_edge = Mean(log_.brightness, x, run.top, window_px_);
    double sky = Mean(log_.brightness, x, above, window_px_);
    if (!(sky - below_edge > kSkyEdgeStep)) return false;
    const double bluest = Mean(log_.blueness, x, above, window_px_) + kBluer;
    if (Mean(log_.blueness, x, run.top, window_px_) > bluest) return false;
    sky = std::min(sky, SkyAround(x, above));
    if (!(sky - below_edge > kSkyEdgeStep)) return false;
    int dark = 0;
    std::vector<double> values;
    for (int y = run.top; y < run.bottom; ++y) {
      const double value = log_.brightness.At(x, y);
      values.push_back(value);
      dark += value < sky - kSomewhatDark && log_.blueness.At(x, y) < bluest ? 1 : 0;
    }
    return dark > kShareDark * (run.bottom - run.top) && UpperMedianInPlace(values) < sky - kDark;
  }

  const Gray8Image& shows_sky_;
  int window_px_;
  int gap_px_;
  int around_px_;
  int over_mesh_px_;
  LogMap log_;
};

// Keeps columns whose neighbours have such a thing, too, and fills gaps between those that do.
Gray8Image AmongNeighbours(const Gray8Image& found, const Gray8Image& shows_sky) {
  const int width = found.width;
  const int reach = MapRows(kNeighbourhoodDeg, found.height);
  Gray8Image kept(width, found.height, 0);
  tbb::parallel_for(0, found.height / 2, [&](int y) {
    for (int x = 0; x < width; ++x) {
      if (shows_sky.At(x, y) == 0) continue;
      int others = 0;
      int left = 0;
      for (int dx = -reach; dx <= reach; ++dx) {
        const bool there = found.At((x + dx + width) % width, y) != 0;
        others += there ? 1 : 0;
        left += there && dx < 0 ? 1 : 0;
      }
      const bool itself = found.At(x, y) != 0;
      const int right = others - left - (itself ? 1 : 0);
      const bool enough = others > kShareOfNeighbours * (2 * reach + 1) - 0.5;
      if (itself ? enough : enough && left > 0 && right > 0) kept.At(x, y) = 255;
    }
  });
  return kept;
}

}  // namespace

Gray8Image FindHiddenSky(const RgbImage& radiance, const Gray8Image& shows_sky) {
  const SkylineSearch search(radiance, shows_sky);
  Gray8Image found(radiance.width, radiance.height, 0);
  tbb::parallel_for(0, radiance.width, [&](int x) {
    for (const ColumnRun& run : search.InColumn(x)) {
      for (int y = run.top; y < run.bottom; ++y) found.At(x, y) = 255;
    }
  });
  return AmongNeighbours(found, shows_sky);
}

Skyline SkylineOf(const RgbImage& radiance,
                  const Gray8Image& hidden,
                  const glm::dvec3& sky_irradiance_rgb) {
  const int width = radiance.width;
  const int rows = radiance.height / 2;
  int top = 0;
  while (top < rows && std::none_of(&hidden.At(0, top), &hidden.At(0, top) + width, [](auto pixel) {
           return pixel != 0;
         })) {
    ++top;
  }
  if (top == rows) return {};
  // With the row below the horizon like the one above it, so that neither fades there.
  RgbImage share(width, radiance.height, glm::vec3(0.0f));
  RgbImage reflected = share;
  for (int y = top; y <= rows && y < radiance.height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int row = std::min(y, rows - 1);
      if (hidden.At(x, row) == 0) continue;
      share.At(x, y) = glm::vec3(1.0f);
      glm::dvec3 of_sky_rgb(0.0);
      for (int c = 0; c < 3; ++c) {
        if (!(sky_irradiance_rgb[c] > 0.0)) continue;
        of_sky_rgb[c] = radiance.At(x, row)[c] / sky_irradiance_rgb[c];
      }
      const double most = std::max({of_sky_rgb.x, of_sky_rgb.y, of_sky_rgb.z, kMostReflected});
      reflected.At(x, y) = glm::vec3(kMostReflected / most * of_sky_rgb);
    }
  }
  const LatLongSize size{width, radiance.height};
  const auto highest = static_cast<float>(DirectionFromLatLong({0.5, top - 0.5}, size).z);
  std::vector<float> share_of_cell(SkyTable::kCells, 0.0f);
  std::vector<glm::vec3> reflected_by_cell(SkyTable::kCells, glm::vec3(0.0f));
  tbb::parallel_for(std::size_t{0}, SkyTable::kCells, [&](std::size_t cell) {
    const glm::dvec3 direction = SkyTable::DirectionOfCell(cell);
    if (direction.z > highest) return;
    share_of_cell[cell] = SampleLatLong(share, direction).x;
    reflected_by_cell[cell] = SampleLatLong(reflected, direction);
  });
  return MakeSkyline(std::move(share_of_cell), std::move(reflected_by_cell));
}

}  // namespace pleinair
