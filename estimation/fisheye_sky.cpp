#include "estimation/fisheye_sky.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "estimation/internal/measured_pixel.h"
#include "scene/angle_between.h"
#include "scene/half_float.h"
#include "scene/sun_in_picture.h"
#include "scene/upper_median.h"

namespace pleinair {
namespace {

using estimation_internal::IsMeasured;

// Largest error of orientation and refraction.
constexpr double kSearchRadiusRad = 2.5 * std::numbers::pi / 180.0;
// The sky around the disc that is used as the sky behind it.
constexpr double kRingWidthRad = 1.5 * std::numbers::pi / 180.0;
// Above the sky around: a thin cloud's bright patch is not a disc.
constexpr float kDiscContrast = 3.0f;
// The least above the ring for a disc that is far above the sky around that.
constexpr float kSpreadContrast = 1.5f;
// Values this near to the picture's largest one are as large as it: half precision's steps.
constexpr float kFlatTop = 0.999f;
// A disc that a lens spreads has no flat top wider than itself; half again for pixels on its rim.
constexpr double kWidestFlatTop = 1.5;

// Water on a dome spreads the sun without leaving a disc, over this and around; its share of the
// light is more than an aureole's, which is half of the sky's at most.
constexpr double kSpreadRad = 10.0 * std::numbers::pi / 180.0;
constexpr double kAroundSpreadRad = 15.0 * std::numbers::pi / 180.0;
// A disc with less than half of it is a glint in the water.
constexpr double kSpreadOverDisc = 2.0;
constexpr double kSpreadError = 0.2;  // Relative: what lies outside, and the aureole in it.

// Half of the light up to this many times the sky may be a bright aureole, not of the lens.
constexpr double kBrightestAureole = 10.0;
// A disc that is not where it should be, or none but spread light, counts as the sun if it has this
// share of the sky's light. A clear sun has 1.5 times and more of it, its reflection in a window a
// tenth of that.
constexpr double kLeastShareElsewhere = 0.7;

float Luminance(const glm::vec3& rgb) { return rgb.x + rgb.y + rgb.z; }
double Luminance(const glm::dvec3& rgb) { return rgb.x + rgb.y + rgb.z; }
float Largest(const glm::vec3& rgb) { return std::max({rgb.x, rgb.y, rgb.z}); }

// A pixel near the sun's place.
struct Near {
  std::uint32_t pixel;
  double from_peak_rad;
};

// The solid angle of what is level with `top`, if a sensor's limit makes it so; else 0.
double CutOffSr(const RgbImage& radiance,
                const GrayImage& solid_angle_sr,
                std::span<const Near> near,
                float top) {
  std::ptrdiff_t level = 0;
  std::ptrdiff_t almost = 0;
  double level_sr = 0.0;
  for (const Near& at : near) {
    const float value = Largest(radiance.pixels[at.pixel]);
    almost += value >= top * (1.0 - kFewSteps) ? 1 : 0;
    if (!(std::abs(value - top) <= kOneLevel * top)) continue;
    ++level;
    level_sr += solid_angle_sr.pixels[at.pixel];
  }
  return almost < 2 * level ? level_sr : 0.0;
}

// Of infinite radiance, as half floats have a sun. NaN is no measurement at all.
std::vector<std::uint32_t> PixelsBeyondRange(const RgbImage& radiance) {
  std::vector<std::uint32_t> pixels;
  for (std::size_t i = 0; i < radiance.pixels.size(); ++i) {
    const glm::vec3& value = radiance.pixels[i];
    if (std::isinf(Luminance(value)) && Luminance(value) > 0.0f) {
      pixels.push_back(static_cast<std::uint32_t>(i));
    }
  }
  return pixels;
}

// Infinite values become finite, and far above the sky.
RgbImage WithinRange(const RgbImage& radiance, std::span<const std::uint32_t> overflowed) {
  float largest = kLargestHalf;
  for (const glm::vec3& value : radiance.pixels) {
    if (IsMeasured(value)) largest = std::max(largest, Largest(value));
  }
  RgbImage bounded = radiance;
  for (const std::uint32_t pixel : overflowed) {
    bounded.pixels[pixel] = glm::min(bounded.pixels[pixel], glm::vec3(largest));
  }
  return bounded;
}

}  // namespace

FisheyeSky::FisheyeSky(const FisheyeCamera& camera, const SkyRegions& regions, SkyDetail detail)
    : detail_(detail),
      lens_(camera.intrinsics),
      camera_from_world_(glm::transpose(camera.world_from_camera)),
      table_(MakeFisheyePixelTable(camera)),
      region_averages_(table_, regions) {
  if (!region_averages_.SeesSky()) {
    throw std::invalid_argument(
        "fish-eye camera: it sees no sky; expected some of its pixels to "
        "look above the horizon");
  }
  const Image<glm::vec3>& direction = table_.direction_world;
  for (std::size_t cell = 0; cell < SkyTable::kCells; ++cell) {
    const glm::dvec3 to_cell = SkyTable::DirectionOfCell(cell);
    region_of_cell_.push_back(static_cast<std::uint32_t>(regions.RegionOf(to_cell).value_or(0)));
    pixel_of_cell_.push_back(kNone);
    const auto at = lens_.ProjectToPixel(camera_from_world_ * to_cell);
    if (!at) continue;
    const int x = static_cast<int>(std::lround(at->x));
    const int y = static_cast<int>(std::lround(at->y));
    if (!direction.Contains(x, y)) continue;
    const std::size_t pixel = direction.Index(x, y);
    if (table_.solid_angle_sr.pixels[pixel] > 0.0f) {
      pixel_of_cell_.back() = static_cast<std::uint32_t>(pixel);
    }
  }
}

void FisheyeSky::Read(const RgbImage& radiance,
                      const glm::dvec3& sun_direction_enu,
                      double sun_angular_radius_rad) {
  const Image<glm::vec3>& direction = table_.direction_world;
  if (radiance.width != direction.width || radiance.height != direction.height) {
    throw std::invalid_argument(
        std::string("fish-eye picture is ") + std::to_string(radiance.width) + "x" +
        std::to_string(radiance.height) + ": expected the camera's " +
        std::to_string(direction.width) + "x" + std::to_string(direction.height));
  }
  const std::vector<std::uint32_t> overflowed = PixelsBeyondRange(radiance);
  if (overflowed.empty()) {
    ReadSky(radiance, FindDisc(radiance, sun_direction_enu, sun_angular_radius_rad));
    return;
  }
  const RgbImage bounded = WithinRange(radiance, overflowed);
  const DiscArea disc = FindDisc(bounded, sun_direction_enu, sun_angular_radius_rad);
  const bool is_in_disc = std::ranges::any_of(disc.pixels, [&](std::uint32_t pixel) {
    return std::ranges::binary_search(overflowed, pixel);
  });
  if (is_in_disc) {
    sun_.clipped = true;
    // The picture may have been scaled since it was written: what its file could hold is no bound.
    sun_.irradiance_rgb = glm::dvec3(0.0);
  }
  ReadSky(bounded, disc);
}

FisheyeSky::DiscArea FisheyeSky::FindDisc(const RgbImage& radiance,
                                          const glm::dvec3& sun_direction_enu,
                                          double sun_angular_radius_rad) {
  DiscArea disc = ReadDisc(radiance, sun_direction_enu, sun_angular_radius_rad);
  if (sun_direction_enu.z > 0.0 && disc.pixels.empty()) {
    const std::uint32_t brightest = BrightestPixel(radiance);
    // A sensor's limit is the most that the picture holds anywhere.
    sun_.clipped =
        brightest != kNone &&
        disc.level_luminance >= (1.0 - kOneLevel) * Luminance(radiance.pixels[brightest]);
    if (brightest != kNone && !sun_.clipped) {
      disc = FindDiscElsewhere(radiance, brightest, sun_angular_radius_rad);
    }
  }
  if (sun_direction_enu.z > 0.0 && !sun_.clipped && !sun_.elsewhere_enu) {
    DiscArea spread = ReadSpreadSun(radiance, sun_direction_enu);
    if (!spread.pixels.empty()) return spread;
  }
  return disc;
}

FisheyeSky::PixelWindow FisheyeSky::WindowAround(const glm::dvec3& direction_enu,
                                                 double radius_rad) const {
  const Image<glm::vec3>& direction = table_.direction_world;
  PixelWindow window{0, 0, direction.width, direction.height};
  const auto centre = lens_.ProjectToPixel(camera_from_world_ * direction_enu);
  if (!centre) return window;
  const double solid_angle_sr = lens_.PixelSolidAngleSr(*centre);
  if (!(solid_angle_sr > 0.0)) return window;
  // Pixels are squeezed towards the rim by less than a half either way.
  const double reach_px = 2.0 * radius_rad / std::sqrt(solid_angle_sr) + 2.0;
  window.left = std::max(window.left, static_cast<int>(std::floor(centre->x - reach_px)));
  window.top = std::max(window.top, static_cast<int>(std::floor(centre->y - reach_px)));
  window.right = std::min(window.right, static_cast<int>(std::ceil(centre->x + reach_px)) + 1);
  window.bottom = std::min(window.bottom, static_cast<int>(std::ceil(centre->y + reach_px)) + 1);
  return window;
}

FisheyeSky::DiscArea FisheyeSky::ReadDisc(const RgbImage& radiance,
                                          const glm::dvec3& sun_direction_enu,
                                          double sun_angular_radius_rad) {
  sun_ = {};
  DiscArea disc;
  if (!(sun_direction_enu.z > -std::sin(sun_angular_radius_rad))) return disc;
  // Radius of the search for the disc, the same again for clipping, and a ring around it.
  const double reach_cosine = std::cos(2.0 * kSearchRadiusRad + kRingWidthRad);
  std::vector<Near> near;
  std::uint32_t peak = kNone;
  float brightest_beyond = 0.0f;
  const PixelWindow window =
      WindowAround(sun_direction_enu, 2.0 * kSearchRadiusRad + kRingWidthRad);
  for (int y = window.top; y < window.bottom; ++y) {
    for (int x = window.left; x < window.right; ++x) {
      const auto pixel = static_cast<std::uint32_t>(table_.direction_world.Index(x, y));
      const glm::dvec3 direction(table_.direction_world.pixels[pixel]);
      if (!(direction.z > 0.0) || !(glm::dot(direction, sun_direction_enu) > reach_cosine) ||
          !IsMeasured(radiance.pixels[pixel])) {
        continue;
      }
      near.push_back({pixel, 0.0});
      const float luminance = Luminance(radiance.pixels[pixel]);
      if (AngleBetweenRad(direction, sun_direction_enu) > kSearchRadiusRad) {
        brightest_beyond = std::max(brightest_beyond, luminance);
      } else if (peak == kNone || luminance > Luminance(radiance.pixels[peak])) {
        peak = pixel;
      }
    }
  }
  // The slope of a sun that stands beyond is no disc.
  if (peak == kNone || brightest_beyond > kDiscContrast * Luminance(radiance.pixels[peak])) {
    return disc;
  }

  const double pixel_sr = table_.solid_angle_sr.pixels[peak];
  const double pixel_rad = std::sqrt(pixel_sr);
  const float largest = Largest(radiance.pixels[peak]);
  const float top = kFlatTop * largest;
  const glm::dvec3 centre(table_.direction_world.pixels[peak]);
  double flat_sr = 0.0;
  double flat_radius = 0.0;
  for (Near& at : near) {
    at.from_peak_rad = AngleBetweenRad(glm::dvec3(table_.direction_world.pixels[at.pixel]), centre);
    if (at.from_peak_rad > kSearchRadiusRad || Largest(radiance.pixels[at.pixel]) < top) continue;
    flat_sr += table_.solid_angle_sr.pixels[at.pixel];
    flat_radius = std::max(flat_radius, at.from_peak_rad);
  }
  const double true_disc_sr = std::numbers::pi * sun_angular_radius_rad * sun_angular_radius_rad;
  // Few pixels of a picture have the same value by chance.
  const double level_sr = CutOffSr(radiance, table_.solid_angle_sr, near, largest);
  const bool has_flat_top = flat_sr > kWidestFlatTop * true_disc_sr + pixel_sr ||
                            level_sr > kWidestFlatTop * true_disc_sr + 0.5 * pixel_sr;
  // A lens, and the picture's own sampling, spread the disc by a pixel or two.
  const double disc_radius =
      (has_flat_top ? flat_radius : sun_angular_radius_rad) + 2.0 * pixel_rad;
  std::array<std::vector<double>, 3> ring;
  for (const Near& at : near) {
    if (at.from_peak_rad <= disc_radius) {
      disc.pixels.push_back(at.pixel);
    } else if (at.from_peak_rad <= disc_radius + kRingWidthRad) {
      for (std::size_t c = 0; c < 3; ++c) {
        ring[c].push_back(radiance.pixels[at.pixel][static_cast<int>(c)]);
      }
    }
  }
  if (ring[0].empty()) return {};
  glm::dvec3 spread(0.0);
  for (int c = 0; c < 3; ++c) {
    std::vector<double>& values = ring[static_cast<std::size_t>(c)];
    const double background = UpperMedianInPlace(values);
    disc.background[c] = static_cast<float>(background);
    for (double& value : values) value = std::abs(value - background);
    spread[c] = 1.4826 * UpperMedianInPlace(values);
  }
  const float contrast = Luminance(radiance.pixels[peak]) / Luminance(disc.background);
  // A lens may spread the disc over the ring.
  bool is_spread = false;
  if (contrast > kSpreadContrast && contrast <= kMuchBrighterThanSky) {
    std::vector<double> beyond_glare;
    for (const Near& at : near) {
      if (at.from_peak_rad <= kGlareRad) continue;
      beyond_glare.push_back(Luminance(radiance.pixels[at.pixel]));
    }
    const double sky = UpperMedianInPlace(beyond_glare);
    is_spread = sky > 0.0 && Luminance(radiance.pixels[peak]) > kMuchBrighterThanSky * sky;
  }
  if (!(contrast > kDiscContrast) && !is_spread) {
    DiscArea none;
    if (level_sr > kWidestFlatTop * true_disc_sr + 0.5 * pixel_sr) {
      none.level_luminance = Luminance(radiance.pixels[peak]);
    }
    return none;
  }

  double disc_sr = 0.0;
  for (const std::uint32_t pixel : disc.pixels) {
    const double solid_angle = table_.solid_angle_sr.pixels[pixel];
    sun_.irradiance_rgb += solid_angle * glm::dvec3(radiance.pixels[pixel] - disc.background);
    disc_sr += solid_angle;
  }
  sun_.irradiance_rgb = glm::max(sun_.irradiance_rgb, glm::dvec3(0.0));
  sun_.stddev_rgb = disc_sr * spread;
  sun_.clipped = has_flat_top;
  if (contrast > kMuchBrighterThanSky || is_spread) TakeGlare(radiance, centre, disc);
  return disc;
}

void FisheyeSky::TakeGlare(const RgbImage& radiance, const glm::dvec3& centre_enu, DiscArea& disc) {
  std::vector<std::uint32_t> in_disc = disc.pixels;
  std::sort(in_disc.begin(), in_disc.end());
  const double near_cosine = std::cos(kGlareRad);
  const double far_cosine = std::cos(kAroundGlareRad);
  std::vector<std::uint32_t> near;
  std::array<std::vector<double>, 3> far;
  const PixelWindow window = WindowAround(centre_enu, kAroundGlareRad);
  for (int y = window.top; y < window.bottom; ++y) {
    for (int x = window.left; x < window.right; ++x) {
      const auto pixel = static_cast<std::uint32_t>(table_.direction_world.Index(x, y));
      const glm::dvec3 direction(table_.direction_world.pixels[pixel]);
      const glm::vec3& value = radiance.pixels[pixel];
      const double cosine = glm::dot(direction, centre_enu);
      if (!(direction.z > 0.0) || !(cosine > far_cosine) || !IsMeasured(value)) {
        continue;
      }
      if (cosine > near_cosine) {
        if (!std::binary_search(in_disc.begin(), in_disc.end(), pixel)) near.push_back(pixel);
      } else {
        for (int c = 0; c < 3; ++c) far[static_cast<std::size_t>(c)].push_back(value[c]);
      }
    }
  }
  if (far[0].empty()) return;
  glm::vec3 most;
  for (int c = 0; c < 3; ++c) {
    most[c] =
        static_cast<float>(kMostAureole * UpperMedianInPlace(far[static_cast<std::size_t>(c)]));
  }
  const glm::vec3 background = glm::min(disc.background, most);
  double disc_sr = 0.0;
  for (const std::uint32_t pixel : disc.pixels) disc_sr += table_.solid_angle_sr.pixels[pixel];
  glm::dvec3 glare = disc_sr * glm::dvec3(disc.background - background);
  glm::dvec3 doubtful(0.0);
  disc.background = background;
  const glm::vec3 brightest_aureole = static_cast<float>(kBrightestAureole / kMostAureole) * most;
  for (const std::uint32_t pixel : near) {
    const glm::vec3& value = radiance.pixels[pixel];
    if (!(Luminance(value) > Luminance(most))) continue;
    disc.pixels.push_back(pixel);
    const double solid_angle_sr = table_.solid_angle_sr.pixels[pixel];
    const auto above = [&](const glm::vec3& radiance_there) {
      return solid_angle_sr * glm::max(glm::dvec3(radiance_there - background), glm::dvec3(0.0));
    };
    glare += above(value);
    doubtful += 0.5 * above(glm::min(value, brightest_aureole));
  }
  sun_.irradiance_rgb += glare;
  sun_.stddev_rgb += doubtful;
}

std::uint32_t FisheyeSky::BrightestPixel(const RgbImage& radiance) const {
  float peak = 0.0f;
  std::uint32_t brightest = kNone;
  for (std::size_t pixel = 0; pixel < radiance.pixels.size(); ++pixel) {
    const glm::vec3& value = radiance.pixels[pixel];
    if (!(Luminance(value) > peak) || !IsMeasured(value)) continue;
    if (!(table_.direction_world.pixels[pixel].z > 0.0f) ||
        !(table_.solid_angle_sr.pixels[pixel] > 0.0f)) {
      continue;
    }
    peak = Luminance(value);
    brightest = static_cast<std::uint32_t>(pixel);
  }
  return brightest;
}

FisheyeSky::DiscArea FisheyeSky::FindDiscElsewhere(const RgbImage& radiance,
                                                   std::uint32_t brightest,
                                                   double sun_angular_radius_rad) {
  const glm::dvec3 there(table_.direction_world.pixels[brightest]);
  const float peak = Luminance(radiance.pixels[brightest]);
  DiscArea disc = ReadDisc(radiance, there, sun_angular_radius_rad);
  if (!disc.pixels.empty() && peak > kMuchBrighterThanSky * Luminance(disc.background)) {
    const double disc_light = Luminance(sun_.irradiance_rgb);
    const double rest = HorizontalLight(radiance) - disc_light * there.z;
    if (disc_light > kLeastShareElsewhere * rest) {
      sun_.elsewhere_enu = there;
      return disc;
    }
  }
  sun_ = {};
  return {};
}

FisheyeSky::DiscArea FisheyeSky::ReadSpreadSun(const RgbImage& radiance,
                                               const glm::dvec3& sun_direction_enu) {
  DiscArea area;
  std::array<std::vector<double>, 3> ring;
  const PixelWindow window = WindowAround(sun_direction_enu, kAroundSpreadRad);
  for (int y = window.top; y < window.bottom; ++y) {
    for (int x = window.left; x < window.right; ++x) {
      const auto pixel = static_cast<std::uint32_t>(table_.direction_world.Index(x, y));
      const glm::dvec3 direction(table_.direction_world.pixels[pixel]);
      const double cosine = glm::dot(direction, sun_direction_enu);
      const glm::vec3& value = radiance.pixels[pixel];
      if (!(direction.z > 0.0) || !(cosine > std::cos(kAroundSpreadRad)) || !IsMeasured(value)) {
        continue;
      }
      if (cosine > std::cos(kSpreadRad)) {
        area.pixels.push_back(pixel);
      } else {
        for (int c = 0; c < 3; ++c) ring[static_cast<std::size_t>(c)].push_back(value[c]);
      }
    }
  }
  if (ring[0].empty()) return {};
  for (int c = 0; c < 3; ++c) {
    area.background[c] = static_cast<float>(UpperMedianInPlace(ring[static_cast<std::size_t>(c)]));
  }
  glm::dvec3 light(0.0);
  for (const std::uint32_t pixel : area.pixels) {
    light += double{table_.solid_angle_sr.pixels[pixel]} *
             glm::max(glm::dvec3(radiance.pixels[pixel] - area.background), glm::dvec3(0.0));
  }
  if (!(Luminance(light) > kSpreadOverDisc * Luminance(sun_.irradiance_rgb))) return {};
  const double rest = HorizontalLight(radiance) - Luminance(light) * sun_direction_enu.z;
  if (!(Luminance(light) > kLeastShareElsewhere * rest)) return {};
  sun_.irradiance_rgb = light;
  sun_.stddev_rgb = kSpreadError * light;
  return area;
}

double FisheyeSky::HorizontalLight(const RgbImage& radiance) const {
  double light = 0.0;
  for (std::size_t pixel = 0; pixel < radiance.pixels.size(); ++pixel) {
    const float up = table_.direction_world.pixels[pixel].z;
    const glm::vec3& value = radiance.pixels[pixel];
    if (!(up > 0.0f) || !IsMeasured(value)) continue;
    light += double{Luminance(value) * table_.solid_angle_sr.pixels[pixel] * up};
  }
  return light;
}

void FisheyeSky::ReadSky(const RgbImage& radiance, const DiscArea& disc) {
  region_averages_.Average(radiance, disc.pixels, disc.background);
  std::vector<glm::vec3> sky_table(SkyTable::kCells);
  std::vector<std::uint32_t> in_disc = disc.pixels;
  std::sort(in_disc.begin(), in_disc.end());
  const std::span<const glm::dvec3> region_radiance = region_averages_.Radiance();
  for (std::size_t cell = 0; cell < sky_table.size(); ++cell) {
    const std::uint32_t pixel = pixel_of_cell_[cell];
    if (detail_ == SkyDetail::kRegions || pixel == kNone || !IsMeasured(radiance.pixels[pixel])) {
      sky_table[cell] = glm::vec3(region_radiance[region_of_cell_[cell]]);
    } else if (!in_disc.empty() && std::binary_search(in_disc.begin(), in_disc.end(), pixel)) {
      sky_table[cell] = disc.background;
    } else {
      sky_table[cell] = radiance.pixels[pixel];
    }
  }
  if (shape_ != nullptr && sky_table == sky_table_) return;
  sky_table_ = std::move(sky_table);
  sky_irradiance_rgb_ = HorizontalIrradiance(sky_table_);
  shape_ = MakeTableSkyShape("fisheye", sky_table_);
}

}  // namespace pleinair
