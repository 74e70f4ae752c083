// What is known of sun and sky before the picture is looked at.
#pragma once

#include <optional>
#include <span>
#include <string>

#include <Eigen/Core>
#include <glm/vec3.hpp>

#include "estimation/diffuse_sample.h"
#include "estimation/lighting_source.h"
#include "scene/utc_time.h"

namespace pleinair {

inline constexpr int kMaxLightUnknowns = 3 * (1 + kMaxSkyShapes);

// Over (sun RGB, sky[0] RGB, sky[1] RGB, ...), Lighting::covariance's order. Never on the heap.
using LightVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxLightUnknowns, 1>;
using LightMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxLightUnknowns, kMaxLightUnknowns>;

// A Gaussian in information form, so that priors add: minus twice its logarithm is
//   x' information x - 2 x' information_times_mean + constant.
// Singular where it says nothing.
struct LightingPrior {
  int sky_shapes = 1;
  LightMatrix information;
  LightVector information_times_mean;

  // Of sun over the whole sky under a clear sky, where only that ratio is known; 0 where not even
  // that. Its strength is relative to the fitted sky, so the fit turns it into rows.
  glm::dvec3 sun_to_sky_rgb{0.0};
  double sun_to_sky_weight = 0.0;  // 1: full strength.

  // The shape whose light comes of the beam, as around the sun in clear air: where hardly any of
  // the beam is found that a clear sky has, it has hardly a share. Below 0: none does. Sun over the
  // whole sky under a clear sky tells how much that is; where it is little itself, as at sunset, or
  // not known (0), nothing is said.
  int beam_shape = -1;
  glm::dvec3 clear_sun_to_sky_rgb{0.0};

  // Irradiance of usual size, for when there is no sample to take the unit from; 0 where unknown.
  glm::dvec3 scale_rgb{0.0};

  // Says nothing. Throws std::invalid_argument when sky_shapes is outside 1 .. kMaxSkyShapes.
  static LightingPrior Nothing(int sky_shapes);
  bool SaysSomething() const;
};

// An earlier answer, carried forward.
struct CarriedLighting {
  UtcTime time{};
  LightVector mean;
  LightMatrix covariance;
};

// The survey's light as such an answer for a frame at `time`, before it or after; nothing is known
// of the shapes' shares. None where it is too far off in time to say anything.
std::optional<CarriedLighting> CarryFromSurvey(const SurveyedLight& survey,
                                               UtcTime time,
                                               int sky_shapes);

// Before the picture the sun is taken to be half the clear-sky beam, give or take this share of it:
// the first two moments of "anything from fully covered to fully free", a little widened.
inline constexpr double kSunPriorMean = 0.5;    // Of the beam.
inline constexpr double kSunPriorSigma = 0.35;  // Of the beam.

// The prior of architecture section 4. The clear sky holds always; an earlier answer fades into it
// as the weather forgets (an Ornstein-Uhlenbeck process with a correlation time of one minute), and
// is left out when it is later than `time` or older than ten minutes.
//
// An earlier answer is widened so far that a frame which can tell sun from sky by itself does not
// feel it: 15 % of the beam, half the sky. So a cloud's step is followed in the frame that shows
// it. `kept` is the share of the memory that is left: see KeptMemory.
LightingPrior MakeLightingPrior(const ClearSkyExpectation& clear_sky,
                                const std::optional<CarriedLighting>& earlier,
                                UtcTime time,
                                int sky_shapes,
                                double kept = 1.0);

// Makes the clear shape, where it is among those of these names, the one that comes of the beam.
void SetBeamShape(std::span<const std::string> shape_names,
                  const ClearSkyExpectation& clear_sky,
                  LightingPrior& prior);

// How much of an earlier answer is still to be kept, once a fit under it has found `found`: 1 while
// sun and sky are within its widened deviation, and the less the farther they have moved in spite
// of it. 1, too, for an answer that is too old to count. Continuous in `found`.
double KeptMemory(const ClearSkyExpectation& clear_sky,
                  const CarriedLighting& earlier,
                  UtcTime time,
                  const LightVector& found);

// Holds sun and whole sky to within 10^-4 of the larger, so that the samples decide the sky's shape
// alone.
void HoldIrradiance(const glm::dvec3& sun_rgb, const glm::dvec3& sky_rgb, LightingPrior& prior);

// The answer to carry on from this frame: `mean` is the frame's, its covariance what the frame's
// samples and the earlier answer (not widened) know together.
CarriedLighting CarryForward(const ClearSkyExpectation& clear_sky,
                             const std::optional<CarriedLighting>& earlier,
                             UtcTime time,
                             const LightVector& mean,
                             const LightMatrix& data_information,
                             double kept = 1.0);

}  // namespace pleinair
