#include "relight/survey/internal/sky_completion.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include <glm/common.hpp>

#include "relight/transport/edge_distance.h"
#include "scene/lat_long.h"

namespace pleinair {
namespace {

// An eave of half a metre at 7 m.
constexpr double kNearSurfaceRad = 4.0 * std::numbers::pi / 180.0;
// Near a surface, sky is what lies within this factor of the prediction, both ways. A cloud's edge
// differs less from a blue sky; a shaded eave or a sunlit wall differs more.
constexpr float kSkyLikeFactor = 1.6f;
// Less sky than this share of what is visible is too little to predict from.
constexpr double kEnoughSky = 0.25;

// Distance in pixels to the nearest pixel of the upper hemisphere that shows a surface. The ground
// is no neighbour of the sky over the horizon. Near the zenith a pixel of a row is narrower than
// 180 deg / height, and so is the margin.
GrayImage DistanceToSurfaces(const Gray8Image& shows_sky, int sky_rows) {
  Gray8Image surfaces(shows_sky.width, sky_rows, 0);
  for (int y = 0; y < sky_rows; ++y) {
    for (int x = 0; x < shows_sky.width; ++x) {
      surfaces.At(x, y) = shows_sky.At(x, y) == 0 ? 255 : 0;
    }
  }
  return DistanceTo(surfaces, true);
}

// Mean of each row's weighted pixels; rows without take the nearest row that has (from above
// first).
std::vector<glm::dvec3> RowMeans(const RgbImage& image, const GrayImage& weight) {
  std::vector<glm::dvec3> means(static_cast<std::size_t>(image.height), glm::dvec3(0.0));
  std::vector<bool> known(means.size(), false);
  for (int y = 0; y < image.height; ++y) {
    double sum = 0.0;
    glm::dvec3& mean = means[static_cast<std::size_t>(y)];
    for (int x = 0; x < image.width; ++x) {
      mean += static_cast<double>(weight.At(x, y)) * glm::dvec3(image.At(x, y));
      sum += weight.At(x, y);
    }
    if (sum > 0.0) {
      mean /= sum;
      known[static_cast<std::size_t>(y)] = true;
    }
  }
  for (std::size_t y = 1; y < means.size(); ++y) {
    if (!known[y] && known[y - 1]) {
      means[y] = means[y - 1];
      known[y] = true;
    }
  }
  for (std::size_t y = means.size() - 1; y-- > 0;) {
    if (!known[y] && known[y + 1]) {
      means[y] = means[y + 1];
      known[y] = true;
    }
  }
  return means;
}

// The sky that the weighted pixels predict everywhere; they themselves are kept.
RgbImage PredictedSky(const RgbImage& image, const GrayImage& weight) {
  const std::vector<glm::dvec3> row_means = RowMeans(image, weight);
  RgbImage factor(image.width, image.height, glm::vec3(0.0f));
  for (int y = 0; y < image.height; ++y) {
    const glm::dvec3& mean = row_means[static_cast<std::size_t>(y)];
    for (int x = 0; x < image.width; ++x) {
      for (int channel = 0; channel < 3; ++channel) {
        if (mean[channel] > 0.0) {
          factor.At(x, y)[channel] = static_cast<float>(image.At(x, y)[channel] / mean[channel]);
        }
      }
    }
  }
  FillPushPull(weight, factor);
  RgbImage predicted = image;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (weight.At(x, y) > 0.0f) continue;
      predicted.At(x, y) = glm::vec3(row_means[static_cast<std::size_t>(y)]) * factor.At(x, y);
    }
  }
  return predicted;
}

bool IsSkyLike(const glm::vec3& value, const glm::vec3& predicted) {
  for (int channel = 0; channel < 3; ++channel) {
    if (value[channel] > kSkyLikeFactor * predicted[channel] ||
        predicted[channel] > kSkyLikeFactor * value[channel]) {
      return false;
    }
  }
  return true;
}

}  // namespace

