// One pass of reweighting: from a guess of the light to a linear, whitened least-squares problem.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "estimation/internal/fit_problem.h"
#include "estimation/internal/noise_units.h"
#include "estimation/lighting_fit.h"

namespace pleinair::estimation_internal {

// Rows and targets of the weighted problem of one channel: minimise |rows x_c - target|^2, whose
// rows have unit, uncorrelated noise. Row-major, sample_count x ColumnCount().
using ErrorVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxCameraErrors, 1>;

struct WhitenedChannel {
  std::vector<double> rows;
  std::vector<double> target;
};

// The robust weights
//   w = (1 - (d / (width * scale))^2)^2 for d inside width * scale, 0 outside (Tukey),
//   w = min(1, width * scale / d) (Huber), or w = 1 (least squares),
// with d the sample's combined residual over RGB and scale 1.4826 times its median, far ones left
// out.
//
// Under Tukey's weights a sample is left out, of the scale too, that is more likely in the shadow
// of something that the mesh lacks (a tree, a car, a house outside it) than where the mesh has it:
// however many there are, they do not widen the cut. With r the mean over RGB of its residual, u of
// the sunlight that is predicted on it, a large part of its light, and s^2 its own variance, that
// is
//   exp(-(r + u)^2 / (2 s^2)) p > exp(-r^2 / (2 s^2)) (1 - p),   p = kShadeTheMeshLacks.
// s^2 is that within planes, as all of a plane errs alike by its albedo; before it is known, 0:
// what lacks half of its sun is left out.
//
// The noise is that of the M-estimator: the variance n for which n (sum w J J')^-1 is its
// asymptotic covariance, n = mean(w) * mean(psi^2) / mean(psi')^2 (Huber, Robust Statistics,
// section 7.6), as a 3 x 3 matrix over the channels, since albedo errors are often grey.
//
// Samples of one plane, lit and shaded, share three errors beside their own: of albedo, a part t of
// their whole prediction; of the sky's shape, a part s of the sky's share v of it; and, of the same
// size s, of what hides the sky from some of them though the mesh lacks it (an awning over the
// shaded part), which looks like more or less sun: the sun's column times what of v is in
// proportion to it, u. So 400 samples of one wall count as much as that wall's albedo allows, and
// the contrast of lit and shaded on it gives the sun whatever the sky's shape, but to s of the
// sky's light. The plane's covariance is
//   n I + t^2 1 1' + s^2 (v v' + u u').
// It is whitened by taking from each row the part phi of the plane's mean row, 1 - phi =
// (1 + t^2 W / n)^-1/2 with W the plane's summed weight, and then in the same way along what that
// leaves of v, and of u. t and s are as many times what is expected of them as the planes'
// residuals say (one-way analysis of variance).
//
// Neighbours share more: a texture, the dark of a corner. n counts that in by the design effect
// (Kish, Survey Sampling, section 8.1): how many times as uncertain the means over parts of a plane
// are as they would be of samples that err alone. So many samples of a view are worth no more than
// the picture has to say, and how many that is the residuals tell.
class Reweighting {
 public:
  // The next pass expects of the planes' errors what the options say; those after it find them.
  void Forget();
  // Not after Forget, nor when the sun has risen or set since.
  bool KnowsSharedErrors(const FitProblem& problem) const {
    return last_normal_[0].rows() == problem.ColumnCount();
  }

  // `prior_information` is what else holds the unknowns, as the residuals of planes tell more of
  // their errors where the fit is not free to follow them. `rescale` false keeps the scales
  // (robust, noise, shared) of the last pass.
  void Update(FitProblem& problem,
              const LightVector& x,
              const ErrorVector& camera_errors,
              const LightMatrix& prior_information,
              const LightingFitOptions& options,
              bool rescale);

  // Whether `x` explains as many samples as the light that was found last did, and as well: then it
  // is a start as good as any. False before the first Update.
  bool Explains(FitProblem& problem,
                const LightVector& x,
                const ErrorVector& camera_errors,
                const LightingFitOptions& options);

  // Normal equations of the whitened problem of channel c: rows' rows and rows' target.
  const BasisMatrix& Normal(int c) const { return normal_[static_cast<std::size_t>(c)]; }
  const BasisVector& Gradient(int c) const { return gradient_[static_cast<std::size_t>(c)]; }

  // Writes the rows themselves, which most passes can do without.
  void Whiten(const FitProblem& problem);
  const WhitenedChannel& Channel(int c) const { return channels_[static_cast<std::size_t>(c)]; }

