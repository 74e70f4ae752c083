#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/packing.hpp>

#include "relight/transport/internal/exposed_gather.h"
#include "relight/transport/transport.h"
#include "scene/lat_long.h"
#include "scene/low_discrepancy.h"

namespace pleinair {
namespace {

// A receiver's batch is stored on its own, so that rays are cast without a common lock and joined
// in order. Large enough to hide the scheduling, small enough to spread over many cores.
constexpr std::size_t kReceiversPerBatch = 64;

// Upper hemisphere to the unit diamond, turned by 45 deg to fill a square of 16-bit steps.
std::uint32_t PackUpperDirection(const glm::vec3& direction) {
  const float scale =
      1.0f / (std::abs(direction.x) + std::abs(direction.y) + std::abs(direction.z));
  const float x = direction.x * scale;
  const float y = direction.y * scale;
  const auto quantise = [](float value) {
    return static_cast<std::uint32_t>(
        std::lround((glm::clamp(value, -1.0f, 1.0f) * 0.5f + 0.5f) * 65535.0f));
  };
  return (quantise(x + y) << 16) | quantise(x - y);
}

glm::vec3 UnpackUpperDirection(std::uint32_t packed) {
  const float u = static_cast<float>(packed >> 16) * (2.0f / 65535.0f) - 1.0f;
  const float v = static_cast<float>(packed & 0xffffu) * (2.0f / 65535.0f) - 1.0f;
  // A direction that was above the horizon stays above it.
  const float z = std::max(1.0f - std::max(std::abs(u), std::abs(v)), 1e-6f);
  return glm::normalize(glm::vec3(0.5f * (u + v), 0.5f * (u - v), z));
}

std::uint32_t PackDirection(const glm::vec3& direction) {
  return glm::packSnorm3x10_1x2(glm::vec4(direction, 0.0f));
}

glm::vec3 UnpackDirection(std::uint32_t packed) {
  return glm::normalize(glm::vec3(glm::unpackSnorm3x10_1x2(packed)));
}

// Each face of `hits` once, ascending, with `share` for each of its hits. Sorts `hits`.
void AppendShares(std::vector<std::int32_t>& hits,
                  float share,
                  std::vector<std::int32_t>& face,
                  std::vector<float>& face_share) {
  std::sort(hits.begin(), hits.end());
  for (std::size_t first = 0; first < hits.size();) {
    std::size_t last = first;
    while (last < hits.size() && hits[last] == hits[first]) ++last;
    face.push_back(hits[first]);
    face_share.push_back(share * static_cast<float>(last - first));
    first = last;
  }
}

// Where a ray of a receiver starts, and about which normal it is spread.
struct RayStart {
  glm::vec3 origin_m;
  glm::vec3 normal;
};

struct AtPoint {
  std::span<const Receiver> receivers;
  std::span<const std::uint32_t> identities;  // Empty: their places in the list.
  std::size_t Identity(std::size_t i) const { return identities.empty() ? i : identities[i]; }
  glm::vec3 Normal(std::size_t i) const { return receivers[i].normal; }
  RayStart StartOf(std::size_t i, int, const glm::dvec2&) const {
    const auto& [position_m, normal] = receivers[i];
    return {OffsetFromSurface(position_m, normal), normal};
  }
};

// A receiver's rays, and the faces that they meet, PatchScene::kSky where none.
struct RaysOfReceiver {
  std::vector<glm::vec3> origins_m;
  std::vector<glm::vec3> directions;
  std::vector<FaceHit> hits;
  std::vector<std::int32_t> faces;
};

struct OfScene {
  const PatchScene& scene;
  void Cast(RaysOfReceiver& rays) const {
    const std::size_t count = rays.directions.size();
    rays.hits.resize(count);
    rays.faces.resize(count);
    scene.caster.Intersect(rays.origins_m.data(), rays.directions.data(), count, rays.hits.data());
    for (std::size_t k = 0; k < count; ++k) {
      const FaceHit& hit = rays.hits[k];
      rays.faces[k] = hit.triangle == FaceHit::kNone ? PatchScene::kSky : scene.FaceOfHit(hit);
    }
  }
};

struct OfTwo {
  const PatchScene& first;
  const PatchScene& second;
  void Cast(RaysOfReceiver& rays) const {
    const std::size_t count = rays.directions.size();
    OfScene{first}.Cast(rays);
    second.caster.IntersectNearer(
        rays.origins_m.data(), rays.directions.data(), count, rays.hits.data());
    for (std::size_t k = 0; k < count; ++k) {
      const FaceHit& hit = rays.hits[k];
      if (hit.triangle == FaceHit::kNone) continue;
      rays.faces[k] = static_cast<std::int32_t>(first.FaceCount()) + second.FaceOfHit(hit);
    }
  }
};

// `share` of a receiver's rays would meet what the skyline hides, were there no mesh.
float HiddenScale(const Skyline& skyline, const glm::vec3& normal, float share) {
  // Where fewer meet it the rays hardly do, and there is nothing to scale.
  constexpr float kMost = 2.0f;
  if (!(share > 0.0f)) return 1.0f;
  const float irradiance = SampleLatLong(skyline.irradiance_of_hidden, glm::dvec3(normal)).x;
  return std::clamp(irradiance / (std::numbers::pi_v<float> * share), 1.0f / kMost, kMost);
}

bool IsUnit(const glm::vec3& normal) { return std::abs(glm::dot(normal, normal) - 1.0f) < 1e-3f; }

}  // namespace

void GatherOptions::Validate() const {
  if (rays_per_receiver < 1 || rays_per_receiver > 65536) {
    throw std::invalid_argument("rays_per_receiver is " + std::to_string(rays_per_receiver) +
                                ": expected 1 to 65536");
  }
  if (receivers_per_set < 1 || receivers_per_set > 1024) {
    throw std::invalid_argument("receivers_per_set is " + std::to_string(receivers_per_set) +
                                ": expected 1 to 1024");
  }
}

template <class RayStarts, class Scenes>
void GatheredRays::Gather(const Skyline& skyline,
                          std::size_t receiver_count,
                          const GatherOptions& options,
                          const RayStarts& ray_start,
                          const Scenes& scenes) {
  options.Validate();
  rays_per_receiver_ = options.rays_per_receiver;
  const float share = 1.0f / static_cast<float>(options.rays_per_receiver);
  const int sharers = options.receivers_per_set;

  struct Batch {
    std::vector<std::uint32_t> face_count;
    std::vector<std::uint32_t> sky_count;
    std::vector<std::int32_t> face;
    std::vector<float> face_share;
    std::vector<std::uint32_t> sky;
    std::vector<float> hidden_scale;
    std::vector<std::uint32_t> other_count;
    std::vector<std::uint32_t> other;
  };
  const std::size_t other_from = options.keep_directions_from_face;
  const bool keeps_others = other_from != GatherOptions().keep_directions_from_face;
  std::vector<Batch> batches((receiver_count + kReceiversPerBatch - 1) / kReceiversPerBatch);
  tbb::parallel_for(std::size_t{0}, batches.size(), [&](std::size_t b) {
    Batch& batch = batches[b];
    std::vector<std::int32_t> hits;
    RaysOfReceiver rays;
    const std::size_t end = std::min(receiver_count, (b + 1) * kReceiversPerBatch);
    for (std::size_t i = b * kReceiversPerBatch; i < end; ++i) {
      const std::size_t faces_before = batch.face.size();
      const std::size_t skies_before = batch.sky.size();
      const std::size_t others_before = batch.other.size();
      const glm::vec3 normal = ray_start.Normal(i);
      float hidden = 0.0f;
      if (IsUnit(normal)) {
        hits.clear();
        const std::size_t identity = options.first_receiver + ray_start.Identity(i);
        const auto set = identity / static_cast<std::size_t>(sharers);
        const auto part = static_cast<int>(identity % static_cast<std::size_t>(sharers));
        const glm::dvec2 rotation = RotationOf(options.seed, set);
        rays.origins_m.clear();
        rays.directions.clear();
        for (int k = 0; k < options.rays_per_receiver; ++k) {
          const auto [origin_m, ray_normal] = ray_start.StartOf(i, k, rotation);
          rays.origins_m.push_back(origin_m);
          rays.directions.push_back(
              NormalFrame(ray_normal)
                  .CosineDirection(FibonacciPoint(
                      k * sharers + part, options.rays_per_receiver * sharers, rotation)));
        }
        scenes.Cast(rays);
        for (std::size_t k = 0; k < rays.directions.size(); ++k) {
          const glm::vec3& direction = rays.directions[k];
          if (!skyline.Empty() && direction.z > 0.0f) {
            // As it is kept: a rounding may take it over a cell's edge.
            const glm::vec3 kept = UnpackUpperDirection(PackUpperDirection(direction));
            hidden += skyline.hidden[SkyTable::CellOf(kept)];
          }
          if (const std::int32_t face = rays.faces[k]; face != PatchScene::kSky) {
            hits.push_back(face);
            if (static_cast<std::size_t>(face) >= other_from) {
              batch.other.push_back(PackDirection(direction));
            }
          } else if (direction.z > 0.0f) {
            batch.sky.push_back(PackUpperDirection(direction));
          } else if (keeps_others) {
            batch.other.push_back(PackDirection(direction));
          }
        }
        AppendShares(hits, share, batch.face, batch.face_share);
      }
      if (!skyline.Empty()) {
        batch.hidden_scale.push_back(HiddenScale(skyline, normal, hidden * share));
      }
      batch.face_count.push_back(static_cast<std::uint32_t>(batch.face.size() - faces_before));
      batch.sky_count.push_back(static_cast<std::uint32_t>(batch.sky.size() - skies_before));
      if (keeps_others) {
        batch.other_count.push_back(static_cast<std::uint32_t>(batch.other.size() - others_before));
      }
    }
  });

  face_begin_.assign(1, 0);
  sky_begin_.assign(1, 0);
  if (keeps_others) other_begin_.assign(1, 0);
  for (Batch& batch : batches) {
    for (const std::uint32_t count : batch.other_count) {
      other_begin_.push_back(other_begin_.back() + count);
    }
    for (const std::uint32_t count : batch.face_count) {
      face_begin_.push_back(face_begin_.back() + count);
    }
    for (const std::uint32_t count : batch.sky_count) {
      sky_begin_.push_back(sky_begin_.back() + count);
    }
  }
  face_.reserve(face_begin_.back());
  face_share_.reserve(face_begin_.back());
  sky_direction_.reserve(sky_begin_.back());
  for (Batch& batch : batches) {
    face_.insert(face_.end(), batch.face.begin(), batch.face.end());
    face_share_.insert(face_share_.end(), batch.face_share.begin(), batch.face_share.end());
    sky_direction_.insert(sky_direction_.end(), batch.sky.begin(), batch.sky.end());
    other_direction_.insert(other_direction_.end(), batch.other.begin(), batch.other.end());
    hidden_scale_.insert(hidden_scale_.end(), batch.hidden_scale.begin(), batch.hidden_scale.end());
    batch = Batch{};
  }
  DescribeSky();
}

void GatheredRays::DescribeSky() {
  static_assert(SkyTable::kCells <= 65536);
  sky_cell_.resize(sky_direction_.size());
  sky_heights_.resize(ReceiverCount());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, ReceiverCount(), 16),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) {
                        double heights = 0.0;
                        for (std::uint64_t k = sky_begin_[i]; k < sky_begin_[i + 1]; ++k) {
                          const glm::vec3 direction = UnpackUpperDirection(sky_direction_[k]);
                          sky_cell_[k] = static_cast<std::uint16_t>(SkyTable::CellOf(direction));
                          heights += double{direction.z};
                        }
                        sky_heights_[i] = heights;
                      }
                    });
}

