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
#include "relight/internal/low_discrepancy.h"
#include "relight/internal/plane_blocks.h"

namespace pleinair {
namespace {

// See the header.
constexpr float kLeastShare = 1.0f / 1024.0f;
constexpr float kLeastChange = 1.0f / 512.0f;
// Sides of the blocks that share a receiver, in pixels. Two is as fine as it gets: a pixel that an
// object's edge covers half has then always a receiver that none covers beside it.
constexpr std::array<int, 3> kBlocksPx{2, 4, 8};
// A block's side on the surface is at most this share of the distance to the object, over which
// the object's share of the view changes by about as much of itself.
constexpr float kBlockPerDistance = 0.25f;

struct Bounds {
  glm::vec3 centre_m{0.0f};
  float radius_m = 0.0f;
  BoundingBox box;
};

// Of each group's triangles; none for a group without any.
std::vector<std::optional<Bounds>> BoundsOfObjects(const Mesh& mesh) {
  std::vector<std::optional<Bounds>> bounds(mesh.group_names.size());
  const auto for_corners = [&mesh](const auto& visit) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (int corner = 0; corner < 3; ++corner) {
        visit(mesh.triangle_group[t], mesh.positions_m[mesh.triangles[t][corner]]);
      }
    }
  };
  for_corners([&](std::uint32_t group, const glm::vec3& position_m) {
    if (!bounds[group]) bounds[group] = Bounds{{}, 0.0f, {position_m, position_m}};
    bounds[group]->box.lower_m = glm::min(bounds[group]->box.lower_m, position_m);
    bounds[group]->box.upper_m = glm::max(bounds[group]->box.upper_m, position_m);
  });
  for (std::optional<Bounds>& object : bounds) {
    if (object) object->centre_m = 0.5f * (object->box.lower_m + object->box.upper_m);
  }
  for_corners([&](std::uint32_t group, const glm::vec3& position_m) {
    bounds[group]->radius_m =
        std::max(bounds[group]->radius_m, glm::distance(position_m, bounds[group]->centre_m));
  });
  return bounds;
}

// The directions in which an object's bounding sphere is seen.
struct Cone {
  glm::vec3 axis{0.0f};
  // 1 - cos of the half angle: solid angle / 2 pi. 2 from inside.
  float one_minus_cos = 2.0f;
};

Cone ConeOf(const Bounds& object, const glm::vec3& from_m) {
  const glm::vec3 apart = object.centre_m - from_m;
  const float distance_m = glm::length(apart);
  if (!(distance_m > object.radius_m)) return {};
  const float sine = object.radius_m / distance_m;
  return {apart / distance_m, sine * sine / (1.0f + std::sqrt(1.0f - sine * sine))};
}

// Bound of the share of a cosine-weighted hemisphere that the cone fills.
float LargestShare(const Cone& cone, const glm::vec3& normal) {
  const float cos_half = 1.0f - cone.one_minus_cos;
  const float cos_axis = glm::clamp(glm::dot(normal, cone.axis), -1.0f, 1.0f);
  // Largest cosine in the cone: of the angle to the axis less the half angle.
  float largest = 1.0f;
  if (cos_half > 0.0f && cos_axis < cos_half) {
    const float sin_half = std::sqrt(1.0f - cos_half * cos_half);
    const float sin_axis = std::sqrt(1.0f - cos_axis * cos_axis);
    largest = cos_axis * cos_half + sin_axis * sin_half;
  }
  return std::min(1.0f, 2.0f * cone.one_minus_cos * std::max(largest, 0.0f));
}

float DistanceTo(const BoundingBox& box, const glm::vec3& position_m) {
  return glm::distance(position_m, glm::clamp(position_m, box.lower_m, box.upper_m));
}

// Directions with the share of the cosine-weighted hemisphere that each stands for.
//
// The same set at every receiver, standing on its plane or turned with its cone, so that what the
// set misses changes smoothly over a surface and does not show as noise.
template <class Visit>  // visit(direction, share)
void ForDirections(const Cone& cone, const glm::vec3& normal, int count, const Visit& visit) {
  const NormalFrame hemisphere(normal);
  // From a half angle of 60 deg on, a cosine-distributed ray stands nowhere for more than one that
  // is uniform over the cone: the hemisphere's own set is the better one.
  if (cone.one_minus_cos > 0.5f) {
    for (int k = 0; k < count; ++k) {
      visit(hemisphere.CosineDirection(FibonacciPoint(k, count, {0.0, 0.0})),
            1.0f / static_cast<float>(count));
    }
    return;
  }
  glm::vec3 across = glm::cross(normal, cone.axis);
  const float length = glm::length(across);
  // Straight above there is no such direction; a ring around the axis is then any direction's.
  across = length > 1e-4f ? across / length : hemisphere.tangent;
  const glm::vec3 upwards = glm::normalize(glm::cross(cone.axis, across));
  for (int k = 0; k < count; ++k) {
    const glm::dvec2 point = FibonacciPoint(k, count, {0.0, 0.0});
    const double down = point.x * static_cast<double>(cone.one_minus_cos);
    const double radius = std::sqrt(down * (2.0 - down));
    const double angle = 2.0 * std::numbers::pi * point.y;
    const glm::vec3 direction =
        glm::normalize(static_cast<float>(radius * std::cos(angle)) * across +
                       static_cast<float>(radius * std::sin(angle)) * upwards +
                       static_cast<float>(1.0 - down) * cone.axis);
    const float cosine = glm::dot(normal, direction);
    if (cosine > 0.0f) {
      visit(direction, 2.0f * cone.one_minus_cos * cosine / static_cast<float>(count));
    }
  }
}

