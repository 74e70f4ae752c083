#include "objects/object_influence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <glm/vector_relational.hpp>

#include "objects/internal/influence_plan.h"
#include "objects/internal/influence_rays.h"
#include "objects/internal/object_cone.h"
#include "relight/transport/face_lattice.h"
#include "relight/transport/plane_blocks.h"
#include "relight/volume/basis_sum.h"

namespace pleinair {
namespace {

// See the header.
constexpr float kLeastChange = 1.0f / 512.0f;
// A receiver whose view objects fill to this share stands under or in one.
constexpr float kShareInside = 0.95f;
// Below that, all that a pixel shows is within an object.
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
  if (!(least_share > 0.0) || !(least_share < 1.0)) {
    throw std::invalid_argument("least_share is " + std::to_string(least_share) +
                                ": expected more than 0 and less than 1");
  }
  if (!(coarseness > 0.0) || !std::isfinite(coarseness)) {
    throw std::invalid_argument("coarseness is " + std::to_string(coarseness) +
                                ": expected more than 0");
  }
  in_motion.Validate();
}

void InfluenceInMotionOptions::Validate() const {
  const auto require = [](const char* name, double value, bool holds, const char* expected) {
    if (holds) return;
    throw std::invalid_argument(std::string("influence in motion: ") + name + " is " +
                                std::to_string(value) + ": expected " + expected);
  };
  require("rays_per_receiver",
          rays_per_receiver,
          rays_per_receiver >= 0 && rays_per_receiver <= 65536,
          "0 to 65536");
  require("least_share",
          least_share,
          least_share > 0.0 && least_share < 1.0,
          "more than 0 and less than 1");
  require("coarseness", coarseness, coarseness > 0.0 && std::isfinite(coarseness), "more than 0");
  require("receivers_at_rest", receivers_at_rest, receivers_at_rest >= 0, "0 or more");
}

ObjectInfluenceOptions ObjectInfluenceOptions::InMotion() const {
  ObjectInfluenceOptions options = *this;
  options.rays_per_receiver = in_motion.rays_per_receiver;
  options.least_share = in_motion.least_share;
  options.coarseness = in_motion.coarseness;
  return options;
}

ObjectInfluence::ObjectInfluence(const PatchScene& real,
                                 const PatchScene& objects,
                                 const SurfaceView& view,
                                 const ObjectInfluenceOptions& options)
    : ObjectInfluence(InParts(real, objects, view, options)) {
  Cast(real, objects, 0);
}

ObjectInfluence::ObjectInfluence(const PatchScene& real,
                                 const PatchScene& objects,
                                 const ObjectInfluenceOptions& options)
    : ObjectInfluence(InParts(real, objects, options)) {
  Cast(real, objects, 0);
}

ObjectInfluence ObjectInfluence::InParts(const PatchScene& real,
                                         const PatchScene& objects,
                                         const SurfaceView& view,
                                         const ObjectInfluenceOptions& options) {
  options.Validate();
  ObjectInfluence influence;
  influence.real_faces_ = real.FaceCount();
  influence.object_faces_ = objects.FaceCount();
  influence.picture_width_px_ = view.Width();
  influence.picture_height_px_ = view.Height();
  influence.PlacePixels(objects, view, options);
  if (influence.receivers_.empty()) return influence;
  influence.rays_ =
      std::make_shared<InfluenceRays>(objects, influence.receivers_, options.rays_per_receiver);
  return influence;
}

bool ObjectInfluence::Cast(const PatchScene& real, const PatchScene& objects, int receivers) {
  if (rays_ == nullptr || rays_->IsComplete()) return true;
  const bool is_complete =
      rays_->Cast(real, objects, receivers_, static_cast<std::size_t>(receivers));
  if (!is_complete || lattice_ == nullptr) return is_complete;
  for (std::size_t i = 0; i < receivers_.size(); ++i) {
    float share = 0.0f;
    for (const InfluenceRays::Hit& hit : rays_->HitsOf(i)) share += hit.share;
    is_open_.push_back(share > kShareInside ? 0.0f : 1.0f);
  }
  return true;
}

namespace {

// Pixels that have a receiver to themselves, row by row, and how many are before each row.
std::vector<std::size_t> PixelsOfOwn(const PixelPlan& plan,
                                     std::vector<std::uint32_t>& first_of_row) {
  const auto width = static_cast<std::size_t>(plan.size.width);
  const auto height = static_cast<std::size_t>(plan.size.height);
  std::vector<std::vector<std::size_t>> of_row(height);
  tbb::parallel_for(std::size_t{0}, height, [&](std::size_t y) {
    for (std::size_t pixel = y * width; pixel < (y + 1) * width; ++pixel) {
      if (plan.size.pixels[pixel] == 1) of_row[y].push_back(pixel);
    }
  });
  std::vector<std::size_t> pixels;
  first_of_row.reserve(height);
  for (const std::vector<std::size_t>& row : of_row) {
    first_of_row.push_back(static_cast<std::uint32_t>(pixels.size()));
    pixels.insert(pixels.end(), row.begin(), row.end());
  }
  return pixels;
}

}  // namespace

void ObjectInfluence::PlacePixels(const PatchScene& objects,
                                  const SurfaceView& view,
                                  const ObjectInfluenceOptions& options) {
  const PixelPlan plan = PlanPixels(objects,
                                    BoundsOfObjects(objects.mesh),
                                    view,
                                    static_cast<float>(options.least_share),
                                    static_cast<float>(options.coarseness));
  const glm::vec3 eye_m(view.camera.CentreWorldM());
  std::array<std::optional<PlaneBlocks>, kInfluenceBlocksPx.size()> blocks;  // None for pixels.
  tbb::parallel_for(std::size_t{1}, blocks.size(), [&](std::size_t size) {
    const Gray8Image candidates = Candidates(plan, size);
    blocks[size].emplace(
        view,
        eye_m,
        PlaneBlocks::Options{
            .block_px = kInfluenceBlocksPx[size], .wraps_x = false, .candidates = &candidates});
  });
  // Pixels of their own receiver come first.
  std::vector<std::uint32_t> first_of_row;
  stands_at_ = PixelsOfOwn(plan, first_of_row);
  std::array<std::uint32_t, kInfluenceBlocksPx.size()> first_receiver{};
  for (std::size_t size = 1; size < blocks.size(); ++size) {
    first_receiver[size] = static_cast<std::uint32_t>(stands_at_.size());
    const std::vector<std::size_t>& pixels = blocks[size]->ReceiverPixels();
    stands_at_.insert(stands_at_.end(), pixels.begin(), pixels.end());
  }
  if (stands_at_.empty()) return;
  receivers_.reserve(stands_at_.size());
  for (const std::size_t pixel : stands_at_) {
    receivers_.push_back({view.position_world_m.pixels[pixel], view.normal_world.pixels[pixel]});
  }
  rows_.resize(static_cast<std::size_t>(view.Height()));
  tbb::parallel_for(0, view.Height(), [&](int y) {
    Row& row = rows_[static_cast<std::size_t>(y)];
    const auto matters = [&](int x) { return plan.size.At(x, y) != 0; };
    int end = view.Width();
    while (row.first_px < end && !matters(row.first_px)) ++row.first_px;
    while (row.first_px < end && !matters(end - 1)) --end;
    std::uint32_t own = first_of_row[static_cast<std::size_t>(y)];
    row.begin.reserve(static_cast<std::size_t>(end - row.first_px) + 1);
    row.entries.reserve(4 * static_cast<std::size_t>(end - row.first_px));
    row.begin.push_back(0);
    for (int x = row.first_px; x < end; ++x) {
      const std::size_t first = row.entries.size();
      if (plan.size.At(x, y) == 1) {
        row.entries.push_back({own++, 1.0f});
      } else if (matters(x)) {
        const std::size_t size = plan.size.At(x, y) - 1u;
        double sum = 0.0;
        blocks[size]->ForPixel(x, y, [&](std::uint32_t receiver, double weight) {
          row.entries.push_back({first_receiver[size] + receiver, static_cast<float>(weight)});
          sum += weight;
        });
        const auto scale = static_cast<float>(1.0 / sum);
        for (std::size_t i = first; i < row.entries.size(); ++i) row.entries[i].weight *= scale;
      }
      row.begin.push_back(static_cast<std::uint32_t>(row.entries.size()));
    }
  });
}

ObjectInfluence ObjectInfluence::InParts(const PatchScene& real,
                                         const PatchScene& objects,
                                         const ObjectInfluenceOptions& options) {
  options.Validate();
  ObjectInfluence influence;
  influence.real_faces_ = real.FaceCount();
  influence.object_faces_ = objects.FaceCount();
  influence.face_albedo_rgb_ = real.face_albedo_rgb;
  influence.lattice_ =
      std::make_shared<const FaceLattice>(real,
                                          PartsOfFaces(real,
                                                       BoundsOfObjects(objects.mesh),
                                                       static_cast<float>(options.least_share),
                                                       static_cast<float>(options.coarseness),
                                                       options.least_spacing));
  const FaceLattice& lattice = *influence.lattice_;
  influence.receivers_ = lattice.Receivers();
  influence.stands_at_.reserve(influence.receivers_.size());
  for (const std::uint32_t side : lattice.SideOfReceiver()) {
    influence.stands_at_.push_back(
        static_cast<std::size_t>(real.FaceOfSide(static_cast<std::int32_t>(side))));
  }
  influence.rays_ =
      std::make_shared<InfluenceRays>(objects, influence.receivers_, options.rays_per_receiver);
  return influence;
}

void ObjectInfluence::See(const PatchScene& real,
                          const SurfaceView& view,
                          const Image<std::int32_t>& sides) {
  if (lattice_ == nullptr) {
    throw std::logic_error("object influence: See is for receivers on faces");
  }
  RequireFaces(real.FaceCount(), real_faces_, "the real scene");
  if (sides.width != view.Width() || sides.height != view.Height()) {
    throw std::invalid_argument(std::string("object influence: sides of a picture of ") +
                                std::to_string(sides.width) + "x" + std::to_string(sides.height) +
                                ", expected the view's " + std::to_string(view.Width()) + "x" +
                                std::to_string(view.Height()));
  }
  picture_width_px_ = sides.width;
  picture_height_px_ = sides.height;
  has_spans_ = false;
  rows_.resize(static_cast<std::size_t>(sides.height));
  tbb::parallel_for(0, sides.height, [&](int y) {
    Row& row = rows_[static_cast<std::size_t>(y)];
    const auto may_change = [&](int x) {
      const std::int32_t side = sides.At(x, y);
      return side != PatchScene::kSky && lattice_->HasReceivers(static_cast<std::size_t>(side));
    };
    int end = sides.width;
    row.first_px = 0;
    while (row.first_px < end && !may_change(row.first_px)) ++row.first_px;
    while (row.first_px < end && !may_change(end - 1)) --end;
    row.entries.clear();
    row.begin.assign(1, 0);
    FaceLattice::LastSide last_side(*lattice_, real);
    for (int x = row.first_px; x < end; ++x) {
      if (!may_change(x)) {
        row.begin.push_back(static_cast<std::uint32_t>(row.entries.size()));
        continue;
      }
      const std::size_t pixel = sides.Index(x, y);
      const auto around = last_side.Around(static_cast<std::size_t>(sides.pixels[pixel]),
                                           view.position_world_m.pixels[pixel]);
      // Receivers under an object must not darken what lies beside it.
      float open = 0.0f;
      for (const FaceLattice::Weighted& at : around) open += at.weight * is_open_[at.receiver];
      for (std::size_t k = 0; k < 3; ++k) {
        const float weight = open > kLeastOpen
                                 ? around[k].weight * is_open_[around[k].receiver] / open
                                 : around[k].weight;
        row.entries.push_back({around[k].receiver, weight});
      }
      row.begin.push_back(static_cast<std::uint32_t>(row.entries.size()));
    }
  });
}

std::function<bool(std::int32_t, const glm::vec3&)> ObjectInfluence::MayChange(
    const PatchScene& real, const Lighting& lighting, const InfluenceParts& parts) const {
  if (lattice_ == nullptr) throw std::logic_error("object influence: MayChange is for faces");
  // For what the light may change by until it is evaluated.
  constexpr float kMargin = 0.5f;
  return [this, &real, change = AtReceivers(lighting, parts, kMargin * kLeastChange)](
             std::int32_t side, const glm::vec3& point_m) {
    const auto of_side = static_cast<std::size_t>(side);
    if (!lattice_->HasReceivers(of_side)) return false;
    const auto around = lattice_->Around(real, of_side, point_m);
    return std::any_of(around.begin(), around.end(), [&](const FaceLattice::Weighted& at) {
      return change[at.receiver] != glm::vec3(0.0f);
    });
  };
}

void ObjectInfluence::FindSpans() {
  if (has_spans_) return;
  has_spans_ = true;
  // Per thread and receiver, the place of its span; valid where that span is of this receiver.
  tbb::enumerable_thread_specific<std::vector<std::uint32_t>> places_of_thread(
      std::vector<std::uint32_t>(receivers_.size(), 0));
  tbb::parallel_for(std::size_t{0}, rows_.size(), [&](std::size_t y) {
    Row& row = rows_[y];
    std::vector<std::uint32_t>& places = places_of_thread.local();
    row.spans.clear();
    for (int x = row.first_px; x < row.EndPx(); ++x) {
      for (const Entry& entry : row.EntriesOf(x)) {
        if (entry.weight == 0.0f) continue;
        std::uint32_t& place = places[entry.receiver];
        if (place >= row.spans.size() || row.spans[place].receiver != entry.receiver) {
          place = static_cast<std::uint32_t>(row.spans.size());
          row.spans.push_back({entry.receiver, x, x});
        }
        row.spans[place].end_px = x + 1;
      }
    }
  });
}

void ObjectInfluence::Fold(std::size_t light,
                           const InfluenceBasis& basis,
                           const SurfaceView& view) {
  if (!basis.hidden_sky.empty() && basis.hidden_sky.size() != receivers_.size()) {
    throw std::invalid_argument(std::string("object influence: hidden_sky has ") +
                                std::to_string(basis.hidden_sky.size()) + " entries, expected " +
                                std::to_string(receivers_.size()) + ", one a receiver");
  }
  RequireFaces(basis.real_radiosity.size(), real_faces_, "the real scene's radiosity");
  RequireFaces(basis.object_radiosity.size(), object_faces_, "the objects' radiosity");
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
    if (!basis.hidden_sky.empty()) response.hidden = basis.hidden_sky[i];
    for (const InfluenceRays::Hit& hit : rays_->HitsOf(i)) {
      if (hit.behind != PatchScene::kSky) {
        response.hidden += hit.share * basis.real_radiosity[static_cast<std::size_t>(hit.behind)];
      } else if (basis.sky != nullptr) {
        response.hidden +=
            hit.share * std::numbers::pi_v<float> * basis.sky->Radiance(hit.direction);
      }
      response.gained +=
          hit.share * basis.object_radiosity[static_cast<std::size_t>(hit.object_face)];
    }
    response.before = Before(light, i, view, basis.real_radiosity);
    responses[i] = response;
  });
}