GatheredRays::GatheredRays(const PatchScene& scene,
                           std::span<const Receiver> receivers,
                           const GatherOptions& options) {
  Gather(scene.skyline, receivers.size(), options, AtPoint{receivers, {}}, OfScene{scene});
}

GatheredRays::GatheredRays(const PatchScene& scene,
                           std::span<const Receiver> receivers,
                           std::span<const std::uint32_t> identities,
                           const GatherOptions& options) {
  if (identities.size() != receivers.size()) {
    throw std::invalid_argument("identities has " + std::to_string(identities.size()) +
                                " entries: expected " + std::to_string(receivers.size()) +
                                ", one a receiver");
  }
  Gather(scene.skyline, receivers.size(), options, AtPoint{receivers, identities}, OfScene{scene});
}

GatheredRays::GatheredRays(const PatchScene& first,
                           const PatchScene& second,
                           std::span<const Receiver> receivers,
                           const GatherOptions& options) {
  Gather(Skyline(), receivers.size(), options, AtPoint{receivers, {}}, OfTwo{first, second});
}

GatheredRays GatheredRays::OfFaces(const PatchScene& scene, const GatherOptions& options) {
  struct OnFace {
    const PatchScene& scene;
    static std::size_t Identity(std::size_t face) { return face; }
    glm::vec3 Normal(std::size_t face) const { return scene.FaceNormal(face); }
    RayStart StartOf(std::size_t face, int ray, const glm::dvec2& rotation) const {
      const auto [position_m, triangle] =
          scene.PointOn(face / 2, R2Point(ray, {rotation.y, rotation.x}));
      const glm::vec3 normal = scene.SideNormal(2 * triangle + face % 2);
      return {OffsetFromSurface(position_m, normal), normal};
    }
  };
  GatheredRays rays;
  rays.Gather(scene.skyline, scene.FaceCount(), options, OnFace{scene}, OfScene{scene});
  return rays;
}

