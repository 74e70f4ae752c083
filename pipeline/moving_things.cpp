#include "pipeline/moving_things.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "scene/is_finite.h"

namespace pleinair {
namespace {

// Nearer to an edge of the model than that, a mesh or pose that is slightly off shows another
// surface.
constexpr float kEdgePx = 3.0f;
// Frames in which a block has to be seen, and blocks that make a class, before medians mean
// anything.
constexpr std::size_t kFewestFrames = 5;
constexpr std::size_t kFewestBlocks = 20;

float MedianOf(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

float Rms(const glm::vec3& v) { return std::sqrt(glm::dot(v, v) / 3.0f); }

// The change nearest to `change` between shade and sun, with one share of the sun for all channels.
glm::vec3 NearestSunlit(const glm::vec3& change, const glm::vec3& shaded, const glm::vec3& lit) {
  const glm::vec3 way = lit - shaded;
  const float length2 = glm::dot(way, way);
  if (!(length2 > 0.0f)) return shaded;
  return shaded + std::clamp(glm::dot(change - shaded, way) / length2, 0.0f, 1.0f) * way;
}

// Radiance per channel of a block, summed over its pixels.
struct BlockSums {
  glm::dvec3 seen{0.0};
  glm::dvec3 model{0.0};
  glm::dvec3 lit{0.0};
  glm::dvec3 shaded{0.0};
};

// The model's radiance of one pixel: with its own, all and none of the disc.
void AddPixel(const SurfaceView& view,
              const Lighting& lighting,
              std::size_t pixel,
              const glm::vec3& seen,
              BlockSums& sums) {
  const glm::dvec3 reflected = glm::dvec3(view.albedo_rgb.pixels[pixel]) / std::numbers::pi;
  glm::dvec3 sky(0.0);
  for (std::size_t k = 0; k < lighting.sky.size(); ++k) {
    sky += lighting.sky[k].irradiance_rgb * glm::dvec3(view.sky_response[k].pixels[pixel]);
  }
  const glm::dvec3 sun = lighting.sun.irradiance_rgb;
  const double n_dot_l = std::max(
      0.0, glm::dot(glm::dvec3(view.normal_world.pixels[pixel]), lighting.sun.direction_enu));
  const glm::dvec3 shaded = sky + sun * glm::dvec3(view.sun_bounce.pixels[pixel]);
  sums.seen += glm::dvec3(seen);
  sums.shaded += reflected * shaded;
  sums.lit += reflected * (shaded + sun * n_dot_l);
  sums.model += reflected * (shaded + sun * (view.sun_visibility.pixels[pixel] * n_dot_l));
}

// Index of one of 27 parts of the sphere, by the signs of the components that are not near 0.
int SideOf(const glm::vec3& normal) {
  int side = 0;
  for (int i = 0; i < 3; ++i) {
    side = 3 * side + (normal[i] > 0.3f ? 2 : normal[i] < -0.3f ? 0 : 1);
  }
  return side;
}

// Blocks of which all eight neighbours are set as well, with their neighbours: what is narrower
// than three blocks goes.
std::vector<std::uint8_t> Opened(const std::vector<std::uint8_t>& set, int columns, int rows) {
  std::vector<std::uint8_t> opened(set.size(), 0);
  const auto at = [&](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(x);
  };
  for (int y = 1; y + 1 < rows; ++y) {
    for (int x = 1; x + 1 < columns; ++x) {
      bool all = true;
      for (int k = 0; k < 9; ++k) all = all && set[at(x + k % 3 - 1, y + k / 3 - 1)] != 0;
      if (!all) continue;
      for (int k = 0; k < 9; ++k) opened[at(x + k % 3 - 1, y + k / 3 - 1)] = 1;
    }
  }
  return opened;
}

}  // namespace

void MovingThingsOptions::Validate() const {
  const auto refuse = [](const char* field, double value) {
    throw std::invalid_argument(fmt::format("MovingThingsOptions::{}: found {}", field, value));
  };
  if (!(least_change > 0.0)) refuse("least_change", least_change);
  if (!(least_share >= 0.0 && least_share <= 1.0)) refuse("least_share", least_share);
  if (least_frames < 1) refuse("least_frames", least_frames);
  if (most_blocks < 1) refuse("most_blocks", most_blocks);
}

MovingThings::MovingThings(const MovingThingsOptions& options) : options_(options) {
  options.Validate();
}

// None unless the block shows surfaces alone, away from edges and usable in every pixel.
std::optional<MovingThings::Seen> MovingThings::SeeBlock(const Frame& frame,
                                                         const SurfaceView& view,
                                                         const Lighting& lighting,
                                                         int column,
                                                         int row) const {
  BlockSums sums;
  for (int y = row * block_px_; y < std::min(view.Height(), (row + 1) * block_px_); ++y) {
    for (int x = column * block_px_; x < std::min(view.Width(), (column + 1) * block_px_); ++x) {
      const std::size_t pixel = view.region.Index(x, y);
      if (view.region.pixels[pixel] == SurfaceView::kNoRegion ||
          !(view.edge_distance_px.pixels[pixel] > kEdgePx) || frame.unusable.pixels[pixel] != 0) {
        return std::nullopt;
      }
      AddPixel(view, lighting, pixel, frame.radiance.pixels[pixel], sums);
    }
  }
  Seen seen{glm::vec3(glm::log(sums.seen / sums.model)),
            glm::vec3(glm::log(sums.lit / sums.model)),
            glm::vec3(glm::log(sums.shaded / sums.model))};
  if (!IsFinite(seen.ratio) || !IsFinite(seen.lit) || !IsFinite(seen.shaded)) return std::nullopt;
  return seen;
}

bool MovingThings::Add(const Frame& frame, const SurfaceView& view, const Lighting& lighting) {
  if (frames_.empty()) {
    camera_ = view.camera;
    const double pixels = static_cast<double>(view.Width()) * view.Height();
    block_px_ = std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / options_.most_blocks))));
    columns_ = (view.Width() + block_px_ - 1) / block_px_;
    rows_ = (view.Height() + block_px_ - 1) / block_px_;
    region_names_ = view.region_names;
    region_ = view.region;
    may_be_sampled_ = view.may_be_sampled;
  }
  if (!(view.camera == camera_)) return false;
  for (std::size_t i = 0; i < may_be_sampled_.pixels.size(); ++i) {
    may_be_sampled_.pixels[i] |= view.may_be_sampled.pixels[i];
  }
  // Walls of one group that face different sides have light of their own.
  std::map<std::tuple<std::int32_t, int, bool>, std::int32_t> classes;
  SeenFrame seen;
  seen.blocks.reserve(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      Seen& block = seen.blocks.emplace_back();
      const auto found = SeeBlock(frame, view, lighting, column, row);
      if (!found) continue;
      block = *found;
      const std::size_t pixel = view.region.Index(column * block_px_, row * block_px_);
      block.light_class = classes
                              .try_emplace({view.region.pixels[pixel],
                                            SideOf(view.normal_world.pixels[pixel]),
                                            view.sun_visibility.pixels[pixel] > 0.5f},
                                           static_cast<std::int32_t>(classes.size()))
                              .first->second;
    }
  }
  seen.classes = static_cast<std::int32_t>(classes.size());
  frames_.push_back(std::move(seen));
  return true;
}