glm::vec3 ObjectInfluence::Before(std::size_t light,
                                  std::size_t receiver,
                                  const SurfaceView& view,
                                  std::span<const glm::vec3> real_radiosity) const {
  if (lattice_ == nullptr) {
    return light == 0 ? SunResponse(view, stands_at_[receiver], view.sun_direction_enu)
                      : view.sky_response[light - 1].pixels[stands_at_[receiver]];
  }
  // Irradiance is radiosity over albedo. A black face changes nothing in a picture.
  const std::size_t face = stands_at_[receiver];
  glm::vec3 irradiance(0.0f);
  for (int channel = 0; channel < 3; ++channel) {
    const float albedo = face_albedo_rgb_[face][channel];
    if (albedo > 0.0f) irradiance[channel] = real_radiosity[face][channel] / albedo;
  }
  return irradiance;
}

std::vector<glm::vec3> ObjectInfluence::AtReceivers(const Lighting& lighting,
                                                    const InfluenceParts& parts,
                                                    float least) const {
  const std::vector<glm::vec3> weights =
      internal::BasisWeights(lighting, responses_.size(), "object influence");
  std::vector<glm::vec3> at_receivers(receivers_.size());
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, receivers_.size(), 1024),
      [&](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
          Response sum;
          for (std::size_t light = 0; light < weights.size(); ++light) {
            const Response& response = responses_[light][i];
            sum.hidden += weights[light] * response.hidden;
            sum.gained += weights[light] * response.gained;
            sum.before += weights[light] * response.before;
          }
          const glm::vec3 change = (parts.object_light ? sum.gained : glm::vec3(0.0f)) -
                                   (parts.hidden_light ? sum.hidden : glm::vec3(0.0f));
          const bool matters = glm::any(glm::greaterThan(glm::abs(change), least * sum.before));
          at_receivers[i] = matters ? change : glm::vec3(0.0f);
        }
      });
  return at_receivers;
}