GatheredRays GatheredRays::OfExposedFaces(const PatchScene& scene,
                                          const GatherOptions& options,
                                          FacePoints& points) {
  options.Validate();
  internal::ExposedRays exposed = internal::GatherFromExposedFaces(scene, options);
  const auto per_point = static_cast<std::size_t>(exposed.rays_per_point);
  GatheredRays rays;
  rays.rays_per_receiver_ = exposed.rays_per_point * FacePoints::kCells;
  rays.face_begin_.assign(1, 0);
  rays.sky_begin_.assign(1, 0);
  std::vector<std::int32_t> hits;
  for (std::size_t face = 0; face < scene.FaceCount(); ++face) {
    const std::size_t first = exposed.points.begin[face];
    const std::size_t last = exposed.points.begin[face + 1];
    hits.clear();
    for (std::size_t ray = first * per_point; ray < last * per_point; ++ray) {
      if (exposed.source[ray] >= 0) hits.push_back(exposed.source[ray]);
    }
    // At least 1, so that a face without rays divides nothing by zero.
    rays.ray_count_.push_back(std::max(1, static_cast<std::int32_t>((last - first) * per_point)));
    AppendShares(
        hits, 1.0f / static_cast<float>(rays.ray_count_.back()), rays.face_, rays.face_share_);
    rays.face_begin_.push_back(rays.face_.size());
    for (std::uint64_t k = exposed.sky_begin[first]; k < exposed.sky_begin[last]; ++k) {
      rays.sky_direction_.push_back(PackUpperDirection(exposed.sky_direction[k]));
    }
    rays.sky_begin_.push_back(rays.sky_direction_.size());
  }
  rays.DescribeSky();
  points = std::move(exposed.points);
  return rays;
}

