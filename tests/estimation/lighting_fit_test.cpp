#include "estimation/lighting_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/SVD>

#include "tests/estimation/fit_lighting.h"
#include "tests/estimation/synthetic_scene.h"

namespace pleinair::lighting_fit_test {
namespace {

using testing::MakeSamples;
using testing::SyntheticPrior;
using testing::SyntheticScene;

LightVector TruthOf(const SyntheticScene& scene) {
  LightVector truth(6);
  truth << scene.sun.x, scene.sun.y, scene.sun.z, scene.sky.x, scene.sky.y, scene.sky.z;
  return truth;
}

// Samples err alone here, and there is no prior: the unbounded estimate of plain noise.
LightingFitOptions AloneOptions() {
  LightingFitOptions options;
  options.shared_error = 0.0;
  options.sky_shape_error = 0.0;
  options.solver = LightingFitOptions::Solver::kClosed;  // For speed: many draws.
  return options;
}

TEST(LightingFit, FindsTheLightOfExactSamples) {
  const SyntheticScene scene;
  const LightingFit fit = FitLighting(MakeSamples(scene), LightingPrior::Nothing(1), true);
  // The weak prior's share is below 1e-6 (lighting_fit.cpp); convergence 1e-8.
  const LightVector truth = TruthOf(scene);
  for (int u = 0; u < 6; ++u) EXPECT_NEAR(fit.irradiance_rgb[u], truth[u], 2e-6 * truth[u]);
  EXPECT_TRUE(fit.converged);
  EXPECT_EQ(fit.samples_used, scene.samples);
  EXPECT_EQ(fit.inlier_fraction, 1.0);
  EXPECT_LT(fit.relative_residual, 1e-6);
}

// The clear sky says 5 % more sun than there is; known to some per cent, the picture outweighs it.
TEST(LightingFit, LeavesAWellPosedFrameToItsSamples) {
  SyntheticScene scene;
  scene.albedo_noise = 0.1;
  const std::vector<DiffuseSample> samples = MakeSamples(scene);
  const LightingFit with = FitLighting(samples, SyntheticPrior(), true);
  const LightingFit without = FitLighting(samples, LightingPrior::Nothing(1), true);
  for (int c = 0; c < 3; ++c) {
    // (sigma of data / sigma of prior)^2 = (3 % / 35 %)^2 of half a beam: a sky of another shape,
    // which the fit allows for, takes a third of what the samples know.
    EXPECT_NEAR(with.irradiance_rgb[c], without.irradiance_rgb[c], 0.004 * scene.sun[c]);
  }
}

TEST(LightingFit, CeresAndTheClosedSolveAgree) {
  LightingFitOptions closed;
  closed.solver = LightingFitOptions::Solver::kClosed;
  int at_a_bound = 0;
  for (int i = 0; i < 150; ++i) {
    SyntheticScene scene;
    scene.seed = static_cast<std::uint64_t>(i);
    scene.samples = 3 + 3 * i;
    scene.albedo_noise = 0.1;
    scene.channel_noise = 0.03;
    if (i % 3 == 0) scene.sun = glm::dvec3(0.0);
    if (i % 3 == 1) scene.sky = glm::dvec3(0.0);
    if (i % 7 == 0) scene.lit_share = 0.0;
    const std::vector<DiffuseSample> samples = MakeSamples(scene);
    const LightingFit one = FitLighting(samples, SyntheticPrior(), true);
    const LightingFit other = FitLighting(samples, SyntheticPrior(), true, closed);
    EXPECT_TRUE(one.converged) << i;
    EXPECT_LT((one.irradiance_rgb - other.irradiance_rgb).cwiseAbs().maxCoeff(),
              1e-6 * other.irradiance_rgb.maxCoeff())
        << i;
    EXPECT_GE(one.irradiance_rgb.minCoeff(), 0.0);
    if (other.irradiance_rgb.minCoeff() == 0.0) ++at_a_bound;
  }
  EXPECT_GT(at_a_bound, 10);  // The bounds were met.
}

TEST(LightingFit, ScalesWithTheRadiance) {
  SyntheticScene scene;
  scene.albedo_noise = 0.1;
  scene.outliers = SyntheticScene::Outliers::kRandom;
  scene.outlier_share = 0.2;
  const std::vector<DiffuseSample> samples = MakeSamples(scene);
  for (const bool with_prior : {false, true}) {
    const auto prior = [&](double scale) {
      if (!with_prior) return LightingPrior::Nothing(1);
      ClearSkyExpectation clear_sky = testing::SyntheticClearSky();
      clear_sky.beam_rgb *= scale;
      clear_sky.diffuse_rgb *= scale;
      return MakeClimatePrior(clear_sky, 1);
    };
    const LightingFit reference = FitLighting(samples, prior(1.0), true);
    for (int k = -8; k <= 8; ++k) {
      const double scale = std::pow(10.0, k);
      std::vector<DiffuseSample> scaled = samples;
      for (DiffuseSample& sample : scaled) sample.radiance_rgb *= scale;
      const LightingFit fit = FitLighting(scaled, prior(scale), true);
      for (int u = 0; u < 6; ++u) {
        EXPECT_NEAR(fit.irradiance_rgb[u] / scale / reference.irradiance_rgb[u], 1.0, 1e-9);
        EXPECT_NEAR(fit.covariance(u, u) / (scale * scale) / reference.covariance(u, u), 1.0, 1e-8);
      }
      EXPECT_NEAR(
          fit.condition_number, reference.condition_number, 1e-8 * reference.condition_number);
    }
  }
}

TEST(LightingFit, TheOrderOfTheSamplesDoesNotChangeABit) {
  SyntheticScene scene;
  scene.albedo_noise = 0.1;
  std::vector<DiffuseSample> samples = MakeSamples(scene);
  samples.push_back(samples[7]);  // A tie.
  const LightingFit reference = FitLighting(samples, SyntheticPrior(), true);
  std::mt19937_64 random(3);
  for (int i = 0; i < 10; ++i) {
    std::shuffle(samples.begin(), samples.end(), random);
    const LightingFit fit = FitLighting(samples, SyntheticPrior(), true);
    EXPECT_EQ(fit.irradiance_rgb, reference.irradiance_rgb);
    EXPECT_EQ(fit.covariance, reference.covariance);
  }
}

// Reusing the fitter, after fits of other sizes, changes nothing either.
// The last frame's light is where the fit starts, not a part of its answer: that stops where a pass
// moves it by 1e-5 of the light and its scales by 1e-3, here hundredths of its deviation.
TEST(LightingFit, AKeptFittersLastFitDoesNotChangeTheNext) {
  LightingFitter fitter{LightingFitOptions{}};
  SyntheticScene scene;
  scene.albedo_noise = 0.1;
  for (const int count : {500, 500, 20, 0, 1000, 500}) {
    scene.samples = count;
    scene.seed += 1;
    const std::vector<DiffuseSample> samples = MakeSamples(scene);
    const LightingFit kept = fitter.Fit(samples, SyntheticPrior(), true);
    const LightingFit fresh = FitLighting(samples, SyntheticPrior(), true);
    for (int u = 0; u < 6; ++u) {
      EXPECT_NEAR(
          kept.irradiance_rgb[u], fresh.irradiance_rgb[u], 0.02 * std::sqrt(fresh.covariance(u, u)))
          << "of " << count << " samples, unknown " << u;
    }
  }
}

TEST(LightingFit, AKeptFitterGoesOnWhenTheSunSetsAndRises) {
  LightingFitter fitter{LightingFitOptions{}};
  SyntheticScene scene;
  scene.albedo_noise = 0.1;
  for (const bool sun_is_up : {true, false, true, true, false, false}) {
    SyntheticScene now = scene;
    if (!sun_is_up) now.sun = glm::dvec3(0.0);
    const std::vector<DiffuseSample> samples = MakeSamples(now);
    const LightingFit kept = fitter.Fit(samples, SyntheticPrior(), sun_is_up);
    const LightingFit fresh = FitLighting(samples, SyntheticPrior(), sun_is_up);
    for (int u = 0; u < 6; ++u) {
      EXPECT_NEAR(kept.irradiance_rgb[u],
                  fresh.irradiance_rgb[u],
                  0.02 * std::sqrt(fresh.covariance(u, u)) + 1e-9)
          << "sun " << sun_is_up << ", unknown " << u;
    }
  }
}

// A handful of noisy samples says nothing of what planes share: as expected is what it is. What
// hides the sky from a part of a plane takes a share of the scatter, 0.395 being the least here.
TEST(LightingFit, SharedErrorsAreAsExpectedWhereSamplesCannotShowThem) {
  SyntheticScene scene;
  scene.samples = 24;
  scene.albedo_noise = 0.5;
  const LightingFitOptions options;
  int much_less = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    scene.seed = seed;
    const LightingFit fit = FitLighting(MakeSamples(scene), SyntheticPrior(), true, options);
    EXPECT_GT(fit.shared_error, 0.35 * options.shared_error) << seed;
    EXPECT_LT(fit.shared_error, 4.0 * options.shared_error) << seed;
    much_less += fit.shared_error < 0.4 * options.shared_error ? 1 : 0;
  }
  EXPECT_LE(much_less, 2);  // A hundredth of the draws.
}

// Nine tenths of the samples still see the old light: the sun of the tenth is gone.
TEST(LightingFit, AStaleLightIsNotKeptForWhatItStillExplains) {
  SyntheticScene scene;
  scene.albedo_noise = 0.03;
  scene.lit_share = 0.1;
  LightingFitter fitter{LightingFitOptions{}};
  for (const double sun : {1.0, 0.1, 0.0, 0.6}) {
    SyntheticScene now = scene;
    now.sun *= sun;
    const std::vector<DiffuseSample> samples = MakeSamples(now);
    const LightingFit kept = fitter.Fit(samples, LightingPrior::Nothing(1), true);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(kept.irradiance_rgb[c], now.sun[c], 4.0 * std::sqrt(kept.covariance(c, c)))
          << "sun times " << sun;
    }
  }
}

