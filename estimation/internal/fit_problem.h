// The samples of one fit in its own units and order.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <glm/vec3.hpp>

#include "estimation/diffuse_sample.h"
#include "estimation/lighting_prior.h"

namespace pleinair::estimation_internal {

// Basis lights that are fitted: sun (where it is up), then the sky shapes.
inline constexpr int kMaxBasis = 1 + kMaxSkyShapes;
using BasisVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxBasis, 1>;
using BasisMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxBasis, kMaxBasis>;

// Unknowns inside the fit are channel-major, u = channel * basis_count + basis, and without unit:
// irradiance = unknown * irradiance_unit[channel]. Radiances are divided by their channel's median.
// So a frame times 10^k is the same problem but for rounding.
struct FitProblem {
  int basis_count = 0;
  bool has_sun = false;
  int sample_count = 0;
  int ignored = 0;
  int plane_count = 0;
  glm::dvec3 radiance_unit{1.0};
  glm::dvec3 irradiance_unit{1.0};

  // Per sample and channel, [i * 3 + c]; transport [(i * 3 + c) * basis_count + j].
  std::vector<double> radiance;
  std::vector<double> noise;   // Camera noise.
  std::vector<double> weight;  // 0 where the channel cannot be used.
  std::vector<double> transport;
  std::vector<std::int32_t> plane;  // Per sample, 0 .. plane_count - 1; ascending.
  // Per sample: neighbours in the picture on one plane. A plane has a few cells of about equal
  // numbers of samples; one where it has few samples or they have no place.
  std::vector<std::int32_t> cell;
  std::vector<std::int32_t> plane_of_cell;

  // Takes over the usable samples in canonical order: by plane, pixel, then value, so that the
  // order in which they come does not change a bit of any sum.
  void Load(std::span<const DiffuseSample> samples,
            int sky_shapes,
            bool sun_is_up,
            const glm::dvec3& usual_irradiance_rgb);

  int UnknownCount() const { return 3 * basis_count; }
  const double* Transport(int sample, int channel) const {
    return transport.data() + static_cast<std::size_t>((sample * 3 + channel) * basis_count);
  }
  // Index in the prior's order (sun RGB, sky[0] RGB, ...) of the unknown (channel, basis).
  int LightIndex(int channel, int basis) const { return 3 * (basis + (has_sun ? 0 : 1)) + channel; }

 private:
  struct Usable {
    const DiffuseSample* sample = nullptr;
    unsigned channels = 0;  // Bit c says that channel c is usable.
  };
  // A sample's place while its plane is cut into cells.
  struct Place {
    glm::ivec2 pixel{0};
    int sample = 0;
  };
  std::vector<Usable> order_;
  std::vector<Place> places_;
  std::vector<double> scratch_;

  void DivideIntoCells();
  void Divide(std::int32_t in_plane, std::span<Place> places, int most_cells);
  void ChooseUnits(const glm::dvec3& usual_irradiance_rgb);
};

}  // namespace pleinair::estimation_internal