std::vector<glm::vec3> GatheredRays::FromSky(const SkyShape& shape) const {
  const SkyShape* const one = &shape;
  return std::move(FromSkies(std::span(&one, 1)).front());
}

std::vector<std::vector<glm::vec3>> GatheredRays::FromSkies(
    std::span<const SkyShape* const> shapes) const {
  struct Terms {
    const std::vector<glm::vec3>* table = nullptr;
    const std::vector<glm::vec3>* change = nullptr;
    std::optional<SkyShape::ByHeight> by_height;
  };
  std::vector<Terms> terms_of;
  for (const SkyShape* shape : shapes) {
    const PartlyHiddenTables* const hidden = shape->PartlyHidden();
    terms_of.push_back(hidden != nullptr ? Terms{&hidden->bare, &hidden->change, std::nullopt}
                                         : Terms{shape->Table(), nullptr, shape->LinearInHeight()});
  }
  const auto sum_over = [](const std::vector<glm::vec3>& table,
                           std::span<const std::uint16_t> cells) {
    glm::dvec3 sum(0.0);
    for (const std::uint16_t cell : cells) sum += glm::dvec3(table[cell]);
    return sum;
  };
  const auto sum_of = [&](std::size_t i, const Terms& terms, const SkyShape& shape) {
    const std::uint64_t begin = sky_begin_[i];
    const std::uint64_t end = sky_begin_[i + 1];
    const auto cells = std::span(sky_cell_).subspan(begin, end - begin);
    glm::dvec3 sum(0.0);
    if (terms.by_height) {
      sum = glm::dvec3(terms.by_height->level * static_cast<double>(cells.size()) +
                       terms.by_height->rise * sky_heights_[i]);
    } else if (terms.table != nullptr) {
      sum = sum_over(*terms.table, cells);
    } else {
      for (std::uint64_t k = begin; k < end; ++k) {
        sum += glm::dvec3(shape.Radiance(UnpackUpperDirection(sky_direction_[k])));
      }
    }
    if (terms.change == nullptr) return sum;
    const double scale = hidden_scale_.empty() ? 1.0 : static_cast<double>(hidden_scale_[i]);
    return sum + scale * sum_over(*terms.change, cells);
  };
  std::vector<std::vector<glm::vec3>> irradiance(
      shapes.size(), std::vector<glm::vec3>(ReceiverCount(), glm::vec3(0.0f)));
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, ReceiverCount(), 16),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) {
                        const double scale = std::numbers::pi / RayCountOf(i);
                        for (std::size_t k = 0; k < shapes.size(); ++k) {
                          irradiance[k][i] = glm::vec3(scale * sum_of(i, terms_of[k], *shapes[k]));
                        }
                      }
                    });
  return irradiance;
}

