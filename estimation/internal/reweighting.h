// One pass of reweighting: from a guess of the light to a linear, whitened least-squares problem.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "estimation/internal/fit_problem.h"
#include "estimation/internal/noise_units.h"
#include "estimation/lighting_fit.h"

namespace pleinair::estimation_internal {

using ErrorVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxCameraErrors, 1>;

// What predicts the samples' radiances.
struct LightGuess {
  const LightVector& x;  // The problem's unknowns.
  const ErrorVector& camera_errors;
};

// Rows and targets of the weighted problem of one channel: minimise |rows x_c - target|^2, whose
// rows have unit, uncorrelated noise. Row-major, sample_count x ColumnCount().
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
// Under Tukey's weights some samples are left out, of the scale too, so that any number of them
// does not widen the cut. They are the samples that are more likely in the shadow of something that
// the mesh lacks (a tree, a car, a house outside it) than as the mesh has them. Let r be the mean
// over RGB of the residual, u that of the predicted sunlight, a large part of the light, and s^2
// the sample's own variance. The condition is
//   exp(-(r + u)^2 / (2 s^2)) p > exp(-r^2 / (2 s^2)) (1 - p),   p = kShadeTheMeshLacks.
// s^2 is the variance within planes, as all samples of a plane share the error of its albedo.
// Before it is known it is 0: a sample that lacks half of its sun is left out.
//
// The noise is that of the M-estimator: the variance n for which n (sum w J J')^-1 is its
// asymptotic covariance, n = mean(w) * mean(psi^2) / mean(psi')^2 (Huber, Robust Statistics,
// section 7.6). It is a 3 x 3 matrix over the channels, since albedo errors are often grey.
//
// Samples of one plane, lit and shaded, share four errors:
// - of albedo: a part t of their entire prediction;
// - of the sky's shape: a part s of the sky's share v of the prediction;
// - of an occluder of the sky that the mesh lacks (an awning over the shaded part), of the same
//   size s. It looks like more or less sun: u is the sun's column times the part of v that is
//   proportional to it.
// - of albedo, and of what the mesh lacks, slowly varying over the plane: a part m, at most t
//   and 5 %, along the trend g of FitProblem. Among the lit samples of a plane, as among the shaded
//   ones, the ratio of the responses to sun and sky differs by a few per cent, and albedos by as
//   much: that difference must not count as evidence of sun or sky.
// So 400 samples of one wall count as much as that wall's albedo allows. The contrast of lit and
// shaded samples determines the sun to s of the sky's light, whatever the sky's shape. The plane's
// covariance is
//   n I + t^2 1 1' + m^2 g g' + s^2 (v v' + u u').
// It is whitened by subtracting from each row the part phi of the plane's mean row, 1 - phi = (1 +
// t^2 W / n)^-1/2 with W the plane's summed weight. The same follows along the remaining v, along
// u, and along g. t, m and s are a multiple of their expected values; the planes' residuals
// determine it (one-way analysis of variance).
//
// Neighbours share more: a texture, the dark of a corner. n includes that by the design effect
// (Kish, Survey Sampling, section 8.1): the variance of means over parts of a plane, over the
// variance that they would have with independent samples. So more samples do not carry more
// information than the picture has. The residuals determine the effect.
class Reweighting {
 public:
  // The next pass uses the planes' errors of the options; later passes estimate them.
  void Restart();
  // Not after Restart, nor when the sun has risen or set since.
  bool KnowsSharedErrors(const FitProblem& problem) const {
    return last_normal_[0].rows() == problem.ColumnCount();
  }

  // `prior_information` is the prior of the unknowns: residuals of planes contain more of their
  // errors where the fit is not free to follow them. `rescale` false keeps the scales (robust,
  // noise, shared) of the last pass.
  void Update(FitProblem& problem,
              const LightGuess& guess,
              const LightMatrix& prior_information,
              const LightingFitOptions& options,
              bool rescale);

  // Whether `guess` explains as many samples as the light of the last fit did, and as well: then it
  // is a good start. False before the first Update.
  bool Explains(FitProblem& problem, const LightGuess& guess, const LightingFitOptions& options);

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
  double own_variance_ = 0.0;  // Variance of samples within their planes; 0 before the first pass.
  LightVector explained_;      // The light of the last call of Explains; else empty.
  // Normal equations of the pass before, or of a frame like this one; empty after Restart.
  std::array<BasisMatrix, 3> last_normal_;
  double error_ = 1.0;  // e of the planes' errors.
  double shared_error_ = 0.0;
  double trend_error_ = 0.0;
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
  // The trend g: its weighted mean, and its summed products with itself, with target and row. Each
  // whitening takes its part of these; after that along g the last two are means along it.
  std::vector<double> trend_mean_;
  std::vector<double> trend_trend_;
  std::vector<double> trend_sky_;  // With v; after whitening along v the mean along it.
  std::vector<double> trend_sun_;  // The mean along u.
  std::vector<double> trend_target_;
  std::vector<double> trend_row_;
  std::vector<double> trend_taken_;
  // Per cell: the sum of psi, and the inliers; and those of its plane.
  std::vector<Eigen::Vector3d> cell_psi_;
  std::vector<double> cell_inliers_;
  std::vector<double> plane_inliers_;
  std::vector<double> scratch_;

  // The loops over the samples, with the number of columns known to the compiler.
  void Standardise(FitProblem& problem, const LightGuess& guess, const LightingFitOptions& options);
  template <int kColumns>
  void Predict(const FitProblem& problem, const LightVector& x);
  template <int kColumns>
  void Accumulate(const FitProblem& problem);

  double ShadeFrom() const;  // Limit for shade_.
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
  // A plane's evidence on e, per channel: the shift of its mean, and the part of it that its
  // samples' own errors explain. Then the weight of the squared shift in units of its expectation,
  // and its degrees of freedom. A weight of 0: no evidence.
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
  void WhitenTrend(const FitProblem& problem);
  void FinishNormal(const FitProblem& problem);
};

}  // namespace pleinair::estimation_internal
