#include "pipeline/light_forecast.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

#include "calib/camera_noise.h"
#include "calib/response.h"
#include "datasets/degradation.h"
#include "datasets/picture_frame.h"
#include "pipeline/internal/observation.h"
#include "scene/lighting.h"
#include "scene/low_discrepancy.h"

namespace pleinair {
namespace {

// As SampleSet leaves out surfaces that graze the sun, where there are others.
constexpr double kLeastFacing = 0.1;
// Automatic exposure puts all but the brightest hundredth of the surfaces below this signal.
constexpr double kExposedTo = 0.9;
constexpr double kExposedShare = 0.99;

// The same view in fewer pixels; integer coordinates stay pixels' centres.
Camera AtMostAsWideAs(Camera camera, int width_px) {
  CameraIntrinsics& lens = camera.intrinsics;
  if (lens.width_px <= width_px) return camera;
  const double scale = double(width_px) / lens.width_px;
  lens.width_px = width_px;
  lens.height_px = std::max(1, static_cast<int>(std::lround(scale * lens.height_px)));
  lens.fx_px *= scale;
  lens.fy_px *= scale;
  lens.cx_px = (lens.cx_px + 0.5) * scale - 0.5;
  lens.cy_px = (lens.cy_px + 0.5) * scale - 0.5;
  return camera;
}

// Surfaces are patchier than what is known of their albedos: by that share (standard deviation),
// from one block of pixels to the next.
double Patchiness(std::uint64_t seed, std::size_t x, std::size_t y) {
  constexpr double kRelativeStddev = 0.05;
  constexpr std::size_t kBlockPx = 8;
  const std::uint64_t block = (std::uint64_t{y / kBlockPx} << 32) | (x / kBlockPx);
  const double unit = UnitFromHash(HashBits(HashBits(seed) ^ block));
  return 1.0 + kRelativeStddev * std::sqrt(12.0) * (unit - 0.5);
}

std::size_t ClearShapeOf(const SurfaceView& view) {
  const auto& names = view.sky_shape_names;
  const auto found = std::find(names.begin(), names.end(), NameOf(SkyShapeKind::kClear));
  return found == names.end() ? 0 : static_cast<std::size_t>(found - names.begin());
}

void CountShares(const SurfaceView& view, LightForecast& forecast) {
  std::size_t lit = 0;
  std::size_t shaded = 0;
  for (std::size_t i = 0; i < view.region.pixels.size(); ++i) {
    if (view.may_be_sampled.pixels[i] == 0) continue;
    const double facing =
        glm::dot(glm::dvec3(view.normal_world.pixels[i]), forecast.sun.direction_enu);
    const bool is_visible = view.sun_visibility.pixels[i] >= 0.5f;
    if (is_visible && facing >= kLeastFacing) ++lit;
    if (!is_visible || facing <= 0.0) ++shaded;
  }
  const auto pixels = static_cast<double>(view.region.pixels.size());
  forecast.lit_share = static_cast<double>(lit) / pixels;
  forecast.shaded_share = static_cast<double>(shaded) / pixels;
}

}  // namespace

LightForecaster::LightForecaster(const PreparedScene& scene,
                                 const Site& site,
                                 const Camera& camera,
                                 const LightForecastOptions& options)
    : scene_(scene),
      site_(site),
      options_(options),
      clear_sky_(site, scene.survey ? &scene.survey->light : nullptr),
      view_builder_(scene, options.view) {
  constexpr int kLeastWidthPx = 16;
  if (options.most_width_px < kLeastWidthPx) {
    throw std::invalid_argument("most_width_px " + std::to_string(options.most_width_px) +
                                ": expected at least " + std::to_string(kLeastWidthPx));
  }
  options_.light.aerosol_optical_depth_500nm = scene.aerosol_optical_depth_500nm;
  options_.light.Validate();
  camera_ = AtMostAsWideAs(camera, options.most_width_px);
}

Rgb8Image LightForecaster::PictureOf(const SurfaceView& view,
                                     const ClearSkyExpectation& light,
                                     const glm::dvec3& sun_direction_enu,
                                     double& exposure) const {
  const std::size_t clear = ClearShapeOf(view);
  const glm::vec3 sun(light.beam_rgb);
  const glm::vec3 sky(light.diffuse_rgb);
  const auto per_pi = static_cast<float>(std::numbers::inv_pi);
  RgbImage radiance(view.Width(), view.Height());
  std::vector<float> brightest;
  for (std::size_t i = 0; i < radiance.pixels.size(); ++i) {
    glm::vec3& pixel = radiance.pixels[i];
    if (view.region.pixels[i] == SurfaceView::kNoRegion) {
      pixel = sky * per_pi;  // The mean radiance of the sky: no sample is taken there.
      continue;
    }
    const auto width = static_cast<std::size_t>(view.Width());
    const auto patch = static_cast<float>(Patchiness(options_.seed, i % width, i / width));
    pixel =
        view.albedo_rgb.pixels[i] * (patch * per_pi) *
        (sky * view.sky_response[clear].pixels[i] + sun * SunResponse(view, i, sun_direction_enu));
    brightest.push_back(std::max({pixel.x, pixel.y, pixel.z}));
  }
  exposure = 1.0;
  if (!brightest.empty()) {
    const auto at = brightest.begin() +
                    static_cast<std::ptrdiff_t>(kExposedShare * double(brightest.size() - 1));
    std::nth_element(brightest.begin(), at, brightest.end());
    if (*at > 0.0f) exposure = kExposedTo / *at;
  }
  return Degradation({}, options_.seed).Picture(radiance, exposure, 0);
}

LightForecast LightForecaster::At(UtcTime time) {
  LightForecast forecast;
  forecast.time = time;
  forecast.sun = SunOverSite(site_, time);
  if (!(forecast.sun.direction_enu.z > 0.0)) return forecast;

  Frame frame;
  frame.time = time;
  frame.camera = camera_;
  frame.units = options_.units;
  // A source of its own: hours know nothing of each other.
  const std::unique_ptr<LightingSource> source = MakeOutdoorLightingSource(options_.light);
  const auto basis = source->BasisFor(frame, forecast.sun);
  if (!basis) {
    forecast.estimate = tl::unexpected(basis.error());
    return forecast;
  }
  const SurfaceView& view = view_builder_.Update(
      camera_, forecast.sun.direction_enu, forecast.sun.angular_radius_rad, *basis, {});
  CountShares(view, forecast);

  const ClearSkyExpectation light = clear_sky_.At(forecast.sun.direction_enu);
  forecast.sun_irradiance_rgb = light.beam_rgb;
  forecast.sky_irradiance_rgb = light.diffuse_rgb;
  double exposure = 1.0;
  forecast.picture = PictureOf(view, light, forecast.sun.direction_enu, exposure);
  const bool exposure_is_known = options_.units != LightUnits::kRelativePerFrame;
  if (exposure_is_known) frame.exposure = exposure;
  const ResponseCurve response = ResponseCurve::Srgb();
  SetCodes(forecast.picture, response, std::make_shared<const SignalNoise>(response), frame);
  forecast.estimate = source->Estimate(Observe(scene_, clear_sky_, frame, view, forecast.sun));
  if (!*forecast.estimate) return forecast;

  const Lighting& lighting = (*forecast.estimate)->lighting;
  const double unit = exposure_is_known ? 1.0 : exposure;
  const double sun = unit * MeanOf(light.beam_rgb);
  const double sky = unit * MeanOf(light.diffuse_rgb);
  if (sun > 0.0) forecast.sun_relative_stddev = MeanSunIrradiance(lighting).stddev / sun;
  if (sky > 0.0) forecast.sky_relative_stddev = MeanSkyIrradiance(lighting).stddev / sky;
  return forecast;
}

}  // namespace pleinair
