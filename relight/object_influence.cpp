#include "relight/object_influence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

#include "relight/internal/basis_sum.h"
#include "relight/internal/face_lattice.h"
#include "relight/internal/influence_plan.h"
#include "relight/internal/object_cone.h"
#include "relight/internal/plane_blocks.h"

namespace pleinair {
namespace {

// See the header.
constexpr float kLeastChange = 1.0f / 512.0f;
// A receiver whose view objects fill to this share stands under or in one.
constexpr float kShareInside = 0.95f;
// Below that what a pixel shows is all within an object.
constexpr float kLeastOpen = 0.01f;

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
  if (!(least_spacing > 0.0) || !std::isfinite(least_spacing)) {
    throw std::invalid_argument("least_spacing is " + std::to_string(least_spacing) +
                                ": expected more than 0, of an object's radius");
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
  for (std::size_t size = 0; size < kInfluenceBlocksPx.size(); ++size) {
    const Gray8Image candidates = Candidates(plan, size);
    blocks.emplace_back(
        view,
        eye_m,
        PlaneBlocks::Options{
            .block_px = kInfluenceBlocksPx[size], .wraps_x = false, .candidates = &candidates});
    first_receiver.push_back(static_cast<std::uint32_t>(receivers_.size()));
    for (const std::size_t pixel : blocks.back().ReceiverPixels()) {
      receivers_.push_back(
          {.pixel = pixel,
           .face = 0,
           .place = {view.position_world_m.pixels[pixel], view.normal_world.pixels[pixel]},
           .hits = {}});
    }
  }
  entry_begin_.assign(1, 0);
  extents_.resize(receivers_.size());
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
        for (std::size_t i = first; i < entries_.size(); ++i) {
          entries_[i].weight = static_cast<float>(entries_[i].weight / sum);
          const glm::ivec2 place(x - x_px_, y - y_px_);
          Extent& extent = extents_[entries_[i].receiver];
          extent.lower = glm::min(extent.lower, place);
          extent.upper = glm::max(extent.upper, place + 1);
        }
      }
      entry_begin_.push_back(static_cast<std::uint32_t>(entries_.size()));
    }
  }
  Gather(real, objects, options.rays_per_receiver);
}

ObjectInfluence::ObjectInfluence(const PatchScene& real,
                                 const PatchScene& objects,
                                 const ObjectInfluenceOptions& options)
    : real_faces_(real.FaceCount()),
      object_faces_(objects.FaceCount()),
      face_albedo_rgb_(real.face_albedo_rgb) {
  options.Validate();
  lattice_ = std::make_shared<const FaceLattice>(
      real, PartsOfFaces(real, BoundsOfObjects(objects.mesh), options.least_spacing));
  const std::vector<Receiver>& places = lattice_->Receivers();
  for (std::size_t i = 0; i < places.size(); ++i) {
    receivers_.push_back(
        {.pixel = 0, .face = lattice_->FaceOfReceiver()[i], .place = places[i], .hits = {}});
  }
  Gather(real, objects, options.rays_per_receiver);
  for (const ReceiverHits& receiver : receivers_) {
    float share = 0.0f;
    for (const Hit& hit : receiver.hits) share += hit.share;
    is_open_.push_back(share > kShareInside ? 0.0f : 1.0f);
  }
}

void ObjectInfluence::See(const PatchScene& real,
                          const SurfaceView& view,
                          const Image<std::int32_t>& faces) {
  if (lattice_ == nullptr) {
    throw std::logic_error("object influence: See is for receivers on faces");
  }
  RequireFaces(real.FaceCount(), real_faces_, "the real scene");
  if (faces.width != view.Width() || faces.height != view.Height()) {
    throw std::invalid_argument(std::string("object influence: faces of a picture of ") +
                                std::to_string(faces.width) + "x" + std::to_string(faces.height) +
                                ", expected the view's " + std::to_string(view.Width()) + "x" +
                                std::to_string(view.Height()));
  }
  picture_width_px_ = width_px_ = faces.width;
  picture_height_px_ = height_px_ = faces.height;
  // Three a pixel, of no weight where nothing changes.
  entries_.assign(3 * faces.pixels.size(), Entry{0, 0.0f});
  entry_begin_.resize(faces.pixels.size() + 1);
  for (std::size_t i = 0; i < entry_begin_.size(); ++i) {
    entry_begin_[i] = static_cast<std::uint32_t>(3 * i);
  }
  tbb::parallel_for(0, faces.height, [&](int y) {
    for (int x = 0; x < faces.width; ++x) {
      const std::size_t pixel = faces.Index(x, y);
      if (faces.pixels[pixel] == PatchScene::kSky) continue;
      const auto face = static_cast<std::size_t>(faces.pixels[pixel]);
      if (!lattice_->HasReceivers(face)) continue;
      const auto around = lattice_->Around(real, face, view.position_world_m.pixels[pixel]);
      // What an object stands on is not to darken what lies beside it.
      float open = 0.0f;
      for (const FaceLattice::Weighted& at : around) open += at.weight * is_open_[at.receiver];
      for (std::size_t k = 0; k < 3; ++k) {
        const float weight = open > kLeastOpen
                                 ? around[k].weight * is_open_[around[k].receiver] / open
                                 : around[k].weight;
        entries_[3 * pixel + k] = {around[k].receiver, weight};
      }
    }
  });
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
  if (lattice_ == nullptr &&
      (view.Width() != picture_width_px_ || view.Height() != picture_height_px_ ||
       (light > 0 && view.sky_response.size() < light))) {
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
    response.before = Before(light, receivers_[i], view, real_radiosity);
    responses[i] = response;
  });
}