// Per pixel 0 where no object can matter, else 1 + the index of its block's side.
Gray8Image BlockSizes(const std::vector<std::optional<Bounds>>& objects, const SurfaceView& view) {
  Gray8Image sizes(view.Width(), view.Height(), 0);
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
      for (const std::optional<Bounds>& object : objects) {
        if (!object) continue;
        share += LargestShare(ConeOf(*object, position_m), normal);
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
      sizes.pixels[pixel] = static_cast<std::uint8_t>(1 + size);
    }
  });
  return sizes;
}

// Pixels that may hold a receiver for blocks of size `size`: those of the blocks around any pixel
// that has that size. An object's own pixels show another surface than the view says.
Gray8Image Candidates(const Gray8Image& sizes,
                      std::size_t size,
                      const RayCaster& objects,
                      const SurfaceView& view) {
  const int block_px = kBlocksPx[size];
  Gray8Image around(
      (view.Width() + block_px - 1) / block_px, (view.Height() + block_px - 1) / block_px, 0);
  for (int y = 0; y < view.Height(); ++y) {
    for (int x = 0; x < view.Width(); ++x) {
      if (sizes.At(x, y) != 1 + size) continue;
      for (int row = y / block_px - 1; row <= y / block_px + 1; ++row) {
        for (int column = x / block_px - 1; column <= x / block_px + 1; ++column) {
          if (around.Contains(column, row)) around.At(column, row) = 1;
        }
      }
    }
  }
  const glm::vec3 eye_m(view.camera.CentreWorldM());
  Gray8Image candidates(view.Width(), view.Height(), 0);
  tbb::parallel_for(0, view.Height(), [&](int y) {
    for (int x = 0; x < view.Width(); ++x) {
      if (around.At(x / block_px, y / block_px) == 0) continue;
      const std::size_t pixel = view.region.Index(x, y);
      if (view.region.pixels[pixel] == SurfaceView::kNoRegion) continue;
      const glm::vec3 start_m =
          OffsetFromSurface(view.position_world_m.pixels[pixel], view.normal_world.pixels[pixel]);
      const float range_m = glm::distance(eye_m, start_m);
      candidates.pixels[pixel] =
          objects.Occluded(start_m, (eye_m - start_m) / range_m, range_m) ? 0 : 1;
    }
  });
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
  const Gray8Image sizes = BlockSizes(BoundsOfObjects(objects.mesh), view);
  glm::ivec2 lower(view.Width(), view.Height());
  glm::ivec2 upper(-1);
  for (int y = 0; y < view.Height(); ++y) {
    for (int x = 0; x < view.Width(); ++x) {
      if (sizes.At(x, y) == 0) continue;
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
    const Gray8Image candidates = Candidates(sizes, size, objects.caster, view);
    blocks.emplace_back(
        view,
        eye_m,
        PlaneBlocks::Options{
            .block_px = kBlocksPx[size], .wraps_x = false, .candidates = &candidates});
    first_receiver.push_back(static_cast<std::uint32_t>(receivers_.size()));
    for (const std::size_t pixel : blocks.back().ReceiverPixels()) {
      receivers_.push_back({pixel, {}});
    }
  }
  entry_begin_.assign(1, 0);
  for (int y = y_px_; y < y_px_ + height_px_; ++y) {
    for (int x = x_px_; x < x_px_ + width_px_; ++x) {
      const std::size_t first = entries_.size();
      if (sizes.At(x, y) != 0) {
        const std::size_t size = sizes.At(x, y) - 1u;
        double sum = 0.0;
        blocks[size].ForPixel(x, y, [&](std::uint32_t receiver, double weight) {
          entries_.push_back({first_receiver[size] + receiver, static_cast<float>(weight)});
          sum += weight;
        });
        for (std::size_t i = first; i < entries_.size(); ++i) {
          entries_[i].weight = static_cast<float>(entries_[i].weight / sum);
        }
      }
      entry_begin_.push_back(static_cast<std::uint32_t>(entries_.size()));
    }
  }
  Gather(real, objects, view, options.rays_per_receiver);
}

void ObjectInfluence::Gather(const PatchScene& real,
                             const PatchScene& objects,
                             const SurfaceView& view,
                             int rays_per_receiver) {
  const std::vector<std::optional<Bounds>> bounds = BoundsOfObjects(objects.mesh);
  tbb::parallel_for(std::size_t{0}, receivers_.size(), [&](std::size_t i) {
    ReceiverHits& receiver = receivers_[i];
    const glm::vec3& position_m = view.position_world_m.pixels[receiver.pixel];
    const glm::vec3& normal = view.normal_world.pixels[receiver.pixel];
    const glm::vec3 start_m = OffsetFromSurface(position_m, normal);
    for (std::size_t group = 0; group < bounds.size(); ++group) {
      if (!bounds[group]) continue;
      const Cone cone = ConeOf(*bounds[group], position_m);
      ForDirections(cone, normal, rays_per_receiver, [&](const glm::vec3& direction, float share) {
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
                           std::span<const glm::vec3> object_radiosity) {
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
  const auto changes = [&](int x, int y) {
    const std::span<const Entry> entries = entries_of(x, y);
    return std::any_of(entries.begin(), entries.end(), [&](const Entry& entry) {
      return at_receivers[entry.receiver] != glm::vec3(0.0f);
    });
  };
  // The smallest rectangle around all pixels that change.
  glm::ivec2 lower(width_px_, height_px_);
  glm::ivec2 upper(0);
  for (int y = 0; y < height_px_; ++y) {
    int first = 0;
    while (first < width_px_ && !changes(first, y)) ++first;
    if (first == width_px_) continue;
    int last = width_px_ - 1;
    while (!changes(last, y)) --last;
    lower = glm::min(lower, glm::ivec2(first, y));
    upper = glm::max(upper, glm::ivec2(last + 1, y + 1));
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