struct Coverage {
  double within_68 = 0.0;
  double within_95 = 0.0;
};

Coverage CoverageOver(SyntheticScene scene, int draws, const LightingFitOptions& options) {
  LightingFitter fitter(options);
  const LightVector truth = TruthOf(scene);
  Coverage coverage;
  for (int i = 0; i < draws; ++i) {
    scene.seed = static_cast<std::uint64_t>(1000 + i);
    const LightingFit fit = fitter.Fit(MakeSamples(scene), LightingPrior::Nothing(1), true);
    for (int u = 0; u < 6; ++u) {
      const double error =
          std::abs(fit.irradiance_rgb[u] - truth[u]) / std::sqrt(fit.covariance(u, u));
      if (error < 1.0) coverage.within_68 += 1.0 / (6.0 * draws);
      if (error < 1.96) coverage.within_95 += 1.0 / (6.0 * draws);
    }
  }
  return coverage;
}

// 10^4 draws of six numbers, where the bar is 68 % +- 5 % and 95 % +- 3 %.
TEST(LightingFit, StandardDeviationsHoldForNoiseOfEachChannel) {
  SyntheticScene scene;
  scene.samples = 100;
  scene.channel_noise = 0.1;
  const Coverage coverage = CoverageOver(scene, 10000, AloneOptions());
  EXPECT_NEAR(coverage.within_68, 0.68, 0.05);
  EXPECT_NEAR(coverage.within_95, 0.95, 0.03);
}

