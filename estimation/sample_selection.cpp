#include "estimation/sample_selection.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <unordered_set>
#include <utility>

#include <glm/geometric.hpp>

#include "calib/lens.h"
#include "estimation/internal/random.h"
#include "estimation/internal/view_footprints.h"
#include "scene/frame.h"
#include "scene/is_finite.h"
#include "scene/upper_median.h"

namespace pleinair {
namespace {

using estimation_internal::kEdgeMarginPx;
using estimation_internal::kFacings;
using estimation_internal::PixelAt;
using estimation_internal::SplitMix64;
using estimation_internal::ViewFootprints;

// Footprints between asking for one's pixels and reading them.
constexpr std::size_t kReadsAhead = 4;
// Robust standard deviations of log albedo inside its region, and the least one of them can be: a
// measured albedo's own error.
constexpr double kAlbedoOutlier = 3.0;
constexpr double kLeastAlbedoSpread = 0.1;
// A filled albedo has about twice the error of a measured one.
constexpr double kFilledAlbedoWeight = 0.25;

void CheckSize(const char* what, int width, int height, int expected_width, int expected_height) {
  if (width == expected_width && height == expected_height) return;
  throw std::invalid_argument(std::string(what) + " is " + std::to_string(width) + "x" +
                              std::to_string(height) + ": expected the view's " +
                              std::to_string(expected_width) + "x" +
                              std::to_string(expected_height));
}

void CheckInput(const SurfaceView& view,
                const RgbImage& radiance,
                const Gray8Image& unusable,
                const SampleSelectionOptions& options) {
  options.Validate();
  CheckSize("frame radiance", radiance.width, radiance.height, view.Width(), view.Height());
  CheckSize("frame unusable mask", unusable.width, unusable.height, view.Width(), view.Height());
  if (view.sky_response.empty() || view.sky_response.size() > kMaxSkyShapes) {
    throw std::invalid_argument("SurfaceView::sky_response has " +
                                std::to_string(view.sky_response.size()) +
                                " shapes: expected 1 .. " + std::to_string(kMaxSkyShapes));
  }
}

// One draw, step by step; lives for the length of Draw.
class SampleDraw {
 public:
  SampleDraw(const SurfaceView& view,
             const glm::dvec3& sun_direction_enu,
             const RgbImage& radiance,
             const Gray8Image& unusable,
             bool takes_grazing,
             const SampleSelectionOptions& options)
      : view_(view),
        footprints_(view, sun_direction_enu, radiance, unusable, takes_grazing),
        options_(options) {}

  // Keeps `kept`, which are of this view.
  std::vector<SampleFootprint> Run(std::vector<SampleFootprint> kept) {
    CollectCandidates();
    DropAlbedoOutliers();
    std::vector<SampleFootprint> footprints = PickShares(std::move(kept));
    SortByPlace(footprints);
    return footprints;
  }

  // Those of another view of this size that this one shows, too.
  std::vector<SampleFootprint> Follow(std::span<const SampleFootprint> before) {
    const Lens lens(view_.camera.intrinsics);
    std::vector<SampleFootprint> followed;
    followed.reserve(before.size());
    for (const SampleFootprint& footprint : before) {
      const std::optional<std::size_t> pixel = footprints_.PixelOf(footprint, lens);
      if (!pixel || !footprints_.IsCandidate(*pixel)) continue;
      std::optional<SampleFootprint> now = footprints_.Gather(*pixel);
      if (!now) continue;
      now->plane = footprint.plane;
      now->place_world_m = footprint.place_world_m;
      now->weight = footprint.weight;
      followed.push_back(*now);
    }
    SortByPlace(followed);
    return followed;
  }
  bool RefusedUnusablePixels() const { return footprints_.RefusedUnusablePixels(); }
  bool LeftOutGrazing() const { return footprints_.LeftOutGrazing(); }

 private:
  struct Candidate {
    std::uint32_t pixel;
    float order;  // Dither rank in [0, 1), then the measured albedos before the filled ones.
  };
  struct Stratum {
    std::vector<Candidate> candidates;
    int region = 0;
    int plane = 0;
    bool is_lit = false;
    std::size_t next = 0;    // Candidates before it are taken or refused.
    std::size_t sorted = 0;  // Candidates before it are in order.
  };

  static void SortByPlace(std::vector<SampleFootprint>& footprints) {
    std::sort(footprints.begin(), footprints.end(), [](const auto& a, const auto& b) {
      return std::tie(a.plane, a.y, a.x) < std::tie(b.plane, b.y, b.x);
    });
  }

  const SurfaceView& view_;
  ViewFootprints footprints_;
  const SampleSelectionOptions& options_;
  std::vector<Stratum> strata_;
  std::unordered_set<std::size_t> is_taken_;  // Pixels of footprints that are kept.
  bool some_measured_ = false;

