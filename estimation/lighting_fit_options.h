// Options of the fit of sun and sky, without the fit itself: for callers that only choose.
#pragma once

#include <cstdint>

namespace pleinair {

// Options of LightingFitter. All errors are relative.
struct LightingFitOptions {
  enum class Solver {
    kCeres,   // Ceres does the last, bounded solve.
    kClosed,  // By the normal equations and an active set: an independent check.
  };
  Solver solver = Solver::kCeres;

  // The weight of a sample far from the model.
  enum class Loss {
    kTukey,    // 0 from tukey_width on: passers-by and wrong walls are left out.
    kHuber,    // Decreasing from huber_width on, but never 0.
    kSquares,  // The same as near the model: plain least squares.
  };
  Loss loss = Loss::kTukey;
  // Tukey's biweight leaves out samples farther than this many robust standard deviations. > 0.
  // A width of 4.685 would keep 95 % of the efficiency on Gaussian noise. A width of 4 keeps 90 %,
  // and reduces the influence of a moderate outlier by a third.
  double tukey_width = 4.0;
  // In robust standard deviations; keeps 95 % of the efficiency on Gaussian noise. > 0.
  double huber_width = 1.345;
  // Expected noise of a sample's albedo and model, relative, before the data are used. It has the
  // weight of one sample, so that a handful of samples cannot claim to be exact. > 0.
  double expected_noise = 0.05;
  // Expected error of the whole prediction that the samples of one plane share, relative: a wall's
  // albedo. The data correct this and the next value by one factor. >= 0; 0: samples have
  // independent errors.
  double shared_error = 0.05;
  // Expected error of the sky's part of the prediction that the samples of one plane share,
  // relative: a real sky is not of the fitted shape. Lit and shaded samples of a plane have the
  // same error, so their contrast depends on the sun, not on the sky's shape. An occluder of the
  // sky on one of the two adds a difference of the same size. A tenth is right for a mix of shapes.
  // Tested on 156 measured and modelled skies and views of two scenes: the stated deviation of the
  // sky covered 71 % of the known skies (with 0.2: 82 %), with the same errors. >= 0.
  double sky_shape_error = 0.1;
  // Prior spread of the shares of the sky's shapes about equal shares. It is wider than any mix of
  // fractions, so that it matters only where the samples do not determine the shares. On measured
  // and modelled skies over three scenes, a spread of 0.35 had half as much error again as 1. The
  // shape that is light of the beam (LightingPrior::beam_shape) has less where there is no beam. >
  // 0.
  double shape_share_spread = 1.0;
  // Spread of the shares of one shape between channels: a white cloud before a blue sky has a
  // larger share of the red than of the blue. > 0.
  double shape_share_colour_spread = 0.5;
  // Noise that does not decrease with a sample's radiance, as a share of the samples' median. > 0.
  double noise_floor = 0.05;
  int max_passes = 40;  // Passes of reweighting. >= 1.
  std::uint64_t seed = 1;

  // Throws std::invalid_argument naming field and value.
  void Validate() const;
};

}  // namespace pleinair