std::array<int, 2> ObjectInfluence::PixelsThatChange(
    const Row& row, std::span<const glm::vec3> at_receivers) const {
  int begin = picture_width_px_;
  int end = 0;
  if (!has_spans_) {
    const auto changes = [&](int x) {
      const std::span<const Entry> entries = row.EntriesOf(x);
      return std::any_of(entries.begin(), entries.end(), [&](const Entry& entry) {
        return entry.weight != 0.0f && at_receivers[entry.receiver] != glm::vec3(0.0f);
      });
    };
    int first = row.first_px;
    int last = row.EndPx();
    while (first < last && !changes(first)) ++first;
    while (first < last && !changes(last - 1)) --last;
    if (first < last) return {first, last};
    return {begin, end};
  }
  for (const Span& span : row.spans) {
    if (span.begin_px >= begin && span.end_px <= end) continue;
    if (at_receivers[span.receiver] == glm::vec3(0.0f)) continue;
    begin = std::min(begin, span.begin_px);
    end = std::max(end, span.end_px);
  }
  return {begin, end};
}

void ObjectInfluence::Evaluate(const Lighting& lighting,
                               const InfluenceParts& parts,
                               IrradianceChange& change) const {
  RgbImage& image = change.irradiance_rgb;
  image.width = 0;
  image.height = 0;
  if (receivers_.empty()) return image.pixels.clear();
  const std::vector<glm::vec3> at_receivers = AtReceivers(lighting, parts, kLeastChange);
  std::vector<std::array<int, 2>> changing(rows_.size());
  tbb::parallel_for(std::size_t{0}, rows_.size(), [&](std::size_t y) {
    changing[y] = PixelsThatChange(rows_[y], at_receivers);
  });
  glm::ivec2 lower(picture_width_px_, picture_height_px_);
  glm::ivec2 upper(0);
  for (int y = 0; y < static_cast<int>(rows_.size()); ++y) {
    const auto [begin, end] = changing[static_cast<std::size_t>(y)];
    if (end == 0) continue;
    lower = glm::min(lower, glm::ivec2(begin, y));
    upper = glm::max(upper, glm::ivec2(end, y + 1));
  }
  if (upper.x <= lower.x) return image.pixels.clear();
  change.x_px = lower.x;
  change.y_px = lower.y;
  image.width = upper.x - lower.x;
  image.height = upper.y - lower.y;
  image.pixels.resize(static_cast<std::size_t>(image.width) *
                      static_cast<std::size_t>(image.height));
  tbb::parallel_for(0, image.height, [&](int y) {
    const auto in_picture = static_cast<std::size_t>(lower.y + y);
    const auto [begin, end] = changing[in_picture];
    for (int x = 0; x < image.width; ++x) {
      glm::vec3 sum(0.0f);
      if (lower.x + x >= begin && lower.x + x < end) {
        for (const Entry& entry : rows_[in_picture].EntriesOf(lower.x + x)) {
          sum += entry.weight * at_receivers[entry.receiver];
        }
      }
      image.At(x, y) = sum;
    }
  });
}

}  // namespace pleinair