  void CollectCandidates() {
    const auto regions = view_.region_names.size();
    std::vector<Stratum> all(regions * 2 * kFacings);
    SplitMix64 random(options_.seed);
    // Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018: x a1 + y a2 mod 1
    // over the pixels; those below any threshold are spread evenly.
    constexpr double kStepX = 0.7548776662466927;
    constexpr double kStepY = 0.5698402909980532;
    std::vector<double> phase(all.size());
    for (double& value : phase) value = random.Uniform();
    for (int y = 0; y < view_.Height(); ++y) {
      for (int x = 0; x < view_.Width(); ++x) {
        const std::size_t pixel = view_.region.Index(x, y);
        if (!footprints_.IsCandidate(pixel)) continue;
        const auto region = static_cast<std::size_t>(view_.region.pixels[pixel]);
        if (region >= regions) continue;
        const int plane = footprints_.PlaneAt(pixel);
        const auto cell = static_cast<std::size_t>(2 * plane + (footprints_.IsLit(pixel) ? 1 : 0));
        const double rank = options_.choice == SampleChoice::kRandom
                                ? SplitMix64(options_.seed + pixel * 0x2545f4914f6cdd1du).Uniform()
                                : phase[cell] + x * kStepX + y * kStepY;
        const bool measured = view_.albedo_measured.pixels[pixel] != 0;
        some_measured_ = some_measured_ || measured;
        all[cell].candidates.push_back(
            {static_cast<std::uint32_t>(pixel),
             static_cast<float>(rank - std::floor(rank)) + (measured ? 0.0f : 1.0f)});
        all[cell].region = static_cast<int>(region);
        all[cell].plane = plane;
        all[cell].is_lit = cell % 2 != 0;
      }
    }
    for (Stratum& stratum : all) {
      if (!stratum.candidates.empty()) strata_.push_back(std::move(stratum));
    }
  }

  // Compares with the median of the whole region, lit and shaded: one material has one albedo.
  void DropAlbedoOutliers() {
    for (std::size_t first = 0; first < strata_.size();) {
      std::size_t last = first;
      std::size_t count = 0;
      while (last < strata_.size() && strata_[last].region == strata_[first].region) {
        count += strata_[last++].candidates.size();
      }
      DropAlbedoOutliers(std::span(strata_).subspan(first, last - first), count);
      first = last;
    }
    std::erase_if(strata_, [](const Stratum& stratum) { return stratum.candidates.empty(); });
  }

  void DropAlbedoOutliers(std::span<Stratum> region, std::size_t count) {
    // A median over this many is accurate to 3 % of the spread.
    constexpr std::size_t kEnough = 2000;
    const std::size_t stride = std::max<std::size_t>(1, count / kEnough);
    glm::dvec3 median(0.0);
    glm::dvec3 reach(0.0);
    std::vector<double> values;
    for (int c = 0; c < 3; ++c) {
      values.clear();
      std::size_t index = 0;
      for (const Stratum& stratum : region) {
        for (const Candidate& candidate : stratum.candidates) {
          if (index++ % stride == 0) {
            values.push_back(std::log(double{view_.albedo_rgb.pixels[candidate.pixel][c]}));
          }
        }
      }
      median[c] = UpperMedianInPlace(values);
      for (double& value : values) value = std::abs(value - median[c]);
      reach[c] = kAlbedoOutlier * std::max(kLeastAlbedoSpread, 1.4826 * UpperMedianInPlace(values));
    }
    // Compared as ratios, to spare a logarithm a pixel.
    const glm::vec3 least(glm::exp(median - reach));
    const glm::vec3 largest(glm::exp(median + reach));
    for (Stratum& stratum : region) {
      std::erase_if(stratum.candidates, [&](const Candidate& candidate) {
        const glm::vec3& albedo = view_.albedo_rgb.pixels[candidate.pixel];
        for (int c = 0; c < 3; ++c) {
          if (!(albedo[c] >= least[c] && albedo[c] <= largest[c])) return true;
        }
        return false;
      });
    }
  }

  // Shares of `wanted` footprints for the strata `open`; they add up to it.
  std::vector<std::size_t> Quotas(std::size_t wanted, std::span<const std::size_t> open) const {
    std::vector<std::size_t> quotas(open.size(), wanted / open.size());
    if (options_.choice == SampleChoice::kBalanced) {
      for (std::size_t i = 0; i < wanted % open.size(); ++i) ++quotas[i];
      return quotas;
    }
    std::size_t total = 0;
    for (const std::size_t s : open) total += strata_[s].candidates.size();
    std::size_t sum = 0;
    std::size_t given = 0;
    for (std::size_t i = 0; i < open.size(); ++i) {
      sum += strata_[open[i]].candidates.size();
      quotas[i] = wanted * sum / total - given;
      given += quotas[i];
    }
    return quotas;
  }