  // The whitened rows of one channel times another's, summed over the samples, times the
  // correlation of the two channels' noise in one sample.
  BasisMatrix CrossNormal(int c, int d) const;
  // w, per sample.
  const std::vector<double>& Weights() const { return weight_; }
  double SharedError() const { return shared_error_; }
  double SkyShapeError() const { return sky_shape_error_; }
  double InlierFraction() const;
  double RelativeResidual() const;

 private:
  std::array<BasisMatrix, 3> normal_;
  std::array<BasisVector, 3> gradient_;
  std::array<WhitenedChannel, 3> channels_;
  double mean_weight_ = 1.0;
  // mean(psi')^-1: turns mean(psi psi') into noise_ (from both sides, times mean_weight_), and
  // with mean_weight_ a weighted mean residual into the shift that caused it.
  Eigen::Matrix3d inverse_slope_ = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d noise_ = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d correlation_ = Eigen::Matrix3d::Identity();
  double scale_ = 1.0;
  double own_variance_ = 0.0;  // Of samples within their planes; 0 before the first pass.
  LightVector explained_;      // What Explains has just looked at; else empty.
  // Of the pass before, or of a frame like this one; empty after Forget.
  std::array<BasisMatrix, 3> last_normal_;
  double error_ = 1.0;  // e of the planes' errors.
  double shared_error_ = 0.0;
  double sky_shape_error_ = 0.0;

  std::vector<double> inverse_unit_;  // Per sample and channel; 0 where unusable.
  std::vector<double> residual_;      // Per sample and channel, in noise units.
  std::vector<double> sky_share_;     // v, as residual_.
  std::vector<double> deviation_;     // d, per sample.
  std::vector<double> shade_;         // -u (2 r + u), per sample; 0 where u is small.
  std::vector<double> weight_;        // w, per sample.
  // Per plane and channel: summed weight, and weighted means of residual, target and row.
  std::vector<double> plane_weight_;
  std::vector<double> plane_residual_;
  std::vector<double> plane_target_;
  std::vector<double> plane_row_;
  std::vector<double> taken_;  // phi.
  // The sky's share v: its weighted mean, and its summed products with itself, with target and
  // row. After whitening along the mean the last two are means along v.
  std::vector<double> sky_mean_;
  std::vector<double> sky_sky_;
  std::vector<double> sky_target_;
  std::vector<double> sky_row_;
  std::vector<double> sky_taken_;
  // The same of the sun's column; and v over it, by least squares: u = sky_per_sun_ times it.
  std::vector<double> sun_target_;
  std::vector<double> sun_row_;
  std::vector<double> sun_taken_;
  std::vector<double> sky_per_sun_;
  // Per cell: the sum of psi, and the inliers; and those of its plane.
  std::vector<Eigen::Vector3d> cell_psi_;
  std::vector<double> cell_inliers_;
  std::vector<double> plane_inliers_;
  std::vector<double> scratch_;

  // The loops over the samples, with the number of columns known to the compiler.
  void Standardise(FitProblem& problem,
                   const LightVector& x,
                   const ErrorVector& camera_errors,
                   const LightingFitOptions& options);
  template <int kColumns>
  void Predict(const FitProblem& problem, const LightVector& x);
  template <int kColumns>
  void Accumulate(const FitProblem& problem);

  double ShadeFrom() const;  // What shade_ must be above.
  static double ScaleOf(std::vector<double>& deviations,
                        double unknowns,
                        const LightingFitOptions& options);
  void EstimateScale(const FitProblem& problem, const LightingFitOptions& options);
  void Weigh(const LightingFitOptions& options);
  void EstimateSlope(const LightingFitOptions& options);
  void EstimateNoise(const FitProblem& problem, const LightingFitOptions& options);
  double DesignEffect(const FitProblem& problem, double mean_square) const;
  void EstimateSharedErrors(const FitProblem& problem,
                            const LightMatrix& prior_information,
                            const LightingFitOptions& options);
  // What a plane says of e, per channel: the shift of its mean, the part of that which its samples'
  // own errors explain, the weight of its square in units of what is expected, and the degrees of
  // freedom that it is worth. A weight of 0: nothing.
  struct Witness {
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();
    Eigen::Vector3d alone = Eigen::Vector3d::Zero();
    Eigen::Vector3d weight = Eigen::Vector3d::Zero();
    Eigen::Vector3d degrees = Eigen::Vector3d::Zero();
  };
  std::vector<Witness> witnesses_;
  Witness WitnessOf(int plane,
                    const std::array<BasisMatrix, 3>& covariance,
                    const LightingFitOptions& options) const;
  void WhitenMeans(const FitProblem& problem);
  void WhitenSky(const FitProblem& problem);
  void WhitenSun(const FitProblem& problem);
  void FinishNormal(const FitProblem& problem);
};

}  // namespace pleinair::estimation_internal
