// Point sets and hashes, with the same bits on every machine and thread count.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace pleinair {

// SplitMix64 (Steele et al. 2014): the next value of a stream whose state is `value`, which then
// grows by kGoldenGamma.
inline constexpr std::uint64_t kGoldenGamma = 0x9e3779b97f4a7c15ull;
inline std::uint64_t HashBits(std::uint64_t value) {
  value += kGoldenGamma;
  value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9ull;
  value = (value ^ (value >> 27)) * 0x94d049bb133111ebull;
  return value ^ (value >> 31);
}

// For unordered containers: of keys that are arrays of 32-bit words.
struct HashOfWords {
  template <class Word, std::size_t kCount>
  std::size_t operator()(const std::array<Word, kCount>& key) const {
    std::uint64_t hash = kGoldenGamma;
    for (const Word word : key) {
      hash = (hash ^ static_cast<std::uint32_t>(word)) * 0xff51afd7ed558ccdull;
      hash ^= hash >> 32;
    }
    return hash;
  }
};

// A number in [0, 1).
inline double UnitFromHash(std::uint64_t bits) {
  return static_cast<double>(bits >> 11) * 0x1.0p-53;
}

// The fractional part, in [0, 1).
inline double Fraction(double value) { return value - std::floor(value); }

// Two numbers in [0, 1) that turn a point set for one receiver (the rotation of
// Cranley and Patterson 1976).
inline glm::dvec2 RotationOf(std::uint64_t seed, std::uint64_t receiver) {
  const std::uint64_t first = HashBits(HashBits(seed) ^ receiver);
  return {UnitFromHash(first), UnitFromHash(HashBits(first))};
}

// Point i of n of the rotated Fibonacci lattice on the unit square.
inline glm::dvec2 FibonacciPoint(int i, int n, const glm::dvec2& rotation) {
  return {Fraction((i + 0.5) / n + rotation.x),
          Fraction(i * (std::numbers::phi - 1.0) + rotation.y)};
}

// Point i of the R2 sequence (Roberts 2018: powers of the inverse plastic number).
inline glm::dvec2 R2Point(int i, const glm::dvec2& rotation) {
  return {Fraction(rotation.x + i * 0.7548776662466927),
          Fraction(rotation.y + i * 0.5698402909980532)};
}

// Orthonormal frame around a unit normal (Duff et al. 2017), and a direction of it.
struct NormalFrame {
  explicit NormalFrame(const glm::vec3& unit_normal) : normal(unit_normal) {
    const float sign = std::copysign(1.0f, normal.z);
    const float a = -1.0f / (sign + normal.z);
    const float b = normal.x * normal.y * a;
    tangent = glm::vec3(1.0f + sign * normal.x * normal.x * a, sign * b, -sign * normal.x);
    bitangent = glm::vec3(b, sign + normal.y * normal.y * a, -normal.y);
  }
  // Cosine-distributed direction of a point of the unit square: pdf cos / pi.
  glm::vec3 CosineDirection(const glm::dvec2& point) const {
    const double radius = std::sqrt(point.x);
    const double angle = 2.0 * std::numbers::pi * point.y;
    const auto x = static_cast<float>(radius * std::cos(angle));
    const auto y = static_cast<float>(radius * std::sin(angle));
    const auto z = static_cast<float>(std::sqrt(1.0 - point.x));
    return glm::normalize(x * tangent + y * bitangent + z * normal);
  }

  glm::vec3 tangent;
  glm::vec3 bitangent;
  glm::vec3 normal;
};

// Uniform point of a triangle for a point of the unit square.
inline glm::vec3 TrianglePoint(const glm::vec3& a,
                               const glm::vec3& b,
                               const glm::vec3& c,
                               glm::dvec2 point) {
  // Folding the square's upper half keeps the low discrepancy.
  if (point.x + point.y > 1.0) point = glm::dvec2(1.0) - point;
  return a + static_cast<float>(point.x) * (b - a) + static_cast<float>(point.y) * (c - a);
}

}  // namespace pleinair
