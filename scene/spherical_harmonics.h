// Real spherical harmonics, orthonormal, in the order (l, m) = (0,0), (1,-1), (1,0), (1,1), (2,-2)
// ... with Y(1,-1) ~ y, Y(1,0) ~ z, Y(1,1) ~ x (no Condon-Shortley sign).
#pragma once

#include <array>
#include <span>

#include <glm/vec3.hpp>

namespace pleinair {

constexpr int ShCoefficientCount(int bands) { return bands * bands; }
inline constexpr int kProbeShBands = 3;
inline constexpr int kProbeShCoefficients = ShCoefficientCount(kProbeShBands);

// Writes the bands * bands basis values at a unit direction. Any bands >= 1.
// Throws std::invalid_argument when `values` has another size.
void EvaluateShBasis(int bands, const glm::dvec3& direction, std::span<double> values);

// The same for the probes' three bands, without checks: for inner loops.
std::array<float, kProbeShCoefficients> EvaluateShBasis9(const glm::vec3& direction);

// A_l: the factor that turns band l of incident radiance into band l of irradiance
// (Ramamoorthi and Hanrahan 2001, equation 8): pi, 2 pi/3, pi/4, 0, ...
double CosineLobeFactor(int band);

// Incident radiance as SH coefficients, RGB.
using ShRgb = std::array<glm::vec3, kProbeShCoefficients>;

// Irradiance on a surface with unit `normal`, from three bands; negative lobes of a single bright
// source are clamped at 0 per channel.
glm::vec3 IrradianceFromSh(const ShRgb& radiance_sh, const glm::vec3& normal);

// Scales band l by kShWindow[l], so that the irradiance of three bands is never negative.
//
// With weights w1, w2 a source of normal irradiance 1 lights a surface at angle theta, t =
// cos(theta), with 1/4 + w1 t/2 + w2 (5/32) (3 t^2 - 1). That stays >= 0 for w1^2 <= 15/8 w2 -
// 75/64 w2^2. The largest w1 is at w2 = 4/5, and leaves the square (1 + sqrt(3) t)^2 / 8, so any
// sum of sources is >= 0 too. A source's own direction keeps 93 % of its irradiance. (Hann's and
// Lanczos' windows do not get there at any width.)
inline constexpr std::array<float, kProbeShBands> kShWindow = {1.0f, 0.866025404f, 0.8f};
void WindowSh(ShRgb& radiance_sh);

}  // namespace pleinair