glm::vec3 GatheredRays::FromFacesAt(std::size_t receiver,
                                    std::span<const glm::vec3> face_radiosity) const {
  glm::vec3 sum(0.0f);
  for (std::uint64_t k = face_begin_[receiver]; k < face_begin_[receiver + 1]; ++k) {
    sum += face_share_[k] * face_radiosity[static_cast<std::size_t>(face_[k])];
  }
  return sum;
}

std::vector<glm::vec3> GatheredRays::FromFaces(std::span<const glm::vec3> face_radiosity) const {
  std::vector<glm::vec3> irradiance(ReceiverCount());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, irradiance.size(), 256),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) {
                        irradiance[i] = FromFacesAt(i, face_radiosity);
                      }
                    });
  return irradiance;
}

std::vector<glm::vec3> GatheredRays::FromFaces(std::span<const glm::vec3> face_radiosity,
                                               std::size_t lights) const {
  std::vector<glm::vec3> irradiance(ReceiverCount() * lights, glm::vec3(0.0f));
  tbb::parallel_for(std::size_t{0}, ReceiverCount(), [&](std::size_t i) {
    glm::vec3* const sum = irradiance.data() + i * lights;
    for (std::uint64_t k = face_begin_[i]; k < face_begin_[i + 1]; ++k) {
      const glm::vec3* const source =
          face_radiosity.data() + static_cast<std::size_t>(face_[k]) * lights;
      for (std::size_t light = 0; light < lights; ++light) {
        sum[light] += face_share_[k] * source[light];
      }
    }
  });
  return irradiance;
}

std::vector<GatheredRays::FaceShare> GatheredRays::FacesOf(std::size_t receiver) const {
  std::vector<FaceShare> faces;
  for (std::uint64_t k = face_begin_[receiver]; k < face_begin_[receiver + 1]; ++k) {
    faces.push_back({face_[k], face_share_[k]});
  }
  return faces;
}

std::vector<glm::vec3> GatheredRays::SkyDirectionsOf(std::size_t receiver) const {
  std::vector<glm::vec3> directions;
  for (std::uint64_t k = sky_begin_[receiver]; k < sky_begin_[receiver + 1]; ++k) {
    directions.push_back(UnpackUpperDirection(sky_direction_[k]));
  }
  return directions;
}

std::vector<glm::vec3> GatheredRays::OtherDirectionsOf(std::size_t receiver) const {
  std::vector<glm::vec3> directions;
  if (other_begin_.empty()) return directions;
  for (std::uint64_t k = other_begin_[receiver]; k < other_begin_[receiver + 1]; ++k) {
    directions.push_back(UnpackDirection(other_direction_[k]));
  }
  return directions;
}

}  // namespace pleinair