TEST(LightingFit, StandardDeviationsHoldForErrorsOfGreyAlbedo) {
  SyntheticScene scene;
  scene.samples = 100;
  scene.albedo_noise = 0.1;
  const Coverage coverage = CoverageOver(scene, 4000, AloneOptions());
  EXPECT_NEAR(coverage.within_68, 0.68, 0.05);
  EXPECT_NEAR(coverage.within_95, 0.95, 0.03);
}

TEST(LightingFit, StandardDeviationsHoldForEveryLoss) {
  SyntheticScene scene;
  scene.samples = 100;
  scene.channel_noise = 0.1;
  for (const auto loss : {LightingFitOptions::Loss::kHuber, LightingFitOptions::Loss::kSquares}) {
    LightingFitOptions options = AloneOptions();
    options.loss = loss;
    const Coverage coverage = CoverageOver(scene, 4000, options);
    EXPECT_NEAR(coverage.within_68, 0.68, 0.05) << static_cast<int>(loss);
    EXPECT_NEAR(coverage.within_95, 0.95, 0.03) << static_cast<int>(loss);
  }
}

// Walls whose albedo is off as a whole: a fit that treats 400 pixels as independent holds a
// quarter of the truths in its 68 %. Two dozen strata estimate their own spread to 15 %, so the
// interval is a little off, too.
TEST(LightingFit, StandardDeviationsHoldForErrorsThatAWallShares) {
  SyntheticScene scene;
  scene.samples = 400;
  scene.regions = 12;
  scene.albedo_noise = 0.1;
  scene.region_noise = 0.07;
  LightingFitOptions options;
  options.sky_shape_error = 0.0;  // The sky is of the fitted shape.
  options.solver = LightingFitOptions::Solver::kClosed;
  const Coverage honest = CoverageOver(scene, 2000, options);
  EXPECT_NEAR(honest.within_68, 0.68, 0.07);
  EXPECT_GT(honest.within_95, 0.90);
  EXPECT_LT(CoverageOver(scene, 500, AloneOptions()).within_68, 0.5);
}

