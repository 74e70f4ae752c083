#include "relight/volume/environment.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include <tbb/parallel_for.h>
#include <glm/ext/scalar_constants.hpp>

#include "relight/volume/basis_sum.h"
#include "scene/lat_long.h"
#include "scene/surface_view.h"

namespace pleinair {
namespace {

constexpr float kInversePi = 1.0f / glm::pi<float>();

template <typename Pixel>
void RequireSize(const Image<Pixel>& image, const SurfaceView& view, const std::string& name) {
  const std::size_t expected =
      static_cast<std::size_t>(view.Width()) * static_cast<std::size_t>(view.Height());
  if (image.width == view.Width() && image.height == view.Height() &&
      image.pixels.size() == expected) {
    return;
  }
  throw std::invalid_argument("survey view: " + name + " is " + std::to_string(image.width) + "x" +
                              std::to_string(image.height) + ", expected the map's " +
                              std::to_string(view.Width()) + "x" + std::to_string(view.Height()));
}

// One row after the other in parallel; `radiance_at` is asked for each pixel of the map.
template <typename RadianceAt>
EnvironmentBasis FillMap(const SurfaceView& view, const RadianceAt& radiance_at) {
  EnvironmentBasis basis{RgbImage(view.Width(), view.Height())};
  tbb::parallel_for(0, view.Height(), [&](int y) {
    for (int x = 0; x < view.Width(); ++x) basis.radiance.At(x, y) = radiance_at(x, y);
  });
  return basis;
}

}  // namespace

EnvironmentBasis EnvironmentOfSun(const Survey& survey, const glm::dvec3& sun_direction_enu) {
  const SurfaceView& view = survey.view;
  RequireSize(view.region, view, "region");
  RequireSize(view.normal_world, view, "normal_world");
  RequireSize(view.albedo_rgb, view, "albedo_rgb");
  RequireSize(view.sun_visibility, view, "sun_visibility");
  RequireSize(view.sun_bounce, view, "sun_bounce");
  if (!(std::isfinite(sun_direction_enu.x) && std::isfinite(sun_direction_enu.y) &&
        std::isfinite(sun_direction_enu.z))) {
    throw std::invalid_argument("sun_direction_enu is not finite, expected a unit vector");
  }
  return FillMap(view, [&](int x, int y) {
    const std::size_t pixel = view.region.Index(x, y);
    if (view.region.pixels[pixel] == SurfaceView::kNoRegion) return glm::vec3(0.0f);
    return kInversePi * view.albedo_rgb.pixels[pixel] * SunResponse(view, pixel, sun_direction_enu);
  });
}

EnvironmentBasis EnvironmentOfSky(const Survey& survey,
                                  std::size_t sky_index,
                                  const SkyShape& shape) {
  const SurfaceView& view = survey.view;
  RequireSize(view.region, view, "region");
  RequireSize(view.albedo_rgb, view, "albedo_rgb");
  if (sky_index >= view.sky_response.size()) {
    throw std::invalid_argument("sky_index " + std::to_string(sky_index) +
                                ": the survey view has sky_response for " +
                                std::to_string(view.sky_response.size()) + " sky shapes");
  }
  const Image<glm::vec3>& response = view.sky_response[sky_index];
  RequireSize(response, view, "sky_response[" + std::to_string(sky_index) + "]");
  const LatLongSize size{view.Width(), view.Height()};
  return FillMap(view, [&](int x, int y) {
    const std::size_t pixel = view.region.Index(x, y);
    if (view.region.pixels[pixel] != SurfaceView::kNoRegion) {
      return kInversePi * view.albedo_rgb.pixels[pixel] * response.pixels[pixel];
    }
    return shape.Radiance(glm::vec3(DirectionFromLatLong({x + 0.5, y + 0.5}, size)));
  });
}

void SynthesiseEnvironment(std::span<const EnvironmentBasis> basis,
                           const Lighting& lighting,
                           RgbImage& environment) {
  constexpr std::string_view kWhat = "environment map";
  const std::vector<glm::vec3> weights = internal::BasisWeights(lighting, basis.size(), kWhat);
  const RgbImage& first = basis.front().radiance;
  std::vector<std::span<const glm::vec3>> terms;
  for (const EnvironmentBasis& light : basis) {
    if (light.radiance.width != first.width || light.radiance.height != first.height ||
        light.radiance.pixels.size() != first.pixels.size()) {
      throw std::invalid_argument(
          "environment map: a basis light's map is " + std::to_string(light.radiance.width) + "x" +
          std::to_string(light.radiance.height) + ", the first one's " +
          std::to_string(first.width) + "x" + std::to_string(first.height) + "; expected one size");
    }
    terms.emplace_back(light.radiance.pixels);
  }
  environment.width = first.width;
  environment.height = first.height;
  environment.pixels.resize(first.pixels.size());
  internal::WeightedSum(terms, weights, environment.pixels, kWhat);
}

}  // namespace pleinair
