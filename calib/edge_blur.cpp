#include "calib/edge_blur.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Dense>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace pleinair {
namespace {

constexpr int kReachPx = 7;  // To each side of an edge.
constexpr int kCount = 2 * kReachPx;
constexpr int kPlateauPx = 3;
constexpr std::size_t kMostLines = 1500;
constexpr int kLeastEdges = 20;
constexpr double kMisplacedPx = 2.0;
// Slant of an edge against the line across it, in pixels for each line.
constexpr double kSteepest = 0.7;
// A pixel's own square.
constexpr double kPixelVariance = 1.0 / 12.0;
constexpr double kLeastPx = 0.15;  // Less moves 1 % of an edge's contrast.
// Largest doubt of a line, in variances: three deviations off, it shows something else.
constexpr double kMostDoubt = 9.0;

using Profile = std::array<double, kCount>;

struct Line {
  glm::ivec2 pixel;   // Before the edge.
  glm::ivec2 across;  // One step.
};

double Light(const RgbImage& radiance, const glm::ivec2& at) {
  const glm::vec3& rgb = radiance.At(at.x, at.y);
  return (double{rgb.r} + double{rgb.g} + double{rgb.b}) / 3.0;
}

bool IsModelEdge(const SurfaceView& view, const glm::ivec2& a, const glm::ivec2& b) {
  const std::size_t i = view.region.Index(a.x, a.y);
  const std::size_t j = view.region.Index(b.x, b.y);
  if (view.region.pixels[i] != view.region.pixels[j]) return true;
  if (view.region.pixels[i] == SurfaceView::kNoRegion) return false;
  constexpr float kSameFacing = 0.94f;  // 20 deg.
  const glm::vec3& normal = view.normal_world.pixels[i];
  if (glm::dot(normal, view.normal_world.pixels[j]) < kSameFacing) return true;
  const glm::vec3 step = view.position_world_m.pixels[j] - view.position_world_m.pixels[i];
  // Distance from the plane over the step: beyond a bend of 20 deg.
  constexpr float kBehind = 0.35f;
  return std::abs(glm::dot(normal, step)) > kBehind * glm::length(step);
}

bool ShadowChanges(const SurfaceView& view, const glm::ivec2& a, const glm::ivec2& b) {
  constexpr float kSameShare = 0.02f;
  return std::abs(view.sun_visibility.At(a.x, a.y) - view.sun_visibility.At(b.x, b.y)) > kSameShare;
}

// Whether the model has one edge there, in the middle, and no other, of shadow neither.
bool IsAlone(const SurfaceView& view, const Line& line) {
  for (int i = -kReachPx + 1; i < kReachPx; ++i) {
    if (i == 0) continue;
    const glm::ivec2 a = line.pixel + i * line.across;
    if (IsModelEdge(view, a, a + line.across) || ShadowChanges(view, a, a + line.across)) {
      return false;
    }
  }
  return true;
}

std::vector<Line> LinesAcrossEdges(const Gray8Image& clipped, const SurfaceView& view) {
  std::vector<Line> lines;
  for (int y = kReachPx; y < view.Height() - kReachPx - 1; ++y) {
    for (int x = kReachPx; x < view.Width() - kReachPx - 1; ++x) {
      for (const glm::ivec2& across : {glm::ivec2(1, 0), glm::ivec2(0, 1)}) {
        const Line line{{x, y}, across};
        if (!IsModelEdge(view, line.pixel, line.pixel + across) || !IsAlone(view, line)) continue;
        bool is_read = true;
        const glm::ivec2 along(across.y, across.x);
        for (int i = -kReachPx + 1; i <= kReachPx && !clipped.Empty(); ++i) {
          for (const glm::ivec2& beside : {-along, glm::ivec2(0), along}) {
            const glm::ivec2 at = line.pixel + i * across + beside;
            is_read = is_read && clipped.At(at.x, at.y) == 0;
          }
        }
        if (is_read) lines.push_back(line);
      }
    }
  }
  return lines;
}

// Deviations of the Gaussian: none, then each 8 % wider. Lines that the last one fits best show no
// lens in focus.
constexpr std::size_t kSigmas = 43;
constexpr double kNarrowestPx = 0.1;
constexpr double kWider = 1.08;

const std::array<double, kSigmas>& SigmasPx() {
  static const std::array<double, kSigmas> kSigmasPx = [] {
    std::array<double, kSigmas> sigmas{};
    for (std::size_t k = 1; k < kSigmas; ++k) {
      sigmas[k] = kNarrowestPx * std::pow(kWider, static_cast<double>(k) - 1.0);
    }
    return sigmas;
  }();
  return kSigmasPx;
}

// A step of light as pixels draw it: of a pixel's own square and a Gaussian along the line.
class PixelSteps {
 public:
  static constexpr int kPerPx = 20;  // Places of the edge.