void FillPushPull(const GrayImage& weight, RgbImage& image) {
  struct Level {
    RgbImage mean;
    GrayImage weight;
  };
  std::vector<Level> levels;
  levels.push_back({image, weight});
  while (levels.back().mean.width > 1 || levels.back().mean.height > 1) {
    const Level& fine = levels.back();
    const int width = (fine.mean.width + 1) / 2;
    const int height = (fine.mean.height + 1) / 2;
    Level coarse{RgbImage(width, height, glm::vec3(0.0f)), GrayImage(width, height, 0.0f)};
    for (int y = 0; y < fine.mean.height; ++y) {
      for (int x = 0; x < fine.mean.width; ++x) {
        const float w = fine.weight.At(x, y);
        coarse.mean.At(x / 2, y / 2) += w * fine.mean.At(x, y);
        coarse.weight.At(x / 2, y / 2) += w;
      }
    }
    for (std::size_t i = 0; i < coarse.mean.pixels.size(); ++i) {
      if (coarse.weight.pixels[i] > 0.0f) coarse.mean.pixels[i] /= coarse.weight.pixels[i];
    }
    levels.push_back(std::move(coarse));
  }
  for (std::size_t level = levels.size() - 1; level-- > 0;) {
    const Level& coarse = levels[level + 1];
    Level& fine = levels[level];
    for (int y = 0; y < fine.mean.height; ++y) {
      for (int x = 0; x < fine.mean.width; ++x) {
        if (fine.weight.At(x, y) > 0.0f) continue;
        // Bilinear in the coarser level, whose pixel (i, j) has its centre at (2 i + 1, 2 j + 1) in
        // corner counts of this one.
        const float u = 0.5f * (static_cast<float>(x) + 0.5f) - 0.5f;
        const float v = 0.5f * (static_cast<float>(y) + 0.5f) - 0.5f;
        const int left = static_cast<int>(std::floor(u));
        const int top = static_cast<int>(std::floor(v));
        const float du = u - static_cast<float>(left);
        const float dv = v - static_cast<float>(top);
        const auto at = [&coarse](int i, int j) {
          const int width = coarse.mean.width;
          return coarse.mean.At((i + width) % width, std::clamp(j, 0, coarse.mean.height - 1));
        };
        fine.mean.At(x, y) = (1.0f - dv) * ((1.0f - du) * at(left, top) + du * at(left + 1, top)) +
                             dv * ((1.0f - du) * at(left, top + 1) + du * at(left + 1, top + 1));
      }
    }
  }
  image = std::move(levels.front().mean);
}

void CompleteSky(const Gray8Image& shows_sky, RgbImage& image) {
  const int width = image.width;
  const LatLongSize size{width, image.height};
  const int sky_rows = (image.height + 1) / 2;
  RgbImage upper(width, sky_rows);
  std::copy_n(image.pixels.begin(), upper.pixels.size(), upper.pixels.begin());

  const GrayImage surface_distance_px = DistanceToSurfaces(shows_sky, sky_rows);
  GrayImage trusted(width, sky_rows, 0.0f);
  GrayImage visible(width, sky_rows, 0.0f);
  for (double margin_rad = kNearSurfaceRad;; margin_rad *= 0.5) {
    // Below a pixel the margin has no meaning: then all that is visible is trusted.
    double margin_px = margin_rad / std::numbers::pi * image.height;
    if (margin_px < 1.0) margin_px = 0.0;
    double trusted_sr = 0.0;
    double visible_sr = 0.0;
    for (int y = 0; y < sky_rows; ++y) {
      const double solid_angle_sr = LatLongPixelSolidAngleSr(y, size);
      for (int x = 0; x < width; ++x) {
        const bool sky = shows_sky.At(x, y) != 0;
        const bool far = surface_distance_px.At(x, y) > margin_px;
        visible.At(x, y) = sky ? static_cast<float>(solid_angle_sr) : 0.0f;
        trusted.At(x, y) = sky && far ? static_cast<float>(solid_angle_sr) : 0.0f;
        visible_sr += visible.At(x, y);
        trusted_sr += trusted.At(x, y);
      }
    }
    if (margin_px == 0.0 || trusted_sr >= kEnoughSky * visible_sr) break;
  }

  // What the trusted sky predicts decides which of the doubtful pixels are sky; these then take
  // part in the final filling.
  const RgbImage predicted = PredictedSky(upper, trusted);
  for (std::size_t i = 0; i < upper.pixels.size(); ++i) {
    if (!(trusted.pixels[i] > 0.0f) && visible.pixels[i] > 0.0f &&
        IsSkyLike(upper.pixels[i], predicted.pixels[i])) {
      trusted.pixels[i] = visible.pixels[i];
    }
  }
  upper = PredictedSky(upper, trusted);
  std::fill(image.pixels.begin(), image.pixels.end(), glm::vec3(0.0f));
  std::copy(upper.pixels.begin(), upper.pixels.end(), image.pixels.begin());
}

}  // namespace pleinair
