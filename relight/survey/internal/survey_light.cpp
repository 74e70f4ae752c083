#include "relight/survey/internal/survey_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "relight/survey/internal/map_pixels.h"
#include "relight/survey/internal/sky_completion.h"
#include "relight/survey/internal/survey_clear_sky.h"
#include "scene/angle_between.h"
#include "scene/lat_long.h"
#include "scene/lighting.h"
#include "scene/sky_shape.h"
#include "scene/sun_in_picture.h"
#include "scene/upper_median.h"
#include "sunmodel/clear_sky.h"
#include "sunmodel/site.h"

namespace pleinair {
namespace {

// How far the map may be turned against the sun's computed place and still have its disc found at
// once: half a degree is what a carefully levelled tripod gives.
constexpr double kPointingRad = 0.5 * std::numbers::pi / 180.0;
// A brighter spot within this of the computed place is treated as the sun all the same.
constexpr double kFollowRad = 5.0 * std::numbers::pi / 180.0;
// Error of an integrated disc: pixel edges, limb and aureole (the sequences' own check: 0.1 %).
constexpr double kDiscRelativeStddev = 0.01;
// Error of the clear-sky model's beam. Cut out of four real panoramas, discs are overestimated by
// 0.5 to 3 times, root mean square of the logarithm 0.7; of one that is hidden, as little is known.
constexpr double kClearBeamRelativeStddev = 0.6;

LatLongSize SizeOf(const RgbImage& image) { return {image.width, image.height}; }

// Median and its robust spread, per channel.
struct Background {
  glm::dvec3 median{0.0};
  glm::dvec3 stddev{0.0};
};

Background BackgroundOf(const RgbImage& map, const std::vector<MapPixel>& pixels) {
  Background background;
  for (int channel = 0; channel < 3; ++channel) {
    std::vector<double> values;
    values.reserve(pixels.size());
    for (const MapPixel& pixel : pixels) values.push_back(map.At(pixel.x, pixel.y)[channel]);
    background.median[channel] = UpperMedian(values);
    for (double& value : values) value = std::abs(value - background.median[channel]);
    background.stddev[channel] = 1.4826 * UpperMedian(values);  // Factor for a normal distribution.
  }
  return background;
}

// The most pixels that a disc of this radius at this elevation can cover wholly, over all places of
// its centre within a pixel.
int MostFullyCovered(double radius_rad, double elevation_rad, LatLongSize size) {
  const double tall = std::numbers::pi / size.height;
  const double wide = 2.0 * std::numbers::pi / size.width * std::cos(elevation_rad);
  const int reach_x = static_cast<int>(radius_rad / std::max(wide, 1e-9)) + 2;
  const int reach_y = static_cast<int>(radius_rad / tall) + 2;
  int most = 0;
  for (const double shift_x : {0.0, 0.25, 0.5, 0.75}) {
    for (const double shift_y : {0.0, 0.25, 0.5, 0.75}) {
      int covered = 0;
      for (int y = -reach_y; y < reach_y; ++y) {
        for (int x = -std::min(reach_x, size.width); x < std::min(reach_x, size.width); ++x) {
          const double far_x = std::max(std::abs(x + shift_x), std::abs(x + 1 + shift_x)) * wide;
          const double far_y = std::max(std::abs(y + shift_y), std::abs(y + 1 + shift_y)) * tall;
          covered += std::hypot(far_x, far_y) <= radius_rad;
        }
      }
      most = std::max(most, covered);
    }
  }
  return most;
}

constexpr double kAboveTheSky = 1.5;  // An evenly white sky has equal maxima, too.

// A disc that the camera could not hold has a flat top wider than the disc itself: an unclipped
// disc's pixels are equal only where it covers them fully.
bool HasFlatTop(const RgbImage& map,
                const std::vector<MapPixel>& window,
                const glm::dvec3& whole_sky_median,
                int most_fully_covered) {
  constexpr float kHalfMax = 65504.0f;  // Largest half float.
  // In the blue of a red evening, a step of a shared-exponent file is several per cent: steps are
  // those of the pixel's largest channel.
  for (int channel = 0; channel < 3; ++channel) {
    float peak = 0.0f;
    float largest_at_peak = 0.0f;
    for (const MapPixel& pixel : window) {
      const glm::vec3& value = map.At(pixel.x, pixel.y);
      if (value[channel] < peak) continue;
      const float largest = std::max({value.x, value.y, value.z});
      largest_at_peak = value[channel] > peak ? largest : std::max(largest, largest_at_peak);
      peak = value[channel];
    }
    int equal = 0;
    int almost = 0;
    for (const MapPixel& pixel : window) {
      const float value = map.At(pixel.x, pixel.y)[channel];
      equal += value >= peak * (1.0 - kOneLevel);
      almost += value >= peak - kFewSteps * largest_at_peak;
    }
    if (!(peak > kAboveTheSky * whole_sky_median[channel])) continue;
    if (peak == kHalfMax) return true;
    if (equal > std::max(1, most_fully_covered) && almost < 2 * equal) return true;
  }
  return false;
}

// Where a disc is within one pixel, its top is a single one: cut at one limit it is as bright in
// all channels. So is a white sun, which holds the light of one, though.
bool IsCutToOneLevel(const RgbImage& map,
                     const std::vector<MapPixel>& window,
                     const glm::dvec3& whole_sky_median,
                     const glm::dvec3& disc_rgb,
                     const glm::dvec3& clear_beam_rgb) {
  if (!(MeanOf(disc_rgb) < 0.5 * MeanOf(clear_beam_rgb))) return false;
  glm::vec3 peak(0.0f);
  for (const MapPixel& pixel : window) peak = glm::max(peak, map.At(pixel.x, pixel.y));
  const float largest = std::max({peak.x, peak.y, peak.z});
  const float smallest = std::min({peak.x, peak.y, peak.z});
  const auto bright = std::count_if(window.begin(), window.end(), [&](const MapPixel& pixel) {
    return map.At(pixel.x, pixel.y).y > 0.5f * peak.y;
  });
  constexpr int kMostTouched = 4;
  return bright <= kMostTouched && smallest >= largest * (1.0 - kOneLevel) &&
         largest >
             kAboveTheSky * std::max({whole_sky_median.x, whole_sky_median.y, whole_sky_median.z});
}

struct DiscPlace {
  glm::dvec3 direction{0.0, 0.0, 1.0};
  double moved_rad = 0.0;
};

// The computed direction; the centre of a much brighter spot around or near it where that is
// farther off than the map's pixels resolve.
DiscPlace FindDisc(const RgbImage& map,
                   const Gray8Image& shows_sky,
                   const glm::dvec3& computed,
                   double window_rad) {
  const LatLongSize size = SizeOf(map);
  double inside = 0.0;
  double outside = 0.0;
  double peak = 0.0;
  MapPixel brightest;
  std::vector<double> around;
  for (const MapPixel& pixel : MapPixelsAround(computed, std::max(kFollowRad, window_rad), size)) {
    const double value = MeanOf(glm::dvec3(map.At(pixel.x, pixel.y)));
    const bool sky = shows_sky.At(pixel.x, pixel.y) != 0;
    (pixel.angle_rad <= window_rad ? inside : outside) =
        std::max(pixel.angle_rad <= window_rad ? inside : outside, sky ? value : 0.0);
    if (sky) around.push_back(value);
    if (sky && value > peak) {
      peak = value;
      brightest = pixel;
    }
  }
  if (!(peak > kMuchBrighterThanSky * UpperMedian(around))) return {computed, 0.0};
  const bool inside_is_it = !(outside > kMuchBrighterThanSky * inside);
  const glm::dvec3 spot =
      inside_is_it ? computed : MapPixelDirection(brightest.x, brightest.y, size);
  const double top = inside_is_it ? inside : outside;
  glm::dvec3 centre(0.0);
  for (const MapPixel& pixel : MapPixelsAround(spot, window_rad, size)) {
    const double value = MeanOf(glm::dvec3(map.At(pixel.x, pixel.y)));
    if (value > 0.01 * top) {
      centre += value * LatLongPixelSolidAngleSr(pixel.y, size) *
                MapPixelDirection(pixel.x, pixel.y, size);
    }
  }
  if (!(glm::length(centre) > 0.0)) return {computed, 0.0};
  centre = glm::normalize(centre);
  const double moved_rad = AngleBetweenRad(computed, centre);
  if (moved_rad < std::numbers::pi / size.height) return {computed, 0.0};
  return {centre, moved_rad};
}

std::vector<double> SkyValues(const RgbImage& map, const Gray8Image& shows_sky, int channel) {
  std::vector<double> values;
  for (std::size_t i = 0; i < map.pixels.size(); ++i) {
    if (shows_sky.pixels[i] != 0) values.push_back(map.pixels[i][channel]);
  }
  return values;
}

double Degrees(double rad) { return rad * 180.0 / std::numbers::pi; }

std::string TwoDecimals(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.2f", value);
  return text.data();
}

// Cuts the sky around a disc that outshines it down to what is farther off; returns what was above.
glm::dvec3 TakeOutGlare(const RgbImage& map,
                        const Gray8Image& shows_sky,
                        const std::vector<MapPixel>& window,
                        const Background& background,
                        SurveyLight& light) {
  double peak = 0.0;
  for (const MapPixel& pixel : window) {
    peak = std::max(peak, MeanOf(glm::dvec3(map.At(pixel.x, pixel.y))));
  }
  glm::dvec3 glare(0.0);
  if (!(peak > kMuchBrighterThanSky * MeanOf(background.median))) return glare;
  std::vector<MapPixel> near;
  std::vector<MapPixel> far;
  for (const MapPixel& pixel :
       MapPixelsAround(light.sun_direction_enu, kAroundGlareRad, SizeOf(map))) {
    if (shows_sky.At(pixel.x, pixel.y) == 0) continue;
    (pixel.angle_rad <= kGlareRad ? near : far).push_back(pixel);
  }
  if (far.empty()) return glare;
  const glm::dvec3 most = kMostAureole * BackgroundOf(map, far).median;
  for (const MapPixel& pixel : near) {
    glm::vec3& sky = light.sky_radiance.At(pixel.x, pixel.y);
    glare += LatLongPixelSolidAngleSr(pixel.y, SizeOf(map)) *
             glm::max(glm::dvec3(sky) - most, glm::dvec3(0.0));
    sky = glm::min(sky, glm::vec3(most));
  }
  return glare;
}

// Measures the disc at light.sun_direction_enu over the sky around it, and fills the sky there with
// that. Returns the pixels that may hold it.
std::vector<MapPixel> TakeOutDisc(const SurveyMap& map,
                                  const Gray8Image& shows_sky,
                                  double window_rad,
                                  SurveyLight& light) {
  const LatLongSize size = SizeOf(map.radiance);
  std::vector<MapPixel> window;
  std::vector<MapPixel> ring;
  std::vector<MapPixel> ring_of_all;
  for (const MapPixel& pixel : MapPixelsAround(light.sun_direction_enu, 2.0 * window_rad, size)) {
    if (pixel.angle_rad <= window_rad) {
      window.push_back(pixel);
    } else {
      ring_of_all.push_back(pixel);
      if (shows_sky.At(pixel.x, pixel.y) != 0) ring.push_back(pixel);
    }
  }
  // Where surfaces are all around, the disc would still have to outshine them.
  const Background background = BackgroundOf(map.radiance, ring.empty() ? ring_of_all : ring);
  glm::dvec3 disc(0.0);
  double window_sr = 0.0;
  for (const MapPixel& pixel : window) {
    const double solid_angle_sr = LatLongPixelSolidAngleSr(pixel.y, size);
    // The scene's surfaces are not sky: only what outshines the sky there counts.
    const glm::dvec3 excess = glm::dvec3(map.radiance.At(pixel.x, pixel.y)) - background.median;
    const bool sky = shows_sky.At(pixel.x, pixel.y) != 0;
    disc += solid_angle_sr * (sky ? excess : glm::max(excess, glm::dvec3(0.0)));
    window_sr += solid_angle_sr;
    if (sky) light.sky_radiance.At(pixel.x, pixel.y) = glm::vec3(background.median);
  }
  const glm::dvec3 glare = TakeOutGlare(map.radiance, shows_sky, window, background, light);
  light.sun_irradiance_rgb = glm::max(disc + glare, glm::dvec3(0.0));
  // Half the glare may be a bright aureole. The sky behind the disc may differ from the ring's
  // median by the ring's own spread.
  light.sun_irradiance_stddev_rgb =
      kDiscRelativeStddev * light.sun_irradiance_rgb + 0.5 * glare + window_sr * background.stddev;
  return window;
}

// What the map's sky says of a beam that it does not show. Clouds add to the sky's light, and haze
// does so at the beam's cost.
void MeasureClearBeam(const SurveyMap& map, const Gray8Image& shows_sky, SurveyLight& light) {
  // Of the logarithm of what the sky's haze makes of beam over diffuse. The sky's shape gives
  // ln(depth + 0.03) to 0.65 (four maps whose disc gives it, too); clear days differ by 0.4 to 0.5.
  constexpr double kHazeTrust = 0.3;
  light.clear_sky_beam_rgb = light.sky_irradiance_rgb * map.clear_sky_beam_to_diffuse_rgb;
  const auto clear = MeasureClearSky(map.radiance, shows_sky, light.sun_direction_enu);
  if (!clear) return;
  light.aerosol_optical_depth_500nm = clear->aerosol_optical_depth_500nm;
  if (!clear->irradiance_rgb) return;
  const double elevation_rad = std::asin(std::clamp(light.sun_direction_enu.z, -1.0, 1.0));
  const auto beam_to_diffuse = [&](double depth) {
    const ClearSkyIrradiance sky =
        ComputeClearSky({}, elevation_rad, {.aerosol_optical_depth_500nm = depth});
    return sky.beam_rgb / sky.diffuse_rgb;
  };
  const glm::dvec3 standard = beam_to_diffuse(kStandardAerosolDepth500nm);
  if (!(std::min({standard.x, standard.y, standard.z}) > 0.0)) return;  // On the horizon.
  // A low sun's beam would follow the haze by any factor, though that is not known so well. This is
  // less than one of the deviations that the beam is stated with (0.55 in the logarithm).
  constexpr double kMostByHaze = 1.6;
  const glm::dvec3 by_haze =
      glm::clamp(glm::pow(beam_to_diffuse(clear->aerosol_optical_depth_500nm) / standard,
                          glm::dvec3(kHazeTrust)),
                 glm::dvec3(1.0 / kMostByHaze),
                 glm::dvec3(kMostByHaze));
  light.clear_sky_beam_rgb = *clear->irradiance_rgb * map.clear_sky_beam_to_diffuse_rgb * by_haze;
}

bool IsClipped(const SurveyMap& map,
               const Gray8Image& shows_sky,
               const std::vector<MapPixel>& window,
               const SurveyLight& light) {
  glm::dvec3 whole_sky_median(0.0);
  for (int channel = 0; channel < 3; ++channel) {
    whole_sky_median[channel] = UpperMedian(SkyValues(map.radiance, shows_sky, channel));
  }
  const double elevation_rad = std::asin(std::clamp(light.sun_direction_enu.z, -1.0, 1.0));
  const int most_fully_covered =
      MostFullyCovered(map.sun_angular_radius_rad, elevation_rad, SizeOf(map.radiance));
  return HasFlatTop(map.radiance, window, whole_sky_median, most_fully_covered) ||
         IsCutToOneLevel(map.radiance,
                         window,
                         whole_sky_median,
                         light.sun_irradiance_rgb,
                         light.clear_sky_beam_rgb);
}

}  // namespace

SurveyLight MeasureSurveyLight(const SurveyMap& map, const Gray8Image& shows_sky, double sun_seen) {
  SurveyLight light;
  const LatLongSize size = SizeOf(map.radiance);
  light.sky_radiance = map.radiance;

  const double pixel_rad = std::numbers::pi / size.height;
  const double window_rad = map.sun_angular_radius_rad + kPointingRad + 1.5 * pixel_rad;
  const glm::dvec3 computed = glm::normalize(map.sun_direction_enu);
  light.sun_direction_enu = computed;
  const bool sun_up = computed.z > -std::sin(map.sun_angular_radius_rad);
  std::vector<MapPixel> window;
  if (!sun_up) {
    light.sun_origin = SunOrigin::kNone;
    light.notes.emplace_back("survey map: no sun above the horizon");
  } else {
    const DiscPlace place = FindDisc(map.radiance, shows_sky, computed, window_rad);
    light.sun_direction_enu = place.direction;
    if (place.moved_rad > 0.0) {
      light.notes.push_back("survey map: the sun's disc stands " +
                            TwoDecimals(Degrees(place.moved_rad)) +
                            " deg from its computed place; the map's place is used");
    }
    window = TakeOutDisc(map, shows_sky, window_rad, light);
  }

  CompleteSky(shows_sky, light.sky_radiance);
  light.sky_irradiance_rgb = HorizontalIrradiance(light.sky_radiance);
  if (sun_up) {
    MeasureClearBeam(map, shows_sky, light);
    constexpr double kSignificant = 5.0;
    if (IsClipped(map, shows_sky, window, light)) {
      light.sun_clipped = true;
      light.notes.emplace_back("survey map: the sun's disc is clipped");
    } else if (sun_seen < 0.5 && !(MeanOf(light.sun_irradiance_rgb) >
                                   kSignificant * MeanOf(light.sun_irradiance_stddev_rgb))) {
      light.sun_clipped = true;
      light.sun_hidden = true;
      light.notes.emplace_back("survey map: the sun's disc is not in view");
    }
  }
  if (light.sun_clipped) {
    light.sun_origin = SunOrigin::kClearSky;
    light.sun_irradiance_rgb = light.clear_sky_beam_rgb;
    light.sun_irradiance_stddev_rgb = kClearBeamRelativeStddev * light.clear_sky_beam_rgb;
  }
  if (!(MeanOf(light.sky_irradiance_rgb) > 0.0)) {
    light.notes.emplace_back("survey map: it shows no light from the sky");
  }
  return light;
}

}  // namespace pleinair