  // Gives every stratum its share, `kept` counted; what one cannot fill goes round again.
  std::vector<SampleFootprint> PickShares(std::vector<SampleFootprint> kept) {
    std::vector<SampleFootprint> picked = std::move(kept);
    for (const SampleFootprint& footprint : picked) {
      is_taken_.insert(view_.region.Index(footprint.x, footprint.y));
    }
    std::vector<std::size_t> open(strata_.size());
    std::iota(open.begin(), open.end(), std::size_t{0});
    auto wanted = static_cast<std::size_t>(options_.samples);
    if (!picked.empty() && !open.empty()) {
      const std::vector<std::size_t> shares = Quotas(wanted, open);
      wanted -= std::min(wanted, picked.size());
      for (const std::size_t s : open) {
        const std::size_t has = CountOf(strata_[s], picked);
        wanted -= Pick(s, std::min(wanted, shares[s] - std::min(shares[s], has)), picked);
      }
    }
    while (wanted > 0 && !open.empty()) {
      std::vector<std::size_t> still_open;
      const std::vector<std::size_t> quotas = Quotas(wanted, open);
      for (std::size_t i = 0; i < open.size(); ++i) {
        const std::size_t got = Pick(open[i], quotas[i], picked);
        wanted -= got;
        if (got == quotas[i]) still_open.push_back(open[i]);
      }
      open = std::move(still_open);
    }
    return picked;
  }

  static std::size_t CountOf(const Stratum& stratum, std::span<const SampleFootprint> footprints) {
    return static_cast<std::size_t>(
        std::count_if(footprints.begin(), footprints.end(), [&](const SampleFootprint& footprint) {
          return footprint.plane == stratum.plane && footprint.is_lit == stratum.is_lit;
        }));
  }

  std::size_t Pick(std::size_t stratum_index,
                   std::size_t quota,
                   std::vector<SampleFootprint>& picked) {
    Stratum& stratum = strata_[stratum_index];
    std::size_t got = 0;
    while (got < quota && stratum.next < stratum.candidates.size()) {
      if (stratum.next >= stratum.sorted) SortMore(stratum, 2 * quota);
      const std::uint32_t pixel = stratum.candidates[stratum.next++].pixel;
      if (is_taken_.contains(pixel)) continue;
      std::optional<SampleFootprint> footprint = footprints_.Gather(pixel);
      if (!footprint) continue;
      footprint->plane = stratum.plane;
      const bool is_measured = view_.albedo_measured.pixels[pixel] != 0;
      footprint->weight = some_measured_ && !is_measured ? kFilledAlbedoWeight : 1.0;
      picked.push_back(*footprint);
      ++got;
    }
    return got;
  }