glm::vec3 ObjectInfluence::Before(std::size_t light,
                                  const ReceiverHits& receiver,
                                  const SurfaceView& view,
                                  std::span<const glm::vec3> real_radiosity) const {
  if (lattice_ == nullptr) {
    return light == 0 ? SunResponse(view, receiver.pixel, view.sun_direction_enu)
                      : view.sky_response[light - 1].pixels[receiver.pixel];
  }
  // What the face reflects, by what it reflects of it. What is black changes nothing in a picture.
  glm::vec3 irradiance(0.0f);
  for (int channel = 0; channel < 3; ++channel) {
    const float albedo = face_albedo_rgb_[receiver.face][channel];
    if (albedo > 0.0f) irradiance[channel] = real_radiosity[receiver.face][channel] / albedo;
  }
  return irradiance;
}

std::vector<glm::vec3> ObjectInfluence::AtReceivers(const Lighting& lighting,
                                                    const InfluenceParts& parts) const {
  const std::vector<glm::vec3> weights =
      internal::BasisWeights(lighting, responses_.size(), "object influence");
  std::vector<glm::vec3> at_receivers(receivers_.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, receivers_.size(), 1024),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) {
                        Response sum;
                        for (std::size_t light = 0; light < weights.size(); ++light) {
                          const Response& response = responses_[light][i];
                          sum.hidden += weights[light] * response.hidden;
                          sum.gained += weights[light] * response.gained;
                          sum.before += weights[light] * response.before;
                        }
                        const glm::vec3 change =
                            (parts.object_light ? sum.gained : glm::vec3(0.0f)) -
                            (parts.hidden_light ? sum.hidden : glm::vec3(0.0f));
                        const bool matters =
                            glm::any(glm::greaterThan(glm::abs(change), kLeastChange * sum.before));
                        at_receivers[i] = matters ? change : glm::vec3(0.0f);
                      }
                    });
  return at_receivers;
}

std::vector<std::array<int, 2>> ObjectInfluence::RowsThatChange(
    std::span<const glm::vec3> at_receivers) const {
  std::vector<std::array<int, 2>> rows(static_cast<std::size_t>(height_px_), {width_px_, 0});
  if (lattice_ == nullptr) {
    for (std::size_t i = 0; i < at_receivers.size(); ++i) {
      if (at_receivers[i] == glm::vec3(0.0f)) continue;
      const auto& [lower, upper] = extents_[i];
      for (int y = lower.y; y < upper.y; ++y) {
        auto& [begin, end] = rows[static_cast<std::size_t>(y)];
        begin = std::min(begin, lower.x);
        end = std::max(end, upper.x);
      }
    }
    return rows;
  }
  tbb::parallel_for(0, height_px_, [&](int y) {
    auto& [begin, end] = rows[static_cast<std::size_t>(y)];
    for (int x = 0; x < width_px_; ++x) {
      for (const Entry& entry : EntriesOf(x, y)) {
        if (entry.weight == 0.0f || at_receivers[entry.receiver] == glm::vec3(0.0f)) continue;
        begin = std::min(begin, x);
        end = x + 1;
        break;
      }
    }
  });
  return rows;
}

void ObjectInfluence::Evaluate(const Lighting& lighting,
                               const InfluenceParts& parts,
                               IrradianceChange& change) const {
  RgbImage& image = change.irradiance_rgb;
  image.width = 0;
  image.height = 0;
  if (receivers_.empty()) return image.pixels.clear();
  const std::vector<glm::vec3> at_receivers = AtReceivers(lighting, parts);
  const std::vector<std::array<int, 2>> rows = RowsThatChange(at_receivers);
  glm::ivec2 lower(width_px_, height_px_);
  glm::ivec2 upper(0);
  for (int y = 0; y < height_px_; ++y) {
    const auto [begin, end] = rows[static_cast<std::size_t>(y)];
    if (end == 0) continue;
    lower = glm::min(lower, glm::ivec2(begin, y));
    upper = glm::max(upper, glm::ivec2(end, y + 1));
  }
  if (upper.x <= lower.x) return image.pixels.clear();
  change.x_px = x_px_ + lower.x;
  change.y_px = y_px_ + lower.y;
  image.width = upper.x - lower.x;
  image.height = upper.y - lower.y;
  image.pixels.resize(static_cast<std::size_t>(image.width) *
                      static_cast<std::size_t>(image.height));
  tbb::parallel_for(0, image.height, [&](int y) {
    const auto [begin, end] = rows[static_cast<std::size_t>(lower.y + y)];
    for (int x = 0; x < image.width; ++x) {
      glm::vec3 sum(0.0f);
      if (lower.x + x >= begin && lower.x + x < end) {
        for (const Entry& entry : EntriesOf(lower.x + x, lower.y + y)) {
          sum += entry.weight * at_receivers[entry.receiver];
        }
      }
      image.At(x, y) = sum;
    }
  });
}

}  // namespace pleinair