// Stains, corners and textures: neighbours err alike, and their places show it. The deviation of
// the sun is on the safe side, as here its lit and shaded samples are neighbours, too.
TEST(LightingFit, StandardDeviationsHoldForErrorsThatNeighboursShare) {
  SyntheticScene scene;
  scene.samples = 1000;
  scene.albedo_noise = 0.03;
  scene.tile_noise = 0.1;
  LightingFitOptions options;
  options.shared_error = 0.01;  // Of whole planes there is none.
  options.sky_shape_error = 0.0;
  options.solver = LightingFitOptions::Solver::kClosed;
  const Coverage honest = CoverageOver(scene, 500, options);
  EXPECT_GT(honest.within_68, 0.63);
  EXPECT_GT(honest.within_95, 0.92);
  EXPECT_LT(CoverageOver(scene, 500, AloneOptions()).within_68, 0.5);
}

// A survey that is better than it had to be is found to be.
TEST(LightingFit, PlanesThatAgreeMakeTheLightSurer) {
  SyntheticScene scene;
  scene.albedo_noise = 0.05;
  LightingFitOptions options;
  const LightingFit exact = FitLighting(MakeSamples(scene), LightingPrior::Nothing(1), true);
  scene.region_noise = 0.1;
  const LightingFit rough = FitLighting(MakeSamples(scene), LightingPrior::Nothing(1), true);
  EXPECT_LT(exact.shared_error, 0.7 * options.shared_error);
  EXPECT_GT(rough.shared_error, options.shared_error);
  for (int u = 0; u < 6; ++u) EXPECT_LT(exact.covariance(u, u), 0.5 * rough.covariance(u, u));
}

// The same picture looked at eight times over says no more than once.
TEST(LightingFit, NeighboursOfTheSamplesAreNoNewWitnesses) {
  SyntheticScene scene;
  scene.albedo_noise = 0.1;
  LightingFitOptions options;
  options.shared_error = 0.005;  // So that the samples' own error is most of it.
  options.sky_shape_error = 0.0;
  options.solver = LightingFitOptions::Solver::kClosed;
  const std::vector<DiffuseSample> once = MakeSamples(scene);
  std::vector<DiffuseSample> often;
  for (int i = 0; i < 8; ++i) often.insert(often.end(), once.begin(), once.end());
  const LightingPrior nothing = LightingPrior::Nothing(1);
  const LightingFit few = FitLighting(once, nothing, true, options);
  const LightingFit many = FitLighting(often, nothing, true, options);
  for (std::size_t i = 0; i < often.size(); ++i) often[i].pixel = {0, 0};  // Neighbours of none.
  const LightingFit believed = FitLighting(often, nothing, true, options);
  for (int u = 0; u < 6; ++u) {
    const double stddev = std::sqrt(few.covariance(u, u));
    // What shrinks a measured noise towards the expected one weighs less with more samples.
    EXPECT_NEAR(many.irradiance_rgb[u], few.irradiance_rgb[u], 0.1 * stddev) << u;
    EXPECT_NEAR(std::sqrt(many.covariance(u, u)), stddev, 0.05 * stddev) << u;
    EXPECT_LT(std::sqrt(believed.covariance(u, u)), 0.9 * stddev) << u;
  }
}

// What the covariance promises of small noise, the fit keeps: e in the input moves the output by
// e / noise of a standard deviation, and no more than four of them.
TEST(LightingFit, MovesWithNoiseAsItsCovarianceSays) {
  SyntheticScene scene;
  scene.channel_noise = 0.1;
  const std::vector<DiffuseSample> samples = MakeSamples(scene);
  const LightingFitOptions options = AloneOptions();
  const LightingFit before = FitLighting(samples, LightingPrior::Nothing(1), true, options);
  std::mt19937_64 random(5);
  std::normal_distribution<double> gauss;
  for (const double size : {1e-6, 1e-4, 1e-2}) {
    std::vector<DiffuseSample> moved = samples;
    for (DiffuseSample& sample : moved) {
      for (int c = 0; c < 3; ++c) sample.radiance_rgb[c] *= 1.0 + size * gauss(random);
    }
    const LightingFit after = FitLighting(moved, LightingPrior::Nothing(1), true, options);
    for (int u = 0; u < 6; ++u) {
      EXPECT_LT(std::abs(after.irradiance_rgb[u] - before.irradiance_rgb[u]),
                4.0 * size / scene.channel_noise * std::sqrt(before.covariance(u, u)));
    }
  }
}

