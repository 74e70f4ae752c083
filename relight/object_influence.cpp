#include "relight/object_influence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

#include "relight/internal/basis_sum.h"
#include "relight/internal/object_cone.h"
#include "relight/internal/plane_blocks.h"

namespace pleinair {
namespace {

// See the header.
constexpr float kLeastShare = 1.0f / 1024.0f;
constexpr float kLeastChange = 1.0f / 512.0f;
// Sides of the blocks that share a receiver, in pixels: odd, so that a pixel is in the middle.
constexpr std::array<int, 3> kBlocksPx{1, 3, 7};
// What an object covers has no receiver. Where its edge lets the surface shine through, one within
// a block of three is found.
constexpr std::size_t kCoveredSize = 1;
// A block's side on the surface is at most this share of the distance to the object, over which
// the object's share of the view changes by about as much of itself. Two fifths or a quarter: no
// pixel of the recordings differs by more than one code value.
constexpr float kBlockPerDistance = 0.4f;

// How the pixels of a view are served.
struct PixelPlan {
  Gray8Image size;     // 0 where no object can matter, else 1 + the index of its block's side.
  Gray8Image covered;  // Where a size is: an object hides the surface that the view speaks of.
};

PixelPlan PlanPixels(const PatchScene& objects,
                     const std::vector<std::optional<ObjectBounds>>& bounds,
                     const SurfaceView& view) {
  PixelPlan plan{Gray8Image(view.Width(), view.Height(), 0),
                 Gray8Image(view.Width(), view.Height(), 0)};
  const glm::vec3 eye_m(view.camera.CentreWorldM());
  const auto focal_px =
      static_cast<float>(std::sqrt(view.camera.intrinsics.fx_px * view.camera.intrinsics.fy_px));
  tbb::parallel_for(0, view.Height(), [&](int y) {
    for (int x = 0; x < view.Width(); ++x) {
      const std::size_t pixel = view.region.Index(x, y);
      if (view.region.pixels[pixel] == SurfaceView::kNoRegion) continue;
      const glm::vec3& position_m = view.position_world_m.pixels[pixel];
      const glm::vec3& normal = view.normal_world.pixels[pixel];
      float share = 0.0f;
      float distance_m = std::numeric_limits<float>::infinity();
      for (const std::optional<ObjectBounds>& object : bounds) {
        if (!object) continue;
        share += ObjectCone(*object, position_m).LargestShare(normal);
        distance_m = std::min(distance_m, DistanceTo(object->box, position_m));
      }
      if (!(share > kLeastShare)) continue;
      // The longer side of a pixel on the surface.
      const float range_m = glm::distance(eye_m, position_m);
      const float cosine = std::abs(glm::dot(normal, position_m - eye_m)) / range_m;
      const float pixel_m = range_m / (focal_px * std::max(cosine, 1e-3f));
      std::size_t size = 0;
      while (size + 1 < kBlocksPx.size() &&
             static_cast<float>(kBlocksPx[size + 1]) * pixel_m < kBlockPerDistance * distance_m) {
        ++size;
      }
      const glm::vec3 start_m = OffsetFromSurface(position_m, normal);
      const glm::vec3 to_eye_m = eye_m - start_m;
      const float start_range_m = glm::length(to_eye_m);
      if (objects.caster.Occluded(start_m, to_eye_m / start_range_m, start_range_m)) {
        plan.covered.pixels[pixel] = 1;
        size = std::max(size, kCoveredSize);
      }
      plan.size.pixels[pixel] = static_cast<std::uint8_t>(1 + size);
    }
  });
  return plan;
}

// Pixels that may hold a receiver for blocks of size `size`: those of the blocks around any pixel
// that has that size.
Gray8Image Candidates(const PixelPlan& plan, std::size_t size) {
  const int block_px = kBlocksPx[size];
  const int width = plan.size.width;
  const int height = plan.size.height;
  Gray8Image around((width + block_px - 1) / block_px, (height + block_px - 1) / block_px, 0);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (plan.size.At(x, y) != 1 + size) continue;
      // A block of one pixel serves that pixel alone.
      const int margin = block_px > 1 ? 1 : 0;
      for (int row = y / block_px - margin; row <= y / block_px + margin; ++row) {
        for (int column = x / block_px - margin; column <= x / block_px + margin; ++column) {
          if (around.Contains(column, row)) around.At(column, row) = 1;
        }
      }
    }
  }
  Gray8Image candidates(width, height, 0);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (around.At(x / block_px, y / block_px) == 0) continue;
      candidates.At(x, y) = plan.size.At(x, y) != 0 && plan.covered.At(x, y) == 0 ? 1 : 0;
    }
  }
  return candidates;
}

