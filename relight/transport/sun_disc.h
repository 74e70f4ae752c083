// The sun's disc as rays: how much of it a point sees.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/transport/transport.h"

namespace pleinair {

// Directions spread over the disc, computed once for many points. Immutable, safe from any thread.
class SunDisc {
 public:
  // Throws std::invalid_argument for a direction without length, a radius outside [0, pi/2) or
  // samples < 1.
  SunDisc(const glm::dvec3& direction_enu, double angular_radius_rad, int samples);

  // Share of the disc seen. Five rays, the centre and four of the rim, decide where they agree (a
  // straight edge may then still hide 9 % of the disc); else all samples are cast. With one sample
  // the centre decides alone. What is below the horizon, or behind the surface, is not seen.
  float Visibility(const RayCaster& caster, const Receiver& receiver) const;
  // The same for many at once, faster where neighbours in the list are neighbours in the scene.
  std::vector<float> Visibility(const RayCaster& caster, std::span<const Receiver> receivers) const;
  // Mean over the sample directions of visible * cosine, each cast from another of `points`.
  float MeanIrradiance(const RayCaster& caster, std::span<const Receiver> points) const;
  const glm::vec3& Direction() const { return centre_; }
  // Direction to a point of the disc: `radius` as a share of the disc's own.
  glm::vec3 DirectionTo(double radius, double angle_rad) const;
  const std::array<glm::vec3, 4>& Rim() const { return rim_; }
  // Directions to equal parts of the disc.
  const std::vector<glm::vec3>& Samples() const { return samples_; }

 private:
  float ShareOfSamples(const RayCaster& caster, const Receiver& receiver) const;

  glm::dvec3 exact_centre_;
  glm::dvec3 across_;  // Orthogonal to it and each other, of the disc's tangent for length.
  glm::dvec3 upwards_;
  glm::vec3 centre_;
  std::array<glm::vec3, 4> rim_;
  std::vector<glm::vec3> samples_;
};

}  // namespace pleinair