// Two samples per channel, alike in all: the whitened Jacobian is the matrix of transport over
// predicted radiance, up to one factor.
TEST(LightingFit, ConditionNumberIsThatOfTheWhitenedJacobian) {
  SyntheticScene scene;
  scene.sky = scene.sun = glm::dvec3(100.0);
  std::vector<DiffuseSample> samples(40);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].sun_transport_rgb = glm::dvec3(i % 2 == 0 ? 0.12 : 0.01);
    samples[i].sky_transport_rgb[0] = glm::dvec3(i % 2 == 0 ? 0.10 : 0.06);
    samples[i].radiance_rgb =
        100.0 * (samples[i].sun_transport_rgb + samples[i].sky_transport_rgb[0]);
    samples[i].pixel = {static_cast<int>(i), 0};
  }
  LightingFitOptions options = AloneOptions();
  options.noise_floor = 1e-9;  // Purely relative noise.
  const LightingFit fit = FitLighting(samples, LightingPrior::Nothing(1), true, options);
  Eigen::Matrix2d jacobian;
  jacobian << 0.12 / 22.0, 0.10 / 22.0, 0.01 / 7.0, 0.06 / 7.0;
  const Eigen::Vector2d values = Eigen::JacobiSVD<Eigen::Matrix2d>(jacobian).singularValues();
  EXPECT_NEAR(fit.condition_number, values[0] / values[1], 1e-6 * fit.condition_number);
}

TEST(LightingFit, SeparatesTwoSkyShapes) {
  SyntheticScene scene;
  std::vector<DiffuseSample> samples = MakeSamples(scene);
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> uniform(0.3, 1.7);
  const glm::dvec3 second(40.0, 50.0, 60.0);
  for (DiffuseSample& sample : samples) {
    sample.sky_transport_rgb[1] = sample.sky_transport_rgb[0] * uniform(random);
    sample.radiance_rgb += second * sample.sky_transport_rgb[1];
  }
  LightingFitOptions options;
  options.shape_share_spread = 1e6;  // Only the samples count.
  options.shape_share_colour_spread = 1e6;
  const LightingFit fit = FitLighting(samples, LightingPrior::Nothing(2), true, options);
  ASSERT_EQ(fit.irradiance_rgb.size(), 9);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(fit.irradiance_rgb[c], scene.sun[c], 1e-5 * scene.sun[c]);
    EXPECT_NEAR(fit.irradiance_rgb[3 + c], scene.sky[c], 1e-5 * scene.sun[c]);
    EXPECT_NEAR(fit.irradiance_rgb[6 + c], second[c], 1e-5 * scene.sun[c]);
  }
}

TEST(LightingFit, SharesAreEqualWhereSamplesCannotSeparateTheShapes) {
  const SyntheticScene scene;
  std::vector<DiffuseSample> samples = MakeSamples(scene);
  for (DiffuseSample& sample : samples) {
    sample.sky_transport_rgb[2] = sample.sky_transport_rgb[1] = sample.sky_transport_rgb[0];
  }
  const LightingFit fit = FitLighting(samples, LightingPrior::Nothing(3), true);
  // Exact data: what is left is the weak prior's pull, and the expected noise's.
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(fit.irradiance_rgb[c], scene.sun[c], 1e-5 * scene.sun[c]);
    for (int k = 1; k <= 3; ++k) {
      EXPECT_NEAR(fit.irradiance_rgb[3 * k + c], scene.sky[c] / 3.0, 1e-4 * scene.sky[c]);
    }
  }
}

// The share of the third of three shapes that samples cannot distinguish, and that comes of a beam.
double ShareOfTheBeamsShape(double sun, double clear_sun_to_sky) {
  SyntheticScene scene;
  scene.sun *= sun;
  std::vector<DiffuseSample> samples = MakeSamples(scene);
  for (DiffuseSample& sample : samples) {
    sample.sky_transport_rgb[2] = sample.sky_transport_rgb[1] = sample.sky_transport_rgb[0];
  }
  LightingPrior prior = LightingPrior::Nothing(3);
  prior.beam_shape = 2;
  prior.clear_sun_to_sky_rgb = glm::dvec3(clear_sun_to_sky);
  const LightingFit fit = FitLighting(samples, prior, true);
  for (int c = 0; c < 3; ++c) {
    const double sky =
        fit.irradiance_rgb[3 + c] + fit.irradiance_rgb[6 + c] + fit.irradiance_rgb[9 + c];
    EXPECT_NEAR(sky, scene.sky[c], 0.01 * scene.sky[c]);
    EXPECT_NEAR(fit.irradiance_rgb[3 + c], fit.irradiance_rgb[6 + c], 0.01 * scene.sky[c]);
  }
  return fit.irradiance_rgb[10] / scene.sky.y;
}

