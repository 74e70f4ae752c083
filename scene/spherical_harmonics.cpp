#include "scene/spherical_harmonics.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include <glm/common.hpp>

namespace pleinair {
namespace {

void RequireSize(const char* what, int bands, std::size_t size) {
  if (bands < 1 || size != static_cast<std::size_t>(ShCoefficientCount(bands))) {
    throw std::invalid_argument(std::string(what) + " of " + std::to_string(size) +
                                " entries for " + std::to_string(bands) +
                                " bands: expected bands >= 1 and bands * bands entries");
  }
}

}  // namespace

// Normalised Legendre functions divided by sin^m(theta), by the three-term recurrence in l, which
// is stable upwards. That factor is in the real and imaginary part of (x + i y)^m, so that nothing
// is singular at the poles.
void EvaluateShBasis(int bands, const glm::dvec3& direction, std::span<double> values) {
  RequireSize("spherical harmonics", bands, values.size());
  const double z = direction.z;
  double sectoral = std::sqrt(1.0 / (4.0 * std::numbers::pi));
  double cosine = 1.0;  // sin^m(theta) cos(m phi)
  double sine = 0.0;    // sin^m(theta) sin(m phi)
  for (int m = 0; m < bands; ++m) {
    if (m > 0) {
      sectoral *= std::sqrt((2.0 * m + 1.0) / (2.0 * m));
      const double next_cosine = cosine * direction.x - sine * direction.y;
      sine = cosine * direction.y + sine * direction.x;
      cosine = next_cosine;
    }
    double below = 0.0;
    double legendre = sectoral;
    for (int l = m; l < bands; ++l) {
      if (l > m) {
        const double ll = static_cast<double>(l) * l;
        const double mm = static_cast<double>(m) * m;
        const double previous = (l - 1.0) * (l - 1.0);
        const double next =
            std::sqrt((4.0 * ll - 1.0) / (ll - mm)) *
            (z * legendre - std::sqrt((previous - mm) / (4.0 * previous - 1.0)) * below);
        below = legendre;
        legendre = next;
      }
      const auto band = static_cast<std::size_t>(l);
      const auto order = static_cast<std::size_t>(m);
      const std::size_t centre = band * band + band;
      if (m == 0) {
        values[centre] = legendre;
      } else {
        values[centre + order] = std::numbers::sqrt2 * legendre * cosine;
        values[centre - order] = std::numbers::sqrt2 * legendre * sine;
      }
    }
  }
}

std::array<float, kProbeShCoefficients> EvaluateShBasis9(const glm::vec3& direction) {
  const float x = direction.x;
  const float y = direction.y;
  const float z = direction.z;
  return {0.282094792f,      // sqrt(1 / (4 pi))
          0.488602512f * y,  // sqrt(3 / (4 pi))
          0.488602512f * z,
          0.488602512f * x,
          1.092548431f * x * y,  // sqrt(15 / (4 pi))
          1.092548431f * y * z,
          0.315391565f * (3.0f * z * z - 1.0f),  // sqrt(5 / (16 pi))
          1.092548431f * x * z,
          0.546274215f * (x * x - y * y)};  // sqrt(15 / (16 pi))
}

// A_l = 2 pi * integral over t from 0 to 1 of t P_l(t).
double CosineLobeFactor(int band) {
  if (band < 0) {
    throw std::invalid_argument("cosine lobe band " + std::to_string(band) + ": must be >= 0");
  }
  if (band == 1) return 2.0 * std::numbers::pi / 3.0;
  if (band % 2 == 1) return 0.0;
  // The closed form 2 pi (-1)^(l/2-1) / ((l+2)(l-1)) * l! / (2^l (l/2)!^2), its last factor as a
  // product that neither overflows nor cancels.
  double central = 1.0;
  for (int i = 1; i <= band / 2; ++i) central *= (2.0 * i - 1.0) / (2.0 * i);
  const double sign = (band / 2) % 2 == 1 ? 1.0 : -1.0;
  return 2.0 * std::numbers::pi * sign * central / ((band + 2.0) * (band - 1.0));
}

glm::vec3 IrradianceFromSh(const ShRgb& radiance_sh, const glm::vec3& normal) {
  constexpr float kA0 = static_cast<float>(std::numbers::pi);
  constexpr float kA1 = static_cast<float>(2.0 * std::numbers::pi / 3.0);
  constexpr float kA2 = static_cast<float>(std::numbers::pi / 4.0);
  const std::array<float, kProbeShCoefficients> basis = EvaluateShBasis9(normal);
  glm::vec3 irradiance = kA0 * basis[0] * radiance_sh[0];
  for (std::size_t i = 1; i < 4; ++i) irradiance += kA1 * basis[i] * radiance_sh[i];
  for (std::size_t i = 4; i < 9; ++i) irradiance += kA2 * basis[i] * radiance_sh[i];
  return glm::max(irradiance, glm::vec3(0.0f));
}

void WindowSh(ShRgb& radiance_sh) {
  for (std::size_t i = 1; i < 4; ++i) radiance_sh[i] *= kShWindow[1];
  for (std::size_t i = 4; i < 9; ++i) radiance_sh[i] *= kShWindow[2];
}

}  // namespace pleinair