// The changes without the block's own part and its class's part in the frame; NaN where nothing is
// known. Both parts are medians, computed in turn, the second time without each other.
MovingThings::Changes MovingThings::UnusualChanges() const {
  constexpr int kRounds = 2;
  constexpr float kNotKnown = std::numeric_limits<float>::quiet_NaN();
  const std::size_t blocks = frames_.front().blocks.size();
  Changes changes(frames_.size());
  for (std::size_t f = 0; f < frames_.size(); ++f) {
    for (const Seen& seen : frames_[f].blocks) {
      changes[f].push_back(seen.light_class < 0 ? glm::vec3(kNotKnown) : seen.ratio);
    }
  }
  std::vector<float> values;
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t block = 0; block < blocks; ++block) {
      for (int c = 0; c < 3; ++c) {
        values.clear();
        for (const auto& frame : changes) {
          if (!std::isnan(frame[block][c])) values.push_back(frame[block][c]);
        }
        const bool is_known = values.size() >= std::min(kFewestFrames, frames_.size());
        const float own = is_known ? MedianOf(values) : kNotKnown;
        for (auto& frame : changes) frame[block][c] -= own;
      }
    }
    for (std::size_t f = 0; f < frames_.size(); ++f) {
      for (int c = 0; c < 3; ++c) {
        std::vector<std::vector<float>> members(static_cast<std::size_t>(frames_[f].classes));
        const auto members_of = [&](std::size_t block) -> std::vector<float>* {
          if (std::isnan(changes[f][block][c])) return nullptr;
          return &members[static_cast<std::size_t>(frames_[f].blocks[block].light_class)];
        };
        for (std::size_t block = 0; block < blocks; ++block) {
          if (auto* of_class = members_of(block)) of_class->push_back(changes[f][block][c]);
        }
        std::vector<float> usual;
        usual.reserve(members.size());
        for (auto& of_class : members) {
          usual.push_back(of_class.size() >= kFewestBlocks ? MedianOf(of_class) : 0.0f);
        }
        for (std::size_t block = 0; block < blocks; ++block) {
          if (const auto* of_class = members_of(block)) {
            changes[f][block][c] -= usual[static_cast<std::size_t>(of_class - members.data())];
          }
        }
      }
    }
  }
  return changes;
}