// Behind cloud there is none of it, in the sun it has its share like the others. Half of the beam
// is between, and has less than half of that share. Where a clear sky's beam is almost 0 itself,
// its absence proves nothing.
TEST(LightingFit, WithoutABeamItsShapeHasNoShare) {
  EXPECT_NEAR(ShareOfTheBeamsShape(0.0, 8.0), 0.0, 0.01);
  EXPECT_NEAR(ShareOfTheBeamsShape(1.0, 8.0), 1.0 / 3.0, 0.01);
  EXPECT_LT(ShareOfTheBeamsShape(0.05, 8.0), 0.05);
  const double half = ShareOfTheBeamsShape(0.5, 8.0);  // Sun over sky is 3.5.
  EXPECT_GT(half, 0.1);
  EXPECT_LT(half, 0.25);
  EXPECT_GT(ShareOfTheBeamsShape(0.0, 0.02), 0.3);
  EXPECT_NEAR(ShareOfTheBeamsShape(0.0, 0.0), 1.0 / 3.0, 0.01);
}

TEST(LightingFit, RefusesABeamForAShapeThatIsNotThere) {
  LightingPrior prior = LightingPrior::Nothing(2);
  prior.beam_shape = 2;
  EXPECT_THROW(FitLighting(MakeSamples(SyntheticScene()), prior, true), std::invalid_argument);
}

TEST(LightingFit, HoldsTheSunAtZeroBelowTheHorizon) {
  SyntheticScene scene;
  scene.sun = glm::dvec3(0.0);
  const LightingFit fit = FitLighting(MakeSamples(scene), LightingPrior::Nothing(1), false);
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(fit.irradiance_rgb[c], 0.0);
    EXPECT_EQ(fit.covariance(c, c), 0.0);
    EXPECT_NEAR(fit.irradiance_rgb[3 + c], scene.sky[c], 2e-6 * scene.sky[c]);
  }
  EXPECT_FALSE(DeterminesSun(fit, 800.0));
}

TEST(LightingFit, RefusesOptionsThatMakeNoSense) {
  const auto refused = [](auto&& change) {
    LightingFitOptions options;
    change(options);
    EXPECT_THROW(options.Validate(), std::invalid_argument);
  };
  refused([](LightingFitOptions& options) { options.tukey_width = 0.0; });
  refused([](LightingFitOptions& options) { options.expected_noise = std::nan(""); });
  refused([](LightingFitOptions& options) { options.shared_error = -0.1; });
  refused([](LightingFitOptions& options) { options.noise_floor = 0.0; });
  refused([](LightingFitOptions& options) { options.max_passes = 0; });
  LightingPrior torn = LightingPrior::Nothing(1);
  torn.sky_shapes = 2;
  EXPECT_THROW(FitLighting({}, torn, true), std::invalid_argument);
}

glm::dvec3 MeanRadianceOf(const std::vector<DiffuseSample>& samples) {
  glm::dvec3 sum(0.0);
  for (const DiffuseSample& sample : samples) sum += sample.radiance_rgb;
  return sum / static_cast<double>(samples.size());
}

// Errors of the ratio of sun to sky, per channel, in logarithms; the largest.
double WorstRatioError(const LightingFit& fit, const SyntheticScene& scene) {
  double worst = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double ratio = fit.irradiance_rgb[c] / fit.irradiance_rgb[3 + c];
    worst = std::max(worst, std::abs(std::log(ratio / (scene.sun[c] / scene.sky[c]))));
  }
  return worst;
}

// Haze and flare of 3 % of the mean picture brighten shade by some 10 %.
TEST(LightingFit, FindsAVeil) {
  SyntheticScene scene;
  scene.albedo_noise = 0.03;
  std::vector<DiffuseSample> samples = MakeSamples(scene);
  const glm::dvec3 mean = MeanRadianceOf(samples);
  for (DiffuseSample& sample : samples) sample.radiance_rgb += 0.03 * mean;
  LightingPrior prior = LightingPrior::Nothing(1);
  const double without = WorstRatioError(FitLighting(samples, prior, true), scene);
  prior.camera.mean_radiance_rgb = mean;
  prior.camera.veil_stddev = 0.02;
  const LightingFit fit = FitLighting(samples, prior, true);
  // Planes' albedos are known to 5 %: a veil of a third of the darkest ones shows.
  EXPECT_NEAR(fit.veil, 0.03, 0.01);
  EXPECT_LT(WorstRatioError(fit, scene), 0.5 * without);
}

// A picture style that flattens contrasts by 10 %: an exponent of -0.1.
void Flatten(std::vector<DiffuseSample>& samples, double white) {
  for (DiffuseSample& sample : samples) {
    for (int c = 0; c < 3; ++c) {
      sample.radiance_rgb[c] = white * std::pow(sample.radiance_rgb[c] / white, 0.9);
    }
  }
}

// A weak sun, in samples far below white.
struct DarkPicture {
  SyntheticScene scene;
  std::vector<DiffuseSample> samples;
  double white = 4000.0;

