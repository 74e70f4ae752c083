#include "calib/response_correction.h"

#include <array>
#include <cmath>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

namespace pleinair {
namespace {

// Light of what is seen of it through lens and veil.
glm::dvec3 Unveiled(const glm::dvec3& seen,
                    const ResponseCorrection& correction,
                    double share_of_corner) {
  const double kept = 1.0 - correction.vignetting * share_of_corner;
  return glm::max(seen / kept - correction.veil_rgb, glm::dvec3(0.0)) * correction.unit_rgb;
}

}  // namespace

LensCircle LensCircle::Of(int width_px, int height_px) {
  const glm::dvec2 centre_px = 0.5 * glm::dvec2(width_px, height_px);
  return {centre_px, glm::length(centre_px)};
}

double LensCircle::ShareOfCorner(const glm::dvec2& place_px) const {
  const glm::dvec2 from_centre = (place_px - centre_px) / radius_px;
  return glm::dot(from_centre, from_centre);
}

glm::dvec3 Saturated(const glm::dvec3& rgb, double saturation) {
  const glm::dvec3 grey((rgb.x + rgb.y + rgb.z) / 3.0);
  return grey + (1.0 + saturation) * (rgb - grey);
}

glm::dvec3 Desaturated(const glm::dvec3& rgb, double saturation) {
  return Saturated(rgb, 1.0 / (1.0 + saturation) - 1.0);
}

bool ResponseCorrection::IsNone() const {
  return exponent == 0.0 && saturation == 0.0 && vignetting == 0.0 && veil_rgb == glm::dvec3(0.0) &&
         unit_rgb == glm::dvec3(1.0);
}

glm::vec3 Recorded(const glm::vec3& light,
                   const ResponseCorrection& correction,
                   double share_of_corner) {
  const double white = correction.white_radiance;
  const glm::dvec3 seen =
      Saturated((glm::dvec3(light) / correction.unit_rgb + correction.veil_rgb) *
                    (1.0 - correction.vignetting * share_of_corner) / white,
                correction.saturation);
  glm::vec3 recorded(0.0f);
  for (int c = 0; c < 3; ++c) {
    if (seen[c] <= 0.0) continue;
    recorded[c] = static_cast<float>(white * std::pow(seen[c], 1.0 + correction.exponent));
  }
  return recorded;
}

glm::dvec3 LightOf(const glm::dvec3& recorded,
                   const ResponseCorrection& correction,
                   double share_of_corner) {
  const double white = correction.white_radiance;
  const glm::dvec3 share_of_white = glm::max(recorded / white, glm::dvec3(0.0));
  const glm::dvec3 seen =
      white * glm::pow(share_of_white, glm::dvec3(1.0 / (1.0 + correction.exponent)));
  return Unveiled(Desaturated(seen, correction.saturation), correction, share_of_corner);
}

void LightOf(const Rgb8Image& codes,
             const ResponseCurve& response,
             const ResponseCorrection& correction,
             RgbImage& light) {
  // A picture has millions of pixels: what depends on the code or the row alone is computed once.
  std::array<std::array<float, 256>, 3> seen_of_code{};
  for (int c = 0; c < 3; ++c) {
    for (std::size_t code = 0; code < 256; ++code) {
      seen_of_code[static_cast<std::size_t>(c)][code] = static_cast<float>(
          correction.white_radiance *
          std::pow(double{response.LinearOfCode(c)[code]}, 1.0 / (1.0 + correction.exponent)));
    }
  }
  const glm::vec3 veil(correction.veil_rgb);
  const glm::vec3 unit(correction.unit_rgb);
  const auto desaturation = static_cast<float>(1.0 / (1.0 + correction.saturation));
  const LensCircle circle = LensCircle::Of(codes.width, codes.height);
  if (light.width != codes.width || light.height != codes.height) {
    light = RgbImage(codes.width, codes.height);
  }
  tbb::parallel_for(0, codes.height, [&](int y) {
    // Shares grow as x squared from the row's middle on.
    const double middle = circle.ShareOfCorner({circle.centre_px.x, y + 0.5});
    const auto kept_in_middle = static_cast<float>(1.0 - correction.vignetting * middle);
    const auto lost_per_px2 =
        static_cast<float>(correction.vignetting / (circle.radius_px * circle.radius_px));
    const float first_px = 0.5f - static_cast<float>(circle.centre_px.x);
    const glm::u8vec3* code = &codes.At(0, y);
    glm::vec3* out = &light.At(0, y);
    for (int x = 0; x < codes.width; ++x, ++code, ++out) {
      const float from_middle_px = first_px + static_cast<float>(x);
      const glm::vec3 seen(
          seen_of_code[0][code->x], seen_of_code[1][code->y], seen_of_code[2][code->z]);
      const float kept = kept_in_middle - lost_per_px2 * from_middle_px * from_middle_px;
      const glm::vec3 grey((seen.x + seen.y + seen.z) * (1.0f / 3.0f));
      const glm::vec3 desaturated = grey + desaturation * (seen - grey);
      *out = glm::max(desaturated / kept - veil, glm::vec3(0.0f)) * unit;
    }
  });
}

}  // namespace pleinair
