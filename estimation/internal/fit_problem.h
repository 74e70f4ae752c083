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
// A sample's columns: its response to the basis lights, then to the camera's errors.
inline constexpr int kMaxColumns = kMaxBasis + kMaxCameraErrors;
using BasisVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxColumns, 1>;
using BasisMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxColumns, kMaxColumns>;

// Unknowns inside the fit are channel-major, u = channel * basis_count + basis, and without unit:
// irradiance = unknown * irradiance_unit[channel]. Radiances are divided by their channel's median.
// So a frame times 10^k is the same problem but for rounding.
struct FitProblem {
  int basis_count = 0;
  // Errors of the camera, common to all channels, as unknowns of unit variance. The exponent
  // is the last.
  struct CameraError {
    int place = -1;  // Among the errors; below 0: not an unknown.
    double stddev = 0.0;
    double mean = 0.0;  // That the prior expects, in deviations.
  };
  CameraError veil;
  CameraError vignetting;
  CameraError pattern;
  CameraError saturation;
  int error_count = 0;
  double exponent_stddev = 0.0;  // 0: the exponent is not an unknown.
  glm::dvec3 white{1.0};  // In the fit's units: the radiance that a wrong exponent does not change.
  // Taken out of the radiances when they are loaded: the unknown exponent is what differs from it.
  double removed_exponent = 0.0;
  double exponent_mean = 0.0;  // That the prior expects of what differs, in its deviations.
  bool has_sun = false;
  int sample_count = 0;
  int ignored = 0;
  int plane_count = 0;
  glm::dvec3 radiance_unit{1.0};
  glm::dvec3 irradiance_unit{1.0};

  // Per sample and channel, [i * 3 + c]; transport [(i * 3 + c) * ColumnCount() + j].
  std::vector<double> radiance;
  std::vector<double> noise;   // Camera noise.
  std::vector<double> weight;  // 0 where the channel cannot be used.
  std::vector<double> transport;
  std::vector<std::int32_t> source;  // Per sample: its index in what was loaded.
  std::vector<double> corner_share;  // Per sample: LensCircle::ShareOfCorner.
  // Per sample and channel: ln(albedo) less its plane's mean; 0 where the albedo is not measured.
  std::vector<double> log_albedo;
  std::vector<double> plane_over_own_albedo;  // exp(-log_albedo).
  std::vector<std::int32_t> plane;            // Per sample, 0 .. plane_count - 1; ascending.
  // Per sample: neighbours in the picture on one plane. A plane has a few cells of about equal
  // numbers of samples; one where it has few samples or they have no place.
  std::vector<std::int32_t> cell;
  std::vector<std::int32_t> plane_of_cell;
  // Per sample: by how much the sun's share of its responses exceeds the mean over the lit, or over
  // the shaded, samples of its plane, in twice their standard deviation. Less where neighbours
  // differ as much as distant samples do, and 0 where only neighbours differ.
  std::vector<double> trend;

  // Takes over the usable samples in canonical order: by plane, pixel, then value, so that the
  // order in which they come does not change a bit of any sum. `exponent` is the one to take out:
  // near the true one, so that the fit, which is linear in what is left, is exact.
  void Load(std::span<const DiffuseSample> samples,
            const LightingPrior& prior,
            bool sun_is_up,
            double exponent);

  // Radiance v as the picture has it, with the exponent that was taken out.
  double InPicture(std::size_t v) const;

  // Refreshes the columns of errors in proportion to what is predicted, per sample and channel: the
  // vignetting, the pattern, the saturation with the distance from grey, and the exponent with
  // predicted ln(predicted / white).
  void SetResponseColumns(std::span<const double> predicted);

  int ColumnCount() const { return basis_count + error_count; }
  int UnknownCount() const { return 3 * basis_count; }
  const double* Transport(int sample, int channel) const {
    return transport.data() + static_cast<std::size_t>((sample * 3 + channel) * ColumnCount());
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
  struct Mean {
    double sum = 0.0;
    double count = 0.0;
    void Add(double value) {
      sum += value;
      count += 1.0;
    }
    double Value() const { return count > 0.0 ? sum / count : 0.0; }
  };
  std::vector<Mean> cell_means_;  // Per cell, in the shade and in the sun.
  std::vector<double> scratch_;

  struct Division {
    int most_cells = 1;
    std::size_t least_in_cell = 1;
  };
  struct Range {
    std::size_t first = 0;
    std::size_t last = 0;  // One past the last.
  };
  static const Division kForNoise;
  static const Division kForTrends;
  void DivideIntoCells(const Division& division);
  void FindTrends();
  void FindTrend(const Range& samples, const Range& cells);
  double SunShare(std::size_t sample) const;
  void Divide(std::int32_t in_plane, std::span<Place> places, const Division& division);
  void ChooseUnits(const glm::dvec3& usual_irradiance_rgb);
  void FillLogAlbedo();
  void SetSaturationColumn(std::span<const double> predicted);
  void FillVeilColumn(const glm::dvec3& veil_rgb);
};

}  // namespace pleinair::estimation_internal