  DarkPicture() {
    scene.sun = 0.3 * scene.sky;
    samples = MakeSamples(scene);
    Flatten(samples, white);
  }
};

// A picture style that flattens contrasts makes a sun of nine times the sky 20 % weaker.
TEST(LightingFit, FindsAResponseThatIsNotTheStatedOne) {
  SyntheticScene scene;
  scene.albedo_noise = 0.03;
  std::vector<DiffuseSample> samples = MakeSamples(scene);
  const double white = 400.0;
  Flatten(samples, white);
  LightingPrior prior = LightingPrior::Nothing(1);
  const double without = WorstRatioError(FitLighting(samples, prior, true), scene);
  prior.camera.exponent_stddev = 0.05;
  prior.camera.white_radiance = white;
  const LightingFit fit = FitLighting(samples, prior, true);
  // The planes' albedos, known to 5 %, leave 0.03.
  EXPECT_NEAR(fit.exponent, -0.1, 0.03);
  EXPECT_LT(WorstRatioError(fit, scene), 0.5 * without);
  // In the picture's units the light explains the mean sample.
  for (int c = 0; c < 3; ++c) {
    double recorded = 0.0;
    double explained = 0.0;
    for (const DiffuseSample& sample : samples) {
      recorded += sample.radiance_rgb[c];
      explained += fit.picture_over_light_rgb[c] *
                   (fit.irradiance_rgb[c] * sample.sun_transport_rgb[c] +
                    fit.irradiance_rgb[3 + c] * sample.sky_transport_rgb[0][c]);
    }
    EXPECT_NEAR(explained / recorded, 1.0, 0.02);
  }
}

// A lens that loses a quarter of the light in the corners, in pictures whose surfaces lie anywhere.
TEST(LightingFit, FindsTheVignetting) {
  SyntheticScene scene;
  scene.albedo_noise = 0.03;
  std::vector<DiffuseSample> samples = MakeSamples(scene);
  LightingPrior prior = LightingPrior::Nothing(1);
  prior.camera.vignetting_stddev = 0.1;
  prior.camera.lens_circle = LensCircle::Of(480, 360);
  for (DiffuseSample& sample : samples) {
    const glm::dvec2 place_px = glm::dvec2(sample.pixel) + 0.5;
    sample.radiance_rgb *= 1.0 - 0.25 * prior.camera.lens_circle.ShareOfCorner(place_px);
  }
  const LightingFit fit = FitLighting(samples, prior, true);
  EXPECT_NEAR(fit.vignetting, 0.25, 3.0 * fit.vignetting_stddev);
  EXPECT_LT(fit.vignetting_stddev, 0.02);
  // Light is that at the centre.
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(fit.irradiance_rgb[c] / scene.sun[c], 1.0, 0.02);
    EXPECT_NEAR(fit.irradiance_rgb[3 + c] / scene.sky[c], 1.0, 0.05);
  }
  // Known beforehand, it is taken from what is known.
  prior.camera.vignetting = 0.1;
  prior.camera.vignetting_stddev = 1e-4;
  EXPECT_NEAR(FitLighting(samples, prior, true).vignetting, 0.1, 1e-3);
}

// A camera that makes colours livelier, over planes of several colours whose patterns lie beside
// their places. Sun and sky have the colours of light, not of the picture.
TEST(LightingFit, FindsTheSaturation) {
  SyntheticScene scene;
  scene.albedo_noise = 0.03;
  std::vector<DiffuseSample> samples = MakeSamples(scene);
  const glm::dvec3 colours[] = {{1.3, 0.9, 0.7}, {0.8, 1.0, 1.1}, {1.0, 1.0, 1.0}};
  std::mt19937_64 random(5);
  std::normal_distribution<double> gauss;
  for (DiffuseSample& sample : samples) {
    const glm::dvec3& colour = colours[sample.plane % 3];
    sample.radiance_rgb = Saturated(colour * sample.radiance_rgb, 0.25);
    for (int c = 0; c < 3; ++c) {
      const double beside = std::exp(0.15 * gauss(random));
      sample.measured_albedo_rgb[c] = 0.3 * colour[c] * beside;
      sample.sun_transport_rgb[c] *= colour[c] * beside;
      sample.sky_transport_rgb[0][c] *= colour[c] * beside;
    }
  }
  LightingPrior prior = LightingPrior::Nothing(1);
  prior.camera.pattern_stddev = 0.2;
  const double without = WorstRatioError(FitLighting(samples, prior, true), scene);
  prior.camera.saturation_stddev = 0.1;
  const LightingFit fit = FitLighting(samples, prior, true);
  EXPECT_NEAR(fit.saturation, 0.25, 3.0 * fit.saturation_stddev);
  EXPECT_LT(fit.saturation_stddev, 0.07);
  EXPECT_LT(WorstRatioError(fit, scene), 0.5 * without);
  // Red is clipped where it is brightest: the other channels are saturated all the same.
  std::vector<DiffuseSample> clipped = samples;
  for (DiffuseSample& sample : clipped) {
    if (sample.is_lit && sample.plane % 3 == 0) {
      sample.radiance_stddev_rgb.r = std::numeric_limits<double>::infinity();
    }
  }
  const LightingFit of_clipped = FitLighting(clipped, prior, true);
  EXPECT_NEAR(of_clipped.saturation, 0.25, 3.0 * of_clipped.saturation_stddev);
  EXPECT_LT(WorstRatioError(of_clipped, scene), 0.5 * without);
  // Known beforehand, it is taken from what is known.
  prior.camera.saturation = 0.1;
  prior.camera.saturation_stddev = 1e-4;
  EXPECT_NEAR(FitLighting(samples, prior, true).saturation, 0.1, 1e-3);
}