  static void SortMore(Stratum& stratum, std::size_t count) {
    const auto before = [](const Candidate& a, const Candidate& b) {
      return a.order != b.order ? a.order < b.order : a.pixel < b.pixel;
    };
    const auto first = stratum.candidates.begin() + static_cast<std::ptrdiff_t>(stratum.sorted);
    stratum.sorted =
        std::min(stratum.candidates.size(), stratum.sorted + std::max<std::size_t>(count, 16));
    const auto last = stratum.candidates.begin() + static_cast<std::ptrdiff_t>(stratum.sorted);
    if (last != stratum.candidates.end()) {
      std::nth_element(first, last, stratum.candidates.end(), before);
    }
    std::sort(first, last, before);
  }
};

}  // namespace

void SampleSelectionOptions::Validate() const {
  if (samples < 1 || samples > 100000) {
    throw std::invalid_argument("samples is " + std::to_string(samples) + ": expected 1 .. 100000");
  }
}

void SampleSet::Draw(const SurfaceView& view,
                     const glm::dvec3& sun_direction_enu,
                     const RgbImage& radiance,
                     const Gray8Image& unusable,
                     const SampleSelectionOptions& options) {
  footprints_.clear();
  Refill(view, sun_direction_enu, radiance, unusable, options);
}

int SampleSet::Follow(const SurfaceView& view,
                      const glm::dvec3& sun_direction_enu,
                      const RgbImage& radiance,
                      const Gray8Image& unusable,
                      const SampleSelectionOptions& options) {
  CheckInput(view, radiance, unusable, options);
  const bool is_of_size = view.Width() == width_ && view.Height() == height_;
  SampleDraw draw(view, sun_direction_enu, radiance, unusable, takes_grazing_, options);
  footprints_ = is_of_size ? draw.Follow(footprints_) : std::vector<SampleFootprint>();
  return Size();
}

std::vector<PixelRect> SampleSet::PixelsFollowed(const Camera& camera) const {
  // Footprints grow and shrink a little from view to view, and keep their distance to edges, as
  // which the rectangle's rim counts.
  constexpr float kGrowth = 1.25f;
  const Lens lens(camera.intrinsics);
  std::vector<PixelRect> rects;
  rects.reserve(footprints_.size());
  for (const SampleFootprint& footprint : footprints_) {
    const std::optional<glm::ivec2> at = PixelAt(footprint.place_world_m, camera, lens);
    if (!at) continue;
    const float corner = static_cast<float>(footprint.radius + 1) * std::numbers::sqrt2_v<float>;
    const auto reach = static_cast<int>(std::ceil(kGrowth * corner + kEdgeMarginPx)) + 1;
    rects.push_back({*at - reach, *at + reach + 1});
  }
  return rects;
}

void SampleSet::Refill(const SurfaceView& view,
                       const glm::dvec3& sun_direction_enu,
                       const RgbImage& radiance,
                       const Gray8Image& unusable,
                       const SampleSelectionOptions& options) {
  CheckInput(view, radiance, unusable, options);
  width_ = view.Width();
  height_ = view.Height();
  for (const bool takes_grazing : {false, true}) {
    takes_grazing_ = takes_grazing;
    SampleDraw draw(view, sun_direction_enu, radiance, unusable, takes_grazing, options);
    footprints_ = draw.Run(std::move(footprints_));
    short_of_usable_pixels_ = Size() < options.samples && draw.RefusedUnusablePixels();
    // A few places in a mast's shadow are not enough.
    constexpr int kEnoughShare = 10;
    if (!draw.LeftOutGrazing() || Size() * kEnoughShare >= options.samples) return;
  }
}

// Footprints are strewn over the picture: reading them is waiting for memory.
void SampleSet::Prefetch(const SampleFootprint& footprint,
                         const RgbImage& radiance,
                         const Gray8Image& unusable) {
  const int left = footprint.x - footprint.radius;
  const int right = footprint.x + footprint.radius;
  for (int dy = -footprint.radius; dy <= footprint.radius; dy += footprint.stride) {
    const std::size_t first = radiance.Index(left, footprint.y + dy);
    const std::size_t last = radiance.Index(right, footprint.y + dy);
    __builtin_prefetch(&radiance.pixels[first]);
    __builtin_prefetch(&radiance.pixels[last]);
    __builtin_prefetch(&unusable.pixels[first]);
  }
}

int SampleSet::Measure(const glm::dvec3& sun_direction_enu,
                       const RgbImage& radiance,
                       const Gray8Image& unusable,
                       std::vector<DiffuseSample>& samples) const {
  CheckSize("frame radiance", radiance.width, radiance.height, width_, height_);
  CheckSize("frame unusable mask", unusable.width, unusable.height, width_, height_);
  samples.clear();
  samples.reserve(footprints_.size());
  for (std::size_t i = 0; i < footprints_.size(); ++i) {
    if (i + kReadsAhead < footprints_.size()) {
      Prefetch(footprints_[i + kReadsAhead], radiance, unusable);
    }
    const SampleFootprint& footprint = footprints_[i];
    glm::dvec3 sum(0.0);
    unsigned any_unusable = 0;
    const int across = 2 * footprint.radius / footprint.stride + 1;
    const auto stride = static_cast<std::size_t>(footprint.stride);
    for (int row = 0; row < across; ++row) {
      std::size_t pixel = radiance.Index(footprint.x - footprint.radius,
                                         footprint.y - footprint.radius + row * footprint.stride);
      // At most kReadsAcross + 1 values: their sum is as good in float.
      glm::vec3 row_sum(0.0f);
      for (int column = 0; column < across; ++column, pixel += stride) {
        any_unusable |= unusable.pixels[pixel];
        row_sum += radiance.pixels[pixel];
      }
      sum += glm::dvec3(row_sum);
    }
    if ((any_unusable & kUnusable) != 0 || !IsFinite(glm::vec3(sum))) continue;
    DiffuseSample& sample = samples.emplace_back();
    sample.pixels = across * across;
    sample.radiance_rgb = sum / static_cast<double>(sample.pixels);
    for (int c = 0; c < 3; ++c) {
      if ((any_unusable & kClipped[c]) != 0) {
        sample.radiance_stddev_rgb[c] = std::numeric_limits<double>::infinity();
      }
      const double direct =
          std::max(0.0, glm::dot(footprint.direct[static_cast<std::size_t>(c)], sun_direction_enu));
      sample.sun_transport_rgb[c] = direct + footprint.bounce[c];
    }
    sample.sky_transport_rgb = footprint.sky;
    sample.measured_albedo_rgb = footprint.measured_albedo;
    sample.weight = footprint.weight;
    sample.plane = footprint.plane;
    sample.is_lit = footprint.is_lit;
    sample.pixel = {footprint.x, footprint.y};
    sample.place_world_m = footprint.place_world_m;
  }
  return Size() - static_cast<int>(samples.size());
}

}  // namespace pleinair