  PixelSteps() {
    for (std::size_t k = 0; k < kSigmas; ++k) {
      for (int place = -kFarthest; place <= kFarthest; ++place) {
        const double x_px = static_cast<double>(place) / kPerPx;
        table_[k][static_cast<std::size_t>(place + kFarthest)] =
            Below(x_px + 0.5, SigmasPx()[k]) - Below(x_px - 0.5, SigmasPx()[k]);
      }
    }
  }

  // Light of a pixel so far behind the edge, in places.
  double At(std::size_t k, int place) const {
    return table_[k]
                 [static_cast<std::size_t>(std::clamp(place, -kFarthest, kFarthest) + kFarthest)];
  }

 private:
  static constexpr int kFarthest = 2 * kReachPx * kPerPx;

  // Integral of the blurred step up to x.
  static double Below(double x, double sigma) {
    if (sigma == 0.0) return std::max(x, 0.0);
    const double t = x / sigma;
    return x * 0.5 * std::erfc(-t / std::numbers::sqrt2) +
           sigma * std::exp(-0.5 * t * t) * 0.5 * std::numbers::inv_sqrtpi * std::numbers::sqrt2;
  }

  std::array<std::array<double, 2 * kFarthest + 1>, kSigmas> table_{};
};

// A line's squared error by the width of the step.
struct LineErrors {
  std::array<double, kSigmas> of_sigma{};
  double least = 0.0;
};

// Squared error of the best step of that width there.
double ErrorOf(const PixelSteps& steps, const Profile& profile, std::size_t k, int place) {
  double s = 0.0, ss = 0.0, p = 0.0, sp = 0.0, pp = 0.0;
  for (int i = 0; i < kCount; ++i) {
    const double step = steps.At(k, i * PixelSteps::kPerPx - place);
    const double value = profile[static_cast<std::size_t>(i)];
    s += step;
    ss += step * step;
    p += value;
    sp += step * value;
    pp += value * value;
  }
  const double variance = ss - s * s / kCount;
  const double covariance = sp - s * p / kCount;
  return pp - p * p / kCount - covariance * covariance / variance;
}

// The least of them around there, between places too.
double LeastErrorAround(const PixelSteps& steps, const Profile& profile, std::size_t k, int place) {
  constexpr int kAround = PixelSteps::kPerPx / 2;
  std::array<double, 2 * kAround + 1> by_place{};
  for (int off = -kAround; off <= kAround; ++off) {
    by_place[static_cast<std::size_t>(off + kAround)] = ErrorOf(steps, profile, k, place + off);
  }
  const auto least = static_cast<std::size_t>(std::min_element(by_place.begin(), by_place.end()) -
                                              by_place.begin());
  double error = by_place[least];
  if (least > 0 && least + 1 < by_place.size()) {
    const double before = by_place[least - 1];
    const double after = by_place[least + 1];
    const double bend = before - 2.0 * error + after;
    if (bend > 0.0) error -= 0.125 * (after - before) * (after - before) / bend;
  }
  return std::max(error, 0.0);
}

// Scales a line's sides to 0 and 1 and returns where half of the step is reached: by its area,
// which noise changes little. None where the line shows something else than a step.
std::optional<double> MiddleOfStep(Profile& profile) {
  double low = 0.0;
  double high = 0.0;
  for (std::size_t i = 0; i < kPlateauPx; ++i) {
    low += profile[i] / kPlateauPx;
    high += profile[kCount - 1 - i] / kPlateauPx;
  }
  const double contrast = high - low;
  constexpr double kLeastContrast = 0.1;  // Share of both sides' sum.
  if (!(std::abs(contrast) > kLeastContrast * (low + high))) return std::nullopt;
  for (double& value : profile) value = (value - low) / contrast;
  constexpr double kEven = 0.15;
  for (std::size_t i = 0; i < kPlateauPx; ++i) {
    if (std::abs(profile[i]) > kEven || std::abs(profile[kCount - 1 - i] - 1.0) > kEven) {
      return std::nullopt;
    }
  }
  double area = 0.0;
  for (const double value : profile) area += 1.0 - value;
  const double middle = area - 0.5;
  if (!(std::abs(middle - (kReachPx - 0.5)) <= kMisplacedPx)) return std::nullopt;
  return middle;
}

constexpr double kGoodFit = 0.06;  // Root mean square, of the step.

// Whether a line shows a sharp step that a camera has sharpened by an unsharp mask: step and step
// the difference to the blurred step fit it together.
bool IsSharpened(const PixelSteps& steps, const Profile& profile, int place) {
  // Less is fitted by a step alone.
  constexpr double kLeastAmount = 0.7;
  constexpr int kAround = PixelSteps::kPerPx / 2;
  for (const double mask_px : {0.8, 1.2, 1.8}) {
    const auto& sigmas = SigmasPx();
    const auto mask = static_cast<std::size_t>(
        std::lower_bound(sigmas.begin(), sigmas.end(), mask_px) - sigmas.begin());
    for (int off = -kAround; off <= kAround; ++off) {
      Eigen::Matrix<double, kCount, 3> model;
      Eigen::Matrix<double, kCount, 1> seen;
      for (int i = 0; i < kCount; ++i) {
        const int behind = i * PixelSteps::kPerPx - place - off;
        const double step = steps.At(0, behind);
        model.row(i) << 1.0, step, step - steps.At(mask, behind);
        seen[i] = profile[static_cast<std::size_t>(i)];
      }
      const Eigen::Vector3d fit =
          (model.transpose() * model).ldlt().solve(model.transpose() * seen);
      const double error = (model * fit - seen).squaredNorm();
      if (fit[1] > 0.0 && fit[2] >= kLeastAmount * fit[1] &&
          error <= kGoodFit * kGoodFit * kCount) {
        return true;
      }
    }
  }
  return false;
}

std::optional<LineErrors> ErrorsOf(const PixelSteps& steps, Profile profile) {
  const std::optional<double> middle = MiddleOfStep(profile);
  if (!middle) return std::nullopt;
  const int place = static_cast<int>(std::lround(*middle * PixelSteps::kPerPx));
  LineErrors errors;
  for (std::size_t k = 0; k < kSigmas; ++k) {
    errors.of_sigma[k] = LeastErrorAround(steps, profile, k, place);
  }
  const auto best = std::min_element(errors.of_sigma.begin(), errors.of_sigma.end());
  errors.least = *best;
  // No modelled step fits a sharpened edge: it supports the smallest width only.
  const bool fits = errors.least <= kGoodFit * kGoodFit * kCount ||
                    (best == errors.of_sigma.begin() && IsSharpened(steps, profile, place));
  if (!fits || best + 1 == errors.of_sigma.end()) return std::nullopt;
  return errors;
}

// The lens's own sigma from the errors, for a slanted edge: along the line both the blur and the
// pixel's side across the line are wider.
double ErrorAt(const LineErrors& errors, double sigma_px, double slant) {
  const double along_px =
      std::sqrt(sigma_px * sigma_px * (1.0 + slant * slant) + slant * slant * kPixelVariance);
  const auto& sigmas_px = SigmasPx();
  const auto next = std::upper_bound(sigmas_px.begin(), sigmas_px.end(), along_px);
  if (next == sigmas_px.end()) return errors.of_sigma.back();
  const auto k = static_cast<std::size_t>(next - sigmas_px.begin());
  const double share = (along_px - sigmas_px[k - 1]) / (sigmas_px[k] - sigmas_px[k - 1]);
  return (1.0 - share) * errors.of_sigma[k - 1] + share * errors.of_sigma[k];
}

// Sideways shift of the edge from line to line.
double SlantOf(const RgbImage& radiance, const Line& line) {
  const glm::ivec2 along(line.across.y, line.across.x);
  double difference = 0.0;
  for (int i = -kReachPx + 1; i <= kReachPx; ++i) {
    const glm::ivec2 at = line.pixel + i * line.across;
    difference += 0.5 * (Light(radiance, at + along) - Light(radiance, at - along));
  }
  const double step = Light(radiance, line.pixel + kReachPx * line.across) -
                      Light(radiance, line.pixel - (kReachPx - 1) * line.across);
  return std::abs(difference / step);
}

}  // namespace