// Half of a surveyed pattern's contrast is elsewhere in the picture, as where north is off by a
// degree: that is no flat response. One that is flat all the same is found.
TEST(LightingFit, TakesADisplacedPatternForNoResponse) {
  SyntheticScene scene;
  std::vector<DiffuseSample> displaced = MakeSamples(scene);
  std::mt19937_64 random(5);
  std::normal_distribution<double> pattern(0.0, 0.2);
  for (DiffuseSample& sample : displaced) {
    const double here = pattern(random);
    const double elsewhere = pattern(random);
    sample.measured_albedo_rgb = glm::dvec3(0.3 * std::exp(here + elsewhere));
    const double measured = std::exp(here + elsewhere);
    sample.sun_transport_rgb *= measured;
    sample.sky_transport_rgb[0] *= measured;
    sample.radiance_rgb *= std::exp(here + pattern(random));
  }
  std::vector<DiffuseSample> flat = displaced;
  const double white = 400.0;
  Flatten(flat, white);
  LightingPrior prior = LightingPrior::Nothing(1);
  prior.camera.exponent_stddev = 0.05;
  prior.camera.white_radiance = white;
  const double misled = FitLighting(displaced, prior, true).exponent;
  EXPECT_LT(misled, -0.05);
  prior.camera.pattern_stddev = 0.2;
  // The one unknown of all planes leaves a part of each; less than half of the error is the point.
  EXPECT_NEAR(FitLighting(displaced, prior, true).exponent, 0.0, 0.35 * std::abs(misled));
  const LightingFit fit = FitLighting(flat, prior, true);
  EXPECT_NEAR(fit.exponent, -0.1, 3.0 * fit.exponent_stddev);
}

// In a dark picture the first order of an exponent is far off: the fit repeats it about what it
// found.
TEST(LightingFit, FindsAResponseOfADarkPicture) {
  const DarkPicture dark;
  LightingPrior prior = LightingPrior::Nothing(1);
  prior.camera.exponent_stddev = 0.05;
  prior.camera.white_radiance = dark.white;
  const LightingFit fit = FitLighting(dark.samples, prior, true);
  EXPECT_NEAR(fit.exponent, -0.1, 2e-3);
  EXPECT_LT(WorstRatioError(fit, dark.scene), 5e-3);
}

// A response that earlier frames have shown is taken out as it is, not to first order: of a weak
// sun in a dark picture nothing would be left otherwise.
TEST(LightingFit, TakesOutAResponseThatIsKnown) {
  const DarkPicture dark;
  LightingPrior prior = LightingPrior::Nothing(1);
  prior.camera.exponent = -0.1;
  prior.camera.exponent_stddev = 0.005;
  prior.camera.white_radiance = dark.white;
  const LightingFit fit = FitLighting(dark.samples, prior, true);
  EXPECT_NEAR(fit.exponent, -0.1, 1e-4);
  EXPECT_LT(WorstRatioError(fit, dark.scene), 1e-3);
  // Where it is known wrongly, what is found is the entire exponent.
  prior.camera.exponent = -0.09;
  prior.camera.exponent_stddev = 0.02;
  EXPECT_NEAR(FitLighting(dark.samples, prior, true).exponent, -0.1, 2e-3);
  // A curve that is upside down is none: the light is finite.
  prior.camera.exponent = -1.0;
  EXPECT_TRUE(FitLighting(dark.samples, prior, true).irradiance_rgb.allFinite());
}

}  // namespace
}  // namespace pleinair::lighting_fit_test
