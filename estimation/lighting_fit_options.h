// How the fit of sun and sky is made: apart from the fit, so that who only chooses need not know
// it.
#pragma once

#include <cstdint>

namespace pleinair {

struct LightingFitOptions {
  enum class Solver {
    kCeres,   // The last, bounded solve by Ceres.
    kClosed,  // By the normal equations and an active set: an independent check.
  };
  Solver solver = Solver::kCeres;

  // What a sample far from the model counts.
  enum class Loss {
    kTukey,    // Nothing from tukey_width on: passers-by and wrong walls are left out.
    kHuber,    // Less and less from huber_width on, but never nothing.
    kSquares,  // As much as any other: plain least squares.
  };
  Loss loss = Loss::kTukey;
  // Tukey's biweight leaves out samples farther than this many robust standard deviations. > 0.
  // 4.685 would keep 95 % of the efficiency on Gaussian noise; 4 keeps 90 % and lets a third less
  // of a moderate outlier through.
  double tukey_width = 4.0;
  // In robust standard deviations; keeps 95 % of the efficiency on Gaussian noise. > 0.
  double huber_width = 1.345;
  // Of a sample's albedo and model, relative, before the data have spoken. It counts as much as one
  // sample, so that a handful of samples cannot claim to be exact. > 0.
  double expected_noise = 0.05;
  // Expected error of the whole prediction that the samples of one plane share, relative: a wall's
  // albedo. The data correct it, and the next, by one factor for both. >= 0; 0 says that samples
  // err alone.
  double shared_error = 0.05;
  // Expected error of the sky's part of the prediction that the samples of one plane share,
  // relative: a real sky is not of the fitted shape. Lit and shaded samples of a plane err alike,
  // so that their contrast is of the sun whatever the sky's shape; what hides the sky from one of
  // the two makes them differ by as much again. A tenth is right for a mix of shapes: held to it,
  // over 156 measured and modelled skies and views of two scenes, the stated deviation of the sky
  // held 71 % of the known skies (0.2: 82 %), with the same errors. >= 0.
  double sky_shape_error = 0.1;
  // Shares of the sky's shapes before the data have spoken: all equal, give or take this. Wider
  // than any mix of fractions, so that it speaks only where the samples cannot: on measured and
  // modelled skies over three scenes a spread of 0.35 cost half as much error again as 1. Of the
  // shape that comes of a beam (LightingPrior::beam_shape) less where there is none. > 0.
  double shape_share_spread = 1.0;
  // How much the shares of one shape differ from channel to channel: a white cloud before a blue
  // sky takes more of the red than of the blue. > 0.
  double shape_share_colour_spread = 0.5;
  // Noise that does not shrink with a sample's radiance, as a share of the samples' median. > 0.
  double noise_floor = 0.05;
  int max_passes = 40;  // Of reweighting. >= 1.
  std::uint64_t seed = 1;

  // Throws std::invalid_argument naming field and value.
  void Validate() const;
};

}  // namespace pleinair