void EdgeBlurMeter::Add(const RgbImage& radiance,
                        const Gray8Image& clipped,
                        const SurfaceView& view) {
  const bool fits =
      radiance.width == view.Width() && radiance.height == view.Height() &&
      (clipped.Empty() || (clipped.width == view.Width() && clipped.height == view.Height()));
  if (!fits) {
    throw std::invalid_argument("edge blur: a picture of " + std::to_string(radiance.width) + "x" +
                                std::to_string(radiance.height) + ", expected the view's " +
                                std::to_string(view.Width()) + "x" + std::to_string(view.Height()));
  }
  static const PixelSteps kSteps;
  const std::vector<Line> lines = LinesAcrossEdges(clipped, view);
  const std::size_t stride = (lines.size() + kMostLines - 1) / kMostLines;
  doubts_.resize(kSigmas - 1);
  for (std::size_t i = 0; i < lines.size(); i += stride) {
    const Line& line = lines[i];
    Profile profile{};
    for (int k = 0; k < kCount; ++k) {
      profile[static_cast<std::size_t>(k)] =
          Light(radiance, line.pixel + (k - kReachPx + 1) * line.across);
    }
    // NaN and infinities fail every test of MiddleOfStep.
    const std::optional<LineErrors> errors = ErrorsOf(kSteps, profile);
    if (!errors) continue;
    const double slant = SlantOf(radiance, line);
    if (!(slant <= kSteepest)) continue;
    ++edges_;
    constexpr double kLeastNoise = 0.01;  // Share of the step: lenses are not exactly Gaussian.
    constexpr int kFitted = 4;            // Both sides, place and width.
    const double variance = std::max(errors->least / (kCount - kFitted), kLeastNoise * kLeastNoise);
    for (std::size_t k = 0; k < doubts_.size(); ++k) {
      const double excess = ErrorAt(*errors, SigmasPx()[k], slant) - errors->least;
      doubts_[k] += std::min(excess / variance, kMostDoubt);
    }
  }
}

EdgeBlur EdgeBlurMeter::Blur() const {
  EdgeBlur blur;
  blur.edges = edges_;
  blur.is_measured = edges_ >= kLeastEdges;
  if (!blur.is_measured) return blur;
  const auto best =
      static_cast<std::size_t>(std::min_element(doubts_.begin(), doubts_.end()) - doubts_.begin());
  const auto& sigmas_px = SigmasPx();
  double sigma_px = sigmas_px[best];
  if (best > 0 && best + 1 < doubts_.size()) {
    const double before = doubts_[best - 1] - doubts_[best];
    const double after = doubts_[best + 1] - doubts_[best];
    const double off = before + after > 0.0 ? 0.5 * (before - after) / (before + after) : 0.0;
    sigma_px += off * (off < 0.0 ? sigma_px - sigmas_px[best - 1] : sigmas_px[best + 1] - sigma_px);
  }
  if (sigma_px >= kLeastPx) blur.sigma_px = sigma_px;
  return blur;
}

}  // namespace pleinair