void RequireFaces(std::size_t given, std::size_t expected, const char* what) {
  if (given != expected) {
    throw std::invalid_argument(std::string("object influence: ") + what + " has " +
                                std::to_string(given) + " faces, expected " +
                                std::to_string(expected));
  }
}

}  // namespace

void ObjectInfluenceOptions::Validate() const {
  if (rays_per_receiver < 1 || rays_per_receiver > 65536) {
    throw std::invalid_argument("rays_per_receiver is " + std::to_string(rays_per_receiver) +
                                ": expected 1 to 65536");
  }
}

ObjectInfluence::ObjectInfluence(const PatchScene& real,
                                 const PatchScene& objects,
                                 const SurfaceView& view,
                                 const ObjectInfluenceOptions& options)
    : real_faces_(real.FaceCount()),
      object_faces_(objects.FaceCount()),
      picture_width_px_(view.Width()),
      picture_height_px_(view.Height()) {
  options.Validate();
  const PixelPlan plan = PlanPixels(objects, BoundsOfObjects(objects.mesh), view);
  glm::ivec2 lower(view.Width(), view.Height());
  glm::ivec2 upper(-1);
  for (int y = 0; y < view.Height(); ++y) {
    for (int x = 0; x < view.Width(); ++x) {
      if (plan.size.At(x, y) == 0) continue;
      lower = glm::min(lower, glm::ivec2(x, y));
      upper = glm::max(upper, glm::ivec2(x, y));
    }
  }
  if (upper.x < lower.x) return;
  x_px_ = lower.x;
  y_px_ = lower.y;
  width_px_ = upper.x + 1 - lower.x;
  height_px_ = upper.y + 1 - lower.y;

  const glm::vec3 eye_m(view.camera.CentreWorldM());
  std::vector<PlaneBlocks> blocks;
  std::vector<std::uint32_t> first_receiver;
  for (std::size_t size = 0; size < kBlocksPx.size(); ++size) {
    const Gray8Image candidates = Candidates(plan, size);
    blocks.emplace_back(
        view,
        eye_m,
        PlaneBlocks::Options{
            .block_px = kBlocksPx[size], .wraps_x = false, .candidates = &candidates});
    first_receiver.push_back(static_cast<std::uint32_t>(receivers_.size()));
    for (const std::size_t pixel : blocks.back().ReceiverPixels()) {
      receivers_.push_back(
          {.pixel = pixel,
           .place = {view.position_world_m.pixels[pixel], view.normal_world.pixels[pixel]},
           .lower_px = {width_px_, height_px_},
           .upper_px = {},
           .hits = {}});
    }
  }
  entry_begin_.assign(1, 0);
  for (int y = y_px_; y < y_px_ + height_px_; ++y) {
    for (int x = x_px_; x < x_px_ + width_px_; ++x) {
      const std::size_t first = entries_.size();
      if (plan.size.At(x, y) != 0) {
        const std::size_t size = plan.size.At(x, y) - 1u;
        double sum = 0.0;
        blocks[size].ForPixel(x, y, [&](std::uint32_t receiver, double weight) {
          entries_.push_back({first_receiver[size] + receiver, static_cast<float>(weight)});
          sum += weight;
        });
        const glm::ivec2 place(x - x_px_, y - y_px_);
        for (std::size_t i = first; i < entries_.size(); ++i) {
          entries_[i].weight = static_cast<float>(entries_[i].weight / sum);
          ReceiverHits& receiver = receivers_[entries_[i].receiver];
          receiver.lower_px = glm::min(receiver.lower_px, place);
          receiver.upper_px = glm::max(receiver.upper_px, place + 1);
        }
      }
      entry_begin_.push_back(static_cast<std::uint32_t>(entries_.size()));
    }
  }
  Gather(real, objects, options.rays_per_receiver);
}