MovingThingsFound MovingThings::Find() const {
  MovingThingsFound found;
  found.frames = static_cast<int>(frames_.size());
  if (frames_.empty()) return found;
  const std::size_t blocks = frames_.front().blocks.size();
  const Changes changes = UnusualChanges();

  std::vector<int> seen_in(blocks, 0);
  std::vector<int> hidden_in(blocks, 0);
  std::vector<std::vector<float>> sizes(blocks);
  for (std::size_t f = 0; f < frames_.size(); ++f) {
    std::vector<std::uint8_t> is_hidden(blocks, 0);
    for (std::size_t block = 0; block < blocks; ++block) {
      const glm::vec3& change = changes[f][block];
      if (!IsFinite(change)) continue;
      ++seen_in[block];
      sizes[block].push_back(Rms(change));
      const Seen& seen = frames_[f].blocks[block];
      is_hidden[block] =
          Rms(change - NearestSunlit(change, seen.shaded, seen.lit)) > options_.least_change;
    }
    is_hidden = Opened(is_hidden, columns_, rows_);
    for (std::size_t block = 0; block < blocks; ++block) hidden_in[block] += is_hidden[block];
  }
  std::vector<float> values;
  for (auto& size : sizes) {
    if (!size.empty()) values.push_back(MedianOf(size));
  }
  if (!values.empty()) found.typical_change = MedianOf(values);

  std::vector<std::uint8_t> moves(blocks, 0);
  for (std::size_t block = 0; block < blocks; ++block) {
    moves[block] = hidden_in[block] >= options_.least_frames &&
                   hidden_in[block] >= options_.least_share * seen_in[block];
  }
  found.mask = Gray8Image(region_.width, region_.height);
  found.hidden_share = Image<float>(region_.width, region_.height, 0.0f);
  found.regions.resize(region_names_.size());
  for (std::size_t r = 0; r < region_names_.size(); ++r) found.regions[r].name = region_names_[r];
  for (int y = 0; y < region_.height; ++y) {
    for (int x = 0; x < region_.width; ++x) {
      const int column = x / block_px_;
      const int row = y / block_px_;
      bool is_masked = false;
      for (int k = 0; k < 9; ++k) {
        const int near_column = std::clamp(column + k % 3 - 1, 0, columns_ - 1);
        const int near_row = std::clamp(row + k / 3 - 1, 0, rows_ - 1);
        is_masked = is_masked ||
                    moves[static_cast<std::size_t>(near_row) * static_cast<std::size_t>(columns_) +
                          static_cast<std::size_t>(near_column)] != 0;
      }
      found.mask.At(x, y) = is_masked ? 0 : 255;
      const std::size_t block = static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                                static_cast<std::size_t>(column);
      if (seen_in[block] > 0) {
        found.hidden_share.At(x, y) =
            static_cast<float>(hidden_in[block]) / static_cast<float>(seen_in[block]);
      }
      const std::int32_t region = region_.At(x, y);
      if (region == SurfaceView::kNoRegion || may_be_sampled_.At(x, y) == 0) continue;
      ++found.regions[static_cast<std::size_t>(region)].pixels;
      found.regions[static_cast<std::size_t>(region)].masked += is_masked;
    }
  }
  std::erase_if(found.regions, [](const auto& region) { return region.pixels == 0; });
  return found;
}

}  // namespace pleinair
