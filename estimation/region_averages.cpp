#include "estimation/region_averages.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/type_ptr.hpp>

#include "estimation/internal/measured_pixel.h"
#include "scene/float4.h"

namespace pleinair {
namespace {

using estimation_internal::IsMeasured;

struct RunSum {
  glm::vec3 radiance_sr{0.0f};
  float least = 0.0f;  // Mean of all values, or 0.
};

// Four pixels at a time: a sum of one pixel after another waits for every single addition.
RunSum SumOf(std::span<const glm::vec3> radiance, std::span<const float> solid_angle_sr) {
  // Values lie as rgbr gbrg brgb.
  Float4 sum_rgbr{};
  Float4 sum_gbrg{};
  Float4 sum_brgb{};
  Float4 least{};
  const auto lesser = [](const Float4& a, const Float4& b) { return a < b ? a : b; };
  std::size_t pixel = 0;
  for (; pixel + 4 <= radiance.size(); pixel += 4) {
    const float* values = glm::value_ptr(radiance[pixel]);
    const Float4 rgbr = LoadFour(values);
    const Float4 gbrg = LoadFour(values + 4);
    const Float4 brgb = LoadFour(values + 8);
    const Float4 weight = LoadFour(&solid_angle_sr[pixel]);
    sum_rgbr += __builtin_shufflevector(weight, weight, 0, 0, 0, 1) * rgbr;
    sum_gbrg += __builtin_shufflevector(weight, weight, 1, 1, 2, 2) * gbrg;
    sum_brgb += __builtin_shufflevector(weight, weight, 2, 3, 3, 3) * brgb;
    least = lesser(lesser(rgbr, gbrg), lesser(brgb, least));
  }
  RunSum sum;
  sum.radiance_sr = {(sum_rgbr[0] + sum_rgbr[3]) + (sum_gbrg[2] + sum_brgb[1]),
                     (sum_rgbr[1] + sum_gbrg[0]) + (sum_gbrg[3] + sum_brgb[2]),
                     (sum_rgbr[2] + sum_gbrg[1]) + (sum_brgb[0] + sum_brgb[3])};
  sum.least = std::min({least[0], least[1], least[2], least[3]});
  for (; pixel < radiance.size(); ++pixel) {
    sum.radiance_sr += solid_angle_sr[pixel] * radiance[pixel];
    sum.least = std::min({sum.least, radiance[pixel].x, radiance[pixel].y, radiance[pixel].z});
  }
  return sum;
}

}  // namespace

RegionAverages::RegionAverages(const FisheyePixelTable& table, const SkyRegions& regions)
    : regions_(regions), solid_angle_sr_(table.solid_angle_sr.pixels) {
  const Image<glm::vec3>& direction = table.direction_world;
  region_of_pixel_.resize(direction.pixels.size());
  for (int y = 0; y < direction.height; ++y) {
    for (int x = 0; x < direction.width; ++x) {
      const std::size_t pixel = direction.Index(x, y);
      if (!(solid_angle_sr_[pixel] > 0.0f)) continue;
      const auto region = regions_.RegionOf(glm::dvec3(direction.pixels[pixel]));
      if (!region) continue;
      const auto index = static_cast<std::uint32_t>(pixel);
      region_of_pixel_[pixel] = static_cast<std::uint32_t>(*region);
      if (x > 0 && !runs_.empty() && runs_.back().end == index && runs_.back().region == *region) {
        ++runs_.back().end;
      } else {
        runs_.push_back({index, index + 1, static_cast<std::uint32_t>(*region), 0.0f});
      }
      runs_.back().solid_angle_sr += solid_angle_sr_[pixel];
    }
  }
}

void RegionAverages::Average(const RgbImage& radiance,
                             std::span<const std::uint32_t> replaced,
                             const glm::vec3& replacement) {
  average_.assign(regions_.Count(), glm::dvec3(0.0));
  weight_sr_.assign(regions_.Count(), 0.0);
  const std::span<const glm::vec3> pixels(radiance.pixels);
  const std::span<const float> solid_angle_sr(solid_angle_sr_);
  for (const Run& run : runs_) {
    const std::size_t count = run.end - run.begin;
    const RunSum sum =
        SumOf(pixels.subspan(run.begin, count), solid_angle_sr.subspan(run.begin, count));
    glm::vec3 radiance_sr = sum.radiance_sr;
    float weight_sr = run.solid_angle_sr;
    // Most runs are clean: defects are searched only where the sum reveals some.
    if (sum.least != 0.0f || !IsMeasured(radiance_sr)) {
      radiance_sr = glm::vec3(0.0f);
      weight_sr = 0.0f;
      for (std::size_t pixel = run.begin; pixel < run.end; ++pixel) {
        if (!IsMeasured(pixels[pixel])) continue;
        radiance_sr += solid_angle_sr[pixel] * pixels[pixel];
        weight_sr += solid_angle_sr[pixel];
      }
    }
    average_[run.region] += glm::dvec3(radiance_sr);
    weight_sr_[run.region] += double{weight_sr};
  }
  for (const std::uint32_t pixel : replaced) {
    average_[region_of_pixel_[pixel]] +=
        double{solid_angle_sr[pixel]} * glm::dvec3(replacement - pixels[pixel]);
  }
  glm::dvec3 all(0.0);
  double all_sr = 0.0;
  for (std::size_t region = 0; region < average_.size(); ++region) {
    all += average_[region];
    all_sr += weight_sr_[region];
  }
  const auto sectors = static_cast<std::size_t>(regions_.Sectors());
  for (std::size_t region = regions_.Count(); region-- > 0;) {
    if (weight_sr_[region] > 0.0) {
      average_[region] /= weight_sr_[region];
    } else if (region + sectors < regions_.Count()) {
      average_[region] = average_[region + sectors];
    } else if (all_sr > 0.0) {
      average_[region] = all / all_sr;
    }
  }
}

}  // namespace pleinair