std::vector<Receiver> ObjectInfluence::Receivers() const {
  std::vector<Receiver> receivers;
  receivers.reserve(receivers_.size());
  for (const ReceiverHits& receiver : receivers_) receivers.push_back(receiver.place);
  return receivers;
}

void ObjectInfluence::Gather(const PatchScene& real,
                             const PatchScene& objects,
                             int rays_per_receiver) {
  const std::vector<std::optional<ObjectBounds>> bounds = BoundsOfObjects(objects.mesh);
  // What is a small share of a surface's view bears a larger error in itself: half the rays for
  // half the share.
  constexpr float kShareOfAllRays = 1.0f / 16.0f;
  const ConeDirections direction_sets[] = {ConeDirections(rays_per_receiver),
                                           ConeDirections((rays_per_receiver + 1) / 2),
                                           ConeDirections((rays_per_receiver + 3) / 4),
                                           ConeDirections((rays_per_receiver + 7) / 8)};
  tbb::parallel_for(std::size_t{0}, receivers_.size(), [&](std::size_t i) {
    ReceiverHits& receiver = receivers_[i];
    const auto& [position_m, normal] = receiver.place;
    const glm::vec3 start_m = OffsetFromSurface(position_m, normal);
    for (std::size_t group = 0; group < bounds.size(); ++group) {
      if (!bounds[group]) continue;
      const BoundingBox& box = bounds[group]->box;
      const ObjectCone cone(*bounds[group], position_m);
      const float share_of_rays = cone.LargestShare(normal) / kShareOfAllRays;
      std::size_t set = 0;
      while (set + 1 < std::size(direction_sets) &&
             share_of_rays < 1.0f / static_cast<float>(1u << set)) {
        ++set;
      }
      direction_sets[set].ForEach(cone, normal, [&](const glm::vec3& direction, float share) {
        if (!MayMeet(box, start_m, direction)) return;
        const auto hit = objects.caster.Intersect(start_m, direction);
        // Cones may overlap: each object's own cone counts it.
        if (!hit || objects.mesh.triangle_group[hit->triangle] != group) return;
        const auto behind = real.caster.Intersect(start_m, direction);
        if (behind && behind->distance_m < hit->distance_m) return;
        receiver.hits.push_back(
            {share,
             PatchScene::FaceOfHit(*hit, direction),
             behind ? PatchScene::FaceOfHit(*behind, direction) : PatchScene::kSky,
             direction});
      });
    }
  });
}

