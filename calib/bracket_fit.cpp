#include "calib/bracket_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "calib/internal/exposed_pictures.h"
#include "calib/internal/residual_text.h"
#include "scene/upper_median.h"

namespace pleinair {
namespace {

// Enough for medians.
constexpr std::size_t kComparedPixels = 20000;

// Offsets and scatter of the green channel's light, over pixels that three pictures or more show
// unclipped.
void CompareLight(std::span<const ExposedPicture> pictures,
                  const std::vector<std::size_t>& kept,
                  const ResponseTable& table,
                  std::vector<BracketPicture>& compared) {
  std::vector<std::vector<double>> deviations(pictures.size());
  const std::size_t count = pictures[kept[0]].codes.pixels.size();
  const std::size_t step = std::max<std::size_t>(1, count / kComparedPixels);
  for (std::size_t pixel = 0; pixel < count; pixel += step) {
    std::vector<std::pair<std::size_t, double>> seen;
    std::vector<double> values;
    for (const std::size_t i : kept) {
      const int code = pictures[i].codes.pixels[pixel].y;
      if (code >= kClippedFromCode || code <= 8 * kNoiseFloorUpToCode) continue;
      const double light = table[1][static_cast<std::size_t>(code)] / pictures[i].exposure;
      seen.emplace_back(i, std::log(light));
      values.push_back(seen.back().second);
    }
    if (seen.size() < 3) continue;
    const double median = UpperMedian(values);
    for (const auto& [i, value] : seen) deviations[i].push_back(value - median);
  }
  for (const std::size_t i : kept) {
    compared[i].is_compared = !deviations[i].empty();
    compared[i].offset = UpperMedian(deviations[i]);
    for (double& deviation : deviations[i]) deviation = std::abs(deviation - compared[i].offset);
    compared[i].scatter = UpperMedian(deviations[i]);
  }
}

// Mean exponent of the light over the code.
double Exponent(const std::array<float, 256>& linear_of_code, int low, int high) {
  const double light = linear_of_code[static_cast<std::size_t>(high)] /
                       linear_of_code[static_cast<std::size_t>(low)];
  return std::log(light) / std::log(static_cast<double>(high) / low);
}

}  // namespace

BracketFit FitBracket(std::span<const ExposedPicture> pictures, const BracketFitOptions& options) {
  BracketFit fit;
  fit.pictures.resize(pictures.size());
  std::vector<std::size_t> kept(pictures.size());
  for (std::size_t i = 0; i < kept.size(); ++i) kept[i] = i;
  while (true) {
    std::vector<ExposedPicture> used;
    used.reserve(kept.size());
    for (const std::size_t i : kept) used.push_back(pictures[i]);
    fit.response = FitResponseFromBrackets(used, options);
    if (kept.size() <= 3) return fit;
    CompareLight(pictures, kept, fit.response.table, fit.pictures);
    const auto badness = [&](std::size_t i) {
      return std::max(std::abs(fit.pictures[i].offset) / kLargestOffset,
                      fit.pictures[i].scatter / kLargestScatter);
    };
    const auto worst =
        std::max_element(kept.begin(), kept.end(), [&](std::size_t a, std::size_t b) {
          return badness(a) < badness(b);
        });
    if (!(badness(*worst) > 1.0)) return fit;
    BracketPicture& picture = fit.pictures[*worst];
    picture.reason =
        std::abs(picture.offset) > kLargestOffset
            ? NumberText("its light is %.2f times that of the others: expected its exposure",
                         std::exp(picture.offset))
            : NumberText(
                  "its light scatters by %.0f %% about that of the others: expected the "
                  "same view",
                  100.0 * picture.scatter);
    kept.erase(worst);
  }
}

std::string DoubtAbout(const ResponseFit& fit) {
  // Codes below are noise, and black that is cut off.
  constexpr int kLeastCode = 16;
  for (std::size_t c = 0; c < fit.channels.size(); ++c) {
    const ResponseChannelFit& channel = fit.channels[c];
    const std::string name = std::string("response of ") + kChannelNames[c];
    if (!(channel.rms_relative <= kLargestCredibleBracketRms)) {
      return name + NumberText(": the pictures are %.0f %% (rms) off one curve",
                               100.0 * channel.rms_relative);
    }
    const int low = std::max(channel.lowest_code, kLeastCode);
    const int middle = (low + channel.highest_code) / 2;
    const double least = std::min(Exponent(fit.table[c], low, middle),
                                  Exponent(fit.table[c], middle, channel.highest_code));
    if (!(least >= kLeastExponent)) {
      return name +
             NumberText(": the curve is nearly flat, the light's exponent over the code is %.2f",
                        least);
    }
  }
  return {};
}

}  // namespace pleinair