void ObjectInfluence::Fold(std::size_t light,
                           const SkyShape* sky,
                           const SurfaceView& view,
                           std::span<const glm::vec3> real_radiosity,
                           std::span<const glm::vec3> object_radiosity,
                           std::span<const glm::vec3> hidden_sky) {
  if (!hidden_sky.empty() && hidden_sky.size() != receivers_.size()) {
    throw std::invalid_argument(std::string("object influence: hidden_sky has ") +
                                std::to_string(hidden_sky.size()) + " entries, expected " +
                                std::to_string(receivers_.size()) + ", one a receiver");
  }
  RequireFaces(real_radiosity.size(), real_faces_, "the real scene's radiosity");
  RequireFaces(object_radiosity.size(), object_faces_, "the objects' radiosity");
  if (view.Width() != picture_width_px_ || view.Height() != picture_height_px_ ||
      (light > 0 && view.sky_response.size() < light)) {
    throw std::invalid_argument("object influence: basis light " + std::to_string(light) +
                                " of a view of " + std::to_string(view.Width()) + "x" +
                                std::to_string(view.Height()) + " with " +
                                std::to_string(view.sky_response.size()) +
                                " sky shapes: expected the view of construction");
  }
  if (responses_.size() <= light) responses_.resize(light + 1);
  std::vector<Response>& responses = responses_[light];
  responses.resize(receivers_.size());
  tbb::parallel_for(std::size_t{0}, receivers_.size(), [&](std::size_t i) {
    Response response;
    if (!hidden_sky.empty()) response.hidden = hidden_sky[i];
    for (const Hit& hit : receivers_[i].hits) {
      if (hit.behind != PatchScene::kSky) {
        response.hidden += hit.share * real_radiosity[static_cast<std::size_t>(hit.behind)];
      } else if (sky != nullptr) {
        response.hidden += hit.share * std::numbers::pi_v<float> * sky->Radiance(hit.direction);
      }
      response.gained += hit.share * object_radiosity[static_cast<std::size_t>(hit.object_face)];
    }
    response.before = light == 0 ? SunResponse(view, receivers_[i].pixel, view.sun_direction_enu)
                                 : view.sky_response[light - 1].pixels[receivers_[i].pixel];
    responses[i] = response;
  });
}

std::vector<glm::vec3> ObjectInfluence::AtReceivers(const Lighting& lighting,
                                                    const InfluenceParts& parts) const {
  const std::vector<glm::vec3> weights =
      internal::BasisWeights(lighting, responses_.size(), "object influence");
  std::vector<glm::vec3> at_receivers(receivers_.size());
  for (std::size_t i = 0; i < receivers_.size(); ++i) {
    Response sum;
    for (std::size_t light = 0; light < weights.size(); ++light) {
      const Response& response = responses_[light][i];
      sum.hidden += weights[light] * response.hidden;
      sum.gained += weights[light] * response.gained;
      sum.before += weights[light] * response.before;
    }
    const glm::vec3 change = (parts.object_light ? sum.gained : glm::vec3(0.0f)) -
                             (parts.hidden_light ? sum.hidden : glm::vec3(0.0f));
    const bool matters = glm::any(glm::greaterThan(glm::abs(change), kLeastChange * sum.before));
    at_receivers[i] = matters ? change : glm::vec3(0.0f);
  }
  return at_receivers;
}

void ObjectInfluence::Evaluate(const Lighting& lighting,
                               const InfluenceParts& parts,
                               IrradianceChange& change) const {
  RgbImage& image = change.irradiance_rgb;
  image.width = 0;
  image.height = 0;
  image.pixels.clear();
  if (receivers_.empty()) return;
  const std::vector<glm::vec3> at_receivers = AtReceivers(lighting, parts);
  const auto entries_of = [this](int x, int y) {
    const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_px_) +
                          static_cast<std::size_t>(x);
    return std::span(entries_).subspan(entry_begin_[i], entry_begin_[i + 1] - entry_begin_[i]);
  };
  glm::ivec2 lower(width_px_, height_px_);
  glm::ivec2 upper(0);
  for (std::size_t i = 0; i < receivers_.size(); ++i) {
    if (at_receivers[i] == glm::vec3(0.0f)) continue;
    lower = glm::min(lower, receivers_[i].lower_px);
    upper = glm::max(upper, receivers_[i].upper_px);
  }
  if (upper.x <= lower.x) return;
  change.x_px = x_px_ + lower.x;
  change.y_px = y_px_ + lower.y;
  image.width = upper.x - lower.x;
  image.height = upper.y - lower.y;
  image.pixels.resize(static_cast<std::size_t>(image.width) *
                      static_cast<std::size_t>(image.height));
  tbb::parallel_for(0, image.height, [&](int y) {
    for (int x = 0; x < image.width; ++x) {
      glm::vec3 sum(0.0f);
      for (const Entry& entry : entries_of(lower.x + x, lower.y + y)) {
        sum += entry.weight * at_receivers[entry.receiver];
      }
      image.At(x, y) = sum;
    }
  });
}

}  // namespace pleinair
